"""What goes over loopback by RTPS, captured and dissected by tshark: an observer that is no DDS program."""

import json
import os
import shutil
import subprocess

from programs import die_with_parent, wait_until

TSHARK = shutil.which("tshark")
# DDSI-RTPS 2.3, 9.3.1.5: writers of discovery.
PARTICIPANTS, PUBLICATIONS, SUBSCRIPTIONS = "0x000100c2", "0x000003c2", "0x000004c2"
PORT_BASE, DOMAIN_GAIN = 7400, 250  # 9.6.1.1


class Capture:
    """Datagrams of loopback from now on; begins with the first one that is written down."""

    def __init__(self, folder):
        self.path, self.said = os.path.join(folder, "wire.pcapng"), os.path.join(folder, "tshark.err")
        with open(self.said, "w", encoding="utf-8") as err:
            self.process = subprocess.Popen([TSHARK, "-i", "lo", "-f", "udp", "-w", self.path], stdout=subprocess.DEVNULL,
                                            stderr=err, preexec_fn=die_with_parent)
        wait_until(lambda: "Capture started" in self.text() or self.process.poll() is not None, 30, "tshark captures")

    def text(self):
        with open(self.said, encoding="utf-8") as file:
            return file.read()

    def end(self):
        self.process.terminate()
        self.process.wait()

    def packets(self):
        """Those of RTPS that are in the file; its last one may be half written."""
        done = subprocess.run([TSHARK, "-r", self.path, "-Y", "rtps", "-T", "json", "--no-duplicate-keys"],
                              capture_output=True, text=True, check=False)
        return [packet["_source"]["layers"] for packet in json.loads(done.stdout or "[]")]

    def wait_for(self, condition, limit_s, what):
        """Datagrams are written down some time after they were sent."""
        def found():
            packets = self.packets()
            return packets if condition(packets) else None
        return wait_until(found, limit_s, what, poll_s=1)


def trees(value):
    return [one for one in (value if isinstance(value, list) else [value]) if isinstance(one, dict)]


def messages(rtps):
    """The submessages of a packet that have data: (its tree, its parameters)."""
    for tree in trees(rtps.get("rtps.sm.id_tree", [])):
        for data in trees(tree.get("serializedData", [])):
            for parameters in trees(data.get("serializedData:", [])):
                yield tree, parameters


def text_of(digits):
    return bytes.fromhex(digits.replace(":", "")).decode()


def prefixes_of(packets, domain):
    """GUID prefixes of all that announced itself to the domain's multicast port."""
    port = str(PORT_BASE + DOMAIN_GAIN * domain)
    return {packet["rtps"]["rtps.guidPrefix.src"] for packet in packets if packet["udp"]["udp.dstport"] == port}


def participants(packets):
    """USER_DATA of each participant, by its GUID prefix."""
    found = {}
    for packet in packets:
        for tree, parameters in messages(packet["rtps"]):
            if tree["rtps.sm.wrEntityId"] == PARTICIPANTS and "PID_USER_DATA" in parameters:
                data = parameters["PID_USER_DATA"].get("rtps.param.userData", "")
                found[packet["rtps"]["rtps.guidPrefix.src"]] = text_of(data)
    return found


def endpoints(packets):
    """Each announced reader and writer, by its GUID: kind, topic, type and QoS as numbers of the standard."""
    found = {}
    for packet in packets:
        for tree, p in messages(packet["rtps"]):
            if "PID_TOPIC_NAME" not in p or "PID_ENDPOINT_GUID" not in p:
                continue
            kind = {PUBLICATIONS: "writer", SUBSCRIPTIONS: "reader"}[tree["rtps.sm.wrEntityId"]]
            found[p["PID_ENDPOINT_GUID"]["rtps.param.endpoint_guid"]] = {
                "kind": kind,
                "topic": p["PID_TOPIC_NAME"]["rtps.param.topicName"],
                "type": p["PID_TYPE_NAME"]["rtps.param.typeName"],
                "user_data": text_of(p.get("PID_USER_DATA", {}).get("rtps.param.userData", "")),
                "reliable": int(p.get("PID_RELIABILITY", {}).get("rtps.reliability_kind", "0x1" if kind == "reader" else "0x2"),
                                16) == 2,
                "durability": int(p.get("PID_DURABILITY", {}).get("rtps.durability", "0x0"), 16),
                "depth": int(p.get("PID_HISTORY", {}).get("rtps.history_depth", "1")),
                "keeps_all": int(p.get("PID_HISTORY", {}).get("rtps.history.kind", "0x0"), 16) == 1,
                "lifespan_s": seconds_of(p.get("PID_LIFESPAN"))}
    return found


def seconds_of(duration):
    """None: endless, as without."""
    return next((int(value["rtps.param.ntpTime.sec"]) for value in (duration or {}).values() if isinstance(value, dict)), None)


def samples_of(packets, guid):
    """The serialized samples of a writer, without their encapsulation."""
    found = []
    for packet in packets:
        if not guid.startswith(packet["rtps"]["rtps.guidPrefix.src"]):
            continue
        for tree in trees(packet["rtps"].get("rtps.sm.id_tree", [])):
            if int(tree.get("rtps.sm.wrEntityId", "0x0"), 16) == int(guid[-11:].replace(":", ""), 16):
                found += [bytes.fromhex(data["rtps.issueData"].replace(":", ""))
                          for data in trees(tree.get("serializedData", [])) if "rtps.issueData" in data]
    return found
