"""exposure.py BUILD_DIR DOCUMENT: what `systemd-analyze security` says of the units as they are installed, against the table
in the document; `--write` puts it there. Every setting that is left open needs its reason here."""

import json
import os
import re
import subprocess
import sys
import tempfile

MOST = 2.0
SYSTEMD = "systemd 252 "  # of Debian 12; others judge differently
UNITS = ("lssd@ardito.service", "lssd-obc@ardito.service", "iox-roudi.service")
BEGIN, END = "<!-- exposure: made by systemd/exposure.py --write -->\n", "<!-- end of exposure -->\n"
REASONS = {
    "SystemCallFilter=~@resources": "real-time threads choose their scheduling and their CPU",
    "RemoveIPC=": "shared memory remains when RouDi or the daemon ends",
    "RootDirectory=/RootImage=": "it uses the system's libraries",
    "SupplementaryGroups=": "serial ports belong to `dialout`",
    "PrivateDevices=": "serial ports and `/dev/cpu_dma_latency`; `DevicePolicy=closed` instead",
    "DeviceAllow=": "only these devices; systemd itself adds `rtc`",
    "PrivateNetwork=": "DDS on the loopback, CAN interfaces",
    "PrivateMounts=": "it shares its `/tmp` with the daemon",
    "PrivateUsers=": "a site may give the socket to a group of its own",
    "RestrictAddressFamilies=~AF_NETLINK": "DDS lists the network interfaces",
    "RestrictAddressFamilies=~AF_UNIX": "RouDi, report of readiness",
    "RestrictAddressFamilies=~…": "CAN",
    "RestrictAddressFamilies=~AF_(INET|INET6)": "DDS",
    "RestrictRealtime=": "SCHED_FIFO",
    "IPAddressDeny=": "DDS discovery needs multicast besides localhost",
    "UMask=": "the daemon opens files of RouDi by their group",
}


def security(root, unit, *words):
    return subprocess.run(["systemd-analyze", "security", "--offline=true", f"--root={root}", "--no-pager", *words, unit],
                          stdout=subprocess.PIPE, text=True, check=False).stdout


def overall(text):
    return float(re.search(r"Overall exposure level for \S+: ([\d.]+)", text)[1])


def made(root):
    """The table, and what is wrong."""
    scores, left, faults = {}, {}, []
    for unit in UNITS:
        scores[unit] = overall(security(root, unit))
        if scores[unit] > MOST:
            faults.append(f"{unit}: {scores[unit]} is more than {MOST}")
        for item in json.loads(security(root, unit, "--json=short")):
            if item["exposure"] is not None and not item["set"]:
                left.setdefault(item["name"], {})[unit] = item["exposure"]
    faults += [f"{name} has no reason in {__file__}" for name in left if name not in REASONS]
    lines = [f"| | {' | '.join(f'`{unit}`' for unit in UNITS)} | needed for |", "|" + "---|" * (len(UNITS) + 2),
             f"| exposure, 0 to 10 | {' | '.join(f'**{scores[unit]}**' for unit in UNITS)} | |"]
    lines += [f"| `{name}` | {' | '.join(left[name].get(unit, '') for unit in UNITS)} | {REASONS.get(name, '?')} |"
              .replace("(INET|INET6)", "(INET\\|INET6)") for name in sorted(left)]
    return "\n".join(lines) + "\n", faults


def main():
    build, document = sys.argv[1:3]
    version = subprocess.run(["systemd-analyze", "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    if not version.startswith(SYSTEMD):
        print(f"skipped: {SYSTEMD}is the one that the document goes by, here is {version.splitlines()[0]}")
        sys.exit(77)
    with open(document, encoding="utf-8") as file:
        before, rest = file.read().split(BEGIN)
    told, after = rest.split(END)
    with tempfile.TemporaryDirectory() as root:
        subprocess.run(["cmake", "--install", build, "--component", "systemd"], env={**os.environ, "DESTDIR": root},
                       stdout=subprocess.DEVNULL, check=True)
        table, faults = made(root)
    if "--write" in sys.argv:
        with open(document, "w", encoding="utf-8") as file:
            file.write(before + BEGIN + table + END + after)
    elif table != told:
        faults.append(f"{document} says otherwise: {' '.join(['python3', *sys.argv])} --write\n{table}")
    print("\n".join(faults) or table, end="")
    sys.exit(bool(faults))


main()
