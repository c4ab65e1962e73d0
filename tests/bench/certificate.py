"""certificate.py BIN RECORDING... [--seconds N] [--idle N]: a timing certificate of Lunar Zebro, made in the deterministic
machine of machine.py of recordings of a walk (in simulated time, for the cycle) and of one that lssd makes there (for the
inputs), then held against frames of lssd in Idle without a bus. BIN: folder of lssd and lss-cli. Prints the certificate, the
largest times, and the events of frames that were later than certified: there must be none. docs/timing.md has the result.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from machine import HERE, QUIET, machine_class

PROGRAMS = ["lssd", "lss-cli"]
LATE = (92, 93)  # idl/codes.inc
CERTIFICATE = "/run/certificate.json"


def libraries(path):
    """Of a program: {name: file}."""
    text = subprocess.run(["ldd", path], stdout=subprocess.PIPE, text=True, check=True).stdout
    return dict(re.findall(r"^\s*(\S+) => (\S+)", text, re.M))


def bring(share, folder):
    """Programs and configuration; the libraries that they need: {name: file}."""
    needed = {}
    paths = [os.path.join(folder, name) for name in PROGRAMS]
    paths += filter(None, map(shutil.which, ("rtla", "cyclictest")))
    for path in paths:
        subprocess.run(["strip", "-o", os.path.join(share, os.path.basename(path)), path], check=True)
        needed.update(libraries(path))
    with open(os.path.join(HERE, "../../config/zebro.toml"), encoding="utf-8") as file:
        text = file.read()
    for old, new in (('certificate = ""', f'certificate = "{CERTIFICATE}"'), ("shared_memory = true", "shared_memory = false")):
        assert old in text
        text = text.replace(old, new)
    with open(os.path.join(share, "zebro.toml"), "w", encoding="utf-8") as file:
        file.write(text)
    return needed


class Zebro:
    """In the machine, with the simulator."""

    def __init__(self, machine):
        self.machine = machine

    def must(self, command, limit_s=60):
        return self.machine.must(f"cd /opt/lss; export PATH=$PWD:$PATH LD_LIBRARY_PATH=$PWD LSS_DOMAIN=7; {command}", limit_s)

    def install(self, needed, share):
        self.machine.run("mkdir -p /opt/lss && cp /mnt/host/* /opt/lss")
        missing = self.must("for f in *; do ldd $f; done 2> /dev/null | sed -n 's/^[[:space:]]*\\(.*\\) => not found/\\1/p' | sort -u")
        for name in missing.split():
            shutil.copy(needed[name], share)
        self.must("cp -n /mnt/host/* .")
        self.must(QUIET)
        self.must("mountpoint -q /sys/kernel/tracing || mount -t tracefs nodev /sys/kernel/tracing")

    def idle(self, folder, seconds):
        """Frames of lssd for so long: their statistics and the events, as JSON, and its journal."""
        self.must(f"mkdir {folder}; lssd --config zebro.toml --run-dir {folder} > {folder}/lssd 2>&1 & echo $! > {folder}.pid")
        self.must(f"lss-cli --timeout 60s status > /dev/null; lss-cli timing --reset; sleep {seconds}", 120 + seconds)
        timing, events = (json.loads(self.must(f"lss-cli --json {verb}")) for verb in ("timing", "events"))
        self.must(f"kill $(cat {folder}.pid); tail --pid=$(cat {folder}.pid) -f /dev/null")
        return timing, events["events"], self.must(f"cat {folder}/lssd")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="BIN")
    parser.add_argument("recordings", metavar="RECORDING", nargs="+")
    parser.add_argument("--seconds", type=int, default=30, help="of measuring the kernel")
    parser.add_argument("--idle", type=int, default=600, help="seconds of frames with the certificate")
    options = parser.parse_args()
    share = tempfile.mkdtemp(prefix="lss-bench-share-")
    os.chmod(share, 0o755)
    machine = None
    try:
        needed = bring(share, options.folder)
        for path in options.recordings:
            shutil.copy(path, share)
        machine = machine_class()(share)
        machine.wait_for_boot()
        zebro = Zebro(machine)
        zebro.install(needed, share)
        zebro.idle("/run/first", 20)
        print(zebro.must(f"lss-cli timing certify --config zebro.toml --seconds {options.seconds} *.lssrec "
                         "/run/first/*.lssrec", 600 + options.seconds), flush=True)
        timing, events, said = zebro.idle("/run/second", options.idle)
        for name in ("command", "release"):
            print(name, {key: timing["points"][name][key] for key in ("p50_us", "p99_us", "max_us")})
        late = [event["text"] for event in events if event["id"] in LATE]
        print(f"{timing['frames']} frames, {len(late)} events of frames later than certified:", late, said)
        return 1 if late or "not taken" in said else 0
    finally:
        if machine is not None:
            machine.end()
        shutil.rmtree(share)


if __name__ == "__main__":
    sys.exit(main())
