"""DDS Security as docs/security.md sets it up: vehicle, pilot, and the services lss-ros and lss-ground, each with the
enclave of its own that systemd hands to it."""

import os
import re
import unittest

from box import SOURCE, Box, setUpModule  # noqa: F401  pylint: disable=unused-import

KEYS = "/var/tmp/keys"
PAGE = 8470


def drop_in():
    """The settings of a service, from the document."""
    with open(os.path.join(SOURCE, "docs/security.md"), encoding="utf-8") as file:
        lines = re.search(r"^    \[Service\]\n(?:    .+\n)+", file.read(), re.M)[0].splitlines()
    return "\n".join(line.strip() for line in lines) + "\n"


class Secured(Box):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.must(f"lss-cli keystore create {KEYS} && for who in 'zebro-1 --role vehicle' 'pilot --role command' "
                 f"'ros --role bridge' 'page --role command'; do lss-cli keystore add {KEYS} $who || exit 1; done")
        cls.must(f"install -d -o lss -m 700 /etc/lss/enclave && install -o lss -m 600 {KEYS}/enclaves/zebro-1/* /etc/lss/enclave/ && "
                 "sed -i 's|^enclave = \"\"|enclave = \"/etc/lss/enclave\"|' /etc/lss/zebro.toml && systemctl start lssd@zebro", 120)

    def give(self, unit, name):
        """The enclave as a credential, as the document says."""
        folder = f"/etc/systemd/system/{unit}.service.d"
        self.must(f"install -d -m 700 /etc/lss/{name} && install -m 600 {KEYS}/enclaves/{name}/* /etc/lss/{name}/ && mkdir -p {folder} && "
                  f"cat > {folder}/override.conf <<'EOF'\n{drop_in().replace('NAME', name)}EOF\nsystemctl daemon-reload")

    def test_1_only_a_certificate_reaches_the_vehicle(self):
        self.wait(f"lss-cli --enclave {KEYS}/enclaves/pilot status", "the pilot is answered", 60)
        self.assertNotEqual(self.run_there("lss-cli --timeout 5s status")[0], 0, "a client without an enclave is answered")

    def test_2_the_node_of_ros_2_joins_with_its_enclave_and_not_without(self):
        self.must("systemctl start lss-ros@zebro-1")
        log = "journalctl -b -u lss-ros@zebro-1 -o cat --no-pager"
        self.wait(f"{log} | grep -q 'waiting for it'", "without an enclave it finds no vehicle", 60)
        self.must("systemctl stop lss-ros@zebro-1")
        self.give("lss-ros@zebro-1", "ros")
        self.must("systemctl start lss-ros@zebro-1")
        self.wait(f"{log} | grep -q '^/zebro_1 on ROS domain 0'", "the node has the vehicle", 60)
        self.assertEqual(self.active("lss-ros@zebro-1"), "active")
        self.assertNotEqual(self.must("stat -c %U /proc/$(systemctl show -P MainPID lss-ros@zebro-1)"), "root")

    def test_3_the_page_shows_the_vehicle(self):
        self.give("lss-ground", "page")
        self.must("systemctl start lss-ground")
        hello = '{"type":"hello","key":"","session":""}'
        request = "\\r\\n".join(["GET / HTTP/1.1", f"Host: 127.0.0.1:{PAGE}", "Upgrade: websocket", "Connection: Upgrade",
                                "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==", "Sec-WebSocket-Version: 13",
                                "Sec-WebSocket-Protocol: lss-ground", "", ""])
        frame = f"\\201\\{0x80 | len(hello):o}\\0\\0\\0\\0{hello}"  # text, masked with zeros
        self.wait(f"exec 3<> /dev/tcp/127.0.0.1/{PAGE} && printf '{request}' >&3 && printf '{frame}' >&3 && "
                  "timeout 5 cat <&3 | grep -qa zebro-1", "the page has the vehicle", 60)

    def test_4_nothing_failed(self):
        self.assertEqual(self.must("systemctl --failed --no-legend"), "")


if __name__ == "__main__":
    unittest.main(failfast=True)
