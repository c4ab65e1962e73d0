"""HTML pages as shown by a browser, and the content of a picture. Needs only Debian's Chromium."""

import html.parser
import os
import shutil
import struct
import subprocess
import zlib

BROWSER = shutil.which("chromium")
COLOURS_OF_A_CHART = 12


def screenshot(page, picture, width=1280, height=2200, dark=False):
    words = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage",
             "--virtual-time-budget=1000", f"--user-data-dir={picture}.profile", f"--window-size={width},{height}",
             f"--screenshot={picture}"]
    if dark:
        words.append("--blink-settings=preferredColorScheme=0")
    subprocess.run([*words, "file://" + os.path.abspath(page)], check=True, timeout=90,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def read_png(path):
    """Width, height, and rows of (red, green, blue) of a PNG with eight bits and no interlacing."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            assert bits == 8 and colour in (2, 6) and interlaced == 0
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    step = 3 if colour == 2 else 4
    raw, rows, before = zlib.decompress(packed), [], bytearray(width * step)
    for y in range(height):
        begin = y * (width * step + 1)
        row = bytearray(raw[begin + 1:begin + 1 + width * step])
        unfilter(raw[begin], row, before, step)
        rows.append(row)
        before = row
    return width, height, [[bytes(row[x:x + 3]) for x in range(0, len(row), step)] for row in rows]


def unfilter(kind, row, before, step):
    for x in range(len(row) if kind else 0):
        left = row[x - step] if x >= step else 0
        up = before[x]
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        else:
            corner = before[x - step] if x >= step else 0
            base = left + up - corner
            guess = min((left, up, corner), key=lambda near: abs(base - near))
        row[x] = (row[x] + guess) & 255


def shares(path):
    """How much of a picture each colour has; every third row and column."""
    _, _, rows = read_png(path)
    counts = {}
    for row in rows[::3]:
        for pixel in row[::3]:
            counts[pixel] = counts.get(pixel, 0) + 1
    total = sum(counts.values())
    return {colour: count / total for colour, count in counts.items()}


class Page(html.parser.HTMLParser):
    """Content of a page: titles, the words in figures, and every external reference."""

    VOID = ("meta", "line", "path", "rect", "br", "img", "link", "i")

    def __init__(self, text):
        super().__init__()
        self.open, self.captions, self.words, self.references = [], [], [], []
        self.boxes, self.shapes = [], 0
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.references += [attributes[name] for name in ("src", "href") if name in attributes]
        self.shapes += tag in ("path", "rect")
        if tag not in self.VOID:
            self.open.append((tag, attributes))

    def handle_startendtag(self, tag, attributes):
        self.references += [value for name, value in attributes if name in ("src", "href")]
        self.shapes += tag in ("path", "rect")

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open and self.open[-1][0] == tag, f"</{tag}> after {self.open[-1:]}"
            self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1][0] == "figcaption":
            self.captions.append(data)
        elif self.open and self.open[-1][0] == "text":
            self.words.append(data)
