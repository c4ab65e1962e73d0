"""machine.py LSS_BENCH [--row ROWS] [--quick] [--json | --markdown FILE]: rows of lss-bench in the deterministic machine.

That is the computer in a box of tests/obc, whose time is counted in instructions, two nanoseconds each, on one CPU and a
PREEMPT_RT kernel: what another program of the host does delays nothing in it. So maxima and "never" mean something
there, which they do not on a shared machine. It has no caches and no hardware: its figures are no times of an OBC. Everything
is done in two machines, one after the other, and compared. `lss-bench --machine` calls this.
"""

import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../obc"))

ROWS = "i,ii,vi,xi"
REFERENCES = ["bench-pty-echo", "bench-can-loop"]
LIMIT_S = 3600
REPEATS = 0.2  # a maximum of one run against the other
# Rare activity of the system falls on a cycle of one machine and not of the other.
QUIET = ("systemctl stop '*.timer' systemd-journald.socket systemd-journald-dev-log.socket systemd-journald-audit.socket "
         "systemd-journald systemd-udevd-control.socket systemd-udevd-kernel.socket systemd-udevd; "
         "echo 3600 > /proc/sys/vm/stat_interval; echo 0 > /proc/sys/vm/dirty_writeback_centisecs; sync")
NOT_HERE = 77  # as ctest's SKIP_RETURN_CODE


def machine_class():
    import vm  # pylint: disable=import-outside-toplevel

    class Deterministic(vm.Machine):
        COUNTED = ["-accel", "tcg,thread=single", "-icount", "shift=1,sleep=off", "-rtc", "clock=vm", "-smp", "1"]
    return Deterministic


def libraries(path):
    """Of a program: {name: file}."""
    text = subprocess.run(["ldd", path], stdout=subprocess.PIPE, text=True, check=True).stdout
    return dict(re.findall(r"^\s*(\S+) => (\S+)", text, re.M))


def bring(share, bench):
    """Files missing in the box: lss-bench, its references, cyclictest."""
    references = os.path.join(os.path.dirname(bench), "../tests/bench")
    cyclictest = shutil.which("cyclictest")
    if cyclictest is None:
        sys.exit("cyclictest is not installed: see rt-tests in tools/packages.txt")
    needed = {}
    for path in [bench, cyclictest, *(os.path.join(references, name) for name in REFERENCES)]:
        subprocess.run(["strip", "-o", os.path.join(share, os.path.basename(path)), path], check=True)
        needed.update(libraries(path))
    return needed


def measure(bench, rows, quick):
    """The figures of one machine."""
    share = tempfile.mkdtemp(prefix="lss-bench-share-")
    os.chmod(share, 0o755)
    machine = None
    try:
        needed = bring(share, bench)
        machine = machine_class()(share)
        machine.wait_for_boot()
        # From its own disk: a page that comes from the host comes when the host likes.
        machine.must("mkdir -p /opt/bench && cp /mnt/host/* /opt/bench")
        missing = machine.must("for f in /opt/bench/*; do ldd $f; done | sed -n 's/^ *\\(.*\\) => not found/\\1/p' | sort -u")
        for name in missing.split():
            shutil.copy(needed[name], share)
        machine.must("cp -n /mnt/host/* /opt/bench")
        machine.must(QUIET)
        machine.must("cd /opt/bench && PATH=$PWD:$PATH LD_LIBRARY_PATH=$PWD ./lss-bench --maxima --json "
                     f"--row {rows} {'--quick' if quick else ''} > /run/figures.json 2> /run/progress || "
                     "{ cat /run/progress; false; }; cp /run/figures.json /mnt/host", LIMIT_S)
        with open(os.path.join(share, "figures.json"), encoding="utf-8") as file:
            kernel = machine.must("uname -rv")
            return json.load(file), kernel
    finally:
        if machine is not None:
            machine.end()
        shutil.rmtree(share)


def apart(first, second):
    """How far two runs are from each other, of the greater one; None: not measured."""
    if first["value"] is None or second["value"] is None:
        return None
    greater = max(abs(first["value"]), abs(second["value"]))
    return abs(first["value"] - second["value"]) / greater if greater else 0.0


def unsteady(pairs):
    """Medians and maxima in microseconds, which have to be the same, or nearly."""
    return [f"{a['row']}, {a['figure']} ({number(a['value'])} and {number(b['value'])})" for a, b in pairs
            if re.search("p50$|max$", a["figure"]) and (apart(a, b) or 0) > REPEATS]


def number(value):
    if value is None or not math.isfinite(value):
        return "-"
    if abs(value) >= 100:
        return f"{value:.0f}"
    return "0" if value == 0 else f"{value:.1f}" if abs(value) >= 10 else f"{value:.3f}"


def goal(figure):
    if figure["goal"] is None:
        return "-"
    bare = figure["goal"] == 0 or "sigma" in figure["figure"]
    return f"<= {number(figure['goal'])}{'' if bare else 'x'}"


def document(pairs, kernel, command):
    lines = [
        "# Timing in the deterministic machine", "",
        f"For reviewers of the timing: figures with a goal, and maxima. Made by `{command}`; do not edit.",
        "Columns as in [performance.md](performance.md); *second*: a second machine, booted after the first; goals are met by",
        "both; other columns are of the first.", "",
        f"The machine (`qemu -icount shift=1,sleep=off -smp 1`, {kernel.split()[0]}, PREEMPT_RT, no KVM) counts",
        "instructions of 2 ns instead of time: no other program of the host delays it. One CPU, no caches: maxima, missed",
        "deadlines and ratios are valid, microseconds are no hardware's.", "",
        "| figure | value | second | reference | ratio | goal |", "|---|---:|---:|---:|---:|---|"]
    shown = [(a, b) for a, b in pairs if a["met"] is not None or a["figure"].endswith("max")]
    notes = list(dict.fromkeys(a["note"] for a, _ in shown if a["note"]))  # each once; figures have its number
    for a, b in shown:
        both = {a["met"], b["met"]}
        met = "no" if "no" in both else "undecided" if "undecided" in both else "yes"
        unit = f", {a['unit']}" if a["unit"] not in ("", "1") else ""
        note = f" [{notes.index(a['note']) + 1}]" if a["note"] else ""
        lines.append(f"| {a['row']}, {a['figure']}{unit}{note} | {number(a['value'])} | {number(b['value'])} | "
                     f"{number(a['reference'])} | {number(a['ratio'])} | "
                     f"{'-' if a['met'] is None else f'{goal(a)}: {met}'} |")
    worst = {kind: max((apart(a, b) or 0 for a, b in pairs if a["figure"].endswith(kind)), default=0)
             for kind in ("p50", "max")}
    lines += ["", f"Medians of both differ by {worst['p50']:.1%} at most, maxima by {worst['max']:.1%}."]
    differ = unsteady(pairs)
    if differ:
        lines += [f"By more than {REPEATS:.0%}: {'; '.join(differ)}."]
    lines += ["", "## Notes", ""]
    lines += [f"{i}. {note}" for i, note in enumerate(notes, 1)]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bench")
    parser.add_argument("--row", default=ROWS)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--markdown")
    words = parser.parse_args()
    bench = os.path.abspath(words.bench)
    os.environ.setdefault("LSS_OBC_IMAGE", os.path.join(os.path.dirname(bench), "../tests/obc/box/image"))
    if not os.path.exists(os.path.join(os.environ["LSS_OBC_IMAGE"], "root.ext4")):
        print("there is no image of the machine: `ctest --preset release -R obc.image` makes it, or says why not")
        sys.exit(NOT_HERE)
    runs = []
    for turn in ("first", "second"):
        print(f"{turn} machine", file=sys.stderr, flush=True)
        runs.append(measure(bench, words.row, words.quick))
    pairs = list(zip(runs[0][0], runs[1][0], strict=True))
    command = " ".join(["lss-bench --machine", *(["--quick"] if words.quick else []),
                        *([f"--row {words.row}"] if words.row != ROWS else [])])
    text = document(pairs, runs[0][1], f"{command} --markdown docs/machine-timing.md")
    if words.markdown:
        with open(words.markdown, "w", encoding="utf-8") as file:
            file.write(text)
    print(json.dumps([{**a, "second": b["value"]} for a, b in pairs], indent=2) if words.json else text, end="")
    wrong = [f"not measured: {a['row']} {a['figure']} {a['note']}" for a, _ in pairs if a["value"] is None]
    wrong += [f"missed: {f['row']} {f['figure']}: {f['value']:g}" for pair in pairs for f in pair
              if f["goal"] == 0 and f["met"] == "no"]
    if not words.quick:
        wrong += [f"does not repeat: {line}" for line in unsteady(pairs)]
    print("\n".join(wrong), file=sys.stderr)
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
