"""A `magician serve` whose arm is a `magician sim` in another process, with access to the traffic
on the arm's line."""

import base64
import json
import os
import select
import socket
import struct
import subprocess
import sys
import threading
import time

JOG, STOPS = 73, (241, 242, 245)


def now():
    return time.monotonic()


class Line(threading.Thread):
    """The arm's line: forwards bytes in both directions, and records frames that set something or
    stop the arm."""

    def __init__(self, arm):
        super().__init__(daemon=True)
        self.arm, self.listener = arm, socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.stops, self.writes, self.noted, self.asked = [], [], threading.Condition(), 0
        self.start()

    def run(self):
        while True:
            station, _ = self.listener.accept()
            arm = socket.create_connection(("127.0.0.1", self.arm))
            for end in (station, arm):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.carry(station, arm)
            station.close()
            arm.close()

    def carry(self, station, arm):
        rest = b""
        while True:
            for end in select.select([station, arm], [], [])[0]:
                try:
                    data = end.recv(4096)
                except ConnectionError:
                    return
                if not data:
                    return
                if end is station:
                    rest = self.look(rest + data)
                try:
                    (arm if end is station else station).sendall(data)
                except OSError:
                    return

    def look(self, data):
        """Records the station's frames. Returns the incomplete rest."""
        while len(data) >= 4:
            if data[:2] != b"\xaa\xaa":
                data = data[1:]
                continue
            length = data[2] + 4
            if len(data) < length:
                break
            command, control, payload = data[3], data[4], data[5 : length - 1]
            writes = control & 1
            self.asked += 1
            if writes:
                self.writes.append(command)
            if command in STOPS or (command == JOG and writes and payload[1] == 0):
                with self.noted:
                    self.stops.append(now())
                    self.noted.notify_all()
            data = data[length:]
        return data

    def stop_after(self, when, patience=3.0):
        """Returns the time from an instant to the next stop; None if there is none."""
        until = now() + patience
        with self.noted:
            while True:
                later = [at for at in self.stops if at >= when]
                if later:
                    return later[0] - when
                if now() >= until or not self.noted.wait(until - now()):
                    return None


class Client:
    """Session of a station over a WebSocket."""

    def __init__(self, port, name, host=None):
        """`host` is the port that the station regards as its own, if it is reached through another
        one."""
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        key = base64.b64encode(os.urandom(16)).decode()
        head = f"GET /api/v1/ws HTTP/1.1\r\nhost: 127.0.0.1:{host or port}\r\nupgrade: websocket\r\nconnection: upgrade\r\n"
        self.socket.sendall(f"{head}sec-websocket-version: 13\r\nsec-websocket-key: {key}\r\n\r\n".encode())
        self.file = self.socket.makefile("rb")
        while self.file.readline() not in (b"\r\n", b""):
            pass
        self.next = 0
        self.call("session.hello", client={"name": name})

    def send(self, method, answered=True, **params):
        self.next += 1
        message = {"jsonrpc": "2.0", "method": method, "params": params}
        if answered:
            message["id"] = self.next
        data, mask = json.dumps(message).encode(), os.urandom(4)
        size = struct.pack(">BB", 0x81, 0x80 | len(data)) if len(data) < 126 else struct.pack(">BBH", 0x81, 0xFE, len(data))
        sent = now()
        self.socket.sendall(size + mask + bytes(byte ^ mask[at % 4] for at, byte in enumerate(data)))
        return sent

    def read(self):
        """Returns the next message, or None if it is not text."""
        head = self.file.read(2)
        if len(head) < 2:
            raise ConnectionError("the station hung up")
        size = head[1] & 0x7F
        if size == 126:
            size = struct.unpack(">H", self.file.read(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self.file.read(8))[0]
        data = self.file.read(size)
        kind = head[0] & 0x0F
        if kind == 9:
            mask = os.urandom(4)
            pong = bytes(byte ^ mask[at % 4] for at, byte in enumerate(data))
            self.socket.sendall(struct.pack(">BB", 0x8A, 0x80 | len(data)) + mask + pong)
        return json.loads(data) if kind == 1 else None

    def answer(self):
        while True:
            message = self.read()
            if message and message.get("id") == self.next:
                if "error" in message:
                    raise AssertionError(message["error"])
                return message["result"]

    def call(self, method, **params):
        self.send(method, **params)
        return self.answer()


class Station:
    """A virtual arm, its line, and the station that owns it."""

    def __init__(self, magician, state, *flags):
        environment = {**os.environ, "XDG_STATE_HOME": state, "MAGICIAN_CONFIG": f"{state}/none.toml"}
        self.arm, where = started([magician, "sim", "--tcp", "127.0.0.1:0"], environment, "serving tcp:")
        self.line = Line(int(where.rsplit(":", 1)[1]))
        words = [magician, "serve", "--port", f"tcp:127.0.0.1:{self.line.port}", "--listen", "127.0.0.1:0", *flags]
        self.process, ready = serving(words, environment)
        self.port, self.link = ready["port"], ready["link"]

    def end(self):
        for process in (self.process, self.arm):
            process.kill()
            process.wait()


def started(words, environment, says):
    """Starts a program and waits until it is ready. Returns it, and the text it prints after some
    words."""
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, env=environment, text=True)
    if process.stdout.readline() != "ready\n":
        sys.exit(f"{words}: {process.stderr.read()}")
    for line in process.stderr:
        if line.startswith(says):
            threading.Thread(target=process.stderr.read, daemon=True).start()
            return process, line[len(says) :].strip()
    sys.exit(f"{words} does not say {says}")


def serving(words, environment):
    """Starts a station and waits until it is ready. Returns its description, with its port."""
    process = subprocess.Popen([*words, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, env=environment, text=True)
    line = process.stdout.readline()
    if not line:
        sys.exit(f"{words}: {process.stderr.read()}")
    threading.Thread(target=process.stderr.read, daemon=True).start()
    ready = json.loads(line)
    return process, {**ready, "port": int(ready["url"].rstrip("/").rsplit(":", 1)[1])}
