"""A network between a page and its gateway, of which parts go away without a word."""

import contextlib
import socket
import threading


class Relay:
    """Passes connections on to a port of this machine. Those that are frozen stay open, and nothing moves any more."""

    def __init__(self, scenario, port):
        self.to = port
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.links = []  # (gate, near, far)
        scenario.addCleanup(self.close)
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        with contextlib.suppress(OSError):
            while True:
                near = self.listener.accept()[0]
                far = socket.create_connection(("127.0.0.1", self.to))
                gate = threading.Event()
                gate.set()
                self.links.append((gate, near, far))
                for source, sink in ((near, far), (far, near)):
                    threading.Thread(target=self.forward, args=(gate, source, sink), daemon=True).start()

    def forward(self, gate, source, sink):
        with contextlib.suppress(OSError):
            while piece := source.recv(65536):
                gate.wait()
                sink.sendall(piece)
            gate.wait()
            sink.shutdown(socket.SHUT_WR)

    def freeze(self):
        """All that are open now."""
        for gate, _, _ in self.links:
            gate.clear()

    def close(self):
        for one in (self.listener, *(end for _, near, far in self.links for end in (near, far))):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()
