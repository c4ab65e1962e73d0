"""Recordings (*.lssrec), read and written again from docs/recording.md alone: to look into them, and to alter them
so that only a replay detects it."""

import json
import struct

PROLOGUE = 16
HEAD = struct.Struct("<4sIIII")  # magic, kind, index, size, crc of what is before
BEGIN, ITEMS, END = 1, 2, 3
FRAME, STATE, LOST = 1, 2, 3


def _table():
    table = []
    for i in range(256):
        for _ in range(8):
            i = i >> 1 ^ (0x82F63B78 if i & 1 else 0)
        table.append(i)
    return table


TABLE = _table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def read(path):
    """(header, [(kind, bytes), ...] of all items, whether it was ended). Checksums are lssd's to check."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89LSSREC\n", path
    at, header, items = PROLOGUE, None, []
    while at + HEAD.size <= len(data):
        magic, kind, _, size, _ = HEAD.unpack_from(data, at)
        if magic != b"LSSc" or at + HEAD.size + size + 8 > len(data):
            break
        payload = data[at + HEAD.size:at + HEAD.size + size]
        at += HEAD.size + size + 8
        if kind == BEGIN:
            header = json.loads(payload)
        elif kind == END:
            return header, items, True
        else:
            begin = 0
            while begin < size:
                item, length = struct.unpack_from("<II", payload, begin)
                items.append((item, payload[begin + 8:begin + 8 + length]))
                begin += 8 + length
    return header, items, False


def write(path, header, items):
    """A file without an end, with all checksums as they should be."""
    def chunk(index, kind, payload):
        head = struct.pack("<4sIII", b"LSSc", kind, index, len(payload))
        head += struct.pack("<I", crc32c(head))
        return head + payload + struct.pack("<I", crc32c(head + payload)) + b"cSSL"

    start = b"\x89LSSREC\n" + struct.pack("<I", 1)
    with open(path, "wb") as file:
        file.write(start + struct.pack("<I", crc32c(start)))
        file.write(chunk(0, BEGIN, json.dumps(header).encode()))
        for index, (kind, payload) in enumerate(items):
            file.write(chunk(index + 1, ITEMS, struct.pack("<II", kind, len(payload)) + payload))


class Schema:
    """Reads records by the text in the header: {"in": {"frame": 1, ...}, ...}. Where members are, too."""

    def __init__(self, text):
        self.text = text
        self.at = 0
        self.members = self._members("")

    def _members(self, end):
        members = []
        while self.at < len(self.text) and self.text[self.at] != end:
            colon = self.text.index(":", self.at)
            name, self.at = self.text[self.at:colon], colon + 1
            members.append((name, self._type()))
            assert self.text[self.at] == ";"
            self.at += 1
        return members

    def _type(self):
        first = self.text[self.at]
        if first == "{":
            self.at += 1
            members = self._members("}")
            self.at += 1
            return "struct", members
        if first == "[":
            end = self.text.index("]", self.at)
            count, self.at = int(self.text[self.at + 1:end]), end + 1
            return "array", count, self._type()
        if first == "<":
            self.at += 1
            element = self._type()
            self.at += 1
            return "list", element
        if first == "(":
            choices = []
            while self.text[self.at] != ")":
                self.at += 1
                choices.append(self._type())
            self.at += 1
            return "one of", choices
        word, self.at = self.text[self.at:self.at + 2], self.at + 2
        return "number", word

    FORMATS = {"i1": "b", "i2": "h", "i4": "i", "i8": "q", "u1": "B", "u2": "H", "u4": "I", "u8": "Q", "f4": "f",
               "f8": "d", "b1": "?", "c1": "c"}

    def read(self, record):
        """(values, {"path.of.member": (offset, size)})"""
        places = {}

        def value(kind, at, path):
            if kind[0] == "number":
                code = struct.Struct("<" + self.FORMATS[kind[1]])
                places[path] = (at, code.size)
                return code.unpack_from(record, at)[0], at + code.size
            if kind[0] == "struct":
                return struct_of(kind[1], at, path)
            if kind[0] == "one of":
                inner, at = value(kind[1][record[at]], at + 1, path)
                return inner, at
            count, element = (kind[1], kind[2]) if kind[0] == "array" else (
                struct.unpack_from("<I", record, at)[0], kind[1])
            at += 0 if kind[0] == "array" else 4
            values = []
            for i in range(count):
                inner, at = value(element, at, f"{path}[{i}]")
                values.append(inner)
            return values, at

        def struct_of(members, at, path):
            values = {}
            for name, kind in members:
                values[name], at = value(kind, at, f"{path}.{name}" if path else name)
            return values, at

        values, end = struct_of(self.members, 0, "")
        assert end == len(record), (end, len(record))
        return values, places
