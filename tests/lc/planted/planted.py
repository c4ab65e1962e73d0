#!/usr/bin/env python3
"""Defects planted in the source of supervisor, watch and solver: lss-lc composition must find each.

planted.py names                      the names, for CMake
planted.py write NAME TREE FILE       a source with the defect, in place of those of the tree
planted.py find NAME PROGRAM          runs the exploration that was built with it
"""
import pathlib
import subprocess
import sys

ZEBRO = ["daemon/vehicles/zebro/watch.cpp", "daemon/vehicles/zebro/solving.cpp", "daemon/vehicles/zebro/solver.cpp"]
CYCLE = ["daemon/cycle/supervisor.cpp"]
LOSS = "each loss leads to a safe state within its time"
WALKS = "whatever can be isolated and leaves a gait ends in Operational again"
SOLVED = "solved is what is solved"

# name: sources, text (or several), instead of each, first failure, property
DEFECTS = {
    "silence_ignored": (ZEBRO, "} else if (!answers(i) && !lost &&", "} else if (false && !answers(i) && !lost &&", "silent", LOSS),
    "trip_ignored": (ZEBRO, "if (rising(flags, before, kFlagOverCurrent) && driven)",
                     "if (false && rising(flags, before, kFlagOverCurrent) && driven)", "jammed", LOSS),
    "disobedience_ignored": (ZEBRO, "if (link.disobeys && !disobeyed_[i])", "if (false && !disobeyed_[i])", "deaf", LOSS),
    "lease_doubled": (CYCLE, "state_.time_ns - state_.heartbeat_ns > state_.lease_ns",
                      "state_.time_ns - state_.heartbeat_ns > 2 * state_.lease_ns", "client lost", LOSS),
    "budget_ignored": (ZEBRO, "if (now > until_ns_) return give_up(vehicle);", "", "unplugged", "no endless solving"),
    "isolation_not_applied": (ZEBRO, "if (contains(modules, i)) supervisor_->happen(event::isolate, number(i));", "",
                              "silent", WALKS),
    "success_without_proof": (ZEBRO, "if (!healthy) break;\n      healthy_since_ns_ = now;",
                              "return Report::solved;", "deaf", SOLVED),
    # Either finds the leg that disobeys only until its next order.
    "nobody_to_isolate_is_success": (ZEBRO, ("if (kind() == StrategyKind::isolate && modules == 0) modules = blamed_;",
                                             "if (misled && leg && symptom.again && isolates) relapsed |="
                                             " 1u << (symptom.module - 1);"), "", "late", WALKS),
}


def write(name, tree, out):
    sources, texts, instead, _, _ = DEFECTS[name]
    source = "\n".join((pathlib.Path(tree) / part).read_text() for part in sources)
    for text in [texts] if isinstance(texts, str) else texts:
        if source.count(text) != 1:
            sys.exit(f"{name}: this text is not there once: {text}")
        source = source.replace(text, instead)
    pathlib.Path(out).write_text(source)


def find(name, program):
    _, _, _, failure, rule = DEFECTS[name]
    sys.exit(subprocess.run([program, "1", failure, rule], check=False).returncode)


if sys.argv[1] == "names":
    print(";".join(DEFECTS), end="")
elif sys.argv[1] == "write":
    write(*sys.argv[2:5])
else:
    find(*sys.argv[2:4])
