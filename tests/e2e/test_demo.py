"""The README's first command, in the tree as it is."""

import os
import re
import tempfile
import unittest

from programs import Program, run, wait_until
from rig import SOURCE


def children(parent):
    """Process numbers of a process' children, by name."""
    found = {}
    for number in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{number}/stat", encoding="utf-8") as file:
                name, rest = re.match(r"\d+ \((.*)\) \S (.*)", file.read()).groups()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(rest.split()[0]) == parent:
            found[name] = int(number)
    return found


class Demo(unittest.TestCase):
    any_machine = True  # none is too slow for it

    def test_the_demo_walks_zebro_and_says_how_far(self):
        result = run([os.path.join(SOURCE, "tools", "demo"), "zebro"], dict(os.environ, NO_COLOR="1"), 1100)
        print(result.out)
        self.assertEqual(result.code, 0, result.err)
        moved_m = float(re.search(r"zebro moved (\S+) m", result.out).group(1))
        self.assertGreaterEqual(moved_m, 0.15)

    def test_the_demo_drives_ardito_and_says_what_it_did(self):
        result = run([os.path.join(SOURCE, "tools", "demo"), "ardito", "--fast"], dict(os.environ, NO_COLOR="1"), 1100)
        print(result.out)
        self.assertEqual(result.code, 0, result.err)
        self.assertRegex(result.out, "an S.*on the spot.*climbed")

    def test_the_demo_flies_talaris_and_says_how_it_landed(self):
        result = run([os.path.join(SOURCE, "tools", "demo"), "talaris", "--fast"], dict(os.environ, NO_COLOR="1"), 1100)
        print(result.out)
        self.assertEqual(result.code, 0, result.err)
        self.assertIn("landed well", result.out)

    def test_a_killed_demo_leaves_no_program_behind(self):
        with tempfile.TemporaryDirectory() as folder:
            demo = Program("demo", [os.path.join(SOURCE, "tools", "demo"), "zebro"], folder,
                           dict(os.environ, NO_COLOR="1", TMPDIR=folder))
            wait_until(lambda: {"lss-sim", "lssd", "lss-cli"} <= children(demo.process.pid).keys(), 1100, "it walks")
            left = children(demo.process.pid)
            demo.kill()
            for name in ("lss-sim", "lssd"):
                wait_until(lambda: not os.path.exists(f"/proc/{left[name]}"), 30, f"{name} ends")


if __name__ == "__main__":
    unittest.main()
