"""pydobot 1.3.2 through `magician proxy` during a `magician pose --watch`: session_proxy.py PTY
UDP_PORT TCP_PORT SPEED MAGICIAN

Each of the two programs has its own pseudo-terminal. The library reads once after 100 ms and never
resynchronises, so that a late answer, or an answer to the other client, would put it one answer
behind for ever.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading

from pydobot import Dobot

import arm as model
from checks import TIMEOUT, Checks
from session_pydobot import connect, home, moves, tools
from wire import Observer

RATE = 200


class Watcher:
    """Background `magician pose --watch` with its output."""

    def __init__(self, magician, port):
        command = [magician, "--port", port, "--timeout", str(TIMEOUT), "pose", "--watch", "--rate", str(RATE), "--json"]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.poses, self.complaints = [], []
        self.threads = [threading.Thread(target=act, daemon=True) for act in (self._poses, self._complaints)]
        for thread in self.threads:
            thread.start()

    def _poses(self):
        for line in self.process.stdout:
            self.poses.append(json.loads(line))

    def _complaints(self):
        for line in self.process.stderr:
            self.complaints.append(line)

    def kill(self):
        self.process.kill()

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=TIMEOUT)
        for thread in self.threads:
            thread.join()


class Proxy:
    """A `magician proxy` with two terminals, and its output."""

    def __init__(self, magician, port, home):
        self.paths = [os.path.join(home, name) for name in ("A", "B")]
        command = [magician, "proxy", "--port", port, "--json"]
        for path in self.paths:
            command += ["--pty", path]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        if line != "ready\n":
            self.process.kill()
            raise AssertionError(f"the proxy said {line!r} instead of ready")
        self.shown = []
        self.thread = threading.Thread(target=self._show, daemon=True)
        self.thread.start()

    def _show(self):
        for line in self.process.stderr:
            self.shown.append(json.loads(line))

    def kill(self):
        self.process.kill()

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(timeout=TIMEOUT)
        self.thread.join()



def check_reply_order(checks, shown, path):
    """Checks that every request of a client is followed by its answer, in order."""
    waiting, matched = [], 0
    for event in shown:
        if event.get("link") != path or event["event"] not in ("request", "reply", "unanswered"):
            continue
        key = (event["id"], event["write"], event["queued"])
        if event["event"] == "request":
            waiting.append(key)
        elif event["event"] == "unanswered":
            waiting.remove(key)
        elif waiting and waiting[0] == key:
            waiting.pop(0)
            matched += 1
        else:
            return checks.ok(f"answers to {os.path.basename(path)} are in its order", False, event)
    return checks.ok(f"answers to {os.path.basename(path)} are in its order", matched > 50 and len(waiting) <= 1, f"{matched} of them")


def drive(checks, proxy, watcher, udp):
    """Drives the library, and checks the poses of the watcher."""
    observer = Observer(udp)
    dobot = Dobot(proxy.paths[0])
    arm = model.Arm()
    arm.ratio, arm.r_speed = (1.0, 1.0), (200.0, 200.0)
    arm.jump_height, arm.jump_limit = 10.0, 200.0
    connect(checks, dobot)
    home(checks, dobot, observer)
    moves(checks, dobot, arm)
    tools(checks, dobot)
    final = dobot.pose()
    print("what the other terminal saw")
    checks.ok("the watcher lives", watcher.process.poll() is None, "".join(watcher.complaints).strip())
    watcher.stop()
    poses = watcher.poses
    # The number depends on the machine. A watcher that is starved by the library's requests would
    # see a handful.
    checks.ok("it saw many poses", len(poses) > 100, len(poses))
    checks.ok("of an arm on its way", len({round(pose["x"], 1) for pose in poses}) > 30)
    last = poses[-1]
    checks.near("and where it stands at last", [last[key] for key in ("x", "y", "z", "r")], final[:4])
    dobot.close()
    observer.close()
    checks.equal("nothing disturbed the observer on UDP", observer.error, None)


def main():
    port, udp, magician = sys.argv[1], int(sys.argv[2]), sys.argv[5]
    checks = Checks()
    with tempfile.TemporaryDirectory(prefix="magician-") as directory:
        proxy = Proxy(magician, port, directory)
        watcher = Watcher(magician, proxy.paths[1])
        try:
            drive(checks, proxy, watcher, udp)
            proxy.stop()
        finally:
            watcher.kill()
            proxy.kill()
        checks.equal("the proxy ends well", proxy.process.returncode, 0)
        # A watcher that is stopped while its request waits is reported as disconnected: ignore
        # these events.
        kinds = [event["event"] for event in proxy.shown if event.get("note") != "its program disconnected"]
        for kind in ("dropped", "noise"):
            checks.equal(f"nothing was {kind}", kinds.count(kind), 0)
        # On a slow machine the watcher repeats a request, and the answer to the first is dropped.
        # The library never repeats one.
        unanswered = [event["link"] for event in proxy.shown if event["event"] == "unanswered"]
        checks.equal("nothing that the library asked was unanswered", unanswered.count(proxy.paths[0]), 0)
        most = len(unanswered) + kinds.count("own")
        checks.ok("nothing was unclaimed but what was asked again, and fences", kinds.count("unclaimed") <= most)
        for path in proxy.paths:
            check_reply_order(checks, proxy.shown, path)
        checks.ok("both paths are gone", not any(os.path.lexists(path) for path in proxy.paths))
    checks.finish()


if __name__ == "__main__":
    main()
