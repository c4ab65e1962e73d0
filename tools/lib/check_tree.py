#!/usr/bin/env python3
"""check_tree.py RULE [ROOT]: rules for the source tree as a whole. Prints FILE:LINE for each violation."""
import graphlib
import os
import pathlib
import re
import subprocess
import sys

rule = sys.argv[1] if len(sys.argv) > 1 else ""
root = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parents[2])
faults = []
PRODUCT = ("idl", "gnc", "drivers", "daemon")
UNIT = re.compile(r"_(m|m_s|rad|rad_s|s|ns|ns2|A|V|degC)$")
FILTER = pathlib.Path(__file__).with_name("doxygen_filter.awk")


def files(*folders):
    return sorted(path for folder in folders for path in (root / folder).rglob("*") if path.is_file())


def fault(path, line, text):
    faults.append(f"{path.relative_to(root)}:{line}: {text}")


def headers():
    """Every header begins with its purpose; Doxygen takes this as the comment of the file."""
    for path in files(*PRODUCT, "tools"):
        if path.suffix != ".h":
            continue
        seen = subprocess.run(["awk", "-f", FILTER, path], check=True, capture_output=True, text=True).stdout
        if not re.match(r"#pragma once\n\n/// @file\n/// \w", seen):
            fault(path, 3, "say after #pragma once what the file is for")


def languages():
    """All code that runs on the on-board computer is C or C++; DDS types are generated from IDL."""
    for path in files(*PRODUCT):
        if path.suffix not in (".h", ".inc", ".cpp", ".c", ".idl") and path.name != "CMakeLists.txt":
            fault(path, 1, "the product is written in C and C++")


def license_():
    """The license lets anybody use, change and redistribute the sources, and every installation contains it."""
    text = (root / "LICENSE").read_text(encoding="utf-8")
    if not re.match(r"\s*Apache License\s+Version 2\.0", text):
        fault(root / "LICENSE", 1, "is not the Apache License 2.0")
    if "/LICENSE" not in (root / "systemd/CMakeLists.txt").read_text(encoding="utf-8"):
        fault(root / "systemd/CMakeLists.txt", 1, "install LICENSE with the documents")


def units():
    """Every number of the DDS interface that is not a count has its SI unit in its name, or a comment that explains it."""
    for path in files("idl"):
        if path.suffix != ".idl":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            m = re.match(r"\s*(?:float|double) (\w+)(?:\[\d+\])?;( *// \S)?", line)
            if m and not UNIT.search(m[1]) and not m[2]:
                fault(path, number, f"{m[1]}: put its unit into its name, or say here what it means")


def imports():
    """The files of the pilot's page import one another in no circle, types included."""
    page = {path.with_suffix(""): path for path in files("tools/lss-ground/page/src") if path.suffix == ".ts"}
    wants = {name: {pathlib.Path(os.path.normpath(path.parent / other))
                    for other in re.findall(r'\bfrom "(\.[^"]+)"', path.read_text(encoding="utf-8"))}
             for name, path in page.items()}
    try:
        graphlib.TopologicalSorter(wants).prepare()
    except graphlib.CycleError as error:
        circle = error.args[1]
        fault(page[circle[0]], 1, "imports form a circle: " + ", ".join(name.name for name in circle))


RULES = {"headers": headers, "languages": languages, "license": license_, "units": units, "imports": imports}
if rule not in RULES:
    sys.exit(f"usage: check_tree.py {'|'.join(RULES)} [ROOT]")
RULES[rule]()
print(*faults, sep="\n", end="\n" if faults else "")
print(f"{rule}: {len(faults)} violations")
sys.exit(1 if faults else 0)
