#!/usr/bin/env python3
"""check_requirements.py [ROOT]: checks that docs/requirements.md lists every requirement of the Zebro thesis, and names
exactly the tests of each. Reads only. How a test carries an ID: tests/README.md."""
import pathlib
import re
import sys

COUNTS = {"Func": 5, "Miss": 3, "P-Int": 2, "S-Int": 2, "O-Int": 4, "Env": 3, "Oper": 8, "Log": 2, "Prod": 6, "Conf": 3,
          "Des": 3, "Ver": 3}
IDS = [f"{kind}-{number}" for kind, count in COUNTS.items() for number in range(1, count + 1)]
DOCUMENT = "docs/requirements.md"
VERDICT = re.compile(r"- ([123]), (fulfilled|partially|not|unknown), \*\*(met|partly|not met)\*\*")

KIND = "|".join(kind.replace("-", "_") for kind in COUNTS)
ID_IN_NAME = re.compile(rf"(?:^|_)({KIND})_(\d+)(?=_|$)")
TAG = re.compile(r"\[([A-Z][A-Za-z-]*-\d+)\]")
TAG_LINE = re.compile(r"\s*(?://|#) (\[[A-Z][A-Za-z-]*-\d+\] ?)+$")
CPP_TEST = re.compile(r"(?:TYPED_TEST_P|TYPED_TEST|TEST|TEST_F|TEST_P|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+),\s*(\w+)")
PYTHON_TEST = re.compile(r"def test_(\w+)\(")
CTEST = re.compile(r"\s*add_test\(NAME ([\w.]+)(?:\s|$)")

root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
faults = []


def fault(path, line, text):
    faults.append(f"{path}:{line}: {text}")


class Test:
    """name: Suite.Name as in the source, or the name of the ctest."""

    def __init__(self, name, path, lines, index):
        self.name, self.path, self.line = name, path, index + 1
        self.ids = [f"{kind.replace('_', '-')}-{number}" for kind, number in ID_IN_NAME.findall(name.split(".")[-1])]
        if index > 0 and TAG_LINE.match(lines[index - 1]):
            self.ids += TAG.findall(lines[index - 1])


def found_tests():
    registered = set(re.findall(r"lss_e2e\((\w+) \S+ (\w+)", read("tests/e2e/CMakeLists.txt")))
    for path in sorted((root / "tests").rglob("*")) + sorted((root / "cmake").glob("*.cmake")):
        where = path.relative_to(root)
        if path.suffix not in (".cpp", ".h", ".py", ".txt", ".cmake"):
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        claimed = set()
        for index, line in enumerate(lines):
            name = None
            if path.suffix in (".cpp", ".h") and (m := CPP_TEST.match("\n".join(lines[index:index + 2]))):
                name = None if "DISABLED_" in m[0] else f"{m[1]}.{m[2]}"  # otherwise it never runs
            elif path.suffix == ".py" and (m := PYTHON_TEST.match(line.strip())):
                module = path.stem.removeprefix("test_")
                if (module, m[1]) in registered:
                    name = f"e2e.{module}.{m[1]}"
            elif path.suffix in (".txt", ".cmake") and (m := CTEST.match(line)):
                name = m[1]
            if name:
                claimed.add(index - 1)
                yield Test(name, where, lines, index)
        for index, line in enumerate(lines):
            if TAG_LINE.match(line) and index not in claimed:
                fault(where, index + 1, "a tag with no test on the next line")


class Entry:
    def __init__(self, line):
        self.line, self.tests, self.verdict = line, [], None


def read(path):
    return (root / path).read_text(encoding="utf-8")


def read_entries():
    entries, entry, listing = {}, None, False
    for number, line in enumerate(read(DOCUMENT).splitlines(), 1):
        if m := re.match(r"#+ (.*)", line):
            entry = None
            if line.startswith("### "):
                if m[1] in entries or m[1] not in IDS:
                    fault(DOCUMENT, number, f"{m[1]}: {'twice' if m[1] in entries else 'no such requirement'}")
                entry = entries.setdefault(m[1], Entry(number))
        if entry is None:
            continue
        entry.verdict = entry.verdict or VERDICT.match(line)
        listing = line.startswith("- Tests: ") or (listing and line != "")
        if listing:
            entry.tests += [(number, name) for name in re.findall(r"`([^`]+)`", line)]
    return entries


def check():
    tests = list(found_tests())
    names = {test.name for test in tests}
    entries = read_entries()
    for test in tests:
        for id_ in test.ids:
            if id_ not in entries:
                fault(test.path, test.line, f"{test.name} carries {id_}, which {DOCUMENT} does not have")
            elif not any(name == test.name or name.endswith("/") and str(test.path).startswith(name)
                         for _, name in entries[id_].tests):
                fault(test.path, test.line, f"{test.name} carries {id_}: name it there in {DOCUMENT}")
    for id_ in IDS:
        if id_ not in entries:
            fault(DOCUMENT, 1, f"{id_} is missing")
            continue
        entry = entries[id_]
        if not entry.tests:
            fault(DOCUMENT, entry.line, f"{id_} has no test")
        for line, name in entry.tests:
            if name.endswith("/"):
                if not any(str(test.path).startswith(name) and id_ in test.ids for test in tests):
                    fault(DOCUMENT, line, f"{id_}: no test in {name} carries it")
            elif name not in names:
                fault(DOCUMENT, line, f"{id_}: there is no test {name}")
            elif not any(test.name == name and id_ in test.ids for test in tests):
                fault(DOCUMENT, line, f"{id_}: {name} does not carry it")
    check_verdicts(entries)


def check_verdicts(entries):
    """The counts in the document's table are those of its verdicts; that of Prod-6 follows from those of priority 1."""
    verdicts = {id_: entry.verdict for id_, entry in entries.items()}
    for id_, verdict in verdicts.items():
        if not verdict:
            fault(DOCUMENT, entries[id_].line, f"{id_}: no line like '- 1, partially, **met**'")
    good = {id_: verdict for id_, verdict in verdicts.items() if verdict}
    thesis, here = [v[2] for v in good.values()], [v[3] for v in good.values()]
    for who, counts in (("thesis", (thesis.count("fulfilled"), thesis.count("partially"),
                                    thesis.count("not") + thesis.count("unknown"))),
                        ("here", (here.count("met"), here.count("partly"), here.count("not met")))):
        row = f"| {who} | " + " | ".join(map(str, counts)) + " |"
        if row not in read(DOCUMENT).splitlines():
            fault(DOCUMENT, 1, f"the table of counts has to say: {row}")
    open_ = [id_ for id_, v in good.items() if v[1] == "1" and v[3] != "met" and id_ != "Prod-6"]
    if open_ and good.get("Prod-6") and good["Prod-6"][3] == "met":
        fault(DOCUMENT, entries["Prod-6"].line, f"Prod-6 is not met while these are open: {', '.join(open_)}")


check()
print(*faults, sep="\n", end="\n" if faults else "")
print(f"{len(faults)} faults" if faults else f"{len(IDS)} requirements, each with its tests")
sys.exit(1 if faults else 0)
