#!/usr/bin/env python3
"""Plants each violation that check_requirements.py looks for in a temporary tree and expects the check to find it."""
import pathlib
import re
import subprocess
import sys
import tempfile

CHECK = pathlib.Path(__file__).with_name("check_requirements.py")
COUNTS = dict(re.findall(r'"([A-Z][\w-]*)": (\d)', CHECK.read_text(encoding="utf-8")))
IDS = [f"{kind}-{number}" for kind, count in COUNTS.items() for number in range(1, int(count) + 1)]
DOCUMENT, CPP, E2E, CMAKE = "docs/requirements.md", "tests/core/a_test.cpp", "tests/e2e/test_walk.py", "tests/CMakeLists.txt"


def good():
    """Func-1 has a test by name and a property by tag, Func-2 an end-to-end test, Func-3 a rule, Func-4 a folder."""
    tests = {id_: "`Rest.All`" for id_ in IDS}
    tests |= {"Func-1": "`Walk.Walks_Func_1`,\n`Walk.Any`", "Func-2": "`e2e.walk.goes`", "Func-3": "`a_rule`",
              "Func-4": "`tests/core/`"}
    entries = [f"### {id_}\nText.\n\n- {1 if id_ in ('Prod-6', 'Func-1') else 2}, not, **met**.\n"
               f"- Tests: {tests[id_]}\n" for id_ in IDS]
    rest = "".join(f"[{id_}] " for id_ in IDS if id_ not in ("Func-1", "Func-2", "Func-3"))
    return {
        DOCUMENT: "| thesis | 0 | 0 | 44 |\n| here | 44 | 0 | 0 |\n" + "\n".join(entries),
        CPP: "TEST_F(Walk, Walks_Func_1) {\n}\n\n// [Func-1]\nRC_GTEST_PROP(Walk,\n              Any, ()) {\n}\n"
             f"// {rest.strip()}\nTEST(Rest, All) {{}}\n",
        E2E: "    # [Func-2]\n    def test_goes(self):\n        pass\n",
        CMAKE: "# [Func-3]\nadd_test(NAME a_rule COMMAND x)\n",
        "tests/e2e/CMakeLists.txt": "lss_e2e(walk Walk goes 10)\n",
        "cmake/x.cmake": "",
    }


def run(files):
    with tempfile.TemporaryDirectory() as tree:
        for path, text in files.items():
            file = pathlib.Path(tree, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        done = subprocess.run([sys.executable, CHECK, tree], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr


failed = 0


def expect_fault(path, old, new, said):
    global failed
    files = good()
    assert old in files[path], (path, old)
    files[path] = files[path].replace(old, new, 1)
    code, output = run(files)
    if code != 1 or said not in output:
        print(f"not caught: {old!r} as {new!r} in {path}\n{output}")
        failed = 1


code, output = run(good())
if code != 0:
    print("a good tree is refused\n" + output)
    failed = 1

expect_fault(DOCUMENT, "### Env-2\n", "### Env-4\n", "Env-2 is missing")
expect_fault(DOCUMENT, "### Env-2\n", "### Env-4\n", "Env-4: no such requirement")
expect_fault(DOCUMENT, "### Env-2\n", "### Env-1\n", "Env-1: twice")
expect_fault(DOCUMENT, "Tests: `a_rule`", "Tests: none", "Func-3 has no test")
expect_fault(DOCUMENT, "Tests: `a_rule`", "Tests: `no_rule`", "there is no test no_rule")
expect_fault(DOCUMENT, "Tests: `a_rule`", "Tests: `a_rule`, `Rest.All`", "Rest.All does not carry it")
expect_fault(DOCUMENT, "`tests/core/`", "`tests/lc/`", "Func-4: no test in tests/lc/ carries it")
expect_fault(DOCUMENT, "`Walk.Walks_Func_1`,\n", "", "Walk.Walks_Func_1 carries Func-1: name it there")
expect_fault(DOCUMENT, "not, **met**", "**met**", "Func-1: no line like")
expect_fault(DOCUMENT, "| here | 44 | 0 | 0 |", "| here | 43 | 1 | 0 |", "| here | 44 | 0 | 0 |")
expect_fault(DOCUMENT, "1, not, **met**", "1, not, **partly**",
             "Prod-6 is not met while these are open: Func-1")
expect_fault(CPP, "Walks_Func_1", "Walks_Func_9", "carries Func-9, which")
expect_fault(CPP, "// [Func-1]", "// [Func-9]", "carries Func-9, which")
expect_fault(CPP, "// [Func-1]\n", "// [Func-1]\n\n", "a tag with no test on the next line")
expect_fault(CPP, "Walks_Func_1", "DISABLED_Walks_Func_1", "there is no test Walk.Walks_Func_1")
expect_fault("tests/e2e/CMakeLists.txt", "goes", "comes", "there is no test e2e.walk.goes")
expect_fault(E2E, "# [Func-2]", "# said", "e2e.walk.goes does not carry it")
expect_fault(CMAKE, "# [Func-3]", "#", "a_rule does not carry it")

if not failed:
    print("each violation is caught")
sys.exit(failed)
