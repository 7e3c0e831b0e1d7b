"""Laser safety: an engraving is framed, paused, stopped and left in every way, judged by the frames
that reach the arm.

The arm is a virtual one at the speed of a real one, in another process, which records every frame
and its laser on its own clock. While an engraving of a line at 200 mm/min runs, its end is
requested. Then

* a frame that stops the arm arrives within PROMPT, and no frame after it burns: no CPLECmd with
  power, no laser switched on;
* no segment that was sent burns for longer than a second;
* the laser is dark within DARK, and remains so until the recording ends.

After kill -9 no frame can arrive; the segments in the arm end within the same time.
"""

import contextlib
import math
import os
import signal
import subprocess
import sys
import threading
import time

from lab import HERE, TIMEOUT, Program, Terminal, mcap_messages

sys.path.insert(0, str(HERE.parent))
from station import Client, serving  # noqa: E402

# Time from the request to the first frame of the stop, and to the laser being dark, s.
PROMPT, DARK = 0.5, 1.5
# Time for which the laser must remain dark afterwards, s.
WATCHED = 2.0
FEED = 200 / 60
STOPS = ("SetQueuedCmdStopExec", "SetQueuedCmdForceStopExec")
BURN = "magician engrave burn.gcode --surface -50 --yes --unhomed"


def burning(lab):
    """Waits until the arm is in the middle of the first line. The arm's own laser state does not
    cover burning segments."""
    end = time.monotonic() + TIMEOUT
    while True:
        pose = lab.read_state("pose")
        if pose["z"] < -49.9 and pose["y"] < -6.6 and pose["x"] > 234:
            return
        assert time.monotonic() < end, f"it does not burn: {pose}"
        time.sleep(0.05)


class Ending:
    """Result of a way to end an engraving: the time of the request, a flag that is true if frames
    may stop it, the duration of the request itself, and a cleanup."""

    def __init__(self, asked, after=lambda: None, stops=True, takes=0.0):
        self.asked, self.after, self.stops, self.takes = asked, after, stops, takes


def at_a_terminal(ending, after=None):
    def scene(lab):
        terminal = Terminal(lab, BURN)
        terminal.wait_for("step")
        burning(lab)
        asked = time.time()
        ending(terminal)

        def ends():
            if after:
                after(terminal)
            terminal.close()

        return Ending(asked, ends)

    return scene


def program_pauses(lab):
    job = Program(lab, f"{BURN} --json")
    burning(lab)
    asked = time.time()
    job.send({"do": "pause"})

    def ends():
        job.wait_for_event(event="paused", reason="person")
        job.close()

    return Ending(asked, ends)


def program_is_killed(lab):
    job = Program(lab, f"{BURN} --json")
    burning(lab)
    asked = time.time()
    job.close()
    return Ending(asked, stops=False)


def program_gets(name):
    def scene(lab):
        job = Program(lab, f"{BURN} --json")
        burning(lab)
        asked = time.time()
        os.kill(job.process.pid, getattr(signal, name))

        def ends():
            assert job.wait_for_exit() == 130

        return Ending(asked, ends)

    return scene


def station(lab):
    words = [lab.magician, "serve", "--port", lab.environment["MAGICIAN_PORT"], "--listen", "127.0.0.1:0"]
    return serving(words, lab.environment)


START = {"format": "gcode", "setup": {"work": "engrave", "surface": -50}, "yes": True, "unhomed": True}


def starts(client, lab):
    """Starts an engraving as a client of a station."""
    client.call("lease.acquire", wait_s=10)
    job = client.call("job.start", text=(lab.dir / "burn.gcode").read_text(), **START)["job"]
    burning(lab)
    return job


def station_pauses(lab):
    process, ready = station(lab)
    client = Client(ready["port"], "workshop")
    job = starts(client, lab)
    asked = time.time()
    client.call("job.pause", job=job)

    def ends():
        process.kill()
        process.wait()

    return Ending(asked, ends)


def socket_closes(lab):
    process, ready = station(lab)
    client = Client(ready["port"], "workshop")
    starts(client, lab)
    asked = time.time()
    client.socket.shutdown(2)

    def ends():
        watcher = Client(ready["port"], "watcher")
        job = watcher.call("job.list")["jobs"][-1]
        assert (job["state"], job["reason"]) == ("paused", "person"), job
        process.kill()
        process.wait()

    return Ending(asked, ends)


def client_is_killed(lab):
    """Kills a client program that holds the lease."""
    process, ready = station(lab)
    words = [sys.executable, "-B", __file__, str(ready["port"]), str(lab.dir / "burn.gcode")]
    client = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert client.stdout.readline() == "burns\n"
    burning(lab)
    asked = time.time()
    client.kill()

    def ends():
        client.wait()
        process.kill()
        process.wait()

    return Ending(asked, ends)


def page_closes(kill):
    """Studio in Chromium: the page starts the engraving and is closed, or the browser is killed."""

    def scene(lab):
        process, ready = station(lab)
        words = ["node", str(HERE / "page.mjs"), f"http://127.0.0.1:{ready['port']}/", str(lab.dir / "burn.gcode")]
        page = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        said = page.stdout.readline().split()
        assert said[:1] == ["burns"], said
        burning(lab)
        asked = time.time()
        if kill:
            os.kill(int(said[1]), signal.SIGKILL)
        else:
            page.stdin.write("close\n")
            page.stdin.flush()

        def ends():
            watcher = Client(ready["port"], "watcher")
            job = watcher.call("job.list")["jobs"][-1]
            assert job["state"] == "paused", job
            page.stdin.close()
            with contextlib.suppress(subprocess.TimeoutExpired):
                page.wait(10)
            page.kill()
            process.kill()
            process.wait()

        # On a busy machine a browser takes its time to close a page.
        return Ending(asked, ends, takes=2.0)

    return scene


def framed(lab):
    """Frames the engraving once, complete."""
    asked = time.time()
    done = lab.run("magician frame burn.gcode --tool laser --surface -50 --speed 60 --unhomed")
    assert done.code == 0, done
    return Ending(asked, stops=False)


ENDINGS = {
    "framing": framed,
    "p at the terminal": at_a_terminal(lambda terminal: terminal.type_keys("p"), lambda terminal: terminal.wait_for("paused: p resumes")),
    '{"do":"pause"}': program_pauses,
    "job.pause of a station": station_pauses,
    "Ctrl-C": at_a_terminal(lambda terminal: terminal.type_keys("\x03"), lambda terminal: terminal.wait_for_exit()),
    "Ctrl-C twice": at_a_terminal(lambda terminal: (terminal.type_keys("\x03"), time.sleep(0.1), terminal.type_keys("\x03")), lambda terminal: terminal.wait_for_exit()),
    "Ctrl-Z (SIGTSTP)": at_a_terminal(lambda terminal: terminal.type_keys("\x1a"), lambda terminal: terminal.wait_for_suspend()),
    "SIGTERM": program_gets("SIGTERM"),
    "the terminal is closed (SIGHUP)": program_gets("SIGHUP"),
    "a station's client closes its socket": socket_closes,
    "a station's client is killed (-9)": client_is_killed,
    "the page is closed": page_closes(False),
    "the browser is killed (-9)": page_closes(True),
    "the command is killed (-9)": program_is_killed,
}
# Cases that need a browser.
PAGES = ("the page is closed", "the browser is killed (-9)")


def burns(frame):
    """True if a frame lights the laser, or is a segment that burns."""
    params = frame["params"]
    if frame["command"] == "SetCPLECmd":
        return params["velocity_or_power"] > 0
    return frame["command"] == "SetEndEffectorLaser" and params["enable_ctrl"] and params["on"]


class Log:
    """Recording of the arm, relative to the time of a request."""

    def __init__(self, path, asked):
        topics = mcap_messages(path)
        frames = [(at - asked, frame) for at, frame in topics["/frames"] if frame["direction"] == "request" and frame.get("write")]
        # Tolerance between the arm's clock and the wall clock.
        self.after = [(at, frame) for at, frame in frames if at >= -0.1]
        self.stop = next((at for at, frame in self.after if frame["command"] in STOPS), None)
        self.burns = [at for at, frame in frames if burns(frame)]
        self.off = next((at for at, frame in self.after if frame["command"] == "SetEndEffectorLaser" and not frame["params"]["on"]), None)
        self.lit = [(at - asked, value["laser"]) for at, value in topics["/io"]]
        # Between two segments it may be dark for a moment. The last time it went out counts.
        last = max((nth for nth, (_, lit) in enumerate(self.lit) if lit), default=None)
        self.dark = next((at for at, _ in self.lit[last + 1 :]), None) if last is not None else None
        self.end = max(at for at, _ in topics["/pose"]) - asked
        self.longest = longest(frames)
        self.corners = sum(frame["queued"] for _, frame in self.after if "params" in frame and "z" in frame["params"])


def longest(frames):
    """Returns the duration of the longest burning segment, s."""
    at, most = None, 0.0
    for _, frame in frames:
        params = frame["params"]
        if frame["command"] in ("SetCPLECmd", "SetCPCmd") and params["cp_mode"] == 1:
            to = [params[axis] for axis in "xyz"]
            if at and frame["command"] == "SetCPLECmd" and burns(frame):
                most = max(most, math.dist(at, to) / FEED)
            at = to
        elif frame["command"] == "SetPTPCmd":
            at = [params[axis] for axis in "xyz"]
    return most


def judged(lab, name):
    """Runs a case. Returns its line of the table, and the faults."""
    arm = lab.arm("1", homed=False, recorded=True)
    # Homing takes as long as at the speed of a real arm.
    assert lab.run("magician alarms --clear").code == 0
    ending = ENDINGS[name](lab)
    framing = ENDINGS[name] is framed
    while time.time() < ending.asked + (0 if framing else ending.takes + DARK + WATCHED):
        time.sleep(0.05)
    ending.after()
    arm.end()
    log = Log(arm.recording, ending.asked)
    wrong = []
    if framing:
        if log.burns or any(lit for _, lit in log.lit):
            wrong.append("it is lit")
        if log.corners < 5:
            wrong.append("it does not go round")
        return log, wrong
    if ending.stops and (log.stop is None or log.stop > ending.takes + PROMPT):
        wrong.append(f"stopped at {log.stop}")
    if ending.stops and log.stop is not None and any(at > log.stop for at in log.burns):
        wrong.append("a frame that burns after the stop")
    if not ending.stops and log.after:
        wrong.append("frames of a program that was killed")
    if log.longest > 1.001:
        wrong.append(f"a piece of {log.longest:.2f} s")
    if log.dark is None or log.dark - (log.stop or 0 if ending.takes else 0) > DARK:
        wrong.append(f"dark at {log.dark}")
    if not any(lit for at, lit in log.lit if at < 0):
        wrong.append("it did not burn before")
    if log.end < DARK + WATCHED - 0.5:
        wrong.append("not watched long enough")
    return log, wrong


HEADS = ("", "stop", "last frame that burns", "laser off", "dark", "longest piece")


def line(name, log):
    instant = lambda at: "" if at is None else f"{at:+.2f} s"
    last = max(log.burns, default=None)
    return (name, instant(log.stop), instant(last), instant(log.off), "throughout" if not log.burns else instant(log.dark), f"{log.longest:.2f} s" if log.burns else "")


def client(port, path):
    """Program that `client_is_killed` starts."""
    one = Client(port, "killed")
    one.call("lease.acquire", wait_s=10)
    one.call("job.start", text=open(path).read(), **START)
    print("burns", flush=True)
    threading.Event().wait()


if __name__ == "__main__":
    client(int(sys.argv[1]), sys.argv[2])
