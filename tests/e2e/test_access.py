"""Access to the pilot's gateway from other machines: keys, TLS, and unsuitable files. Listens on every address,
connects by this machine's own."""

import contextlib
import os
import signal
import socket
import ssl
import time

from programs import run, wait_until
from rig import EXIT, FATAL_ERROR, OPERATIONAL, TOOLS, Scenario, real_time
from test_ground import KEYS, Gateway
from ws import Refused, WebSocket

GUESSES = 200
REQUEST_S = 5  # a request must come as a whole within it


def make_certificate(folder, name="ground"):
    """(certificate, key) for this machine, signed by itself."""
    certificate, key = (os.path.join(folder, f"{name}.{end}") for end in ("pem", "key.pem"))
    made = run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                "-subj", "/CN=ground", "-addext", "subjectAltName=IP:127.0.0.1,DNS:localhost", "-keyout", key,
                "-out", certificate], dict(os.environ), 20)
    if made.code != 0:
        raise AssertionError(made)
    os.chmod(key, 0o600)
    return certificate, key


class Guarded(Scenario):
    IN_LOCKSTEP = True

    def write(self, name, text, mode=0o600):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        os.chmod(path, mode)
        return path

    def write_keys(self, mode=0o600, name="ground.keys"):
        return self.write(name, "".join(f"{role} {key}\n" for role, key in KEYS.items()), mode)

    def start_secured(self):
        """On every address, by keys and TLS (self.tls_files); self.tls trusts its certificate alone."""
        certificate, key = make_certificate(self.folder)
        self.tls = ssl.create_default_context(cafile=certificate)
        self.tls_files = ("--tls-cert", certificate, "--tls-key", key)
        return Gateway(self, "--key-file", self.write_keys(), *self.tls_files, address="0.0.0.0")


class Access(Guarded):
    def get(self, port, tls=None):
        """The page, as it is handed out."""
        with socket.create_connection(("127.0.0.1", port), 10) as plain:
            with tls.wrap_socket(plain, server_hostname="127.0.0.1") if tls else contextlib.nullcontext(plain) as link:
                link.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n".encode())
                answer = b""
                with contextlib.suppress(ConnectionError):
                    while piece := link.recv(65536):
                        answer += piece
        return answer.decode()

    def refused(self, *words):
        """Its message instead of a start."""
        program = run([os.path.join(TOOLS, "lss-ground"), *words], self.environment(), 10)
        self.assertEqual((program.code, program.out), (2, ""), program)
        return program.err

    def test_beyond_this_machine_nothing_begins_without_keys_that_others_cannot_read(self):
        for address in ("0.0.0.0:0", ":0", "[::]:0", "192.0.2.1:0"):
            said = self.refused("--listen", address)
            self.assertIn("--key-file", said)
            self.assertIn("umask 077", said, "what to do")
        for mode in (0o644, 0o604, 0o602):
            path = self.write_keys(mode)
            said = self.refused("--listen", "0.0.0.0:0", "--key-file", path)
            self.assertIn(f"chmod o= {path}", said)
            self.assertNotIn(KEYS["command"], said)
        self.assertIn("has no key", self.refused("--key-file", self.write("empty.keys", "")))
        gateway = Gateway(self, "--key-file", self.write_keys(), address="0.0.0.0")
        self.assertIn("readable for everybody on the way", gateway.program.err(), "keys without TLS are warned of")
        # The whole of 127/8 is this machine: no key, and the page may connect under such a name.
        second = Gateway(self, address="127.0.0.2")
        with contextlib.closing(self.connect(second.port, "127.0.0.2")) as client:
            self.assertEqual(client.hello()["role"], "command")

    def connect(self, port, address):
        here = f"{address}:{port}"
        return WebSocket(port, address=address, host=here, origin=f"http://{here}")

    def test_certificates_that_will_not_do_are_reported_one_by_one(self):
        certificate, key = make_certificate(self.folder)
        _, other_key = make_certificate(self.folder, "other")
        absent = os.path.join(self.folder, "absent.pem")
        locked = os.path.join(self.folder, "locked.pem")
        self.assertEqual(run(["openssl", "pkey", "-in", key, "-aes256", "-passout", "pass:word", "-out", locked],
                             dict(os.environ), 20).code, 0)
        os.chmod(locked, 0o600)
        broken = self.write("broken.pem", "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")
        for of_certificate, of_key, why in (
                (absent, key, f"cannot read {absent}"), (certificate, absent, f"cannot read {absent}"),
                (self.folder, key, f"cannot read {self.folder}"),
                (broken, key, f"{broken} is no certificate"), (key, key, f"{key} is no certificate"),
                (certificate, broken, f"{broken} is no private key"), (certificate, certificate, "others may read"),
                (certificate, locked, f"{locked} is no private key in PEM without a password"),
                (certificate, other_key, f"{other_key} is not the key of {certificate}")):
            self.assertIn(why, self.refused("--listen", "127.0.0.1:0", "--tls-cert", of_certificate, "--tls-key", of_key))
        os.chmod(key, 0o644)
        self.assertIn(f"chmod o= {key}", self.refused("--tls-cert", certificate, "--tls-key", key))
        self.assertIn("belong together", self.refused("--tls-key", key))

    def test_with_tls_nothing_goes_without_and_each_role_may_what_it_may(self):
        self.start_all()
        gateway = self.start_secured()
        self.assertNotIn("warning", gateway.program.err())
        self.assertTrue(gateway.program.out().startswith("https://"))
        page = self.get(gateway.port, self.tls)
        self.assertRegex(page, "<title>lss-ground</title>|The page was not built")
        self.assertNotIn("lss-ground", self.get(gateway.port), "not without TLS")
        with self.assertRaises(Refused):
            WebSocket(gateway.port)
        with self.assertRaises(ssl.SSLCertVerificationError):
            WebSocket(gateway.port, tls=ssl.create_default_context())

        here = f"127.0.0.1:{gateway.port}"
        for origin in (f"http://{here}", "https://elsewhere.example", "https://127.0.0.1", "null"):
            with self.assertRaises(Refused, msg=origin):
                WebSocket(gateway.port, tls=self.tls, origin=origin)
        looker, stopper, commander = (gateway.client(key=KEYS[role], tls=self.tls, origin=f"https://{here}")
                                      for role in ("look", "stop", "command"))
        for client in (looker, stopper):
            client.wait_for(lambda m: m["type"] == "telemetry")
            client.send(type="command", id=1, vehicle="zebro-1", command="start")
            self.assertEqual(self.answer(client)["reason"]["text"], "this key may not command")
        commander.wait_for(lambda m: m["type"] == "vehicle")
        commander.send(type="command", id=2, vehicle="zebro-1", command="start")
        self.assertEqual(self.answer(commander)["phase"], "completed")
        self.wait_state(OPERATIONAL)

        lines = {role: gateway.client("lss-stop", key=KEYS[role], tls=self.tls) for role in ("look", "stop")}
        for line in lines.values():
            line.send(type="command", id=3, vehicle="zebro-1", command="lay-down")
            self.assertIn("for stopping", line.wait_for(lambda m: m["type"] == "bad")["text"])
        lines["look"].send(type="stop", id=4, vehicle="zebro-1")
        self.assertEqual(self.answer(lines["look"])["reason"]["text"], "this key may not stop")
        lines["stop"].send(type="stop", id=5, vehicle="zebro-1")
        self.assertEqual(self.answer(lines["stop"])["phase"], "completed")
        self.wait_state(FATAL_ERROR)

    def answer(self, client):
        return client.wait_for(lambda m: m["type"] == "ack" and m["final"])

    def test_guesses_are_counted_and_who_is_in_can_stop_meanwhile(self):
        self.start_all()
        gateway = self.start_secured()
        looker = gateway.client(key=KEYS["look"], tls=self.tls)
        stopper = gateway.client("lss-stop", key=KEYS["stop"], tls=self.tls)
        begun_s = time.monotonic()
        for guess in range(GUESSES):
            with contextlib.closing(WebSocket(gateway.port, tls=self.tls)) as client:
                client.send(type="hello", key=f"{guess:032x}")
                self.assertEqual(client.why_closed(), "wrong key")
            if guess % 50 == 0:
                stopper.send(type="stop", id=guess, vehicle="zebro-1")
                self.assertEqual(self.answer(stopper)["phase"], "completed")
        print(f"{GUESSES / (time.monotonic() - begun_s):.0f} guesses a second")
        pulse = looker.wait_for(lambda m: m["type"] == "pulse" and m["gateway"]["wrong_keys"] == GUESSES)
        self.assertEqual((pulse["gateway"]["refused"], pulse["gateway"]["bad_messages"]), (0, 0))

    @real_time("how soon it hangs up")
    def test_who_says_nothing_is_hung_up_on(self):
        self.start_daemon()
        secured = self.start_secured()
        plain = Gateway(self)
        silent = []
        for port, tls, said in ((secured.port, None, b""), (secured.port, self.tls, b""), (secured.port, self.tls, b"GET / HTTP"),
                                (plain.port, None, b""), (plain.port, None, b"GET / HTTP")):
            client = socket.create_connection(("127.0.0.1", port), 30)
            if tls:
                client = tls.wrap_socket(client, server_hostname="127.0.0.1")
            self.addCleanup(client.close)
            client.sendall(said)
            silent.append(client)
        begun_s = time.monotonic()
        for client in silent:
            self.assertEqual(client.recv(1), b"")
        self.assertLess(time.monotonic() - begun_s, REQUEST_S + 1)


class Several(Scenario):
    IN_LOCKSTEP = True

    @real_time("two daemons, neither with a vehicle", any_machine=True)
    def test_a_vehicle_is_not_taken_for_the_only_one_when_its_daemon_knows_another(self):
        self.start_daemon()
        other = self.start_daemon(self.write_config("other.toml", vehicle_id='"zebro-2"'), wait=False)
        wait_until(lambda: "zebro-1, zebro-2" in self.cli("status").err, 30, "both are there")
        other.halt()  # DDS of the first knows it for 10 s more; it answers no client
        told = self.cli("--timeout", "1s", "status")
        self.assertEqual((told.code, told.out), (EXIT["usage"], ""), told)
        self.assertIn("zebro-1 is not alone on this domain: it knows another daemon", told.err)
        self.assertIn('"without_status": 1', self.cli_ok("--timeout", "1s", "--json", "fleet").out)
        self.cli_ok("--vehicle", "zebro-1", "status")
        other.signal(signal.SIGCONT)
