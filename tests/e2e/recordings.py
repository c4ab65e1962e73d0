"""Tests of a recording of any vehicle: read by us and by others, exported, plotted."""

import csv
import json
import os
import re
import shutil
import subprocess

import pictures
import programs
from programs import wait_until
from rig import HERE, TOOLS

# That of the page, whose npm packages the readers of others are.
PAGE = os.path.dirname(os.path.dirname(os.environ.get("LSS_E2E_PLAYWRIGHT", "")))


def foreign(test, program, *arguments):
    """The lines that a program in JavaScript prints, which has the npm packages of the page."""
    if shutil.which("node") is None or not os.path.exists(os.path.join(PAGE, "node_modules/@foxglove/rosmsg")):
        test.skipTest("nothing is read by code of others: target lss-ground-page was not built")
    # node looks for the packages from its working folder.
    with open(os.path.join(HERE, program), encoding="utf-8") as text:
        result = subprocess.run(["node", "--input-type=module", "-", *arguments], cwd=PAGE, stdin=text,
                                timeout=60 * programs.patience, capture_output=True, text=True)
    test.assertEqual(result.returncode, 0, result.stderr)
    return result.stdout.splitlines()


def same(ours, theirs):
    """The same values; they have characters as numbers or text, we have text up to its end."""
    if isinstance(ours, str):
        if isinstance(theirs, list):
            theirs = "".join(c if isinstance(c, str) else chr(c) for c in theirs)
        return ours == theirs.split("\0")[0]
    if isinstance(ours, dict):
        return ours.keys() == theirs.keys() and all(same(ours[k], theirs[k]) for k in ours)
    if isinstance(ours, list):
        return len(ours) == len(theirs) and all(same(a, b) for a, b in zip(ours, theirs))
    if isinstance(ours, float):  # theirs is without an exponent, and not all of its digits count
        return ours == float(theirs)
    return ours == theirs


class Recorded:
    """Mixed into a Scenario: `self.recording` is the file."""

    def record(self, *words, name="record"):
        """Begins; returns when messages of the telemetry are in the file."""
        self.recording = os.path.join(self.folder, "run.mcap")
        client = self.begin_cli("--json", "record", "--out", self.recording, *words, name=name)

        def comes():
            listed = self.cli("--json", "log", "list", self.recording)
            topics = json.loads(listed.out).get("topics", []) if listed.code == 0 else []
            return any("telemetry" in t["topic"] and t["messages"] > 0 for t in topics)
        wait_until(lambda: client.running() and comes(), 20, "telemetry is recorded")
        return client

    def listed(self, path=None):
        return json.loads(self.cli_ok("--json", "log", "list", path or self.recording).out)

    def shown(self, *words):
        lines = self.cli_ok("log", "show", self.recording, *words).out.splitlines()
        return [json.loads(line) for line in lines]

    def assert_others_read_the_same(self):
        *theirs, last = [json.loads(line) for line in foreign(self, "decode.mjs", self.recording)]
        everything = self.shown()
        ours = [m for m in everything if not m["topic"].startswith("/")]
        end = last["end"]
        of_ros = [m for m in theirs if m["topic"].startswith("/")]
        theirs = [m for m in theirs if not m["topic"].startswith("/")]
        self.assertTrue(end["done"])
        self.assertEqual({end["counted"], end["streamed"], end["statistics"]}, {len(everything)})
        self.assertTrue(end["library"].startswith("lss-cli"))
        self.assertEqual([m["name"] for m in end["metadata"]][:1], ["lss"])
        order = lambda m: (m["log_ns"], m["topic"], m["publish_ns"], m["sequence"])
        ours.sort(key=order)
        theirs.sort(key=order)
        values = 0
        for our, their in zip(ours, theirs):
            for field in ("topic", "sequence", "log_ns", "publish_ns"):
                self.assertEqual(our[field], their[field])
            self.assertTrue(same(our["data"], their["data"]), f"{our}\n{their}")
            values += 1
        print(f"{values} messages are the same, decoded by others")
        self.assertGreater(values, 50)
        return of_ros, end

    def assert_csv_says_the_same(self):
        path = os.path.join(self.folder, "run.csv")
        self.cli_ok("log", "export", self.recording, "--topic", "telemetry", "--out", path)
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        shown = self.shown("--topic", "telemetry")
        self.assertEqual(len(rows), len(shown))
        for row, message in zip(rows, shown):
            for name, text in row.items():
                if name == "t_s":
                    continue
                value = message if name in message else message["data"]
                for part in re.findall(r"[^.\[\]]+", name):
                    value = value[int(part) if part.isdigit() else part]
                if isinstance(value, str):
                    self.assertEqual(text, value, name)
                elif value is None:
                    self.assertEqual(text, "", name)
                else:
                    self.assertEqual(json.loads(text), value, name)  # true is 1
        # Between rows: times on the command line are rounded.
        times_s = [float(row["t_s"]) for row in rows]
        begin_s, end_s = ((times_s[i - 1] + times_s[i]) / 2 for i in (len(rows) // 4, len(rows) // 2))
        few = self.cli_ok("log", "export", self.recording, "--topic", "telemetry", "--columns", "time_ns,*_m*",
                          "--from", f"{begin_s:.6f}", "--to", f"{end_s:.6f}s").out.splitlines()
        self.assertTrue(few[0].startswith("t_s,log_ns,publish_ns,sequence,time_ns"))
        self.assertEqual([float(line.split(",")[0]) for line in few[1:]], times_s[len(rows) // 4:len(rows) // 2])
        self.assertGreater(len(few), 1)

    def assert_page_shows(self, *captions):
        path = os.path.join(self.folder, "run.html")
        self.cli_ok("report", self.recording, "--out", path)
        with open(path, encoding="utf-8") as file:
            page = pictures.Page(file.read())
        self.assertEqual(page.references, [], "it needs nothing else")
        for caption in captions:
            self.assertIn(caption, page.captions)
        self.assertGreater(page.shapes, 20)
        self.assertFalse([word for word in page.words if "nan" in word.lower() or "inf" in word.lower()])
        kept = os.environ.get("LSS_E2E_PICTURES")
        if kept:
            os.makedirs(kept, exist_ok=True)
            shutil.copy(path, kept)
            shutil.copy(self.recording, kept)
        if pictures.BROWSER is None:
            self.skipTest("no picture is taken: chromium is not installed (tools/packages.txt, group show)")
        picture = os.path.join(self.folder, "run.png")
        pictures.screenshot(path, picture)
        colours = pictures.shares(picture)
        print(len(colours), "colours; the most", sorted(colours.values())[-3:])
        self.assertGreater(len(colours), pictures.COLOURS_OF_A_CHART)
        self.assertGreater(1 - max(colours.values()), 0.03, "it is not blank")
        self.assertGreater(sum(share for colour, share in colours.items() if max(colour) - min(colour) > 60), 0.001,
                           "there are lines and bars")

    def assert_plot(self, signals, ending):
        path = os.path.join(self.folder, "run" + ending)
        done = json.loads(self.cli_ok("--json", "plot", self.recording, "--signals", signals, "--out", path).out)
        with open(path, "rb") as file:
            begin = file.read()
        self.assertTrue(begin.startswith(b"\x89PNG" if ending == ".png" else b"<?xml"))
        if ending == ".svg":
            for name in done["signals"]:
                self.assertIn(name.encode(), begin)
        self.assertGreater(len(begin), 5000)
        return done["signals"]
