"""lss-ros with a peer of another vendor's DDS, which hears and drives the vehicle as a ROS 2 node does."""

import json
import os
import subprocess
import unittest

import dissected
from enclaves import Enclaves
from programs import die_with_parent, wait_until
from rig import TOOLS, IDLE, OPERATIONAL
from rover_rig import Rover

ROS_PEER = os.environ.get("LSS_E2E_ROS_PEER", "")
# As ROS 2 has them (Iron and later): type, RIHS01 hash, reliable, durability (1: transient-local), depth.
TRIGGER = {"Request": "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199",
           "Response": "2d946c21e2fc3f1e9ca6986a8191d85fcc70097a8bb7771a053564bc47009cdf"}
GRAPH = ("rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
         "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e", True, 1)
TF = ("tf2_msgs::msg::dds_::TFMessage_", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087", True)
WIRE = {
    ("writer", "rt/ardito_1/imu/data"): ("sensor_msgs::msg::dds_::Imu_",
                                         "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b", True, 0, 10),
    ("writer", "rt/ardito_1/joint_states"): ("sensor_msgs::msg::dds_::JointState_",
                                             "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e", True, 0, 10),
    ("writer", "rt/ardito_1/odom"): ("nav_msgs::msg::dds_::Odometry_",
                                     "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0", True, 0, 10),
    ("writer", "rt/tf"): (*TF, 0, 100),
    ("writer", "rt/tf_static"): (*TF, 1, 1),
    ("writer", "rt/diagnostics"): ("diagnostic_msgs::msg::dds_::DiagnosticArray_",
                                   "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e", True, 0, 10),
    ("writer", "rt/ardito_1/robot_description"): ("std_msgs::msg::dds_::String_",
                                                  "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18", True, 1, 1),
    ("writer", "rt/rosout"): ("rcl_interfaces::msg::dds_::Log_",
                              "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac", True, 1, 1000),
    ("reader", "rt/ardito_1/cmd_vel"): ("geometry_msgs::msg::dds_::Twist_",
                                        "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a", False, 0, 1),
    ("writer", "ros_discovery_info"): (*GRAPH, 1),
    ("reader", "ros_discovery_info"): (*GRAPH, "all"),
    **{("reader", f"rq/ardito_1/{name}Request"): ("std_srvs::srv::dds_::Trigger_Request_", TRIGGER["Request"], True, 0, 10)
       for name in ("stop", "estop", "solve", "start")},
    **{("writer", f"rr/ardito_1/{name}Reply"): ("std_srvs::srv::dds_::Trigger_Response_", TRIGGER["Response"], True, 0, 10)
       for name in ("stop", "estop", "solve", "start")},
}
NEEDED = "the peer was not built: it needs Fast DDS 2, as of Debian 12 (tools/packages.txt, group ros)"


class Ros(Rover):
    IN_LOCKSTEP, PLANT = True, "kinematic"

    def begin_ros(self, *words, peer_enclave=()):
        ros = self.begin("lss-ros", [os.path.join(TOOLS, "lss-ros"), *words])
        wait_until(lambda: "/ardito_1 on ROS domain" in ros.out() or not ros.running(), 30, "lss-ros is there")
        self.assertTrue(ros.running(), ros.err())
        path = os.path.join(self.folder, "peer.jsonl")
        with open(path, "w", encoding="utf-8") as out:
            self.peer = subprocess.Popen([ROS_PEER, str(self.domain), "/ardito_1", *peer_enclave], stdin=subprocess.PIPE, stdout=out,
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
        stands = len(self.heard(topic="rt/ardito_1/odom"))
        wait_until(lambda: len(self.heard(topic="rt/ardito_1/odom")) > stands + 40, 60, "four seconds, four leases")
        self.assertEqual(self.status()["state"], OPERATIONAL)
        # Without messages the lease ends, and when they are refused.
        self.tell("silent")
        self.wait_state(IDLE, 60)
        self.tell("drive 0.3 0")
        wait_until(lambda: self.heard(topic="rt/ardito_1/odom")[-1]["speed"] > 0.1, 120, "it drives again")
        self.tell("drive nan 0")
        self.wait_state(IDLE, 60)
        self.tell("silent")

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
    def test_an_emergency_stop_goes_before_calls_that_nobody_answers(self):
        daemon = self.start_all()
        self.begin_ros()
        self.wait_heard("a service", reader="rq/ardito_1/estopRequest")
        daemon.kill()

        def refused():
            self.tell("call start")
            return self.heard(topic="rr/ardito_1/startReply", text="too many calls at a time")

        wait_until(refused, 90, "as many calls as it keeps", most_s=0.05)
        self.tell("call estop")
        self.wait_heard("a call that gave way", topic="rr/ardito_1/startReply", text="gave way to an emergency stop")

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

    @unittest.skipUnless(os.path.exists(ROS_PEER) and dissected.TSHARK, f"{NEEDED}, and tshark")
    def test_an_observer_of_the_wire_sees_the_names_types_qos_and_node_of_ros(self):
        capture = dissected.Capture(self.folder)
        self.addCleanup(capture.end)
        if capture.process.poll() is not None:
            self.skipTest(f"skipped: tshark may not capture here: {capture.text()}")
        self.start_all()
        self.begin_ros()
        self.wait_heard("a node", node="/ardito_1/lss_ros")
        self.wait_heard("the last topic", writer="rr/ardito_1/startReply")

        def ours(packets):
            here = tuple(dissected.prefixes_of(packets, self.domain))
            return [guid for guid, e in dissected.endpoints(packets).items()
                    if guid.startswith(here) and (e["kind"], e["topic"]) == ("writer", "ros_discovery_info")
                    and dissected.samples_of(packets, guid)]

        packets = capture.wait_for(ours, 60, "the node graph was captured")
        [graph] = ours(packets)
        prefix = graph[:-len(":00:00:00:00")]
        self.assertEqual(dissected.participants(packets)[prefix], "enclave=/;")
        endpoints = {guid: e for guid, e in dissected.endpoints(packets).items() if guid.startswith(prefix)}
        seen = {(e["kind"], e["topic"]): e for e in endpoints.values()}
        self.assertEqual(len(seen), len(endpoints), "one of each")
        self.assertEqual(seen.keys(), WIRE.keys())
        for (kind, topic), (of_type, type_hash, reliable, durability, depth) in WIRE.items():
            e = seen[kind, topic]
            self.assertEqual((e["type"], e["reliable"], e["durability"]), (of_type, reliable, durability), topic)
            self.assertEqual("all" if e["keeps_all"] else e["depth"], depth, topic)
            self.assertRegex(e["user_data"], rf"^(serviceid=[0-9a-f.]+;)?typehash=RIHS01_{type_hash};$", topic)
            self.assertEqual(e["user_data"].startswith("serviceid"), topic[:2] in ("rq", "rr"), topic)
            self.assertEqual(e["lifespan_s"], 10 if topic == "rt/rosout" else None, topic)
        newest = dissected.samples_of(packets, graph)[-1]
        gids = {bytes.fromhex(guid.replace(":", "")) for guid, e in endpoints.items() if e["topic"] != "ros_discovery_info"}
        self.assertEqual(newest[:16].hex(), prefix.replace(":", "") + "000001c1", "the gid of the participant")
        self.assertEqual({gid for gid in gids if gid in newest}, gids, "every reader and writer is the node's")
        for text in (b"/ardito_1\0", b"lss_ros\0"):
            self.assertIn(text, newest)

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


class SecuredRos(Enclaves, Ros):
    @unittest.skipUnless(os.path.exists(ROS_PEER), NEEDED)
    def test_with_dds_security_only_a_node_with_a_certificate_hears_and_drives(self):
        self.keystore = self.make_keystore(roles={"ardito-1": "vehicle", "pilot": "command", "bridge": "bridge", "teleop": "ros"})
        self.start_all(enclave=f'"{self.enclave("ardito-1")}"')
        self.begin_ros("--cmd-vel-starts", "--lease-ms", "1000", "--enclave", self.enclave("bridge"),
                       peer_enclave=(self.enclave("teleop"),))
        self.wait_heard("the participant", participant="enclave=/bridge;", limit_s=60)
        self.wait_heard("measurements", topic="rt/ardito_1/odom", limit_s=60)
        self.tell("drive 0.3 0")
        wait_until(lambda: self.heard(topic="rt/ardito_1/odom")[-1]["x"] > 0.1, 120, "it drives ahead")
        self.assertEqual(self.status()["authority"][:7], "bridge:")
        self.tell("silent")
        self.wait_state(IDLE, 60)

        stranger = self.begin("stranger", [ROS_PEER, str(self.domain), "/ardito_1"])
        stranger.say("drive 0.3 0")
        wait_until(lambda: '"participant"' in stranger.out(), 60, "it hears that there are participants")
        stands = self.heard(topic="rt/ardito_1/odom")[-1]["x"]
        heard = len(self.heard(topic="rt/ardito_1/odom"))
        wait_until(lambda: len(self.heard(topic="rt/ardito_1/odom")) > heard + 50, 60, "5 s, as a vehicle's frames")
        self.assertAlmostEqual(self.heard(topic="rt/ardito_1/odom")[-1]["x"], stands, delta=1e-3)
        self.assertEqual(self.status()["state"], IDLE, "cmd_vel of a stranger starts nothing")
        self.assertNotIn('"topic"', stranger.out())
        self.assertNotIn('"writer":"rt/ardito_1/odom', stranger.out())


if __name__ == "__main__":
    unittest.main()
