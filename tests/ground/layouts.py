#!/usr/bin/env python3
"""layouts.py SOURCE: the layouts for Foxglove name only fields that a recording and the live topics have (by our IDL), the
topics of ROS that lss-ros makes, and panels that are placed."""
import json
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
TOPICS = {"lss/status": "Status", "lss/event": "Event", "lss/timing_statistics": "TimingStatistics"}


def structs(path):
    """Members of each struct: name to (type, count or None)."""
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    found = {}
    for name, body in re.findall(r"struct\s+(\w+)\s*\{(.*?)\}", text, re.S):
        members = re.findall(r"(?:@key\s+)?([\w ]+?)\s+(\w+)\s*(?:\[(\d+)\])?\s*;", body)
        found[name] = {member: (kind.strip(), int(count) if count else None) for kind, member, count in members}
    return found


def check(path, types, topics):
    """A sentence about a message path that names nothing."""
    topic, *parts = re.fullmatch(r"([\w/]+)((?:\.\w+(?:\[\d+\])?)*)", path).groups()
    if topic not in topics:
        return f"there is no topic {topic}"
    kind = topics[topic]
    for name, index in re.findall(r"\.(\w+)(?:\[(\d+)\])?", parts[0]):
        if name not in types.get(kind, {}):
            return f"{kind} has no {name}"
        kind, count = types[kind][name]
        if index and (count is None or int(index) >= count):
            return f"there is no {name}[{index}]"
        if not index and count is not None and kind != "char":
            return f"{name} is a list"
    return f"{path} is no number" if parts[0] and kind in types else ""


def texts(value):
    if isinstance(value, dict):
        for one in value.values():
            yield from texts(one)
    elif isinstance(value, list):
        for one in value:
            yield from texts(one)
    elif isinstance(value, str):
        yield value


wrong, count = [], 0
ros = "".join(p.read_text(encoding="utf-8") for p in (source / "tools/lss-ros").glob("*.cpp"))
for file in sorted((source / "tools/lss-ground/foxglove").glob("*.json")):
    layout = json.loads(file.read_text(encoding="utf-8"))
    types = structs(source / "idl/lss.idl") | structs(source / f"idl/{file.stem}/{file.stem}.idl")
    topics = TOPICS | {f"lss/telemetry/{file.stem}": f"{file.stem.capitalize()}Telemetry"}
    for panel, config in layout["configById"].items():
        for path in (text for text in texts(config) if text.startswith("lss/")):
            count += 1
            why = check(path, types, topics)
            if why:
                wrong.append(f"{file.name}: {panel}: {path}: {why}")
        named = [*config.get("topics", {}), config.get("topicToRender", "")]
        for topic in filter(None, named):
            count += 1
            if not re.search(rf'["/]{topic.split("/")[-1]}"', ros):
                wrong.append(f"{file.name}: {panel}: lss-ros has no {topic}")
    placed = sorted(text for text in texts(layout["layout"]) if "!" in text)
    if placed != sorted(layout["configById"]):
        wrong.append(f"{file.name}: panels that are not placed, or twice")
print("\n".join(wrong) or f"{count} paths and topics exist")
sys.exit(1 if wrong or count < 60 else 0)
