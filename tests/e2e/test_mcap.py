"""One short run of each vehicle, recorded; the file is read by us and by others, exported, and drawn."""

import json
import math
import os
import resource
import signal
import unittest

from hopper_rig import Hopper
from programs import die_with_parent, wait_until
from recordings import Recorded
from rig import EXIT, TOOLS, Scenario
from rover_rig import Rover


class Zebro(Recorded, Scenario):
    IN_LOCKSTEP = True

    def test_a_walk_is_recorded_killed_gone_on_with_and_read_by_others(self):
        self.start_all()
        self.assert_bad_files_are_reported()
        client = self.record(name="record")
        self.cli_ok("walk", "forward", "--speed", "high", "--for", "6s", limit_s=90)
        asked = [json.loads(self.cli_ok("--json", "data").out)["documents"][0] for _ in range(3)]
        wait_until(lambda: self.has(asked[-1]), 20, "the last answer is in the file")
        client.kill()
        self.assert_torn_file_is_gone_on_with()
        for sample in asked:
            self.assertTrue(self.has(sample), sample)
        self.assert_csv_says_the_same()
        self.assertEqual(len(self.assert_plot("modules[*].current_A,distance_m,timing.margin_ns", ".svg")), 9)
        self.assert_plot("modules[*].position_rad", ".png")
        self.assert_a_part_is_whole()
        self.assert_page_shows("Stance and swing", "Currents", "Temperatures", "State and mode", "Distance")
        self.assert_others_read_the_same()

    def assert_bad_files_are_reported(self):
        nobody = self.cli("record", "--for", "1s", "--vehicle", "nobody")
        self.assertEqual(nobody.code, EXIT["unknown_name"])
        folder = self.cli("record", "--for", "1s", "--out", os.path.join(self.folder, "none", "a.mcap"))
        self.assertEqual(folder.code, EXIT["usage"])
        self.assertIn("--out FILE", folder.err)
        topic = self.cli("record", "--for", "1s", "--topics", "telemtry")
        self.assertEqual(topic.code, EXIT["unknown_name"])

        def tiny_disk():
            die_with_parent()
            resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, resource.RLIM_INFINITY))
        path = os.path.join(self.folder, "full.mcap")
        full = self.begin("full", [os.path.join(TOOLS, "lss-cli"), "record", "--for", "20s", "--out", path], tiny_disk)
        self.assertEqual(full.wait(30), EXIT["failed"])
        self.assertIn("make room", full.err())
        self.assertGreater(self.listed(path)["messages"], 20)

    def assert_torn_file_is_gone_on_with(self):
        torn = self.listed()
        self.assertFalse(torn["whole"])
        last = self.shown("--topic", "timing")[-1]
        again = self.begin_cli("--json", "record", "--append", "--out", self.recording, name="again")
        wait_until(lambda: self.listed()["messages"] > torn["messages"] + 100, 20, "it goes on")
        again.signal(signal.SIGINT)
        self.assertEqual(again.wait(20), 0, "Ctrl-C is its proper end")
        said = json.loads(again.out())
        self.assertEqual(said["ended"], "interrupted")
        self.assertEqual(said["missing"], 0, said)
        whole = self.listed()
        self.assertTrue(whole["whole"], whole["complaint"])
        self.assertEqual(whole["messages"], torn["messages"] + said["messages"])
        self.assertEqual(self.shown("--topic", "timing", "--to", str(last["t_s"]))[-1]["data"], last["data"])
        events = [m["sequence"] for m in self.shown("--topic", "event")]
        self.assertEqual(events, sorted(set(events)), "those that DDS keeps are not recorded twice")

    def has(self, sample):
        """The output of `data` during the recording is one of the messages, to the last digit."""
        def values(modules):
            return [(m["id"], m["position_rad"], m["current_A"], m["supply_V"], m["replies"]) for m in modules]
        wanted = values(sample["telemetry"]["modules"])
        return any(values(m["data"]["modules"]) == wanted for m in self.shown("--topic", "telemetry"))

    def assert_a_part_is_whole(self):
        part = os.path.join(self.folder, "part.mcap")
        self.cli_ok("log", "export", self.recording, "--topic", "timing,event", "--from", "1", "--to", "3s", "--out", part)
        listed = self.listed(part)
        self.assertTrue(listed["whole"])
        self.assertEqual(sorted(t["topic"] for t in listed["topics"]), ["lss/event", "lss/timing"])
        self.assertLess(listed["duration_s"], 2.01)
        names = [f["kind"] for f in json.loads(self.cli_ok("--json", "log", "list", self.folder).out)["files"]]
        self.assertEqual(names.count("mcap"), 3)


class Ardito(Recorded, Rover):
    IN_LOCKSTEP = True

    def test_a_drive_is_recorded_and_drawn(self):
        self.start_all()
        client = self.record("--ros2", "--topics", "telemetry,timing,status,event,command,command_ack",
                             "--max-size", "50")
        self.cli_ok("run", "-e", "drive 0.3 --heading 5 --for 4s; park 0.4 --for 3s; drive 0.4 --for 3s; stop",
                    limit_s=90)
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(20), 0)
        self.assertTrue(self.listed()["whole"])
        self.assert_plot("wheels[*].motor_rad_s", ".svg")
        self.assert_page_shows("Wheel speeds", "Steering", "Failure states", "Seen from above")
        self.assert_ros_says_the_same(*self.assert_others_read_the_same())

    def assert_ros_says_the_same(self, messages, end):
        """The channels of ROS, as others decode them, against our own."""
        self.assertEqual(end["profile"], "ros2")
        own = [channel for channel in end["channels"] if channel["topic"].startswith("/")]
        self.assertIn({"topic": "/ardito_1/odom", "type": "nav_msgs/msg/Odometry"},
                      [{"topic": one["topic"], "type": one["type"]} for one in own])
        for channel in own:
            self.assertIn("reliability: reliable", channel["metadata"]["offered_qos_profiles"])
            self.assertRegex(channel["metadata"]["topic_type_hash"], "^RIHS01_[0-9a-f]{64}$")

        def of(topic):
            return [m for m in messages if m["topic"] == topic]
        telemetry = {m["publish_ns"]: m["data"] for m in self.shown("--topic", "telemetry")}
        for topic in ("/ardito_1/odom", "/ardito_1/joint_states", "/tf"):
            self.assertGreater(len(of(topic)), len(telemetry) - 20, topic)  # those before the first status
        moved = 0
        for message in of("/ardito_1/odom"):
            ours, theirs = telemetry[message["publish_ns"]], message["data"]
            self.assertEqual(theirs["pose"]["pose"]["position"], {"x": ours["x_m"], "y": ours["y_m"], "z": 0})
            self.assertAlmostEqual(2 * math.asin(theirs["pose"]["pose"]["orientation"]["z"]), -ours["yaw_rad"], 9)
            moved = max(moved, theirs["pose"]["pose"]["position"]["x"])
        self.assertGreater(moved, 0.1)
        for message in of("/ardito_1/imu/data"):
            self.assertEqual(message["data"]["angular_velocity"]["z"],
                             -telemetry[message["publish_ns"]]["imu_yaw_rate_rad_s"])
        for message in of("/ardito_1/joint_states"):
            ours = telemetry[message["publish_ns"]]
            joints = dict(zip(message["data"]["name"], message["data"]["position"]))
            self.assertEqual(joints["steer-RF"], ours["steering"][1]["motor_rad"])
            self.assertEqual(joints["left_rocker"], ours["beta_rad"])
        self.assertEqual([m["data"]["msg"] for m in of("/rosout")],
                         [m["data"]["text"] for m in self.shown("--topic", "event")])
        self.assertEqual(len(of("/diagnostics")), len(self.shown("--topic", "status")))
        self.assertEqual([len(of("/tf_static")), len(of("/ardito_1/robot_description"))], [1, 1])


class Talaris(Recorded, Hopper):
    IN_LOCKSTEP = True

    def test_a_hop_is_recorded_and_drawn(self):
        self.start_all()
        client = self.record()
        self.cli_ok("hop", "--arm", "--height", "2", "--distance", "8", limit_s=180)
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(20), 0)
        listed = self.listed()
        self.assertTrue(listed["whole"])
        heights = [m["data"]["position_m"][0] for m in self.shown("--topic", "telemetry")]
        self.assertGreater(max(heights), 1.5)
        self.assert_plot("position_m[*],valves[*].on_s", ".svg")
        self.assert_page_shows("Height", "Attitude", "Valve pulses", "Gas used")
        self.assert_others_read_the_same()


if __name__ == "__main__":
    unittest.main()
