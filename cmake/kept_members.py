#!/usr/bin/env python3
"""kept_members.py STAMP HEADER...: every class with keep(v) names all its members there (daemon/record/state.h).

A member without state is a pointer, or the comment behind its declaration contains "no state". Prints FILE:LINE for each
member that is missing; writes STAMP when there is none. Members are what ends in an underscore, as in all of this tree.
"""
import pathlib
import re
import sys


def end_of_block(text, at):
    """The place behind the brace that closes the block whose content begins at `at`."""
    depth = 1
    while depth:
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        at += 1
    return at


def blanked(text):
    """Without comments; every character stays at its place."""
    return re.sub(r"//.*", lambda comment: " " * len(comment[0]), text)


def declarations(text, begin, end):
    """(place, statement) of the class body itself: without functions' bodies, initialisers and nested classes."""
    depth, statement, at = 0, "", begin
    for place in range(begin, end):
        character = text[place]
        if character in ")}":
            depth -= 1
        if depth == 0 and character == ";":
            yield at, statement
            statement, at = "", place + 1
        elif depth == 0 and character not in ")}":
            statement += character
        elif character == "}" and depth == 0 and "(" in statement:  # a function
            statement, at = "", place + 1
        if character in "({":
            depth += 1


def missing(path):
    source = path.read_text(encoding="utf-8")
    text = blanked(source)
    lines = source.splitlines()
    for keep in re.finditer(r"void keep\(V& v\) \{", text):
        named = set(re.findall(r"\w+_\b", text[keep.end():end_of_block(text, keep.end())]))
        begin, end = [(found.end(), end_of_block(text, found.end()) - 1)
                      for found in re.finditer(r"\b(?:class|struct) \w+[^;{()]*\{", text[:keep.start()])
                      if end_of_block(text, found.end()) > keep.start()][-1]
        for at, statement in declarations(text, begin, end):
            if "(" in statement or "*" in statement or re.match(r"\s*(using|friend|static)\b", statement):
                continue
            for member in re.finditer(r"\b[a-z]\w*_(?=\s*(?:[,={]|$))", statement):
                place = text.index(member[0], at)
                number = text.count("\n", 0, place)
                if member[0] not in named and "no state" not in lines[number]:
                    yield f"{path}:{number + 1}: {member[0]} is missing in keep(v)"


if __name__ == "__main__":
    stamp, *headers = map(pathlib.Path, sys.argv[1:])
    faults = [fault for header in headers for fault in missing(header)]
    if faults:
        sys.exit("\n".join(faults) + "\nname it there, or say behind its declaration why it has \"no state\"")
    stamp.touch()
