"""lss-ros with a peer of another vendor's DDS, which hears and drives the vehicle as a ROS 2 node does."""

import json
import os
import subprocess
import unittest

from programs import die_with_parent, wait_until
from rig import TOOLS, IDLE, OPERATIONAL
from rover_rig import Rover

ROS_PEER = os.environ.get("LSS_E2E_ROS_PEER", "")
NEEDED = "the peer was not built: libfastrtps-dev and fastddsgen are not installed (tools/packages.txt, group ros)"


class Ros(Rover):
    IN_LOCKSTEP, PLANT = True, "kinematic"

    def begin_ros(self, *words):
        ros = self.begin("lss-ros", [os.path.join(TOOLS, "lss-ros"), *words])
        wait_until(lambda: "/ardito_1 on ROS domain" in ros.out() or not ros.running(), 30, "lss-ros is there")
        self.assertTrue(ros.running(), ros.err())
        path = os.path.join(self.folder, "peer.jsonl")
        with open(path, "w", encoding="utf-8") as out:
            self.peer = subprocess.Popen([ROS_PEER, str(self.domain), "/ardito_1"], stdin=subprocess.PIPE, stdout=out,
                                         text=True, preexec_fn=die_with_parent)
        self.addCleanup(self.peer.wait)
        self.addCleanup(self.peer.kill)
        self.heard_path = path
        return ros

    def tell(self, line):
        self.peer.stdin.write(line + "\n")
        self.peer.stdin.flush()

    def heard(self, **wanted):
        """All that the peer printed with these values; None: any value."""
        with open(self.heard_path, encoding="utf-8") as file:
            lines = [json.loads(line) for line in file.read().splitlines(keepends=True) if line.endswith("\n")]
        return [line for line in lines
                if all(key in line and value in (None, line[key]) for key, value in wanted.items())]

    def wait_heard(self, what, limit_s=30, **wanted):
        wait_until(lambda: self.heard(**wanted), limit_s, what)
        return self.heard(**wanted)[-1]

    def answer_to(self, service):
        topic = f"rr/ardito_1/{service}Reply"
        before = len(self.heard(topic=topic))
        wait_until(lambda: self.heard(writer=topic) and self.heard(reader=f"rq/ardito_1/{service}Request"), 30, service)
        self.tell(f"call {service}")
        wait_until(lambda: len(self.heard(topic=topic)) > before, 60, f"an answer of {service}")
        return self.heard(topic=topic)[-1]

    @unittest.skipUnless(os.path.exists(ROS_PEER), NEEDED)
    def test_a_peer_of_another_vendor_hears_drives_and_stops(self):
        self.start_all()
        self.begin_ros("--cmd-vel-starts", "--lease-ms", "1000")
        self.assert_discovered()
        for topic in ("imu/data", "joint_states", "odom"):
            self.wait_heard(topic, topic=f"rt/ardito_1/{topic}")
        self.assertIn("ardito_1/LF_link", self.wait_heard("frames", topic="rt/tf")["children"])
        self.assertEqual(self.wait_heard("map", topic="rt/tf_static")["children"], ["ardito_1/odom"])
        self.assertIn("<robot", self.wait_heard("a picture", topic="rt/ardito_1/robot_description")["text"])
        self.wait_heard("diagnostics", topic="rt/diagnostics")
        self.wait_heard("a log line", topic="rt/rosout")
        node = self.wait_heard("a node", node="/ardito_1/lss_ros")
        self.assertEqual((node["readers"], node["writers"]), (5, 12))

        # Ahead and to the left, from Idle.
        self.tell("drive 0.3 0.1")
        wait_until(lambda: self.heard(topic="rt/ardito_1/odom")[-1]["x"] > 0.3, 120, "it drives ahead")
        odom = self.heard(topic="rt/ardito_1/odom")[-1]
        self.assertEqual((odom["frame"], odom["child"]), ("ardito_1/odom", "ardito_1/base_link"))
        self.assertGreater(odom["yaw"], 0.02, "to the left")
        self.assertGreater(odom["y"], 0)
        self.assertGreater(self.heard(topic="rt/ardito_1/imu/data")[-1]["turn"], 0)
        self.assertEqual(self.status()["authority"][:5], "ros2:")
        self.tell("drive 0 0")
        wait_until(lambda: abs(self.heard(topic="rt/ardito_1/odom")[-1]["speed"]) < 1e-3, 60, "zero stands still")
        self.assertEqual(self.status()["state"], OPERATIONAL)
        # Without messages the lease ends.
        self.tell("silent")
        self.wait_state(IDLE, 60)

        self.assertTrue(self.answer_to("start")["success"])
        stopped = self.answer_to("stop")
        self.assertTrue(stopped["success"], stopped)
        self.assertEqual(stopped["client"], 42)
        self.assertTrue(self.answer_to("estop")["success"])
        self.wait_state("FatalError")
        self.tell("drive 0.3 0")
        wait_until(lambda: any("cmd_vel" in line["text"] for line in self.heard(topic="rt/rosout")), 30,
                   "a refusal in the log")
        self.tell("silent")
        self.assertTrue(self.answer_to("solve")["success"])

    @unittest.skipUnless(os.path.exists(ROS_PEER), NEEDED)
    def test_without_leave_to_start_cmd_vel_is_refused(self):
        self.start_all()
        self.begin_ros()
        self.wait_heard("a reader", reader="rt/ardito_1/cmd_vel")
        self.tell("drive 0.3 0")
        wait_until(lambda: any(line["level"] == 30 and "not allowed in this state" in line["text"]
                               for line in self.heard(topic="rt/rosout")), 30, "a warning in the log")
        wait_until(lambda: any(one[0].endswith("cmd_vel") for line in self.heard(topic="rt/diagnostics")
                               for one in line["status"]), 30, "and in the diagnostics")
        self.assertEqual(self.status()["state"], IDLE)

    def assert_discovered(self):
        self.wait_heard("the participant", participant="enclave=/;")
        self.wait_heard("the last topic", writer="rr/ardito_1/startReply")
        self.wait_heard("cmd_vel", reader="rt/ardito_1/cmd_vel")
        expected = {"rt/ardito_1/imu/data": ("sensor_msgs::msg::dds_::Imu_", False),
                    "rt/ardito_1/joint_states": ("sensor_msgs::msg::dds_::JointState_", False),
                    "rt/ardito_1/odom": ("nav_msgs::msg::dds_::Odometry_", False),
                    "rt/tf": ("tf2_msgs::msg::dds_::TFMessage_", False),
                    "rt/tf_static": ("tf2_msgs::msg::dds_::TFMessage_", True),
                    "rt/diagnostics": ("diagnostic_msgs::msg::dds_::DiagnosticArray_", False),
                    "rt/ardito_1/robot_description": ("std_msgs::msg::dds_::String_", True),
                    "rt/rosout": ("rcl_interfaces::msg::dds_::Log_", True)}
        for topic, (kind, kept) in expected.items():
            writer = self.wait_heard(topic, writer=topic)
            self.assertEqual((writer["type"], writer["reliable"], writer["transient_local"]), (kind, True, kept), topic)
            self.assertRegex(writer["user_data"], r"^typehash=RIHS01_[0-9a-f]{64};$")
        reader = self.heard(reader="rt/ardito_1/cmd_vel")[0]
        self.assertEqual((reader["reliable"], reader["transient_local"]), (False, False))
        def ours():
            return [line for kind in ("writer", "reader") for line in self.heard(**{kind: None})
                    if line[kind].startswith("lss/")]
        wait_until(lambda: len(ours()) > 10, 30, "the endpoints of lssd and lss-ros")
        for line in ours():
            self.assertTrue(line["user_data"], f"a node of ROS warns of {line}")


if __name__ == "__main__":
    unittest.main()
