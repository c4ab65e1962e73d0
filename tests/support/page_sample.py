"""page_sample.py PROGRAM PAGE COUNT-OPTION COUNT: makes a part of a generated page again and compares. The page says which
command made it; the same command with COUNT of its numbers must give tables with the same rows, every number within that
of the whole. Which numbers: LSS_SAMPLE, others at each commit."""

import os
import re
import shlex
import subprocess
import sys
import tempfile

# Columns whose number the whole bounds from below, and those that say nothing about a part.
LEAST = {"least"}
SKIPPED = {"5 %", "median", "95 %", "times real time, by one CPU"}
EQUAL = {"must be within"}


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def tables(text):
    """{first column: {row: {column: number}}}; columns without numbers are left out."""
    found, head, rows = {}, None, {}
    for line in [*text.split("\n"), ""]:
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else None
        if cells is None:
            if head:
                found[", ".join(head)] = rows
            head, rows = None, {}
        elif head is None:
            head = cells
        elif not set(line) <= set("|-: "):
            numbers = {}
            for column, cell in zip(head[1:], cells[1:], strict=True):
                number = re.fullmatch(r"\**(-?[\d.]+)\**( [a-z]+)?", cell)
                if number:
                    numbers[column] = float(number[1])
            rows[cells[0]] = numbers
    return found


def compared(part, whole):
    """What is wrong."""
    wrong = []
    if part.keys() != whole.keys():
        return [f"its tables are {list(part)}, those of the page {list(whole)}"]
    for name, rows in part.items():
        if rows.keys() != whole[name].keys():
            wrong.append(f"rows that the page lacks or has more: {sorted(rows.keys() ^ whole[name].keys())}")
        for row in rows.keys() & whole[name].keys():
            for column, number in rows[row].items():
                of_page = whole[name][row].get(column)
                if column in SKIPPED:
                    continue
                within = of_page is not None and (number >= of_page if column in LEAST else
                                                  number == of_page if column in EQUAL else number <= of_page)
                if not within:
                    wrong.append(f"{row}, {column}: {number:g}, on the page {of_page}")
        satisfied = [row for row in rows if "all satisfied" in rows[row] and
                     rows[row]["all satisfied"] != rows[row]["scenarios"]]
        wrong += [f"{row}: not all satisfied" for row in satisfied]
    return wrong


def main():
    program, page, count_option, samples = sys.argv[1:]
    text = read(page)
    words = shlex.split(re.search(r"^Made by `([^`]+)`", text, re.MULTILINE)[1])
    options = dict(zip(words[1::2], words[2::2], strict=True))
    count, first = int(options.pop(count_option)), int(options.pop("--first"))
    del options["--markdown"]
    begin = first + int(os.environ.get("LSS_SAMPLE", 0)) % (count - int(samples) + 1)
    with tempfile.TemporaryDirectory() as folder:
        part = os.path.join(folder, "page.md")
        command = [program, *(word for pair in options.items() for word in pair), "--first", str(begin),
                   count_option, samples, "--markdown", part]
        print(shlex.join(command), flush=True)
        done = subprocess.run(command, check=False)
        wrong = [f"exit code {done.returncode}"] if done.returncode else []
        wrong += compared(tables(read(part)), tables(text))
    print("\n".join(wrong) or "as on the page")
    if wrong:
        print(f"the page is out of date: {shlex.join(words)}")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
