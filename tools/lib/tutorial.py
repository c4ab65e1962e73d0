#!/usr/bin/env python3
"""The code in tutorials: blocks after a line with the name of their file.

tutorial.py ROOT                       compares those of docs/tutorial-vehicle.md, parts of files, with examples/scout
tutorial.py ROOT --write FOLDER PAGE   writes those of another page, whole files, to FOLDER, as a reader would
"""

import pathlib
import re
import sys

BLOCK = re.compile(r"^`(?P<name>[\w./-]+)`:\n\n```\w*\n(?P<text>.*?)^```$", re.M | re.S)


def main(root, option="--check", folder=None, page="docs/tutorial-vehicle.md"):
    root = pathlib.Path(root)
    text = (root / page).read_text(encoding="utf-8")
    blocks = [(found["name"], found["text"]) for found in BLOCK.finditer(text)]
    if option == "--write":
        for name, content in blocks:
            pathlib.Path(folder, name).write_text(content, encoding="utf-8")
        return 0
    example = root / "examples/scout"
    files = {path.name: path.read_text(encoding="utf-8") for path in sorted(example.iterdir()) if path.is_file()}
    faults = [f"{page} does not name {name}" for name in files if f"`{name}`" not in text]
    faults += [f"{page} has lines as from {name} that are not in {example.relative_to(root)}"
               for name, content in blocks if content not in files.get(name, "")]
    for fault in faults:
        print(fault)
    lines = sum(1 for content in files.values() for line in content.splitlines()
                if line.strip() and not line.strip().startswith(("//", "#", "*")))
    print(f"examples/scout has {lines} lines of code")
    if lines > 600:
        print("more than 600: move what other vehicles can use to daemon/kit or tools/lss-sim/canopen")
    return 1 if faults or lines > 600 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
