#!/usr/bin/env python3
"""kept_members_test.py HEADER...: without any one member in keep(v), cmake/kept_members.py names it and fails."""
import pathlib
import re
import subprocess
import sys
import tempfile

CHECK = pathlib.Path(__file__).parents[2] / "cmake/kept_members.py"
KEEP = re.compile(r"void keep\(V& v\) \{.*?\n  \}", re.S)


def run(folder, text):
    header = folder / "planted.h"
    header.write_text(text, encoding="utf-8")
    return subprocess.run([sys.executable, CHECK, folder / "stamp", header], capture_output=True, text=True)


planted = 0
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    for path in sys.argv[1:]:
        text = pathlib.Path(path).read_text(encoding="utf-8")
        assert run(folder, text).returncode == 0, f"{path} is not whole itself"
        for member in {name for keep in KEEP.findall(text) for name in re.findall(r"\b\w+_\b", keep)}:
            without = KEEP.sub(lambda keep: re.sub(rf"\b{member}\b", "0", keep[0]), text)
            result = run(folder, without)
            assert result.returncode != 0 and f": {member} is missing" in result.stderr, f"{path}: {member} is not missed"
            planted += 1
print(f"{planted} members missed")
sys.exit(0 if planted > 0 else "no header has a keep(v)")
