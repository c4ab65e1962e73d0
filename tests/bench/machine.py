"""machine.py LSS_BENCH [--row ROWS] [--box BOXES] [--quick] [--json | --markdown FILE]: rows of lss-bench in the
deterministic machine.

That is the computer in a box of tests/obc, whose time is counted in instructions, two nanoseconds each, on one CPU and a
PREEMPT_RT kernel: what another program of the host does delays nothing in it. So maxima and "never" mean something
there, which they do not on a shared machine. It has no caches and no hardware: its figures are no times of an OBC. Everything
is done in two machines, one after the other, and compared. Several boxes (BOXES) give a table with a column for each.
`lss-bench --machine` calls this.
"""

import argparse
import dataclasses
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
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
# Boxes besides that of this machine's Debian: folder of their build, root of tools/package, triplet, its options.
OTHERS = {"trixie": ("amd64-trixie", "trixie-amd64", "x86_64-linux-gnu", "--arch amd64 --suite trixie"),
          "arm64": ("arm64", "bookworm-arm64", "aarch64-linux-gnu", "--arch arm64")}
BOXES = ["amd64", *OTHERS]


def machine_class():
    import vm  # pylint: disable=import-outside-toplevel

    class Deterministic(vm.Machine):
        SHIFT = 1
    return Deterministic


@dataclasses.dataclass
class Box:
    """A computer of tests/obc, and what is measured in it: programs that were built for it, with their libraries."""

    name: str
    image: str
    programs: list
    libraries: str  # folder
    image_test: str
    build: str  # the command that makes the programs

    def missing(self):
        """What this box lacks, in words; empty: nothing."""
        if not os.path.exists(os.path.join(self.image, "root.ext4")):
            return f"no image: `ctest --preset release -C Obc -R {self.image_test}` makes it, or says why not"
        absent = [os.path.basename(path) for path in self.programs if not os.path.exists(path)]
        return f"no {', '.join(absent)}: `{self.build}` makes it" if absent else ""


def box_of(name, bench):
    """Of this machine's Debian, or one whose programs `tools/package --bench` has built."""
    built = os.path.dirname(os.path.dirname(bench))
    names = ["lss-bench", "lssd", *REFERENCES]
    if name == "amd64":
        image = os.environ.get("LSS_OBC_IMAGE", os.path.join(built, "tests/obc/box/image"))
        references = [os.path.join(built, "tests/bench", reference) for reference in REFERENCES]
        lssd = os.path.join(os.path.dirname(bench), "lssd")
        return Box(name, image, [bench, lssd, *references], "/usr/lib/x86_64-linux-gnu", "obc.image",
                   f"ninja -C {os.path.relpath(built)} lss-bench lssd")
    folder, root, triplet, words = OTHERS[name]
    return Box(name, os.path.join(built, f"tests/obc/box-{name}/image"),
               [os.path.join(TOP, "build", folder, "bench", program) for program in names],
               os.path.join(TOP, "build/roots", root, "usr/lib", triplet), f"obc.{name}.image", f"tools/package {words} --bench")


def bring(share, box):
    """The programs, without what only a debugger needs (those of OTHERS are already so), and a configuration."""
    for path in box.programs:
        copy = os.path.join(share, os.path.basename(path))
        if box.name in OTHERS:
            shutil.copy(path, copy)
        else:
            subprocess.run(["strip", "-o", copy, path], check=True)
    shutil.copy(os.path.join(TOP, "config/talaris.toml"), share)


def bring_libraries(machine, share, box):
    """Those that the box does not have, and then those that they need."""
    while True:
        missing = machine.must("for f in /opt/bench/*; do LD_LIBRARY_PATH=/opt/bench ldd $f; done 2> /dev/null | "
                               "sed -n 's/^[[:space:]]*\\(.*\\) => not found/\\1/p' | sort -u").split()
        if not missing:
            return
        for name in missing:
            shutil.copy(os.path.join(box.libraries, name), share)
        machine.must("cp -n /mnt/host/* /opt/bench")


def measure(box, rows, quick):
    """The figures of one machine, and its kernel."""
    os.environ["LSS_OBC_IMAGE"] = box.image
    import vm  # pylint: disable=import-outside-toplevel
    vm.IMAGE = box.image
    share = tempfile.mkdtemp(prefix="lss-bench-share-")
    os.chmod(share, 0o755)
    machine = None
    try:
        bring(share, box)
        machine = machine_class()(share)
        machine.wait_for_boot()
        # From its own disk: a page that comes from the host comes when the host likes.
        machine.must("mkdir -p /opt/bench && cp /mnt/host/* /opt/bench")
        machine.must(f"mkdir -p {TOP}/config && cp /mnt/host/talaris.toml {TOP}/config")
        bring_libraries(machine, share, box)
        machine.must(QUIET)
        machine.must("cd /opt/bench && PATH=$PWD:$PATH LD_LIBRARY_PATH=$PWD ./lss-bench --maxima --json "
                     f"--row {rows} {'--quick' if quick else ''} > /run/figures.json 2> /run/progress || "
                     "{ cat /run/progress; false; }; cp /run/figures.json /mnt/host", LIMIT_S)
        with open(os.path.join(share, "figures.json"), encoding="utf-8") as file:
            kernel = machine.must("uname -r")
            return json.load(file), kernel
    except (vm.Gone, AssertionError, OSError) as error:
        words = machine.last_words() if machine is not None and not isinstance(error, vm.Gone) else ""
        sys.exit(f"box {box.name}: {error!r}\n{words}")
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


def verdict(a, b):
    """Of both machines; None: there is no goal."""
    both = {a["met"], b["met"]}
    return None if a["met"] is None else "no" if "no" in both else "undecided" if "undecided" in both else "yes"


def shown(pairs):
    return [(a, b) for a, b in pairs if a["met"] is not None or a["figure"].endswith("max")]


def label(figure):
    return f"{figure['row']}, {figure['figure']}" + (f", {figure['unit']}" if figure["unit"] not in ("", "1") else "")


def one_box(pairs):
    lines = ["| figure | value | second | reference | ratio | goal |", "|---|---:|---:|---:|---:|---|"]
    notes = list(dict.fromkeys(a["note"] for a, _ in shown(pairs) if a["note"]))  # each once; figures have its number
    for a, b in shown(pairs):
        note = f" [{notes.index(a['note']) + 1}]" if a["note"] else ""
        met = verdict(a, b)
        lines.append(f"| {label(a)}{note} | {number(a['value'])} | {number(b['value'])} | "
                     f"{number(a['reference'])} | {number(a['ratio'])} | {f'{goal(a)}: {met}' if met else '-'} |")
    return lines, ["", "## Notes", "", *(f"{i}. {note}" for i, note in enumerate(notes, 1))]


def side_by_side(boxes):
    lines = [f"| figure | goal | {' | '.join(boxes)} |", "|---|---|" + "---:|" * len(boxes)]
    tables = [{label(a): (a, b) for a, b in shown(pairs)} for pairs, _ in boxes.values()]
    for name in dict.fromkeys(name for table in tables for name in table):
        cells = []
        for table in tables:
            a, b = table.get(name, ({"value": None, "ratio": None, "met": None}, {"met": None}))
            ratio = f" ({number(a['ratio'])}x)" if a["ratio"] is not None else ""
            met = verdict(a, b)
            cells.append(number(a["value"]) + ratio + (f": {met}" if met else ""))
        figure = next(table[name][0] for table in tables if name in table)
        lines.append(f"| {name} | {goal(figure)} | {' | '.join(cells)} |")
    return lines


def document(boxes, command):
    """boxes: of each its pairs of figures and its kernel."""
    kernels = [kernel for _, kernel in boxes.values()]
    several = len(boxes) > 1
    lines = [
        "# Timing in the deterministic machine", "",
        f"For reviewers of the timing: figures with a goal, and maxima. Made by `{command}`; do not edit.",
        *(["Of each box the value and its ratio to the reference as in [performance.md](performance.md), both of the first of two",
           "machines, and whether both machines meet the goal. The programs were built for the Debian of each box."]
          if several else
          ["Columns as in [performance.md](performance.md); *second*: a second machine, booted after the first; goals are met by",
           "both; other columns are of the first."]), "",
        f"The machine (`qemu -icount shift=1,sleep=off -smp 1`, {', '.join(kernels)}, PREEMPT_RT, no KVM) counts",
        "instructions of 2 ns instead of time: no other program of the host delays it. One CPU, no caches: maxima, missed",
        "deadlines and ratios are valid, microseconds are no hardware's.", ""]
    table, notes = (side_by_side(boxes), []) if several else one_box(next(iter(boxes.values()))[0])
    lines += table
    for name, (pairs, _) in boxes.items():
        worst = {kind: max((apart(a, b) or 0 for a, b in pairs if a["figure"].endswith(kind)), default=0)
                 for kind in ("p50", "max")}
        lines += ["", f"{f'{name}: m' if several else 'M'}edians of both differ by {worst['p50']:.1%} at most, maxima by "
                      f"{worst['max']:.1%}."]
        differ = unsteady(pairs)
        if differ:
            lines += [f"By more than {REPEATS:.0%}: {'; '.join(differ)}."]
    return "\n".join(lines + notes) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bench")
    parser.add_argument("--row", default=ROWS)
    parser.add_argument("--box", default=BOXES[0], help=f"comma-separated, of {', '.join(BOXES)}")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--markdown")
    words = parser.parse_args()
    bench = os.path.abspath(words.bench)
    names = list(dict.fromkeys(words.box.split(",")))
    for name in names:
        if name not in BOXES:
            parser.error(f"there is no box '{name}', only {', '.join(BOXES)}")
    boxes = [box_of(name, bench) for name in names]
    missing = [f"box {box.name}: {box.missing()}" for box in boxes if box.missing()]
    if missing:
        print("\n".join(missing))
        sys.exit(NOT_HERE)
    measured = {}
    for box in boxes:
        runs = []
        for turn in ("first", "second"):
            print(f"box {box.name}, {turn} machine", file=sys.stderr, flush=True)
            runs.append(measure(box, words.row, words.quick))
        measured[box.name] = (list(zip(runs[0][0], runs[1][0], strict=True)), runs[0][1])
    command = " ".join(["lss-bench --machine", *(["--quick"] if words.quick else []),
                        *([f"--row {words.row}"] if words.row != ROWS else []),
                        *([f"--box {','.join(names)}"] if names != BOXES[:1] else [])])
    text = document(measured, f"{command} --markdown docs/machine-timing.md")
    if words.markdown:
        with open(words.markdown, "w", encoding="utf-8") as file:
            file.write(text)
    figures = [{**({"box": name} if len(names) > 1 else {}), **a, "second": b["value"]}
               for name, (pairs, _) in measured.items() for a, b in pairs]
    print(json.dumps(figures, indent=2) if words.json else text, end="")
    wrong = []
    for name, (pairs, _) in measured.items():
        wrong += [f"{name}: not measured: {a['row']} {a['figure']} {a['note']}" for a, _ in pairs if a["value"] is None]
        wrong += [f"{name}: missed: {f['row']} {f['figure']}: {f['value']:g}" for pair in pairs for f in pair
                  if f["goal"] == 0 and f["met"] == "no"]
        if not words.quick:
            wrong += [f"{name}: does not repeat: {line}" for line in unsteady(pairs)]
    print("\n".join(wrong), file=sys.stderr)
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
