"""The README's first command, in the tree as it is."""

import os
import re
import unittest

from programs import run
from rig import SOURCE


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


if __name__ == "__main__":
    unittest.main()
