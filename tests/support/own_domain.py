"""own_domain.py COMMAND...: runs it with an unused DDS domain in LSS_DOMAIN, for itself until it ends."""

import fcntl
import os
import socket
import sys


def own_domain():
    """An unused DDS domain, and the lock on it. Domains up to 100 stay below the ephemeral ports."""
    for domain in range(60, 100):
        lock = open(f"/tmp/lss-e2e-domain-{domain}.lock", "w", encoding="ascii")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.bind(("", 7400 + 250 * domain))  # where all of a domain listen
            return domain, lock
        except OSError:
            lock.close()
    raise AssertionError("no DDS domain from 60 to 99 is free")


if __name__ == "__main__":
    number, kept = own_domain()
    os.set_inheritable(kept.fileno(), True)
    os.execvpe(sys.argv[1], sys.argv[1:], dict(os.environ, LSS_DOMAIN=str(number)))
