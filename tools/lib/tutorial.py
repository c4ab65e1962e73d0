#!/usr/bin/env python3
"""The code of docs/tutorial-vehicle.md: its blocks with a file name are the files of examples/scout.

tutorial.py ROOT [--update]       compares them with the files, or takes them from the files
tutorial.py ROOT --write FOLDER [PAGE]   writes them, or those of another page, to FOLDER, as a reader would
"""

import pathlib
import re
import sys

BLOCK = re.compile(r"(^`(?P<name>[\w./-]+)`:\n\n```(?P<kind>\w*)\n)(?P<text>.*?)(^```$)", re.M | re.S)


def main(root, option="--check", folder=None, page="docs/tutorial-vehicle.md"):
    root = pathlib.Path(root)
    page, example = root / page, root / "examples/scout"
    text = page.read_text(encoding="utf-8")
    blocks = {found["name"]: found["text"] for found in BLOCK.finditer(text)}
    if option == "--write":
        for name, content in blocks.items():
            pathlib.Path(folder, name).write_text(content, encoding="utf-8")
        return 0
    files = {path.name: path.read_text(encoding="utf-8") for path in sorted(example.iterdir()) if path.is_file()}
    missing = sorted(set(files) - set(blocks)) + sorted(set(blocks) - set(files))
    for name in missing:
        print(f"{name}: in one of {example.relative_to(root)} and {page.relative_to(root)} only")
    if option == "--update" and not missing:
        page.write_text(BLOCK.sub(lambda b: b[1] + files[b["name"]] + b[5], text), encoding="utf-8")
        return 0
    differ = [name for name in blocks if name in files and blocks[name] != files[name]]
    for name in differ:
        print(f"{name}: differs; take it from the file with: python3 tools/lib/tutorial.py . --update")
    lines = sum(1 for content in files.values() for line in content.splitlines()
                if line.strip() and not line.strip().startswith(("//", "#", "*")))
    print(f"examples/scout has {lines} lines of code")
    if lines > 600:
        print("more than 600: move what other vehicles can use to daemon/kit or tools/lss-sim/canopen")
    return 1 if missing or differ or lines > 600 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
