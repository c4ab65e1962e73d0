#!/usr/bin/env python3
"""kept_members_test.py HEADER...: without any one member in keep(v), cmake/kept_members.py names it."""
import pathlib
import re
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "cmake"))
sys.dont_write_bytecode = True
import kept_members  # noqa: E402

KEEP = re.compile(r"void keep\(V& v\) \{.*?\n  \}", re.S)

planted = 0
with tempfile.TemporaryDirectory() as folder:
    header = pathlib.Path(folder) / "planted.h"
    for path in sys.argv[1:]:
        text = pathlib.Path(path).read_text(encoding="utf-8")
        assert not list(kept_members.missing(pathlib.Path(path))), f"{path} is not whole itself"
        for member in {name for keep in KEEP.findall(text) for name in re.findall(r"\b\w+_\b", keep)}:
            header.write_text(KEEP.sub(lambda keep: re.sub(rf"\b{member}\b", "0", keep[0]), text), encoding="utf-8")
            found = "\n".join(kept_members.missing(header))
            assert f": {member} is missing" in found, f"{path}: {member} is not missed"
            planted += 1
print(f"{planted} members missed")
sys.exit(0 if planted > 0 else "no header has a keep(v)")
