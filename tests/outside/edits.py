#!/usr/bin/env python3
"""edits.py CMAKE BUILD EXAMPLE FOLDER: a telemetry field, a command, a parameter and a fault, each added to a copy of the
scout by the edits below and nothing else, are then everywhere: DDS, JSON, CSV, MCAP, flight recording, replay, dictionary.
"""

import glob
import json
import os
import shutil
import subprocess
import sys
import time

# What is added: where, after which line, the new line.
EDITS = {
    "field": [
        ("scout.idl", "    double yaw_rad;", "    double course_rad;             // right is positive"),
        ("vehicle.cpp", "  out.yaw_rad = yaw_rad_;", "  out.course_rad = -yaw_rad_;"),
    ],
    "command": [
        ("commands.h", "inline constexpr CommandInfo kCommands[] = {",
         '    {402, "halt", Access::holder, true, "stand still, motors on", {}},'),
        ("modes.cpp", "constexpr std::array kEvents = {", '    lc::EventInfo{lc::vehicle_event(9), "halt", true, 0, 402},'),
        ("modes.cpp", "constexpr std::array kRows = {",
         "    lc::Row{lc::vehicle_event(9), kOperational, in_mode(Mode::driving), 0, kKeep, State::operational,"
         " kKeep, kKeep, kHalt},"),
    ],
    "parameter": [
        ("vehicle.cpp", "constexpr std::array kTunables{",
         '    tunable<&Parameters::gear>("body.gear", "", 1, 1000, Change::at_rest, "of each wheel"),'),
    ],
    "fault": [
        ("commands.h", "inline constexpr CodeInfo kFaults[] = {",
         '    {501, "too_fast", 3, "the scout is too fast", "drive slower, then: lss-cli solve"},'),
        ("vehicle.cpp", "  const auto mode = static_cast<Mode>(s.controller().mode);",
         "  if (measured_m_s_ > 0.35) s.raise(FaultId{501});"),
    ],
}


def check(fact, what):
    print(f"{'yes' if fact else 'NO '}  {what}", flush=True)
    if not fact:
        sys.exit(1)


def must(*words, **options):
    result = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
    if result.returncode != options.get("code", 0):
        print(result.stdout[-3000:], result.stderr[-3000:])
        sys.exit(f"failed with {result.returncode}: {' '.join(words)}")
    return result.stdout


def edit(folder):
    for what, places in EDITS.items():
        for name, after, line in places:
            path = os.path.join(folder, name)
            with open(path, encoding="utf-8") as file:
                text = file.read()
            if text.count(after + "\n") + text.count(after + "  //") + text.count(after + " ") < 1:
                sys.exit(f"{what}: {name} has no line '{after}'")
            at = text.index("\n", text.index(after)) + 1
            with open(path, "w", encoding="utf-8") as file:
                file.write(text[:at] + line + "\n" + text[at:])
        print(f"{what}: {len(places)} edit{'s' if len(places) > 1 else ''}")


def build(cmake, tree, example, folder):
    shutil.rmtree(folder, ignore_errors=True)
    must(cmake, "--install", tree, "--component", "dev", "--prefix", f"{folder}/usr")
    shutil.copytree(example, f"{folder}/scout")
    edit(f"{folder}/scout")
    options = ["-DBUILD_TESTING=OFF", f"-DCMAKE_PREFIX_PATH={folder}/usr", "-DCMAKE_BUILD_TYPE=Release"]
    if shutil.which("ninja"):
        options += ["-G", "Ninja"]
    if shutil.which("ccache"):
        options += ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"]
    must(cmake, "-S", f"{folder}/scout", "-B", f"{folder}/build", *options)
    must(cmake, "--build", f"{folder}/build", "-j2")


class Scout:
    """The edited scout in simulated time, and the lss-cli that was built without it."""

    def __init__(self, cli, folder):
        self.cli_path, self.folder, self.run = cli, folder, f"{folder}/run"
        os.makedirs(self.run)
        self.bin = f"{folder}/build/bin"
        port = 20000 + int(os.environ["LSS_DOMAIN"])
        self.environment = dict(os.environ, NO_COLOR="1")
        with open(f"{folder}/scout/scout.toml", encoding="utf-8") as file:
            text = file.read().replace("udp://127.0.0.1:20000", f"udp://127.0.0.1:{port}")
        with open(f"{folder}/scout.toml", "w", encoding="utf-8") as file:
            file.write(text + "\n[recorder]\nrecord = true\n" if "[recorder]" not in text else text)
        self.programs = [
            self.begin("lss-sim-scout", "scout", "--lockstep", "--dir", self.run, "--can", f"udp://127.0.0.1:{port}"),
            None,
        ]
        self.programs[1] = self.begin("lssd-scout", "--lockstep", "--config", f"{folder}/scout.toml", "--run-dir", self.run)

    def begin(self, name, *words):
        out = open(f"{self.folder}/{name}.log", "w", encoding="utf-8")
        if name == "lssd-scout":  # the simulator's file says that it is there
            self.wait(lambda: glob.glob(f"{self.run}/*lockstep*") or os.listdir(self.run), "the simulator runs")
        return subprocess.Popen([f"{self.bin}/{name}", *words], stdin=subprocess.DEVNULL, stdout=out, stderr=out,
                                env=self.environment)

    def wait(self, condition, what, limit_s=60):
        end = time.monotonic() + limit_s
        while not condition():
            if time.monotonic() > end:
                for name in ("lss-sim-scout", "lssd-scout"):
                    print(open(f"{self.folder}/{name}.log", encoding="utf-8").read()[-2000:])
                sys.exit(f"not within {limit_s} s: {what}")
            time.sleep(0.2)

    def cli(self, *words, code=0):
        result = subprocess.run([self.cli_path, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, env=self.environment, timeout=120)
        if code is not None and result.returncode != code:
            sys.exit(f"lss-cli {' '.join(words)}: {result.returncode}, {result.stdout}{result.stderr}")
        return result.stdout

    def sequence(self, line, code=0):
        """Takes part in simulated time: how fast the machine is does not matter."""
        return self.cli("--jsonl", "run", "--lockstep", "--dir", self.run, "-e", line, code=code)

    def ready(self):
        out = self.cli("--json", "status", code=None)
        document = json.loads(out) if out.startswith("{") else {}
        return all(d["online"] for d in (document.get("telemetry") or {}).get("drives", [{"online": False}]))

    def end(self):
        for program in reversed(self.programs):
            if program is not None and program.poll() is None:
                program.terminate()
                program.wait(30)


def main(cmake, tree, example, folder):
    build(cmake, tree, example, folder)
    cli = os.path.join(tree, "bin", "lss-cli")
    scout = Scout(cli, folder)
    try:
        look(scout, cli, folder)
    finally:
        scout.end()


def look(scout, cli, folder):
    scout.wait(scout.ready, "both drives answer")

    dictionary = json.loads(scout.cli("dictionary"))
    names = {key: [one["name"] for one in dictionary[key]] for key in ("commands", "parameters", "faults")}
    check("course_rad" in [f["name"] for f in dictionary["telemetry"]["fields"]], "dictionary: the field")
    check("halt" in names["commands"], "dictionary: the command")
    check("body.gear" in names["parameters"], "dictionary: the parameter")
    check("too_fast" in names["faults"], "dictionary: the fault, with its number, text and advice")

    mcap = f"{folder}/run.mcap"
    recorder = subprocess.Popen([cli, "record", "--for", "20s", "--out", mcap], stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, env=scout.environment)
    scout.sequence("drive 0.3 --turn 0.5 --for 4s")
    status = json.loads(scout.cli("--json", "status"))["telemetry"]
    check(status["course_rad"] < -0.5 and status["course_rad"] == -status["yaw_rad"], "JSON: the field, as computed")
    rows = [line.split() for line in scout.cli("data").splitlines()]
    check(["course", "deg"] in [[row[0], row[-1]] for row in rows if len(row) == 3], "data: the field, in degrees")
    scout.cli("param", "set", "body.gear", "60")
    check("60" in scout.cli("param", "get", "body.gear"), "param: set and read by name")
    lines = scout.sequence("start; drive 0.2; wait 2s; halt; stop").splitlines()
    done = [one["command"] for one in map(json.loads, lines) if one.get("phase") == "completed"]
    check("halt" in done, "the command is done in a script")
    scout.sequence("drive 0.5 --for 6s", code=None)
    faults = json.loads(scout.cli("--json", "status"))["faults"]
    check([f["name"] for f in faults] == ["too_fast"] and "drive slower" in faults[0]["advice"],
          "the fault stops the scout, and status says what to do")
    recorder.wait(60)
    scout.end()

    recordings = sorted(glob.glob(f"{scout.run}/*.lssrec"))
    check(recordings, "there is a flight recording")
    csv = must(cli, "log", "export", recordings[0], "--columns", "telemetry.course_rad")
    check("course_rad" in csv.split("\n")[0] and any(line.split(",")[-1].startswith("-") for line in csv.split("\n")[1:]),
          "CSV of the flight recording: the field")
    csv = must(cli, "log", "export", mcap, "--topic", "telemetry", "--columns", "course_rad")
    check("course_rad" in csv.split("\n")[0], "MCAP: the field")
    must(f"{scout.bin}/lssd-scout", "--replay", *recordings)
    check(True, "the recording executes again, bit for bit")


if __name__ == "__main__":
    main(*sys.argv[1:])
