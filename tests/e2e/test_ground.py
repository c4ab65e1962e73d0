"""The pilot's gateway: access, invalid messages, and the safe stop after the loss of a page."""

import json
import os
import signal
import socket
import threading
import time

from programs import run, wait_until
from recordings import Recorded, foreign
from rig import BOOT_S, IDLE, OPERATIONAL, TOOLS, Scenario, read_text, real_time
from ws import Closed, Refused, WebSocket

FOXGLOVE = "foxglove.websocket.v1"
KEYS = {"look": "look" * 8, "stop": "stop" * 8, "command": "command" * 4}


class Gateway:
    """lss-ground of a scenario, and clients that it lets in."""

    def __init__(self, scenario, *words, port=0, address="127.0.0.1", **how):
        self.program = scenario.begin(
            "lss-ground", [os.path.join(scenario.TOOLS, "lss-ground"), "--listen", f"{address}:{port}", *words], **how)
        scenario.wait_for_text(self.program, "http", 20)
        self.port = int(read_text(self.program.out_path).split(":")[2].split("/")[0])
        self.scenario = scenario

    def client(self, protocol="lss-ground", key="", session="", **how):
        client = WebSocket(self.port, protocol, **how)
        self.scenario.addCleanup(client.close)
        client.hello(key, session)
        return client


class Beating:
    """A page's heartbeat, and all messages to it but telemetry, which it receives only: decoding takes a third of a CPU of
    ten of them. Until stopped."""

    def __init__(self, client):
        self.client, self.messages, self.alive = client, [], True
        self.threads = [threading.Thread(target=run, daemon=True) for run in (self.beat, self.listen)]
        for thread in self.threads:
            thread.start()

    def beat(self):
        count = 0
        while self.alive:
            count += 1
            try:
                self.client.send(type="beat", n=count)
            except OSError:
                return
            time.sleep(0.2)

    def listen(self):
        try:
            while self.alive:
                text = self.client.read_text()
                if b'"type":"telemetry"' not in text:
                    self.messages.append(json.loads(text))
        except (Closed, OSError):
            pass

    def acks(self, request):
        return [m for m in list(self.messages) if m["type"] == "ack" and m["request"] == request]

    def phases(self, request):
        return [(m["step"].split()[0], m["phase"]) for m in self.acks(request)]

    def ends(self, request, limit_s):
        wait_until(lambda: any(m["final"] for m in self.acks(request)), limit_s, f"answer of {request}")
        return self.acks(request)[-1]

    def counters(self):
        return [m for m in list(self.messages) if m["type"] == "pulse"][-1]["gateway"]

    def stop(self):
        self.alive = False


class Ground(Recorded, Scenario):
    IN_LOCKSTEP = True

    def keyed(self):
        path = os.path.join(self.folder, "ground.keys")
        with open(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600), "w", encoding="ascii") as file:
            file.write("# who\n" + "".join(f"{role} {key}\n" for role, key in KEYS.items()))
        return Gateway(self, "--key-file", path)

    def wait_mode(self, name, limit_s):
        self.wait_status(lambda s: s["mode"] == name, limit_s, name)

    def walk(self, client, request=1):
        client.send(type="command", id=request, vehicle="zebro-1", command="walk", parameters={"speed": 3}, whole=True)

    def test_a_page_walks_zebro_and_its_end_stops_it_safely(self):
        self.start_all()
        gateway = Gateway(self)
        client = gateway.client(session="a session that only it knows")
        self.assertEqual(client.wait_for(lambda m: m["type"] == "vehicle")["vehicle"], "zebro")
        page = Beating(client)
        client.send(type="command", id=7, vehicle="zebro-1", command="walk", dry_run=True)
        self.assertEqual(page.ends(7, 5)["reason"]["name"], "not_in_state")
        client.send(type="command", id=8, vehicle="zebro-1", command="walk", dry_run=True, whole=True)
        self.assertEqual(page.ends(8, 5)["phase"], "accepted")
        self.assertEqual(self.status()["counters"]["commands_rejected"], 0, "who only asks is not counted")

        self.walk(client)
        wait_until(lambda: ("walk", "executing") in page.phases(1), 40, "it walks")
        steps = [step for step, phase in page.phases(1) if phase == "completed"]
        self.assertEqual(steps, ["start", "stand"])
        source = self.status()["authority"]
        self.assertTrue(source.startswith("ground:"))

        other = gateway.client()
        other.wait_for(lambda m: m["type"] == "vehicle")
        self.walk(other, 2)
        refused = other.wait_for(lambda m: m["type"] == "ack")
        self.assertEqual(refused["reason"]["name"], "not_authorised")

        page.stop()
        client.socket.shutdown(socket.SHUT_RDWR)  # the tab is closed
        self.wait_status(lambda s: s["state"] == IDLE, 40, "without its page it stops safely")
        self.assertEqual(self.status()["faults"], [])

    def test_a_killed_gateway_leaves_a_vehicle_that_stops_safely_and_the_next_shows_the_truth(self):
        self.start_all()
        gateway = Gateway(self)
        client = gateway.client(session="a session that only it knows")
        client.wait_for(lambda m: m["type"] == "vehicle")
        page = Beating(client)
        self.walk(client)
        wait_until(lambda: ("walk", "executing") in page.phases(1), 40, "it walks")
        source = self.status()["authority"]
        gateway.program.process.send_signal(signal.SIGKILL)
        page.stop()
        self.wait_status(lambda s: s["state"] == IDLE, 40, "without the gateway it stops safely")
        gateway = Gateway(self, port=gateway.port)
        again = WebSocket(gateway.port)
        welcome = again.hello(session="a session that only it knows")
        self.assertEqual(welcome["source"], source, "who comes back keeps the name")
        come = {}  # the first of each type: a gateway that has not heard the vehicle yet sends events before its status

        def complete(message):
            come.setdefault("event" if message["type"] == "events" else message["type"], message)
            return {"status", "event"} <= come.keys()
        again.wait_for(complete)
        status = come["status"]
        self.assertEqual((status["state"], status["authority"], status["alive"]), (IDLE, None, True))
        self.assertEqual(come["event"]["id"], "zebro-1")

    def test_a_page_that_comes_back_in_time_goes_on_walking(self):
        self.start_all()
        gateway = Gateway(self, "--lease-ms", "6000")
        client = gateway.client(session="a session that only it knows")
        client.wait_for(lambda m: m["type"] == "vehicle")
        page = Beating(client)
        self.walk(client)
        wait_until(lambda: ("walk", "executing") in page.phases(1), 40, "it walks")
        page.stop()
        client.close()
        page = Beating(gateway.client(session="a session that only it knows"))
        back_ns = self.status()["time_ns"]
        status = self.wait_status(lambda s: s["time_ns"] > back_ns + 8e9, 20, "more than a lease passes")
        self.assertEqual(status["mode"], "Walking")

    def test_an_emergency_stop_has_a_line_of_its_own_and_is_acknowledged(self):
        self.start_all()
        gateway = self.keyed()
        commander = gateway.client(key=KEYS["command"])
        commander.wait_for(lambda m: m["type"] == "vehicle")
        page = Beating(commander)
        self.walk(commander)
        wait_until(lambda: ("walk", "executing") in page.phases(1), 40, "it walks")

        looker = gateway.client("lss-stop", KEYS["look"])
        looker.send(type="stop", id=1, vehicle="zebro-1")
        self.assertEqual(looker.wait_for(lambda m: m["type"] == "ack")["phase"], "rejected")
        self.assertEqual(self.status()["state"], OPERATIONAL)

        stopper = gateway.client("lss-stop", KEYS["stop"])
        stopper.send(type="stop", id=2, vehicle="zebro-1")
        ack = stopper.wait_for(lambda m: m["type"] == "ack" and m["final"])
        self.assertEqual(ack["phase"], "completed")
        print(f"emergency stop acknowledged by the daemon after {ack['after_ms']:.1f} ms")
        self.wait_status(lambda s: s["state"] == "FatalError", 5, "it is stopped")
        self.assertEqual(page.ends(1, 5)["phase"], "failed")
        gateway.program.stop()
        self.assertEqual(gateway.program.process.returncode, 0, "with clients that are connected")

    def start_second(self, vehicle_id):
        """Another daemon on the domain, without modules."""
        self.run_folder = os.path.join(self.folder, "second")
        os.mkdir(self.run_folder)
        return self.start_daemon(self.write_config("second.toml", vehicle_id=f'"{vehicle_id}"'), wait=False)

    @real_time("a second daemon without a simulator")
    def test_stop_all_reaches_every_vehicle_and_shows_each_answer(self):
        self.start_all()
        self.cli_ok("start")
        gateway = Gateway(self)
        page = Beating(gateway.client())
        self.start_second("zebro-2")

        def states():
            return {m["id"]: m["state"] for m in list(page.messages) if m["type"] == "status"}

        wait_until(lambda: states() == {"zebro-1": OPERATIONAL, "zebro-2": IDLE}, BOOT_S, "both are heard")
        stopper = gateway.client("lss-stop")
        stopper.send(type="stop", id=5)
        acks = []
        while not acks or not acks[-1]["final"]:
            acks.append(stopper.wait_for(lambda m: m["type"] == "ack" and m["request"] == 5))
        for vehicle in ("zebro-1", "zebro-2"):
            self.assertIn("completed", [a["phase"] for a in acks if a["vehicle"] == vehicle])
        self.assertEqual((acks[-1]["vehicle"], acks[-1]["phase"], acks[-1]["silent"]), ("*", "completed", []))
        wait_until(lambda: set(states().values()) == {"FatalError"}, 5, "both are stopped")

    @real_time("a second daemon without a simulator")
    def test_two_daemons_of_one_name_are_reported_until_one_is_gone(self):
        first = self.start_all()
        gateway = Gateway(self)
        page = Beating(gateway.client())
        second = self.start_second("zebro-1")

        def daemons():
            return {d["pid"]: d["host"] for d in [m for m in list(page.messages) if m["type"] == "status"][-1]["daemons"]}

        pids = {p.process.pid for p in (first, second)}
        wait_until(lambda: set(daemons()) == pids, BOOT_S, "both are shown")
        self.assertEqual(set(daemons().values()), {socket.gethostname()[:31]})
        second.kill()
        wait_until(lambda: not daemons(), 20, "one is gone")

    @real_time("a daemon without a simulator")
    def test_who_has_no_key_or_comes_from_a_foreign_page_does_not_get_in(self):
        self.start_daemon()
        gateway = self.keyed()
        here = f"http://127.0.0.1:{gateway.port}"
        for how in ({"origin": "http://elsewhere.example"}, {"origin": here, "host": "elsewhere.example"},
                    {"origin": "null"}, {"host": "elsewhere.example"}):
            with self.assertRaises(Refused, msg=str(how)):
                WebSocket(gateway.port, **how)
        WebSocket(gateway.port, origin=here).hello(KEYS["look"])

        for key in ("", "wrong", KEYS["command"][:-1], KEYS["command"] + "x"):
            client = WebSocket(gateway.port)
            client.send(type="hello", key=key)
            self.assertEqual(client.why_closed(), "wrong key", repr(key))
        client = WebSocket(gateway.port)
        self.walk(client)
        self.assertEqual(client.why_closed(), "say hello first")
        begun_s = time.monotonic()
        self.assertEqual(WebSocket(gateway.port).why_closed(), "did not say who it is")
        self.assertLess(time.monotonic() - begun_s, 8)

        looker = gateway.client(key=KEYS["look"])
        looker.wait_for(lambda m: m["type"] == "status")
        self.walk(looker)
        self.assertEqual(looker.wait_for(lambda m: m["type"] == "ack")["reason"]["text"], "this key may not command")
        counters = looker.wait_for(lambda m: m["type"] == "pulse")["gateway"]
        self.assertEqual((counters["refused"], counters["wrong_keys"]), (4, 4))

        for words, why in ((["--listen", "0.0.0.0:0"], "--key-file"), (["--key-file", "/dev/null/none"], "cannot read"),
                           (["--listen", "nowhere"], "is no address"), (["--tls-cert", "x"], "belong together"),
                           (["--page", "/dev/null"], "has no index.html"), (["--domain", "231"], "not in range")):
            refused = run([os.path.join(TOOLS, "lss-ground"), *words], self.environment(), 10)
            self.assertEqual((refused.code, why in refused.err), (2, True), refused)

    def test_parameters_are_reported_and_change_by_the_daemons_rules_and_by_who_may(self):
        gateway = self.keyed()
        client = gateway.client(key=KEYS["command"])  # before the daemon
        self.start_all()
        told = client.wait_for(lambda m: m["type"] == "parameters")
        self.assertEqual(told["id"], "zebro-1")
        listed = json.loads(self.cli_ok("--json", "param", "get").out)
        for key in ("vehicle_id", "save", "saved_parameters", "parameters"):
            self.assertEqual(told[key], listed[key])
        current = next(p for p in told["parameters"] if p["name"] == "limits.current_A")
        requests = iter(range(1, 100))

        def give(who, command, name="", **parameters):
            request = next(requests)
            who.send(type="command", id=request, vehicle="zebro-1", command=command, name=name, parameters=parameters)
            return who.wait_for(lambda m: m["type"] == "ack" and m["request"] == request and m["final"])

        refused = give(client, "set-parameter", current["name"], value=12)
        self.assertEqual((refused["phase"], refused["reason"]["name"]), ("rejected", "parameter_range"))
        self.assertEqual((refused["measured"], refused["limit"]), (12, current["max"]))
        self.assertIn("limits.current_A: 12 A is out of range, allowed 0.05 to 1.5 A", refused["reason"]["text"])
        rounds = next(p for p in told["parameters"] if p["whole"])
        self.assertEqual(give(client, "set-parameter", rounds["name"], value=rounds["min"] + 0.5)["reason"]["name"],
                         "parameter_whole")
        unknown = give(client, "set-parameter", "mobility.ratio_p", value=1)
        self.assertEqual((unknown["phase"], unknown["reason"]["name"]), ("rejected", "no_such_parameter"))
        self.assertIn("there is no parameter 'mobility.ratio_p'", unknown["reason"]["text"])
        for name, parameters in (("", {"value": 1}), ("limits.current_A ", {"value": 1}), ("limits.current_A", {}),
                                 ("limits.current_A", {"value": 1e300}), ("limits.current_A", {"value": 1, "more": 1})):
            self.assertEqual(give(client, "set-parameter", name, **parameters)["phase"], "rejected", parameters)
        self.assertEqual(give(client, "save-parameters", "limits.current_A")["reason"]["name"], "unused_name")
        self.assertEqual(give(client, "save-parameters", value=1)["phase"], "rejected")
        for value in ('"1"', "null", "true", "[1]", "1e999"):
            client.send_bytes(f'{{"type":"command","id":1,"vehicle":"zebro-1","command":"set-parameter","parameters":{{"value":{value}}}}}'
                              .encode())
            client.wait_for(lambda m: m["type"] == "bad")
        client.send(type="command", id=1, vehicle="zebro-1", command="set-parameter", name="x" * 48, parameters={"value": 1})
        client.wait_for(lambda m: m["type"] == "bad")
        for role in ("look", "stop"):
            other = gateway.client(key=KEYS[role])
            for command in ("set-parameter", "save-parameters"):
                refused = give(other, command, current["name"], value=1)
                self.assertEqual(refused["reason"]["text"], "this key may not command")
        self.assertEqual(json.loads(self.cli_ok("--json", "param", "diff").out)["parameters"], [], "nothing of this did anything")

        looker = gateway.client(key=KEYS["look"])

        def told_of(who, **values):
            who.wait_for(lambda m: m["type"] == "parameters" and any(
                {"name": current["name"], **values}.items() <= p.items() for p in m["parameters"]))

        told_of(looker, value=1.2, as_configured=True, as_saved=True)
        self.assertEqual(give(client, "set-parameter", current["name"], value=1.3)["phase"], "completed")
        told_of(looker, value=1.3, saved=None, as_configured=False, as_saved=False)
        self.assertEqual(give(client, "save-parameters")["phase"], "completed")
        told_of(looker, value=1.3, saved=1.3, as_configured=False, as_saved=True)
        told_of(gateway.client(key=KEYS["look"]), value=1.3, saved=1.3)
        self.assertEqual(json.loads(self.cli_ok("--json", "param", "get", "limits.current_A").out)["parameters"][0]["saved"], 1.3)

    @real_time("no frame is late")
    def test_nonsense_is_refused_and_a_thousand_connections_and_one_that_stops_reading_disturb_nobody(self):
        self.start_all()
        gateway = Gateway(self, "--clients", "20")
        client = gateway.client()
        client.wait_for(lambda m: m["type"] == "vehicle")
        page = Beating(client)
        self.cli_ok("timing", "--reset")

        bad = gateway.client()
        for text in ("", "{", "[]", "null", '"x"', '{"type":1}', '{"type":"beat"}', '{"type":"beat","n":-1}',
                     '{"type":"beat","n":1,"more":2}', '{"type":"stop","id":1}'):
            bad.send_bytes(text.encode())
        self.assertEqual(bad.why_closed(), "too many bad messages")
        bad = gateway.client()
        bad.send_bytes(b"x" * 40_000)
        self.assertEqual(bad.why_closed(), "a message was too long, or no text")
        bad = gateway.client()
        bad.send_bytes(b"{}", opcode=2)
        self.assertEqual(bad.why_closed(), "a message was too long, or no text")
        fast = gateway.client()
        try:
            for n in range(2000):
                fast.send(type="beat", n=n)
        except OSError:
            pass  # hung up on already
        self.assertIn(fast.why_closed(), ("too many messages a second", "without a word", "[Errno 104] Connection reset by peer"))
        odd = gateway.client()
        for number, (command, parameters) in enumerate((("fly", {}), ("walk", {"height": 1}), ("walk", {"speed": 1e300}),
                                                        ("leg", {}), ("leg", {"leg": 1.5, "position": 0}))):
            odd.send(type="command", id=number, vehicle="zebro-1", command=command, parameters=parameters)
            self.assertEqual(odd.wait_for(lambda m: m["type"] == "ack")["phase"], "rejected", command)

        slow = gateway.client(receive_bytes=4096)
        crowd, refused = [], 0
        for _ in range(1000):
            try:
                crowd.append(WebSocket(gateway.port))
            except Refused:
                refused += 1
        self.assertGreater(refused, 900)
        for client in crowd:
            client.close()
        # Viewers never block a client that stops on its own connection.
        gateway.client("lss-stop").close()
        wait_until(lambda: page.counters()["too_slow"] >= 1, 60, "who stops reading is dropped")
        counters = page.counters()
        self.assertEqual(counters["bad_messages"], 12)
        self.assertEqual(counters["too_fast"], 1)
        self.assertGreater(counters["refused"], 900)
        after = self.status()
        self.assertEqual((after["state"], after["faults"]), (IDLE, []))
        print("gateway", counters)
        self.assert_no_frame_waited()
        self.assertTrue(page.threads[1].is_alive(), "a client that behaves stays connected")
        slow.close()

    def foxglove(self, gateway, path="/", protocol=FOXGLOVE, **how):
        client = WebSocket(gateway.port, protocol, path=path, **how)
        self.addCleanup(client.close)
        return client, client.wait_for(lambda m: m["op"] == "serverInfo")

    def advertised(self, client, topic):
        channels = client.wait_for(lambda m: m["op"] == "advertise" and m["channels"])["channels"]
        return next(c for c in channels if c["topic"] == topic)

    def test_a_client_of_foxglove_hears_what_a_recording_contains(self):
        self.start_all()
        gateway = Gateway(self)
        recorder = self.record()
        self.cli_ok("start")
        heard = foreign(self, "hear.mjs", f"ws://127.0.0.1:{gateway.port}/", FOXGLOVE, "40")
        recorder.process.send_signal(signal.SIGINT)
        self.assertEqual(recorder.wait(20), 0)
        lines = [json.loads(line) for line in heard]
        self.assertEqual(lines[0]["server"]["capabilities"], [], "nothing can be sent")
        channels = {line["channel"]["topic"]: line["channel"] for line in lines if "channel" in line}
        self.assertEqual(set(channels), {"lss/telemetry/zebro", "lss/status", "lss/timing_statistics", "lss/event"})
        fields = json.loads(channels["lss/telemetry/zebro"]["schema"])["properties"]
        self.assertEqual(fields["modules"]["items"]["properties"]["position_rad"], {"type": "number", "description": "in rad"})
        self.assertEqual(json.loads(channels["lss/status"]["schema"])["properties"]["state"]["oneOf"][1],
                         {"title": "STATE_OPERATIONAL", "const": 1})

        def number(data):
            return next(data[name] for name in ("frame", "frame_index", "index", "until_ns") if name in data)

        recorded = {(m["topic"], number(m["data"])): m["data"] for m in self.shown() if m["topic"] in channels}
        same = dict.fromkeys(channels, 0)
        for message in (line for line in lines if "data" in line):
            data, topic = message["data"], message["topic"]
            self.assertEqual(set(data), set(json.loads(channels[topic]["schema"])["properties"]))
            other = recorded.get((topic, number(data)))
            if other is not None:
                self.assertEqual(data, other, topic)
                same[topic] += 1
        print(f"the same as in the recording: {same}")
        self.assertGreater(same["lss/telemetry/zebro"], 20)
        self.assertGreater(min(same.values()), 0)

        status = self.status()
        last = [line["data"] for line in lines if line.get("topic") == "lss/status"][-1]
        self.assertEqual((last["vehicle"], last["version"]), ("zebro", status["version"]))
        times = [line["log_ns"] for line in lines if line.get("topic") == "lss/telemetry/zebro"]
        self.assertEqual(times, sorted(times))
        self.assertLess(abs(times[-1] - status["utc_ns"]), 60e9, "log time is that of the sample, in UTC")

    def test_who_looks_by_foxglove_needs_the_same_key_and_delays_nobody(self):
        self.start_all()
        gateway = self.keyed()
        here = {"path": f"/?key={KEYS['look']}"}
        for how in ({"path": "/"}, {"path": "/?key=wrong"}, {"path": f"/?key={KEYS['look']}x"},
                    {**here, "origin": "http://elsewhere.example"}, {**here, "host": "elsewhere.example"}):
            with self.assertRaises(Refused, msg=str(how)):
                WebSocket(gateway.port, FOXGLOVE, **how)
        app = "https://foxglove.example"
        other = Gateway(self, "--foxglove-origin", app)
        self.foxglove(other, origin=app)
        with self.assertRaises(Refused):
            WebSocket(other.port, origin=app)  # could command

        page = Beating(gateway.client(key=KEYS["command"]))
        for protocol in (FOXGLOVE, "foxglove.sdk.v1"):
            client, info = self.foxglove(gateway, protocol=protocol, **here)
            self.assertEqual(info["capabilities"], [])
            channel = self.advertised(client, "lss/status")["id"]
        for text in ("", "{", "[]", '{"op":1}', '{"op":"advertise","channels":[]}', '{"op":"subscribe"}',
                     '{"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]}',
                     '{"type":"stop","id":1}', '{"op":"setParameters","parameters":[]}', '{"op":"unsubscribe","subscriptionIds":7}'):
            client.send_bytes(text.encode())
        self.assertEqual(client.why_closed(), "too many bad messages")
        client, _ = self.foxglove(gateway, **here)
        client.send_bytes(b"\x01\0\0\0\0{}", opcode=2)
        self.assertEqual(client.why_closed(), "a message was too long, or no text")
        only, _ = self.foxglove(gateway, path=here["path"] + "&vehicle=nobody-1")
        only.send(op="subscribe", subscriptions=[{"id": 1, "channelId": channel}, {"id": 2, "channelId": 77777}])
        only.send(op="nonsense")
        come = [only.read() for _ in range(2)]
        self.assertEqual((come[0], come[1]["op"], come[1]["level"]), ({"op": "advertise", "channels": []}, "status", 2))
        only, _ = self.foxglove(gateway, path=here["path"] + "&vehicle=zebro-1")
        self.advertised(only, "lss/status")

        slow, _ = self.foxglove(gateway, receive_bytes=4096, **here)
        first = self.advertised(slow, "lss/telemetry/zebro")["id"]
        slow.send(op="subscribe", subscriptions=[{"id": i, "channelId": first + i} for i in range(4)])
        wait_until(lambda: any(m["type"] == "pulse" for m in list(page.messages)), 20, "the first pulse")
        longest_s, before_s = 0, time.monotonic()

        def dropped():
            nonlocal longest_s, before_s
            seen = len(page.messages)
            wait_until(lambda: len(page.messages) > seen, 20, "the page goes on")
            longest_s, before_s = max(longest_s, time.monotonic() - before_s), time.monotonic()
            return page.counters()["too_slow"] >= 1 and page.counters()["replaced"] >= 1

        wait_until(dropped, 60, "who never reads is dropped, what it missed is counted")
        print(f"longest pause of the page {longest_s * 1000:.0f} ms, gateway {page.counters()}")
        self.assertLess(longest_s, 3)
        self.assertTrue(page.threads[1].is_alive())
