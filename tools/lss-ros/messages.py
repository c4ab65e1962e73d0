"""messages.py messages.txt FOLDER: makes from the definitions of ROS messages

ros_types.idl: the types as on the wire, for idlc -t; services with the header of rmw_cyclonedds.
ros_messages.h: plain C++ structs whose each(self, visit) visits their members in order.
ros_messages.inc: LSS_ROS_TYPE(package, kind, name, RIHS01 hash, definition with those that it contains) for each type
that is sent alone.
ros_to_c.inc: to_c(from, to, arena) from each C++ struct to the struct that idlc makes."""

import hashlib
import json
import re
import sys

# Name in .msg: name in IDL, in C++, and number in a type description (type_description_interfaces/msg/FieldType).
PRIMITIVES = {
    "bool": ("boolean", "bool", 15), "byte": ("octet", "std::uint8_t", 16), "char": ("octet", "std::uint8_t", 3),
    "uint8": ("octet", "std::uint8_t", 3), "int32": ("long", "std::int32_t", 6),
    "uint32": ("unsigned long", "std::uint32_t", 7), "uint64": ("unsigned long long", "std::uint64_t", 9),
    "int64": ("long long", "std::int64_t", 8), "float32": ("float", "float", 10), "float64": ("double", "double", 11),
    "string": ("string", "std::string", 17)}
BOUNDED_STRING = 21
ARRAY, SEQUENCE = 48, 144  # added to the number of the element's type


class Field:
    def __init__(self, line):
        found = re.fullmatch(r"([\w/]+)(?:<=(\d+))?(?:\[(\d*)\])?\s+(\w+)", line)
        if not found:
            raise SystemExit(f"messages.txt: cannot read '{line}'")
        self.type, bound, count, self.name = found.groups()
        self.bound = int(bound or 0)
        self.is_sequence = count == ""
        self.count = int(count) if count else 0
        self.nested = None if self.type in PRIMITIVES else self.type.replace("/", "/msg/")

    def description(self):
        number = 1 if self.nested else PRIMITIVES[self.type][2]
        if self.bound:
            number = BOUNDED_STRING
        number += SEQUENCE if self.is_sequence else ARRAY if self.count else 0
        return {"name": self.name, "type": {"type_id": number, "capacity": self.count, "string_capacity": self.bound,
                                            "nested_type_name": self.nested or ""}}

    def idl(self):
        kind = "::".join(self.nested.split("/")[:2] + ["dds_", self.nested.split("/")[2] + "_"]) if self.nested \
            else PRIMITIVES[self.type][0]  # the bound of a string is not on the wire
        kind = f"sequence<{kind}>" if self.is_sequence else kind
        return f"    {kind} {self.name}{f'[{self.count}]' if self.count else ''};\n"

    def cpp(self):
        kind = self.nested.replace("/msg/", "::") if self.nested else PRIMITIVES[self.type][1]
        if self.is_sequence:
            kind = f"std::vector<{kind}>"
        elif self.count:
            kind = f"std::array<{kind}, {self.count}>"
        return f"  {kind} {self.name}{{}};\n"


def read(path):
    types = {}
    with open(path, encoding="utf-8") as file:
        for line in file.read().splitlines():
            if line.startswith("==="):
                fields = types.setdefault(line[3:].strip(), [])
            elif line and not line.startswith("#"):
                fields.append(line)
    return types


def contained(types, name):
    """The types in a type, each once, in the order in which they are met."""
    found = []
    for field in types[name]:
        if field.nested:
            found += [n for n in [field.nested, *contained(types, field.nested)] if n not in found]
    return found


def rihs01(types, name):
    def describe(one):
        fields = types[one] or [Field("uint8 structure_needs_at_least_one_member")]
        return {"type_name": one, "fields": [field.description() for field in fields]}
    whole = {"type_description": describe(name),
             "referenced_type_descriptions": [describe(one) for one in sorted(contained(types, name))]}
    return hashlib.sha256(json.dumps(whole).encode()).hexdigest()


def idl_of(name, fields):
    package, kind, plain = name.split("/")
    members = "".join(field.idl() for field in fields) or "    octet structure_needs_at_least_one_member;\n"
    if kind == "srv":  # before each request and reply
        members = "    unsigned long long rmw_client;\n    long long rmw_sequence;\n" + members
    return f"module {package} {{ module {kind} {{ module dds_ {{\n  @final struct {plain}_ {{\n{members}  }};\n}}; }}; }};\n"


def cpp_of(name, fields):
    package, _, plain = name.split("/")
    body = "".join(field.cpp() for field in fields) or "  std::uint8_t structure_needs_at_least_one_member{};\n"
    names = [field.name for field in fields] or ["structure_needs_at_least_one_member"]
    visits = " ".join(f"visit(self.{one});" for one in names)
    return (f"namespace {package} {{\nstruct {plain} {{\n  static constexpr const char* kName = \"{name}\";\n{body}"
            f"  template <class Self, class Visit>\n  static void each(Self& self, Visit visit) {{ {visits} }}\n}};\n}}\n")


def to_c_of(name, fields):
    package, kind, plain = name.split("/")
    body = "".join(f"  to_c(from.{field.name}, to.{field.name}, arena);\n" for field in fields)
    unused = "" if fields else "[[maybe_unused]] "
    return (f"{package}_{kind}_dds__{plain}_ c_struct_of(const {package}::{plain}&);  // for decltype\n"
            f"inline void to_c({unused}const {package}::{plain}& from, {unused}{package}_{kind}_dds__{plain}_& to, "
            f"{unused}Arena& arena) {{\n{body}}}\n")


def alone(types, texts, name):
    parts = ["\n".join(texts[name])]
    parts += [f"MSG: {one.replace('/msg/', '/')}\n" + "\n".join(texts[one]) for one in contained(types, name)]
    text = ("\n" + "=" * 80 + "\n").join(parts) + "\n"
    package, kind, plain = name.split("/")
    return f'LSS_ROS_TYPE({package}, {kind}, {plain}, "{rihs01(types, name)}", R"msg({text})msg")\n'


def main(source, folder):
    texts = read(source)
    types = {name: [Field(line) for line in lines] for name, lines in texts.items()}
    inner = {one for name in types for one in contained(types, name)}
    def write(name, text):
        with open(f"{folder}/{name}", "w", encoding="utf-8") as out:
            out.write("// Made by messages.py.\n" + text)

    write("ros_types.idl", "".join(idl_of(*one) for one in types.items()))
    write("ros_messages.h", "#pragma once\n#include <array>\n#include <cstdint>\n#include <string>\n#include <vector>\n"
          "namespace lss::ros {\n" + "".join(cpp_of(*one) for one in types.items()) + "}  // namespace lss::ros\n")
    write("ros_to_c.inc", "".join(to_c_of(*one) for one in types.items()))
    write("ros_messages.inc", "".join(alone(types, texts, name) for name in types
                                      if name not in inner or name == "geometry_msgs/msg/Twist"))  # in TwistStamped, too


main(*sys.argv[1:])
