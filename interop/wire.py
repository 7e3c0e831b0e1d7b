"""Frames of the protocol as bytes, and transports that send them without any layer in between."""

import errno
import os
import select
import socket
import struct
import termios
import threading
import time
import tty

from checks import TIMEOUT

GET, SET, QUEUED = 0, 1, 3

POSE, ALARMS, TIME = 10, 20, 4
INDEX = 246


def frame(ident, ctrl=GET, params=b""):
    """Returns one frame with its checksum."""
    body = bytes([ident, ctrl]) + bytes(params)
    return b"\xaa\xaa" + bytes([len(body)]) + body + bytes([-sum(body) & 0xFF])


def split(data):
    """Splits bytes into frames, as (id, ctrl, params), and the remaining bytes. Foreign bytes are
    an error."""
    frames = []
    while len(data) >= 3 and len(data) >= data[2] + 4:
        whole, data = data[: data[2] + 4], data[data[2] + 4 :]
        if whole[:2] != b"\xaa\xaa" or sum(whole[3:]) & 0xFF:
            raise AssertionError(f"not a frame: {whole.hex(' ')}")
        frames.append((whole[3], whole[4], whole[5:-1]))
    return frames, data


def floats(params, count=None):
    """Decodes little-endian 32-bit floats."""
    return struct.unpack(f"<{count or len(params) // 4}f", params)


class Link:
    """Requests and replies over a byte transport."""

    def send(self, data):
        raise NotImplementedError

    def read(self, timeout):
        """Returns the bytes of one read; empty after a timeout."""
        raise NotImplementedError

    def replies(self, count, timeout=TIMEOUT):
        """Returns the next replies; fewer after a timeout."""
        frames, data, end = [], b"", time.monotonic() + timeout
        while len(frames) < count and (left := end - time.monotonic()) > 0:
            data += self.read(left)
            found, data = split(data)
            frames += found
        if data and len(frames) >= count:
            raise AssertionError(f"bytes after the last reply: {data.hex(' ')}")
        return frames

    def ask(self, ident, ctrl=GET, params=b"", timeout=TIMEOUT):
        """Returns the reply to one request. Its id and Ctrl must match."""
        self.send(frame(ident, ctrl, params))
        found = self.replies(1, timeout)
        if not found:
            raise AssertionError(f"no reply to id {ident}, ctrl {ctrl}, {bytes(params).hex(' ')}")
        if len(found) != 1 or found[0][:2] != (ident, ctrl):
            raise AssertionError(f"asked id {ident}, ctrl {ctrl}; got {found}")
        return found[0][2]

    def send_apart(self, pieces):
        """Sends the pieces of a frame one by one. Returns false if this machine was so slow that
        the arm may have discarded the beginning, as it does after 50 ms."""
        begin = time.monotonic()
        for piece in pieces:
            self.send(piece)
            time.sleep(0.002)
        return time.monotonic() - begin < 0.04

    def quiet(self, seconds):
        """Returns the unsolicited bytes within a time."""
        return self.read(seconds)

    # Requests that nearly every check needs.

    def pose(self):
        """Returns x y z r j1 j2 j3 j4."""
        return floats(self.ask(POSE), 8)

    def index(self):
        """Returns the index of the last finished queued command."""
        return struct.unpack("<Q", self.ask(INDEX))[0]

    def time(self):
        """Returns the arm's clock in ms."""
        return struct.unpack("<I", self.ask(TIME))[0]

    def queue(self, ident, params=b"", ctrl=QUEUED):
        """Queues one command and returns its index."""
        return struct.unpack("<Q", self.ask(ident, ctrl, params))[0]

    def wait(self, index, timeout=2 * TIMEOUT):
        """Waits until the command with this index has finished."""
        end = time.monotonic() + timeout
        while (now := self.index()) < index:
            if time.monotonic() > end:
                raise AssertionError(f"index {index} not reached, stands at {now}")
            time.sleep(0.002)
        return now


class Pty(Link):
    """A terminal opened by its path, like a serial port."""

    def __init__(self, path, raw=True):
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
        if raw:
            tty.setraw(self.fd)
            mode = termios.tcgetattr(self.fd)
            mode[4] = mode[5] = termios.B115200
            termios.tcsetattr(self.fd, termios.TCSANOW, mode)

    def send(self, data):
        while data:
            data = data[os.write(self.fd, data) :]

    def read(self, timeout):
        if not select.select([self.fd], [], [], timeout)[0]:
            return b""
        return os.read(self.fd, 4096)

    def close(self):
        os.close(self.fd)


class Udp(Link):
    """Datagrams, as the arm's Wi-Fi module accepts them."""

    def __init__(self, port):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.address = ("127.0.0.1", port)

    def send(self, data):
        self.socket.sendto(data, self.address)

    def read(self, timeout):
        self.socket.settimeout(timeout)
        try:
            return self.socket.recv(4096)
        except TimeoutError:
            return b""

    def close(self):
        self.socket.close()


class Tcp(Link):
    """A stream socket."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT)

    def send(self, data):
        self.socket.sendall(data)

    def read(self, timeout):
        self.socket.settimeout(timeout)
        try:
            return self.socket.recv(4096)
        except TimeoutError:
            return b""

    def close(self):
        self.socket.close()


class Observer:
    """Watches queue and clock over UDP while another host drives the arm.

    Every poll requests clock, index, clock in this order, so that the time at which an index was
    reached is enclosed by two readings of the arm's own clock, however slow this machine is.
    """

    def __init__(self, port):
        self.link = Udp(port)
        self.looks = []
        self.error = None
        self.stopping = threading.Event()
        self.thread = threading.Thread(target=self._watch, daemon=True)
        self.thread.start()

    def _watch(self):
        request = frame(TIME) + frame(INDEX) + frame(TIME)
        try:
            while not self.stopping.is_set():
                self.link.send(request)
                answers = self.link.replies(3)
                if [a[0] for a in answers] != [TIME, INDEX, TIME]:
                    raise AssertionError(f"observer: {answers}")
                before, index, after = (int.from_bytes(a[2], "little") for a in answers)
                self.looks.append((before, index, after))
                time.sleep(0.001)
        except (AssertionError, OSError) as error:
            self.error = error

    def reached(self, index):
        """Returns clock readings (ms) that are certainly before and after the end of the
        command."""
        end = time.monotonic() + TIMEOUT
        # A library that does not sleep may read the index before the observer does.
        while (found := self._bracket(index)) is None:
            if self.error or time.monotonic() > end:
                raise AssertionError(f"index {index} was not seen ({self.error or 'still running'})")
            time.sleep(0.001)
        return found

    def _bracket(self, index):
        lo = 0
        for before, seen, after in list(self.looks):
            if seen >= index:
                return lo, after
            lo = before
        return None

    def duration(self, index):
        """Returns the shortest and longest possible duration of the command after the previous one,
        in seconds."""
        lo0, hi0 = self.reached(index - 1)
        lo1, hi1 = self.reached(index)
        return max(0, lo1 - hi0) / 1000, (hi1 - lo0) / 1000

    def close(self):
        self.stopping.set()
        self.thread.join()
        self.link.close()


def check_durations(checks, observer, timed):
    """Checks that consecutive moves without a pause took the time given by the speed law.

    `timed` is a list of (name, index, expected seconds) in queue order.
    """
    slack = 0.005
    # A motion starts with a control period of 20 ms. Rounding to binary32 can move the end of a
    # path across the boundary of a period.
    border = 0.02
    for name, index, want in timed:
        least, most = observer.duration(index)
        good = least - slack - border <= want <= most + slack + border
        checks.ok(f"{name} takes {want:.3f} s", good, f"between {least:.3f} and {most:.3f} s of the arm's clock")
    total = sum(want for _, _, want in timed)
    lo0, hi0 = observer.reached(timed[0][1] - 1)
    lo1, hi1 = observer.reached(timed[-1][1])
    least, most = (lo1 - hi0) / 1000, (hi1 - lo0) / 1000
    checks.ok(
        f"all {len(timed)} take {total:.3f} s",
        least - slack - border <= total <= most + slack + border and most - least < total / 2,
        f"between {least:.3f} and {most:.3f} s",
    )


def open_eventually(path, seconds=TIMEOUT):
    """Opens a terminal. A busy port is retried for a while."""
    end = time.monotonic() + seconds
    while True:
        try:
            return Pty(path)
        except OSError as error:
            if error.errno != errno.EBUSY or time.monotonic() > end:
                raise
        time.sleep(0.01)
