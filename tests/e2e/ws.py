"""A minimal WebSocket client (RFC 6455), also for messages that no browser sends."""

import base64
import json
import os
import socket
import struct
import time

LIMIT_S = 20


class Refused(Exception):
    pass


class Closed(Exception):
    pass


class WebSocket:
    def __init__(self, port, protocol="lss-ground", origin=None, host=None, receive_bytes=None, tls=None,
                 address="127.0.0.1", path="/"):
        """tls: the ssl.SSLContext of a client, for wss."""
        self.socket = socket.socket()
        if receive_bytes:  # a client that stops reading fills little
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_bytes)
        self.socket.settimeout(LIMIT_S)
        self.socket.connect((address, port))
        if tls:
            self.socket = tls.wrap_socket(self.socket, server_hostname=address)
        self.buffer = b""
        host = host or f"{address}:{port}"
        lines = [f"GET {path} HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade",
                 f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}", "Sec-WebSocket-Version: 13",
                 f"Sec-WebSocket-Protocol: {protocol}"]
        if origin:
            lines.append(f"Origin: {origin}")
        try:
            self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
            while b"\r\n\r\n" not in self.buffer:
                piece = self.socket.recv(4096)
                if not piece:
                    raise ConnectionError("closed")
                self.buffer += piece
        except (ConnectionError, TimeoutError) as error:
            self.socket.close()
            raise Refused(str(error)) from error
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n", 1)[0]:
            self.socket.close()
            raise Refused(head.split(b"\r\n", 1)[0].decode())

    def send_bytes(self, payload, opcode=1, final=True):
        mask = os.urandom(4)
        head = bytes([(0x80 if final else 0) | opcode])
        if len(payload) < 126:
            head += bytes([0x80 | len(payload)])
        elif len(payload) < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", len(payload))
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", len(payload))
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        self.socket.sendall(head + mask + masked)

    def send(self, **message):
        self.send_bytes(json.dumps(message).encode())

    def take(self, count):
        while len(self.buffer) < count:
            try:
                piece = self.socket.recv(65536)
            except ConnectionError as error:
                raise Closed(str(error)) from error
            if not piece:
                raise Closed("without a word")
            self.buffer += piece
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def read(self):
        """The next message; Closed with the reason when there is none any more."""
        return json.loads(self.read_text())

    def read_text(self):
        text = b""
        while True:
            first, second = self.take(2)
            size = second & 127
            if size == 126:
                size = struct.unpack(">H", self.take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self.take(8))[0]
            payload = self.take(size)
            opcode = first & 15
            if opcode == 8:
                raise Closed(payload[2:].decode())
            if opcode == 9:
                self.send_bytes(payload, 10)
            if opcode in (0, 1):
                text += payload
                if first & 0x80:
                    return text

    def wait_for(self, wanted, limit_s=LIMIT_S):
        """The first message that `wanted` says yes to."""
        end_s = time.monotonic() + limit_s
        while time.monotonic() < end_s:
            message = self.read()
            if wanted(message):
                return message
        raise AssertionError("the message did not come")

    def hello(self, key="", session=""):
        self.send(type="hello", key=key, session=session)
        return self.wait_for(lambda m: m["type"] == "welcome")

    def why_closed(self):
        try:
            while True:
                self.read()
        except Closed as closed:
            return str(closed)

    def close(self):
        self.socket.close()
