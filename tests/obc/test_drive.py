"""D.I.A.N.A. Ardito drives over can0, with `candump` as the witness: every SYNC, every frame of it, and that the motors
stop after any end of the drive."""

import itertools
import json
import os
import statistics
import unittest

import canlog
from box import setUpModule  # noqa: F401  pylint: disable=unused-import
from rover import UNIT, Rover

DRIVE_S = int(os.environ.get("LSS_OBC_DRIVE_S", "600"))  # in the box
SPEED_M_S = 0.3
ESTOP = 3  # idl/commands.h
HOUR_US = 3_600_000_000


class Drive(Rover):
    def setUp(self):
        self.all_nodes_run()
        if self.status()["state"] == "FatalError":
            self.must("lss-cli solve", 120)
        self.assertEqual(self.status()["state"], "Idle")
        self.begun = self.status()
        self.watch_bus(self._testMethodName)

    def stop_drive(self):
        self.must("systemctl kill -s INT drive")
        self.wait_status("s['state'] == 'Idle'", "it stopped safely", 60)

    def pass_frames(self, count):
        """So many frames, by their SYNC."""
        self.must(f"candump -n {count} can0,080:7FF > /dev/null", count // 10 + 60)

    def frames_of_the_end(self, count):
        """The last frames that the flight recorder has, and how far UTC is ahead of their clock."""
        frames, in_all, ahead_ns = self.frames_of(self.must("ls -t /var/lib/lss/*.lssrec | head -n 1"))
        return list(itertools.islice(frames, max(0, in_all - count), None)), ahead_ns

    # --- conditions

    def nothing_was_late(self, status):
        self.assertEqual(status["frame"]["overruns"], self.begun["frame"]["overruns"])
        self.assertEqual(status["counters"]["safe_commands"], self.begun["counters"]["safe_commands"])
        self.assertEqual(status["counters"]["telemetry_dropped"], self.begun["counters"]["telemetry_dropped"])

    def every_cycle_is_whole(self, frames):
        """Between two SYNCs: all measurements, before the frame begins; then all orders, when its command is released."""
        late_us = []
        for cycle in canlog.cycles(frames):
            begin_us = cycle[0].time_us
            heard = {f.id: f.time_us for f in reversed(cycle)}  # the first of each
            self.assertLessEqual(set(canlog.TPDOS), set(heard), f"measurements at {begin_us}")
            self.assertLessEqual(set(canlog.ORDERS), set(heard), f"orders at {begin_us}")
            self.assertIn(canlog.MASTER, heard)
            self.assertLess(max(heard[i] for i in canlog.TPDOS), begin_us + canlog.LEAD_US)
            late_us.append(max(heard[i] for i in canlog.ORDERS) - begin_us - canlog.LEAD_US - canlog.OFFSET_US)
        print(f"last of all orders after T_k + offset: median {statistics.median(late_us):.0f} us, max {max(late_us)} us")
        self.assertLess(max(late_us), canlog.RPDOS_US)

    def no_order_moves(self, frames):
        self.assertEqual([f for f in frames if f.id in canlog.DRIVES and f.enables], [])

    # --- tests

    def test_1_it_drives_and_no_frame_is_missed_then_an_emergency_stop_stops_the_motors(self):
        before = self.truth()
        self.drive(SPEED_M_S)
        self.pass_frames(DRIVE_S * 10)
        status = self.status()
        self.assertEqual((status["state"], status["mode"], status["faults"]), ("Operational", "Running", []))
        self.nothing_was_late(status)
        self.must("lss-cli estop")
        self.wait_status("s['state'] == 'FatalError'", "FatalError", 20)
        self.stands()
        recorded, ahead_ns = self.frames_of_the_end(100)
        after = self.truth()
        frames = self.seen()
        driven_m = after["position_m"][0] - before["position_m"][0]
        print(f"driven {driven_m:.2f} m in {after['t_s'] - before['t_s']:.1f} s")
        self.assertGreater(driven_m, 0.95 * SPEED_M_S * DRIVE_S)

        ran = [i for i, f in enumerate(frames) if f.id in canlog.WHEELS and f.enables]
        drive = frames[ran[0]:ran[-1]]
        times_us = canlog.syncs(drive)
        gaps_us = canlog.gaps(times_us)
        print(f"{len(times_us)} SYNC: period {canlog.text(gaps_us)}")
        self.assertGreaterEqual(len(times_us), DRIVE_S * 10)
        # None is missed, and none comes so late that measurements would not be in when the frame begins.
        for gap_us in gaps_us:
            self.assertLess(abs(gap_us - canlog.PERIOD_US), canlog.LEAD_US - canlog.TPDOS_US)
        self.assertLess(abs(statistics.mean(gaps_us) - canlog.PERIOD_US), 1)
        self.every_cycle_is_whole(drive)
        loads = canlog.loads(drive)
        print(f"{len(drive)} frames, bus load mean {statistics.mean(loads):.2%}, max of a second {max(loads):.2%}")
        self.assertLess(max(loads), 0.11)  # docs/icd-ardito.md, section 6

        asked_ns = next(r["arrival_ns"] for f in recorded for r in f["in"]["requests"] if r["kind"] == ESTOP)
        frame_ns = next(f["in"]["time_ns"] for f in recorded if f["in"]["time_ns"] > asked_ns)
        asked_us, frame_us = (asked_ns + ahead_ns) / 1e3, (frame_ns + ahead_ns) / 1e3
        after = [f for f in frames if f.time_us > asked_us and f.id in canlog.DRIVES]
        stopped = {f.id: f.time_us for f in reversed(after) if f.controlword == canlog.QUICK_STOP}
        self.assertEqual(set(stopped), set(canlog.DRIVES), "every drive has its quick stop")
        print(f"quick stop of the last drive {(max(stopped.values()) - asked_us) / 1e3:.2f} ms after the emergency stop came in, "
              f"{(max(stopped.values()) - frame_us) / 1e3:.2f} ms after its frame began")
        self.assertLess(max(stopped.values()), frame_us + canlog.OFFSET_US + canlog.RPDOS_US)
        self.assertLess(max(stopped.values()), asked_us + canlog.PERIOD_US + canlog.OFFSET_US + canlog.RPDOS_US)
        self.no_order_moves([f for f in frames if f.time_us > min(stopped.values())])

    def test_2_a_clock_that_is_set_makes_no_frame_late(self):
        self.drive(SPEED_M_S)
        self.pass_frames(20)
        self.must("date -s '+1 hour'")
        self.pass_frames(50)
        self.must("date -s '-1 hour'")
        self.pass_frames(200)  # longer than DDS goes without a sign of life of the other side
        status = self.status()
        self.assertEqual((status["state"], status["mode"], status["faults"]), ("Operational", "Running", []))
        self.nothing_was_late(status)
        steps = [e for e in json.loads(self.must("lss-cli --json events"))["events"] if e["name"] == "clock_stepped"]
        self.assertEqual([(round(e["arguments"][0]), e["count"]) for e in steps], [(-3600, 2)], "one series, its newest")
        # Logs go on.
        line = json.loads(self.must("tail -n 1 $(ls -t /var/lib/lss/*.log.jsonl | head -n 1)"))
        self.assertGreater(line["frame"], status["frame"]["index"] - 20)
        recorded, _ = self.frames_of_the_end(1)
        self.assertGreater(recorded[0]["in"]["frame"], status["frame"]["index"] - 2)
        self.stop_drive()
        steps, frames = [], self.seen()
        for gap_us in canlog.gaps(canlog.syncs(frames)):
            step_us = round((gap_us - canlog.PERIOD_US) / HOUR_US) * HOUR_US
            if step_us:
                steps.append(step_us)
            self.assertLess(abs(gap_us - step_us - canlog.PERIOD_US), canlog.LEAD_US - canlog.TPDOS_US)
        self.assertEqual(steps, [HOUR_US, -HOUR_US])

    def test_3_bus_off_is_an_emergency_and_the_rover_drives_again_when_it_is_over(self):
        pid = self.pid(UNIT)
        self.drive(SPEED_M_S)
        self.must("cansend can0 20000040#0000000000000000")  # as reported by a controller: CAN_ERR_BUSOFF
        status = self.wait_status("s['state'] == 'FatalError'", "FatalError", 20)
        self.assertIn("bus_off", [f["name"] for f in status["faults"]])
        self.assertEqual(status["telemetry"]["bus_offs"], self.begun["telemetry"]["bus_offs"] + 1)
        self.must("cansend can0 20000100#0000000000000000")  # CAN_ERR_RESTARTED
        self.stands()
        self.wait_status("s['telemetry'] and all(n['online'] for n in s['telemetry']['nodes'])", "all nodes run again", 60)
        self.must("lss-cli solve", 120)
        self.wait_status("s['state'] == 'Idle'", "Idle", 60)
        self.end_drive()
        self.drive(SPEED_M_S)
        self.assertEqual(self.pid(UNIT), pid, "it is the same process")
        self.stop_drive()
        frames = self.seen()
        with open(os.path.join(self.share, self.watched), encoding="ascii") as file:
            told_us = [int(line[1:18].replace(".", "")) for line in file if "20000040#" in line or "20000100#" in line]
        self.assertEqual(len(told_us), 2)
        for begin_us in told_us:
            after = [f for f in frames if f.time_us > begin_us]
            stopped = {f.id: f.time_us for f in reversed(after) if f.id in canlog.DRIVES and f.controlword == canlog.QUICK_STOP}
            self.assertEqual(set(stopped), set(canlog.DRIVES))
            print(f"quick stop of the last drive {(max(stopped.values()) - begin_us) / 1e3:.2f} ms after the bus reported")
            self.assertLess(max(stopped.values()), begin_us + canlog.PERIOD_US + canlog.OFFSET_US + canlog.RPDOS_US)

    def test_4_a_unit_that_is_stopped_leaves_a_rover_that_stands(self):
        self.drive(SPEED_M_S)
        self.must(f"s=$EPOCHREALTIME; systemctl stop {UNIT}; echo $s $EPOCHREALTIME", 60)
        self.assertEqual((self.active(UNIT), self.show(UNIT, "Result")), ("inactive", "success"))
        self.stands()
        frames = self.seen()
        last = canlog.last_orders(frames)
        self.assertEqual(set(last), set(canlog.DRIVES))
        print("last orders:", ", ".join(sorted({f"{f.controlword:04X}" for f in last.values()})))
        self.no_order_moves(last.values())
        # A motor is switched off when it stands, and not before: until then it has its ramp or its quick stop.
        rpm, switched_off = {}, {}
        for frame in frames:
            if frame.id in canlog.SPEEDS:
                rpm[frame.id - canlog.SPEEDS[0] + canlog.WHEELS[0]] = frame.motor_rpm
            elif frame.id in canlog.WHEELS and frame.enables:
                switched_off.pop(frame.id, None)
            elif frame.id in canlog.WHEELS and frame.controlword != canlog.QUICK_STOP:
                switched_off.setdefault(frame.id, rpm.get(frame.id))
        print("motors were switched off at", sorted(switched_off.values()), "rpm; driving takes", round(canlog.rpm(SPEED_M_S)))
        self.assertEqual(set(switched_off), set(canlog.WHEELS))
        self.assertLess(max(map(abs, switched_off.values())), 0.01 * canlog.rpm(SPEED_M_S))
        self.must(f"systemctl start {UNIT}", 120)


if __name__ == "__main__":
    unittest.main(failfast=True)
