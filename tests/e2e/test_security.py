"""DDS Security (docs/security.md): who has no certificate, a stranger's, or a role that does not allow it is neither heard
nor believed; who has one is obeyed as without it."""

import json
import os
import shutil
import socket
import statistics
import sys
import threading
import time

from attack import ATTACK
from enclaves import Enclaves, make_rogue, make_ros2_keystore, uri
from programs import run, wait_until
from rig import BOOT_S, CLOCK, EXIT, FATAL_ERROR, IDLE, PEER, Scenario, real_time
from test_ground import Gateway

SECONDS = float(os.environ.get("LSS_SECURITY_ATTACK_S", "3"))  # of each intruder
ROUNDS = int(os.environ.get("LSS_SECURITY_ROUNDS", "5"))       # of peers that are killed; 100 for docs/security.md
REJOIN_S = 5
WRITTEN = ("command", "stop", "ack", "heartbeat", "status", "event", "telemetry")


class Security(Enclaves, Scenario):
    IN_LOCKSTEP = True

    def start_secured(self, **changes):
        self.keystore = self.make_keystore()
        self.start_sim()
        daemon = self.start_daemon(self.secured(**changes))
        self.wait_modules()
        return daemon

    def intrude(self, source, configuration=None, rate=200):
        """Counts of an intruder with that CYCLONEDDS_URI."""
        more = {} if configuration is None else {"CYCLONEDDS_URI": configuration}
        result = run([ATTACK, "intrude", str(self.domain), "zebro-1", "--source", source, "--rate", str(rate), "--seconds",
                      str(SECONDS)], self.environment(**more), SECONDS + 40)
        self.assertEqual(result.code, 0, result)
        counts = json.loads(result.out)
        self.assertGreater(counts["sent"], 0)
        return counts

    def matched(self, counts):
        return [name for name in WRITTEN if counts[f"matched_{name}"] > 0]

    def test_intruders_are_neither_heard_nor_believed_while_the_pilot_walks(self):
        self.start_secured()
        self.begin_walk("--source", "pilot")
        before = self.status()
        strangers = self.make_keystore("strangers", {"pilot": "command", "zebro-1": "vehicle"})
        rogue = os.path.join(self.folder, "rogue")
        make_rogue(self.enclave("watcher"), "watcher", rogue)
        for who, configuration in {"without a certificate": None,
                                   "a stranger's pilot": uri(self.enclave("pilot", strangers)),
                                   "a stranger's vehicle": uri(self.enclave("zebro-1", strangers)),
                                   "who signs its own permissions": uri(rogue)}.items():
            with self.subTest(who):
                counts = self.intrude("pilot", configuration)
                self.assertEqual((self.matched(counts), counts["heard"]), ([], 0), counts)
        intruder = self.begin("intruder", [ATTACK, "intrude", str(self.domain), "zebro-1", "--rate", "20", "--seconds", "60"])
        self.wait_for_text(intruder, "ready", BOOT_S, intruder.err_path)
        for verb in (("stop", "--dry-run"), ("health",), ("fleet",)):
            self.cli_ok("--timeout", "20s", *verb)  # no other daemon is waited for, or makes it ask which
        self.assertTrue(intruder.running(), "all this while")
        watcher = self.begin("watcher", [ATTACK, "intrude", str(self.domain), "zebro-1", "--source", "pilot", "--rate", "200",
                                         "--seconds", "60"], CYCLONEDDS_URI=uri(self.enclave("watcher")))
        self.wait_for_text(watcher, "heard", BOOT_S, watcher.err_path)  # it may look
        watcher.stop()
        self.assertEqual(watcher.process.returncode, 0)
        looked = json.loads(watcher.out())
        self.assertGreater(looked["sent"], 0)
        self.assertEqual([looked[f"matched_{name}"] for name in WRITTEN], [-1] * len(WRITTEN), looked)
        after = self.status()
        self.assertEqual((after["mode"], after["authority"]), ("Walking", "pilot"))
        self.assertEqual(after["counters"]["commands_rejected"], before["counters"]["commands_rejected"], "nothing arrived")

    def test_nobody_commands_in_the_name_of_another_certificate(self):
        daemon = self.start_secured()
        self.begin_walk("--source", "pilot")
        before = self.status()["counters"]["commands_rejected"]
        peer = self.begin("other", [PEER, "commander", str(self.domain), "zebro-1", "other:probe"],
                          CYCLONEDDS_URI=self.loopback_and(uri(self.enclave("other"))))
        self.wait_for_text(peer, "ready", BOOT_S)
        peer.say("heartbeat pilot 1")
        for source in ("pilot", "pilot:1", "other-pilot", ""):
            peer.say(f"command {source or '-'} 1000 2 0 0")
        peer.say("command other:1 1001 2 1 0")  # its own name, a dry run: it is not the holder
        wait_until(lambda: "ack other:1 1001" in peer.out(), BOOT_S, "its own name is answered")
        self.assertEqual([line for line in peer.out().splitlines() if line.startswith("ack") and "other:1" not in line], [])
        self.assertEqual(self.status()["mode"], "Walking")
        self.wait_status(lambda s: s["counters"]["commands_rejected"] >= before + 4, BOOT_S, "they are counted")
        self.wait_log(daemon, "is not the name of their certificate")
        wrong = self.cli("--source", "other", "stop", "--dry-run")
        self.assertEqual(wrong.code, EXIT["usage"], wrong)
        self.assertIn("not in the name of the certificate, 'pilot'", wrong.err)

    def test_a_revoked_certificate_is_refused_and_its_name_can_have_another(self):
        daemon = self.start_secured()
        self.assertEqual(self.as_enclave("other", "status").code, 0)
        lost, old = os.path.join(self.folder, "lost"), os.path.join(self.folder, "old")
        shutil.copytree(self.enclave("other"), lost)  # the thief's copy, without a list
        shutil.copytree(self.enclave("watcher"), old)  # of a computer that did not get it yet
        self.cli_ok("keystore", "revoke", self.keystore, "other")
        self.cli_ok("keystore", "add", self.keystore, "other", "--role", "command")
        daemon.stop()
        self.start_daemon(self.secured())
        self.assertEqual(self.as_enclave("pilot", "status").code, 0)
        self.assertEqual(self.as_enclave("other", "status").code, 0)
        self.assertEqual(self.cli("--enclave", old, "--timeout", "20s", "status").code, 0)
        refused = self.cli("--enclave", lost, "--timeout", "5s", "stop")
        self.assertEqual(refused.code, EXIT["unreachable"], refused)

    def test_who_has_no_list_of_revoked_certificates_is_warned(self):
        daemon = self.start_secured()
        self.assertNotIn("warning", self.cli_ok("stop", "--dry-run").err)
        for name in ("pilot", "zebro-1"):
            os.remove(os.path.join(self.enclave(name), "crl.pem"))
        daemon.stop()
        warned = "crl.pem is missing: revoked certificates are accepted"
        self.wait_log(self.start_daemon(self.secured()), warned)
        self.assertIn(warned, self.cli_ok("stop", "--dry-run").err)
        self.wait_log(Gateway(self).program, warned)
        face = self.begin("lss-ros", [os.path.join(self.TOOLS, "lss-ros"), "--ros-domain", str(self.domain)])
        self.wait_log(face, warned)

    def test_no_vehicle_is_believed_in_the_name_of_another(self):
        self.start_secured()
        self.begin_walk("--source", "pilot")
        before = self.status()["counters"]["commands_rejected"]
        page = Gateway(self).client()
        page.wait_for(lambda m: m["type"] == "status")
        intruder = self.begin("intruder", [ATTACK, "intrude", str(self.domain), "zebro-1", "--source", "lssd", "--rate", "20",
                                           "--seconds", "20"], CYCLONEDDS_URI=uri(self.enclave("zebro-2")))
        self.wait_status(lambda s: s["counters"]["commands_rejected"] > before, 20, "its heartbeats are dropped")
        status = self.status()
        self.assertEqual((status["mode"], status["authority"], len(status["daemons"])), ("Walking", "pilot", 1))
        self.assertEqual(status["faults"], [])
        said = json.dumps(self.events())
        for forged in ("forged", "name_conflict"):
            self.assertNotIn(forged, said)
        self.assertEqual([v["vehicle_id"] for v in json.loads(self.cli_ok("--json", "fleet").out)["vehicles"]], ["zebro-1"])
        shown = []
        while not any(m["type"] == "status" and m["frame"]["index"] > status["frame"]["index"] for m in shown):
            shown.append(page.read())
        self.assertEqual({m["authority"] for m in shown if m["type"] == "status"}, {"pilot"})
        self.assertNotIn("forged", json.dumps(shown))
        self.assertTrue(intruder.running(), "all this while")
        self.assertEqual(intruder.wait(60), 0)
        counts = json.loads(intruder.out())
        for topic in ("ack", "status", "event", "heartbeat"):
            self.assertGreater(counts[f"matched_{topic}"], 0, "it was on the wire")

    def test_a_vehicle_does_not_start_with_the_certificate_of_another(self):
        self.keystore = self.make_keystore()
        self.start_sim()
        said = self.refused(self.enclave("zebro-2"))
        self.assertIn("is of 'zebro-2', not of zebro-1", said)
        self.assertIn("lss-cli keystore add KEYSTORE zebro-1 --role vehicle", said)

    def test_systemd_does_not_start_a_daemon_again_that_cannot_use_its_enclave(self):
        self.keystore = self.make_keystore()
        self.start_sim()
        own, other = self.enclave("zebro-1"), self.enclave("zebro-2")
        broken = os.path.join(self.folder, "broken")

        def with_file(name, source):
            shutil.rmtree(broken, ignore_errors=True)
            shutil.copytree(own, broken)
            os.remove(os.path.join(broken, name))
            if source:
                shutil.copy(source, os.path.join(broken, name))
            return self.refused(broken)
        self.assertIn("cannot be read", with_file("key.pem", None))
        self.assertIn("is not the key of", with_file("key.pem", os.path.join(other, "key.pem")))
        self.assertIn("refuse the enclave", with_file("permissions.p7s", os.path.join(other, "permissions.p7s")))
        strange = self.make_keystore("strangers", {"zebro-1": "vehicle"})
        permissions = os.path.join(self.enclave("zebro-1", strange), "permissions.p7s")
        self.assertIn("is not signed by", with_file("permissions.p7s", permissions))
        commander = self.make_keystore("commanders", {"zebro-1": "command"})
        self.assertIn("do not allow it", self.refused(self.enclave("zebro-1", commander)))

    def refused(self, enclave):
        """What the daemon says. 78: RestartPreventExitStatus= of systemd/lssd@.service.in."""
        daemon = self.start_daemon(self.write_config(enclave=f'"{enclave}"'), wait=False)
        self.assertEqual(daemon.wait(BOOT_S), 78, enclave)
        return daemon.err() + daemon.out()

    def wait_log(self, program, text):
        wait_until(lambda: text in program.out() + program.err(), BOOT_S, text)

    def loopback_and(self, security):
        return ('<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo" multicast="true"/>'
                f"</Interfaces></General>{security}</Domain></CycloneDDS>")

    def test_who_may_only_look_sees_the_status_of_a_vehicle_that_sends_telemetry_on_request(self):
        self.start_secured(mode='"on_request"')
        for looker in ("watcher", "stopper"):
            status = self.as_enclave(looker, "status")
            self.assertEqual(status.code, 0, status)
            self.assertIn("Idle", status.out)

    def test_systemd_does_not_start_a_service_again_whose_role_does_not_suffice(self):
        self.start_secured()
        for name, program, *words in (("watcher", "lss-ground", "--listen", "127.0.0.1:0"),
                                      ("pilot", "lss-ros", "--ros-domain", str(self.domain))):
            refused = run([os.path.join(self.TOOLS, program), *words, "--enclave", self.enclave(name)], self.environment(), 60)
            self.assertEqual(refused.code, EXIT["usage"], refused)  # RestartPreventExitStatus= of their units
            self.assertIn("the permissions of the enclave do not allow", refused.err)

    def test_each_role_may_what_it_may(self):
        self.start_secured()
        self.begin_walk("--source", "pilot")
        for words in (("estop",), ("--source", "watcher", "stop", "--dry-run")):
            looker = self.as_enclave("watcher", *words)
            self.assertEqual(looker.code, EXIT["not_authorised"], looker)
            self.assertIn("may only look", looker.err)
        status = self.as_enclave("watcher", "status")
        self.assertEqual(status.code, 0, status)
        stopper = self.as_enclave("stopper", "stop", "--dry-run")
        self.assertEqual(stopper.code, EXIT["not_authorised"], stopper)
        self.assertIn("may only stop", stopper.err)
        self.assertEqual(self.status()["mode"], "Walking")
        stopped = self.as_enclave("stopper", "--source", "not-its-name", "estop")
        self.assertEqual(stopped.code, 0, stopped)
        self.wait_state(FATAL_ERROR)
        self.keystore = None
        nobody = self.cli("--timeout", "2s", "status")
        self.assertEqual(nobody.code, EXIT["unreachable"], nobody)

    @real_time("the clock that is set is the wall clock")
    def test_a_keystore_of_ros2_serves_unaltered_and_a_wrong_clock_is_waited_for_or_allowed_for_loudly(self):
        self.keystore = os.path.join(self.folder, "ros2")
        make_ros2_keystore(self.keystore, ["zebro-1", "pilot"])
        self.start_sim()
        daemon = self.start_daemon(self.secured())
        self.wait_log(daemon, "CVE-2023-24011")
        self.cli_ok("stop", "--dry-run")
        daemon.stop()

        clock = os.path.join(self.folder, "clock")
        late = {"LD_PRELOAD": CLOCK, "LSS_E2E_CLOCK": clock}
        for days, advice in ((20_000, "or set the clock"), (-1000, "dds.security.clock_slack_days")):
            with open(clock, "wb") as file:
                file.write((days * 86400).to_bytes(8, sys.byteorder, signed=True))
            began_s = time.monotonic()
            refused = self.start_daemon(self.secured(), wait=False, **late)
            self.assertEqual(refused.wait(BOOT_S), 1, "systemd starts it again")
            self.assertGreater(time.monotonic() - began_s, 4, "but not every 20 ms")
            self.assertIn(advice, refused.err() + refused.out())
        for program, *words in (["lss-ground", "--listen", "127.0.0.1:0"], ["lss-ros", "--ros-domain", str(self.domain)]):
            early = run([os.path.join(self.TOOLS, program), *words, "--enclave", self.enclave("pilot")],
                        {**self.environment(), **late}, BOOT_S)
            self.assertEqual(early.code, 1, f"systemd starts it again, until the clock is set: {early}")
        daemon = self.start_daemon(self.secured(clock_slack_days="1001"), **late)
        self.wait_log(daemon, "expired certificates are accepted")
        self.cli_ok("stop", "--dry-run")

    @real_time("the clock that is set is the wall clock")
    def test_programs_that_run_on_warn_of_a_certificate_that_expires(self):
        self.keystore = self.make_keystore(roles={"zebro-1": "vehicle", "pilot": "command", "bridge": "bridge"})  # 3650 days
        self.start_sim()
        self.clock = os.path.join(self.folder, "clock")
        self.set_clock(0)
        clock = {"LD_PRELOAD": CLOCK, "LSS_E2E_CLOCK": self.clock}
        daemon = self.start_daemon(self.secured(), **clock)
        page = Gateway(self, **clock).program
        ros = self.begin("lss-ros", [os.path.join(self.TOOLS, "lss-ros"), "--ros-domain", str(self.domain)], **clock,
                         LSS_ENCLAVE=self.enclave("bridge"))
        self.wait_log(ros, "on ROS domain")
        for program in (daemon, page, ros):
            self.assertNotIn("expires in", program.out() + program.err())
        self.set_clock(3630 * 86400)
        self.wait_log(daemon, "a certificate of DDS Security expires in 19 days")
        for program, name in ((page, "pilot"), (ros, "bridge")):
            self.wait_log(program, f"enclaves/{name} expires in 19 days: make a new one before")
        self.set_clock(3652 * 86400)
        self.wait_log(daemon, "a certificate of DDS Security expired 2 days ago")
        for program, name in ((page, "pilot"), (ros, "bridge")):
            self.wait_log(program, f"enclaves/{name} expired 2 days ago: make a new one")

    def test_peers_that_are_killed_and_restarted_are_back_in_time(self):
        self.keystore = self.make_keystore()
        self.start_sim()
        config = self.secured()
        daemon = self.start_daemon(config)
        kept = self.begin_watch("kept")
        self.hear(kept)
        daemons, clients = [], []
        for _ in range(ROUNDS):
            daemon.kill()
            begun_s = time.monotonic()
            daemon = self.start_daemon(config, wait=False)
            self.hear(kept, daemon)
            daemons.append(time.monotonic() - begun_s)
            begun_s = time.monotonic()
            client = self.begin_watch("client")
            self.hear(client, daemon)
            clients.append(time.monotonic() - begun_s)
            client.kill()
        for who, times in (("a daemon", daemons), ("a client", clients)):
            print(f"{who} killed {ROUNDS} times: back after {statistics.median(times):.2f} s, at most {max(times):.2f} s")
            self.assertLessEqual(statistics.median(times), REJOIN_S, who)

    def begin_watch(self, name):
        return self.begin(name, [ATTACK, "watch", str(self.domain), "zebro-1", "--seconds", "3600"],
                          CYCLONEDDS_URI=uri(self.enclave("watcher")))

    def hear(self, watcher, daemon=None):
        wait_until(lambda: any("pid" in s and (daemon is None or s["pid"] == daemon.process.pid)
                               for s in watcher.json_lines()), 60, "its status is heard", poll_s=0.01, most_s=0.05)

    @real_time("simulated time takes no shared memory", any_machine=True)
    def test_shared_memory_contains_nothing_of_a_protected_topic(self):
        self.take_roudi()
        self.keystore = self.make_keystore()
        self.start_sim()
        found = {}
        for secured in (True, False):
            if not secured:
                self.keystore = None
            roudi = self.start_roudi()
            write_config = self.secured if secured else self.write_config
            daemon = self.start_daemon(write_config(shared_memory=True))
            status = self.wait_modules()
            found[secured] = (status["shared_memory"], self.in_shared_memory(roudi))
            daemon.stop()
            roudi.stop()
        self.assertEqual(found[True], ("off", []))
        state, topics = found[False]
        self.assertEqual(state, "active")
        self.assertIn("vehicle_id", topics)
        self.assertIn("lss/telemetry/zebro", topics)

    def in_shared_memory(self, roudi):
        """Which of our words stand in the memory that RouDi shares."""
        with open(f"/proc/{roudi.process.pid}/maps", encoding="utf-8") as file:
            segments = {line.split()[5] for line in file if "/dev/shm/" in line}
        self.assertGreaterEqual(len(segments), 2, "its management and its data")
        words = {"vehicle_id": b"zebro-1\0", "lss/telemetry/zebro": b"lss/telemetry/zebro", "lss/timing": b"lss/timing",
                 "lss/status": b"lss/status"}
        held = set()
        for segment in segments:
            with open(segment, "rb") as file:
                data = file.read()
            held |= {name for name, word in words.items() if word in data}
        return sorted(held)

    @real_time("the packets are those of a wire")
    def test_packets_that_are_sent_again_change_nothing(self):
        try:
            tap = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(3))
        except PermissionError:
            self.skipTest("skipped: may not read packets")
        tap.bind(("lo", 0))
        tap.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 24)
        tap.settimeout(0.2)
        self.addCleanup(tap.close)
        self.start_secured()
        ports = range(7400 + 250 * self.domain, 7650 + 250 * self.domain)
        packets = []
        keep = threading.Thread(target=self.keep_packets, args=(tap, ports, packets))
        self.keeping = True
        keep.start()
        self.cli_ok("start")
        self.keeping = False
        keep.join()
        before = self.wait_status(lambda s: s["state"] == IDLE, 60, "its lease is over")
        self.assertGreater(len(packets), 10)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(sender.close)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        for _ in range(3):
            for to, data in packets:
                sender.sendto(data, to)
        after = self.status()  # by a new participant, so the daemon has seen all that came before
        self.assertEqual(after["counters"]["commands_rejected"], before["counters"]["commands_rejected"])
        self.assertEqual(after["state"], IDLE)

    def keep_packets(self, tap, ports, packets):
        """(address, payload) of UDP to these ports."""
        while self.keeping:
            try:
                packet, where = tap.recvfrom(1 << 16)
            except TimeoutError:
                continue
            header = 4 * (packet[0] & 15)
            port = int.from_bytes(packet[header + 2:header + 4], "big")
            if where[2] != 4 and packet[9] == socket.IPPROTO_UDP and port in ports:  # each once, not as it leaves
                packets.append(((socket.inet_ntoa(packet[16:20]), port), packet[header + 8:]))
