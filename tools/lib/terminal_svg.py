#!/usr/bin/env python3
"""Draws text from standard input as a terminal window: tools/demo 2>&1 | tools/lib/terminal_svg.py > docs/images/demo.svg"""
import html
import re
import sys

CHARACTER_W, LINE_H, MARGIN, BAR_H = 8.4, 19, 18, 30

lines = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", line.rstrip("\n").split("\r")[-1]) for line in sys.stdin]
columns = max([60] + [len(line) for line in lines])
width, height = columns * CHARACTER_W + 2 * MARGIN, len(lines) * LINE_H + BAR_H + 2 * MARGIN

print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height}" width="{width:.0f}" height="{height}">')
print(f'<rect width="{width:.0f}" height="{height}" rx="8" fill="#14181f"/>')
for i, colour in enumerate(("#e0605e", "#e3b341", "#57ab5a")):
    print(f'<circle cx="{20 + 20 * i}" cy="16" r="6" fill="{colour}"/>')
print('<g font-family="DejaVu Sans Mono, Menlo, Consolas, monospace" font-size="14" fill="#d6dde6" xml:space="preserve">')
for i, line in enumerate(lines):
    if line:
        print(f'<text x="{MARGIN}" y="{BAR_H + MARGIN + i * LINE_H}" textLength="{len(line) * CHARACTER_W:.1f}">{html.escape(line)}</text>')
print("</g>\n</svg>")
