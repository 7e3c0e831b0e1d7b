"""A `magician sim` to talk to."""

import os
import signal
import socket
import subprocess


def free_port(kind):
    """A port nobody uses at the moment."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Sim:
    """A `magician sim` of its own, from `ready` to a clean end."""

    def __init__(self, magician, path, speed, *more, stderr=None):
        self.path = path
        self.udp, self.tcp = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_STREAM)
        command = [magician, "sim", "--pty", path, "--udp", f"127.0.0.1:{self.udp}"]
        command += ["--tcp", f"127.0.0.1:{self.tcp}", "--speed", speed, *more]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=stderr)
        line = self.process.stdout.readline()
        if line != b"ready\n":
            self.process.kill()
            raise AssertionError(f"the simulator said {line!r} instead of ready")

    def stop(self, sign=signal.SIGTERM):
        """End it; a list of (what was promised, whether it was kept)."""
        alive = self.process.poll() is None
        self.process.send_signal(sign)
        try:
            rest, _ = self.process.communicate(timeout=5)
            ended = True
        except subprocess.TimeoutExpired:
            self.process.kill()
            rest, _ = self.process.communicate()
            ended = False
        return [
            ("the simulator lived until the end", alive),
            (f"it ends on {sign.name}", ended),
            ("its stdout is the one line `ready`", rest == b""),
            ("it takes its symbolic link away", not os.path.lexists(self.path)),
        ]
