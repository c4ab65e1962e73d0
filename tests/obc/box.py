"""Common part of the tests: a machine in a box with our packages, installed as by a user."""

import glob
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import vm

PACKAGES = os.environ["LSS_OBC_PACKAGES"]  # folder of the .deb files
SOURCE = os.environ["LSS_OBC_SOURCE"]


def setUpModule():
    if not os.path.exists(os.path.join(vm.IMAGE, "root.ext4")):
        print("the OBC in a box is skipped: there is no image; the test that makes it (obc.image, obc.BOX.image) says why")
        sys.exit(77)


class Box(unittest.TestCase):
    """One machine for all tests of a class; they go in the order of their names."""

    INSTALL = True

    @classmethod
    def setUpClass(cls):
        setUpModule()
        cls.share = tempfile.mkdtemp(prefix="lss-obc-share-")
        cls.addClassCleanup(shutil.rmtree, cls.share)
        os.chmod(cls.share, 0o755)
        for deb in glob.glob(os.path.join(PACKAGES, "*.deb")):
            shutil.copy(deb, cls.share)
        cls.disk = None
        cls.machine = None
        cls.addClassCleanup(lambda: cls.machine and cls.machine.end())
        cls.boot()
        if cls.INSTALL:
            cls.must("dpkg -i /mnt/host/*.deb", 120)

    @classmethod
    def boot(cls):
        cls.machine = vm.Machine(cls.share, cls.disk)
        cls.machine.wait_for_boot()
        print(f"boot to agent: {cls.machine.boot_s:.1f} s, {cls.machine.cpu_s:.1f} s of CPU", flush=True)

    def tearDown(self):
        result = self._outcome.result
        if any(getattr(test, "test_case", test) is self for test, _ in result.failures + result.errors):
            try:
                _, text = self.machine.run("journalctl -b -o short-monotonic --no-pager | grep -vE 'iox::|was late|keep alive|internal logic' | tail -n 40; systemctl --failed --no-legend")
                print(text, file=sys.stderr)
            except (vm.Gone, AssertionError, OSError) as gone:
                print(gone, file=sys.stderr)

    # --- commands

    @classmethod
    def run_there(cls, command, limit_s=60):
        return cls.machine.run(command, limit_s)

    @classmethod
    def must(cls, command, limit_s=60):
        return cls.machine.must(command, limit_s)

    # --- waiting; all limits are seconds in the box

    @classmethod
    def until(cls, condition, what, limit_s=60):
        """Until a function returns true; how many seconds that took."""
        begun_s = now_s = float(cls.must("cut -d ' ' -f 1 /proc/uptime"))
        while not condition():
            if now_s > begun_s + limit_s:
                raise AssertionError(f"not within {limit_s} s: {what}")
            now_s = float(cls.must("sleep 0.1; cut -d ' ' -f 1 /proc/uptime"))
        return now_s - begun_s

    @classmethod
    def wait(cls, condition, what, limit_s=60):
        """Until a shell command succeeds; how many seconds that took."""
        return cls.until(lambda: cls.run_there(f"{{ {condition}; }} > /dev/null")[0] == 0, what, limit_s)

    def wait_status(self, expression, what, limit_s=60):
        """Until a Python expression about the status `s` is true; that status."""
        status = None

        def holds():
            nonlocal status
            code, text = self.run_there("lss-cli --json status 2> /dev/null")
            status = json.loads(text) if code == 0 else None
            return status is not None and eval(expression, {"s": status})  # pylint: disable=eval-used

        try:
            self.until(holds, what, limit_s)
        except AssertionError as late:
            raise AssertionError(f"{late}: {json.dumps(status)[:2000]}") from None
        return status

    # --- units

    def show(self, unit, name):
        return self.must(f"systemctl show -P {name} {unit}")

    def active(self, unit):
        return self.run_there(f"systemctl is-active {unit}")[1]

    def pid(self, unit):
        return int(self.show(unit, "MainPID"))

    def status(self):
        return json.loads(self.must("lss-cli --json status"))

    @classmethod
    def use_can(cls):
        cls.must("sed -i 's|^path = \"udp://127.0.0.1:20000\"|path = \"can0\"|' /etc/lss/ardito.toml")

    @classmethod
    def start_sim(cls, *words):
        """lss-sim as a unit of its own."""
        cls.must(f"systemd-run -q --unit=lss-sim --collect lss-sim {' '.join(words)}")
        cls.wait("journalctl -b -u lss-sim -o cat --no-pager | grep -q ready", "the simulator is ready", 90)
