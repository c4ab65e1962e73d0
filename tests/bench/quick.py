"""quick.py LSS-BENCH ROW...: `lss-bench --quick --json` measures these rows, or says why it cannot. Never how fast."""

import json
import math
import subprocess
import sys

NUMBERS = ["value", "reference", "ratio", "aa_ratio", "goal"]
FIELDS = ["row", "figure", "unit", *NUMBERS, "met", "note"]


def check(condition, what):
    if not condition:
        sys.exit(f"not so: {what}")


def check_figure(figure):
    check(list(figure) == FIELDS, f"{figure} has the fields {FIELDS}")
    for name in NUMBERS:
        number = figure[name]
        check(number is None or math.isfinite(number), f"{figure} has a number in {name}")
    if figure["value"] is None:
        check(figure["note"].startswith("not measured: "), f"{figure} is measured or says why not")
        check(figure["met"] is None, f"{figure} is not judged without a value")
    else:
        check(figure["value"] >= 0 or "offset" in figure["figure"], f"{figure} is a size")
        check((figure["met"] is None) == (figure["goal"] is None), f"{figure} is judged by its goal")
        check(figure["met"] in (None, "yes", "no", "undecided"), f"{figure} has a verdict")


def main():
    program, *rows = sys.argv[1:]
    done = subprocess.run([program, "--quick", "--json", "--row", ",".join(rows)], stdout=subprocess.PIPE, check=False)
    check(done.returncode == 0, f"exit code {done.returncode} is 0")
    figures = json.loads(done.stdout)
    for figure in figures:
        check_figure(figure)
    seen = list(dict.fromkeys(figure["row"] for figure in figures))
    check(seen == rows, f"{seen} are the rows {rows}")
    measured = sum(figure["value"] is not None for figure in figures)
    print(f"{measured} of {len(figures)} figures measured")


main()
