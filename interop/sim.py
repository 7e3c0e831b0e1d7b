"""A running `magician sim`."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

from checks import TIMEOUT


class Sim:
    """A `magician sim` of its own, from `ready` to a clean end. It chooses its ports itself, so
    that no other process can have them."""

    def __init__(self, magician, path, speed, *more, quiet=False):
        self.path, self.quiet = path, quiet
        command = [magician, "sim", "--pty", path, "--udp", "127.0.0.1:0", "--tcp", "127.0.0.1:0", "--speed", speed, *more]
        pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        self.process = subprocess.Popen(command, **pipes)
        line = self.process.stdout.readline()
        if line != b"ready\n":
            self.process.kill()
            raise AssertionError(f"the simulator said {line!r} instead of ready: {self.process.stderr.read().decode()}")
        self.said, self.more = [], threading.Condition()
        self.listener = threading.Thread(target=self._listen, daemon=True)
        self.listener.start()
        self.udp, self.tcp = (self._port(kind) for kind in (b"udp", b"tcp"))

    def _listen(self):
        for line in self.process.stderr:
            with self.more:
                self.said.append(line)
                self.more.notify_all()
            if not self.quiet:
                print(line.decode(errors="replace"), end="", file=sys.stderr, flush=True)

    def says(self, what):
        """Waits for an output line that matches a pattern, and returns the match."""
        with self.more:
            found = lambda: next(filter(None, (re.search(what, line) for line in self.said)), None)
            if match := self.more.wait_for(found, TIMEOUT):
                return match
        raise AssertionError(f"the simulator did not say {what!r}: {self.said}")

    def _port(self, kind):
        return int(self.says(rb"serving %b:.*:(\d+)" % kind)[1])

    def end(self, sign=signal.SIGTERM):
        """Ends the process. Returns true if it ended, and the rest of its stdout."""
        self.process.send_signal(sign)
        try:
            self.process.wait(timeout=TIMEOUT)
            ended = True
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            ended = False
        self.listener.join(TIMEOUT)
        return ended, self.process.stdout.read()

    def stop(self, sign=signal.SIGTERM):
        """Ends the process. Returns a list of (expectation, true if met)."""
        alive = self.process.poll() is None
        ended, rest = self.end(sign)
        return [
            ("the simulator lived until the end", alive),
            (f"it ends on {sign.name}", ended),
            ("its stdout is the one line `ready`", rest == b""),
            ("it takes its symbolic link away", not os.path.lexists(self.path)),
        ]


def run_on_sim(magician, command, program, look=lambda path: None):
    """Runs a program on a virtual arm of its own, at 20 times the speed of a real one. `command`
    receives the arm's path and the program's file. Returns the result, the elapsed seconds, and the
    result of `look` at the arm's path."""
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        script = os.path.join(home, "program.py")
        with open(script, "w") as file:
            file.write(program)
        sim = Sim(magician, os.path.join(home, "arm"), "20", quiet=True)
        try:
            begun = time.monotonic()
            ended = subprocess.run(
                command(sim.path, script), input=program, capture_output=True, text=True, timeout=5 * TIMEOUT
            )
            return ended, time.monotonic() - begun, look(sim.path)
        finally:
            sim.stop()
