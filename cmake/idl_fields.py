#!/usr/bin/env python3
"""idl_fields.py IN.idl OUT.h: the members of the C structs that idlc makes of IN.idl, by name, for visitors.

The key of a topic is left out: it names the sender of a sample, and the DDS face sets it.
"""
import pathlib
import re
import sys

MEMBER = re.compile(r"(@key )?(?:[\w:]+ )+(\w+) ?(?:\[ ?\w+ ?\])?")


def members(struct, body):
    for statement in filter(None, (" ".join(part.split()) for part in body.split(";"))):
        match = MEMBER.fullmatch(statement)
        if match is None:
            sys.exit(f"{sys.argv[1]}: {struct}: cannot read '{statement}'")
        if not match[1]:
            yield match[2]


def structs(text):
    """Name and members of each struct; the file is one module of enums and structs."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)
    module = re.fullmatch(r"\s*module (\w+) \{(.*)\};\s*", text, re.S)
    body = module[2] if module else sys.exit(f"{sys.argv[1]}: is not one module")
    definition = re.compile(r"(?:@\w+\s+)*(struct|enum)\s+(\w+)\s*\{(.*?)\}\s*;", re.S)
    rest = definition.sub("", body).split()
    if rest:
        sys.exit(f"{sys.argv[1]}: cannot read '{' '.join(rest[:6])}'")
    for kind, name, inside in definition.findall(body):
        if kind == "struct":
            yield f"{module[1]}_{name}", list(members(name, inside))


source, target = map(pathlib.Path, sys.argv[1:])
text = source.read_text(encoding="utf-8")
idl = f"k_{source.stem}_idl"
out = [f"#pragma once\n\n// Made by cmake/idl_fields.py from {source.name}.\n\n#include <string_view>\n#include <type_traits>\n\n"
       f'#include "{source.stem}.h"\n\ninline constexpr std::string_view {idl} = R"idl({text})idl";\n']
for name, names in structs(text):
    lines = "".join(f'  v("{member}", x.{member});\n' for member in names)
    out.append(f"\ntemplate <class V, class X>\n  requires std::is_same_v<std::remove_const_t<X>, {name}>\n"
               f"constexpr void fields(V& v, X& x) {{\n{lines}}}\n"
               f"constexpr std::string_view idl_of(const {name}&) {{ return {idl}; }}\n")
target.write_text("".join(out), encoding="utf-8")
