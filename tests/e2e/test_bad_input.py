"""Bad input from all sides: each has a clear error or a defined reaction."""

import os
import random
import re
import time
import unittest

import motion
import wire
from programs import read_text, run, wait_until
from rig import BOOT_S, DAEMON, EXIT, FATAL_ERROR, FAULT, IDLE, OPERATIONAL, REJECTED, SOURCE, Scenario, own_domain, real_time

UNKNOWN, NOT_FINITE, OUT_OF_RANGE, NOT_A_CHOICE, BAD_SOURCE, STALE, BAD_LEASE, UNUSED = 1, 3, 4, 5, 6, 7, 9, 26
NO_PARAMETER, BAD_NAME, UNUSED_NAME = 72, 96, 97
ACCEPTED_OR_DONE = (0, 2, 3)
START, STOP, DATA, SET, WALK = 1, 2, 6, 9, 104


class BadConfiguration(Scenario):
    IN_LOCKSTEP = True

    def refuse(self, path, limit_s=10, domain=None, code=None):
        """Message of lssd when it does not start; code 78: systemd does not start it again."""
        result = run([DAEMON, "--config", path, "--run-dir", self.run_folder,
                      "--domain", str(domain or self.domain)], self.environment(), limit_s)
        self.assertNotEqual(result.code, 0, result)
        self.assertGreater(result.code, 0, f"not by a signal: {result}")
        self.assertEqual(result.code, code or result.code, result)
        return result.out + result.err

    def test_every_error_of_a_configuration_is_reported_with_file_and_line(self):
        good = read_text(os.path.join(SOURCE, "config", "zebro.toml"))
        cases = {  # what: old line, new line, words that must be in the message
            "unknown key": ("period_ms = 20", "period_ms = 20\nflavour = 3 #", ["flavour"]),
            "wrong unit": ("period_ms = 20", "period_s = 0.02", ["period_s", "period_ms"]),
            "wrong type": ("offset_ms = 5", 'offset_ms = "5"', ["offset_ms"]),
            "out of range": ("baud = 115200", "baud = -1", ["baud"]),
            "not a choice": ('duplex = "full"', 'duplex = "double"', ["duplex", "half"]),
            "not a number": ("flight_s = 3.0", "flight_s = nan", ["flight_s"]),
            "unsynchronised gait": ("[zebro.gait]", "[zebro.gait]\nstance_min_s = 30.0 #", ["stance"]),
            "no TOML": ("[frame]", "[frame", []),
        }
        for what, (old, new, words) in cases.items():
            with self.subTest(what):
                self.assertEqual(good.count("\n" + old), 1)
                text = good.replace("\n" + old, "\n" + new)
                if what == "unsynchronised gait":
                    text = text.replace("\nstance_min_s = 3.3", "\n#")
                wrong = new.split("\n")[0 if what == "unsynchronised gait" else -1]  # several keys: their table
                line = text[:text.index(wrong)].count("\n") + 1
                path = os.path.join(self.folder, "wrong.toml")
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
                said = self.refuse(path, code=78)
                self.assertRegex(said, re.escape(path) + rf":{line}\b")
                for word in words:
                    self.assertIn(word, said)
        self.assertIn("missing.toml", self.refuse(os.path.join(self.folder, "missing.toml")))

    def test_a_silent_obc_that_would_break_off_a_safe_stop_is_refused(self):
        said = self.refuse(self.write_config(obc_timeout_s="5"), code=78)
        self.assertIn("[link] obc_timeout_s is 5: a silent OBC would break off a safe stop", said)
        self.assertIn("at least 12.0", said)

    def test_frames_too_long_to_see_a_leg_that_stands_still_are_refused(self):
        said = self.refuse(self.write_config(period_ms="70"), code=78)
        self.assertIn("[frame] period_ms is 70: a leg that stands still would not be found", said)
        self.assertIn("at most 50", said)

    def test_a_command_line_with_errors_is_not_tried_again(self):
        no_restart = 78  # RestartPreventExitStatus= of systemd/lssd@.service.in
        for words, domain, named in [(["--bogus"], "7", "--bogus"), ([], "7", "--config"), (["--config"], "7", "--config"),
                                     (["--config", "x.toml"], "here", "here"), (["--domain", "231"], "7", "231")]:
            with self.subTest(words=words):
                result = run([DAEMON, *words], {**self.environment(), "LSS_DOMAIN": domain}, 10)
                self.assertEqual(result.code, no_restart, result)
                self.assertIn(named, result.err)

    def test_a_port_that_is_no_terminal_is_refused_by_name(self):
        file = os.path.join(self.folder, "plain-file")
        with open(file, "w", encoding="ascii"):
            pass
        said = self.refuse(self.write_config(path=f'"{file}"'), BOOT_S)
        self.assertIn(file, said)
        self.assertRegex(said, "(?i)terminal|tty|serial port")

    def test_a_second_daemon_on_one_port_leaves_with_a_clear_error(self):
        first = self.start_all()
        domain, lock = own_domain()
        try:
            said = self.refuse(self.write_config("second.toml"), BOOT_S, domain)
        finally:
            lock.close()
        self.assertIn("legs", said)
        self.assertRegex(said, "(?i)in use|used by|another|busy|locked")
        self.assertTrue(first.running())
        self.cli_ok("run", "-e", "start; stop")

    @real_time("a daemon before its simulator")
    def test_a_missing_port_is_reported_refuses_motion_and_is_taken_when_it_comes(self):
        self.start_daemon()
        status = self.wait_status(lambda s: FAULT["port_absent"] in self.fault_ids(s), 10, "the port is missed")
        self.assertEqual(status["state"], IDLE)
        refused = self.cli("start")
        self.assertEqual(refused.code, EXIT["rejected"], refused)
        self.start_sim()
        status = self.wait_modules()
        self.wait_status(lambda s: FAULT["port_absent"] not in self.fault_ids(s), 10, "it is missed no more")
        self.cli_ok("run", "-e", "start; stop")


class BadCommands(Scenario):
    IN_LOCKSTEP = True

    # [Env-2]
    def test_commands_that_make_no_sense_are_rejected_with_the_reason(self):
        self.start_all()
        peer = self.commander()
        sequence = 0

        def answer(kind, parameters=(), lease_ms=1000, source="stranger", number=None, name=""):
            nonlocal sequence
            sequence += 1
            own = sequence if number is None else number
            seen = peer.out().count(f" {own} {kind} ")
            numbers = [*parameters, *[0] * (8 - len(parameters))] if name else parameters
            words = " ".join([*(str(p) for p in numbers), name])
            peer.say(f"command {source} {own} {kind} 0 {lease_ms} {words}")
            pattern = re.compile(rf"^ack (\S+) {own} {kind} (\d) (\d+) ", re.M)
            found = wait_until(lambda: pattern.findall(peer.out())[seen:], 10, f"{source} {own} {kind} is answered",
                               poll_s=0.01)
            return int(found[0][1]), int(found[0][2])

        rejections = 0
        for what, sent, reasons in [
                ("unknown kind", dict(kind=9999), [UNKNOWN]),
                ("kind of another vehicle", dict(kind=250), [UNKNOWN]),
                ("heading out of range", dict(kind=WALK, parameters=[1, 1.58, 2]), [OUT_OF_RANGE]),
                ("heading not a number", dict(kind=WALK, parameters=[1, "nan", 2]), [NOT_FINITE]),
                ("heading infinite", dict(kind=WALK, parameters=[1, "-inf", 2]), [NOT_FINITE]),
                ("speed out of range", dict(kind=WALK, parameters=[1, 0, 7]), [OUT_OF_RANGE, NOT_A_CHOICE]),
                ("speed between two", dict(kind=WALK, parameters=[1, 0, 1.5]), [NOT_A_CHOICE]),
                ("a parameter too many", dict(kind=WALK, parameters=[1, 0, 2, 0, 0, 0, 0, 5]), [UNUSED]),
                ("no such parameter", dict(kind=SET, parameters=[1], name="limits.curent_A"), [NO_PARAMETER]),
                ("parameter of another vehicle", dict(kind=SET, parameters=[1], name="mobility.ratio_p"), [NO_PARAMETER]),
                ("no name", dict(kind=SET, parameters=[1]), [BAD_NAME]),
                ("a name without an end", dict(kind=SET, parameters=[1], name="-"), [BAD_NAME]),
                ("a name too many", dict(kind=WALK, parameters=[1, 0, 2], name="limits.current_A"), [UNUSED_NAME]),
                ("no lease", dict(kind=START, lease_ms=0), [BAD_LEASE]),
                ("an hour's lease", dict(kind=START, lease_ms=3600000), [BAD_LEASE]),
                ("source without an end", dict(kind=DATA, lease_ms=0, source="-"), [BAD_SOURCE])]:
            with self.subTest(what):
                phase, reason = answer(**sent)
                self.assertEqual(phase, REJECTED)
                self.assertIn(reason, reasons)
                rejections += 1

        phase, _ = answer(STOP, lease_ms=0, number=1000)
        self.assertIn(phase, ACCEPTED_OR_DONE)
        final = lambda: re.search(r"^ack stranger 1000 2 3 ", peer.out(), re.M)
        wait_until(final, 10, "it is stopped")
        self.assertEqual(answer(STOP, lease_ms=0, number=1000), (REJECTED, STALE), "repeated")
        self.assertEqual(answer(STOP, lease_ms=0, number=999), (REJECTED, STALE), "stale")
        self.assertIn(answer(DATA, lease_ms=0, number=999)[0], ACCEPTED_OR_DONE, "what anyone may send is not counted")
        status = self.wait_status(lambda s: s["counters"]["commands_rejected"] >= rejections + 2, 5, "counted")
        self.assert_resting(status)
        self.assertEqual(self.fault_ids(status) - {FAULT["bus_noise"]}, set())

    def test_a_second_commander_is_not_authorised_while_the_first_one_walks(self):
        self.start_all()
        self.begin_walk("--source", "first")
        second = self.cli("--source", "second", "walk", "backward")
        self.assertEqual(second.code, EXIT["not_authorised"], second)
        self.assertIn("first", second.err)
        self.assertEqual(self.cli("--source", "second", "stop").code, EXIT["not_authorised"])
        status = self.status()
        self.assertEqual((status["state"], status["mode"], status["authority"]), (OPERATIONAL, "Walking", "first"))

    @real_time("no daemon", any_machine=True)
    def test_the_command_line_says_what_is_wrong_in_bounded_time(self):
        asked = [self.begin_cli(*words, name=words[0])
                 for words in (["status"], ["walk", "forward", "--for", "1s"], ["estop"], ["health"])]
        for client in asked:
            with self.subTest(client.name):
                self.assertEqual(client.wait(15), EXIT["unreachable"], client.err())
        unknown = self.cli("wlak", "forward", limit_s=5)
        self.assertIn(unknown.code, (EXIT["usage"], EXIT["unknown_name"]))
        self.assertIn("walk", unknown.err)
        for words in (["walk", "sideways"], ["walk", "forward", "--speed", "hihg"], ["walk", "--heading", "120"],
                      ["walk", "--heading", "nan"], ["walk", "--for", "soon"], []):
            with self.subTest(words):
                wrong = self.cli(*words, limit_s=5)
                self.assertIn(wrong.code, (EXIT["usage"], EXIT["unknown_name"]), wrong)
                self.assertNotEqual(wrong.err, "")


class BadBytes(Scenario):
    def disturb(self, dice, seconds):
        """Noise, cut and merged frames in both directions, a little of it every 0.3 s."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            direction = dice.randrange(2)
            kind = dice.choice(["inject", "truncate", "merge"])
            self.tap.say(f"inject {direction} {dice.randbytes(40).hex()}" if kind == "inject"
                         else f"{kind} {direction} {dice.randint(1, 2)}")
            time.sleep(0.3)  # the rate of the disturbance

    # [Env-1] [Env-2]
    def test_random_bytes_and_broken_frames_are_dropped_counted_and_walked_through(self):
        daemon = self.start_tapped()
        self.begin_walk()
        before = self.status()
        began_ns = time.monotonic_ns()
        self.disturb(random.Random(5), 20)
        ended_ns = time.monotonic_ns()
        after = self.status()
        self.assertTrue(daemon.running())
        self.assertEqual((after["state"], after["mode"]), (OPERATIONAL, "Walking"), after["faults"])
        dropped = after["telemetry"]["bus_frames_dropped"] - before["telemetry"]["bus_frames_dropped"]
        resent = sum(a["resends"] - b["resends"] for a, b in zip(after["telemetry"]["modules"], before["telemetry"]["modules"]))
        forward_m = motion.moved(motion.at(self.truth, began_ns), motion.at(self.truth, ended_ns))[0]
        print(f"{dropped} frames dropped, {resent} re-sent, {forward_m * 1e3:.0f} mm")
        self.assertGreater(dropped, 20)
        self.assertGreater(forward_m, 0.1)

    def test_replies_that_are_all_broken_are_an_emergency(self):
        daemon = self.start_tapped()
        self.begin_walk()
        began_ns = time.monotonic_ns()
        self.tap.say(f"truncate {wire.TO_DAEMON} 700")  # about two seconds of replies
        status = self.wait_state(FATAL_ERROR, 15)
        self.assertIn(FAULT["module_silent"], self.fault_ids(status))
        event = next(e for e in self.events() if e["id"] == 1000 + FAULT["module_silent"])
        self.assertLess(event["time_ns"] - began_ns, 1.5e9, "module_silent_ms is 500")
        told = [f for f in self.orders(began_ns) if f.code == wire.EMERGENCY]
        self.assertTrue(told)
        self.assertTrue(daemon.running())
        self.wait_modules()
        self.cli_ok("solve")
        self.wait_state(IDLE)


if __name__ == "__main__":
    unittest.main()
