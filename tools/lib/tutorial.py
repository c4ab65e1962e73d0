#!/usr/bin/env python3
"""tutorial.py ROOT: tutorials name every file of their example, and blocks of code after the name of a file are parts of it."""

import pathlib
import re
import sys

EXAMPLES = {"docs/tutorial-vehicle.md": "examples/scout", "docs/tutorial-client.md": "examples/client"}
BLOCK = re.compile(r"^`(?P<name>[\w./-]+)`:\n\n```\w*\n(?P<text>.*?)^```$", re.M | re.S)


def main(root):
    root = pathlib.Path(root)
    faults = []
    for page, example in EXAMPLES.items():
        text = (root / page).read_text(encoding="utf-8")
        files = {path.name: path.read_text(encoding="utf-8") for path in sorted((root / example).iterdir()) if path.is_file()}
        faults += [f"{page} does not name {name}" for name in files if f"`{name}`" not in text]
        faults += [f"{page}: the block of {found['name']} is no part of it in {example}" for found in BLOCK.finditer(text)
                   if found["text"] not in files.get(found["name"], "")]
        lines = sum(1 for content in files.values() for line in content.splitlines()
                    if line.strip() and not line.strip().startswith(("//", "#", "*")))
        print(f"{example} has {lines} lines of code")
        if lines > 600:
            faults.append("more than 600: move what other vehicles can use to daemon/kit or tools/lss-sim/canopen")
    print(*faults, sep="\n", end="\n" if faults else "")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
