"""The driver over Bluetooth, with a mock of BlueZ on a private D-Bus: session_ble.py PTY UDP TCP
SPEED MAGICIAN

The program is one that was built with Bluetooth. bluez.py takes the part of the computer's
Bluetooth stack and of the module in the arm. Behind it is the arm that the runner serves.
"""

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

from checks import TIMEOUT, Checks
from wire import Tcp

HERE = pathlib.Path(__file__).resolve().parent
ARM = {"address": "C0:FF:EE:00:00:01", "name": "Magician", "arm": True}
OTHER = {"address": "AA:00:00:00:00:01", "name": "Pulse 5"}
NAMELESS = {"address": "AA:00:00:00:00:02"}
AROUND = [OTHER, ARM, NAMELESS]
FAST, SLOW = ["write-without-response"], ["write"]
# Exit statuses (`magician help exit-status`).
PORT, UNEXPECTED = 4, 6


def python_with_dbus():
    """Returns an interpreter with dbus-python and PyGObject, which come with the system instead of
    PyPI."""
    for python in (sys.executable, "/usr/bin/python3"):
        found = subprocess.run([python, "-c", "import dbus, gi"], capture_output=True, check=False)
        if found.returncode == 0:
            return python
    raise AssertionError("no Python with dbus and gi; install dbus, python3-dbus and python3-gi")


class MockBus:
    """Private bus with the BlueZ mock."""

    def __init__(self, home, tcp):
        self.address = f"unix:path={home}/bus"
        self.environment = os.environ | {"DBUS_SYSTEM_BUS_ADDRESS": self.address}
        bus = ["dbus-daemon", "--session", f"--address={self.address}", "--nofork", "--nopidfile", "--print-address"]
        self.bus = subprocess.Popen(bus, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.bus.stdout.readline()
        self.tcp = tcp
        self.begin()

    def begin(self):
        self.bluez = self.start([python_with_dbus(), "-B", HERE / "bluez.py", str(self.tcp)])
        assert self.bluez.stdout.readline() == "ready\n", "bluez.py does not come up"

    def crash(self):
        self.bluez.kill()
        self.bluez.wait(TIMEOUT)

    def start(self, command, **more):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        return subprocess.Popen(command, env=self.environment, **(pipes | more))

    def do(self, name, **arguments):
        print(json.dumps({"do": name, **arguments}), file=self.bluez.stdin, flush=True)
        return json.loads(self.bluez.stdout.readline())

    def seen(self):
        return self.do("seen")

    def let_go(self):
        """Waits until there is no connection and no scan. Returns false after a timeout."""
        end = time.monotonic() + TIMEOUT
        while (seen := self.seen())["connected"] or seen["scanning"]:
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def close(self):
        self.bluez.stdin.close()
        self.bluez.wait(TIMEOUT)
        self.bus.kill()
        self.bus.wait(TIMEOUT)


class ProgramRunner:
    """Runs the program against the mock."""

    def __init__(self, air, magician, tcp):
        self.air, self.magician, self.watcher = air, magician, Tcp(tcp)

    def run(self, *arguments, port="ble:Magician", script=None, environment=None):
        """Returns the exit status, the lines of stdout as JSON, and the elapsed seconds."""
        begin = time.monotonic()
        command = [self.magician, "--port", port, "--json", *arguments]
        ended = subprocess.run(
            command, input=script or "", capture_output=True, text=True, timeout=5 * TIMEOUT, env=environment or self.air.environment
        )
        said = [json.loads(line) for line in (ended.stdout + ended.stderr).splitlines() if line.startswith("{")]
        return ended.returncode, said, time.monotonic() - begin

    def error(self, *arguments, **more):
        status, said, seconds = self.run(*arguments, **more)
        error = said[-1].get("error", {}) if said else {}
        return status, error.get("message", str(said)), seconds

    def index(self):
        return self.watcher.index()

    def pose(self):
        return self.watcher.pose()


def looks_and_moves(checks, desk):
    print("an arm that is on the air")
    desk.air.do("set", around=AROUND)
    status, said, seconds = desk.run("pose")
    pose = [said[0][key] for key in ("x", "y", "z", "r", "j1", "j2", "j3", "j4")] if status == 0 else said
    checks.near("magician --port ble:Magician pose", pose, desk.pose(), 1e-3)
    seen = desk.air.seen()
    checks.ok("found, asked and let go", desk.air.let_go(), f"{seconds:.2f} s, {', '.join(seen['asked'])}")
    checks.equal("the one characteristic is written to", {where for where, _, _ in seen["written"]}, {"2"})

    for port in ("ble:mAGICIAN", "ble:c0:ff:ee:00:00:01", "BLE:C0-FF-EE-00-00-01"):
        checks.equal(f"--port {port}", desk.run("pose", port=port)[0], 0)

    checks.equal("home", desk.run("--yes", "home")[0], 0)
    status, said, _ = desk.run("move", "220", "60", "40", "15")
    checks.equal("move", status, 0)
    checks.near("and is there", desk.pose()[:4], (220, 60, 40, 15), 1e-2)
    written = desk.air.seen()["written"]
    checks.equal("a PTP frame of 23 bytes is cut in two", [size for _, _, size in written if size in (20, 3)][-2:], [20, 3])
    checks.ok("no write is longer than 20 bytes", max(size for _, _, size in written) == 20, len(written))
    checks.ok("without responses", {kind for _, kind, _ in written} == {"command"})
    checks.ok("nothing stays connected", desk.air.let_go())


def stops(checks, desk):
    print("Ctrl-C during a slow move")
    desk.air.do("set", around=AROUND, interval=15)
    desk.run("move", "220", "60", "40", "0")
    begun = desk.pose()[:3]
    moving = desk.air.start([desk.magician, "--port", "ble:Magician", "move", "220", "-60", "40", "0", "--linear", "--speed-ratio", "1"])
    while desk.pose()[:3] == begun and moving.poll() is None:
        time.sleep(0.002)
    moving.send_signal(signal.SIGINT)
    moving.communicate(timeout=TIMEOUT)
    checks.equal("exit status", moving.returncode, 130)
    stopped = desk.pose()
    time.sleep(0.1)
    checks.ok("it stands, short of its goal", desk.pose() == stopped and stopped[1] > -59, f"y {stopped[1]:.1f}")
    checks.ok("and is let go", desk.air.let_go())
    desk.run("queue", "clear")
    desk.run("set", "PTPCommonParams", "velocity_ratio=100", "acceleration_ratio=100")


def either_way_round(checks, desk):
    print("which characteristic is which (errata E50)")
    both = ["write", "notify"]
    for name, flags, want in (
        ("CDD1 notifies, CDD2 is written to", {"1": ["notify"], "2": FAST}, ("2", "command")),
        ("CDD1 is written to, CDD2 notifies", {"1": FAST, "2": ["notify"]}, ("1", "command")),
        ("writes with a response, indications", {"1": ["indicate"], "2": SLOW}, ("2", "request")),
        ("both do both: as the document has it", {"1": both, "2": both}, ("2", "request")),
        ("one does both", {"2": [*FAST, "notify"]}, ("2", "command")),
    ):
        desk.air.do("set", around=AROUND, flags=flags)
        status, said, _ = desk.run("move", "220", "-40", "40", "15")
        written = {tuple(one[:2]) for one in desk.air.seen()["written"]}
        checks.equal(name, (status, written), (0, {want}))
    for name, flags in (("neither notifies", {"1": ["read"], "2": FAST}), ("neither takes writes", {"1": ["notify"], "2": ["read"]})):
        desk.air.do("set", around=AROUND, flags=flags)
        status, message, _ = desk.error("pose")
        told = all(f"{flag}" in message.replace("_", "-") for flag in flags["1"] + flags["2"])
        checks.ok(f"{name}: {message}", status == UNEXPECTED and told)
        checks.ok("and it is let go", desk.air.let_go())
    desk.air.do("set", around=AROUND)
    status, message, _ = desk.error("pose", port="ble:Pulse 5")
    checks.ok(f"another device: {message}", status == UNEXPECTED and "is not a Magician" in message)
    checks.ok("and it is let go", desk.air.let_go())


def widths(checks, desk):
    print("packets")
    move = ("move", "220", "40", "40", "0")
    for mtu, longest in ((None, 20), (23, 20), (40, 23), (247, 23)):
        desk.air.do("set", around=AROUND, mtu=mtu)
        status, _, _ = desk.run(*move)
        written = [size for _, _, size in desk.air.seen()["written"]]
        checks.equal(f"MTU {mtu}: longest write", (status, max(written)), (0, longest))


def streams(checks, desk):
    print("a stream")
    for name, flags, interval in (("without responses", None, 0), ("with responses, every 10 ms", {"1": ["notify"], "2": SLOW}, 10)):
        desk.air.do("set", around=AROUND, flags=flags, interval=interval)
        shell = Shell(desk)
        shell.say("move 210 -30 30 0")
        shell.say("queue start")
        begin, indices, full = time.monotonic(), [], 0
        for k in range(300):
            x, y = 210 + 4 * (k % 2), -30 + 0.2 * (k + 1)
            while "index" not in (answer := shell.say(cp(x, y))):
                if answer["error"]["kind"] != "queue-full":
                    raise AssertionError(answer)
                full += 1
                time.sleep(0.005)
            indices.append(answer["index"])
        seconds = time.monotonic() - begin
        desk.watcher.wait(indices[-1])
        shell.close()
        checks.equal(f"300 CP segments {name}: indices that do not follow", [b for a, b in zip(indices, indices[1:]) if b != a + 1], [])
        sent = pieces(desk.air.seen()["written"])
        checks.ok("each was taken once", desk.index() == indices[-1], f"{seconds:.1f} s, {sent} frames in two writes each, full {full} times")
        checks.near("it ends where the last one does", desk.pose()[:3], (214, 30, 30), 1e-2)


def cp(x, y):
    return f"enqueue CPCmd cp_mode=1 x={x} y={y:.1f} z=30 velocity_or_power=0"


def pieces(written):
    """Returns the number of 23-byte frames that were written as 20 and 3 bytes."""
    sizes = [size for _, _, size in written]
    return sum(pair == (20, 3) for pair in zip(sizes, sizes[1:]))


def rates(checks, desk):
    print("how fast GetPose is (a computer's share, and intervals as played; no radio)")
    for name, interval, flags, count in (
        ("the bus alone", 0, None, 400),
        ("connection interval 15 ms", 15, None, 60),
        ("30 ms", 30, None, 60),
        ("30 ms, writes with responses", 30, {"1": ["notify"], "2": SLOW}, 60),
    ):
        desk.air.do("set", around=AROUND, interval=interval, flags=flags)
        _, _, start = desk.run("shell", script="pose\n")
        status, said, seconds = desk.run("shell", script="pose\n" * (count + 1))
        each = (seconds - start) / count
        checks.ok(f"{name}", status == 0 and len(said) == count + 1, f"{1 / max(each, 1e-6):.0f} a second, {each * 1000:.1f} ms each")


class Shell:
    """The program's shell over one connection."""

    def __init__(self, desk):
        command = [desk.magician, "--port", "ble:Magician", "--json", "shell", "--keep-going"]
        self.process = desk.air.start(command, stderr=subprocess.STDOUT)
        self.watchdog = threading.Timer(5 * TIMEOUT, self.process.kill)
        self.watchdog.start()

    def say(self, line):
        """Sends a line and returns the answer as JSON."""
        print(line, file=self.process.stdin, flush=True)
        while answer := self.process.stdout.readline():
            if answer.startswith("{"):
                return json.loads(answer)
        raise AssertionError("the shell has ended")

    def until(self, line, good, seconds=TIMEOUT):
        """Repeats a line until the answer is good. Returns the elapsed time."""
        begin = time.monotonic()
        while not good(answer := self.say(line)):
            if time.monotonic() > begin + seconds:
                raise AssertionError(f"still {answer}")
            time.sleep(0.05)
        return time.monotonic() - begin

    def close(self):
        self.process.stdin.close()
        self.process.stdout.read()
        self.watchdog.cancel()
        return self.process.wait(TIMEOUT)


def comes_back(checks, desk):
    print("an arm that vanishes and comes back")
    desk.air.do("set", around=AROUND)
    shell = Shell(desk)
    checks.ok("pose", "x" in shell.say("pose"))
    desk.air.do("vanish")
    kinds = []
    took = shell.until("pose", lambda answer: kinds.append(answer) or "error" in answer)
    error = kinds[-1]["error"]
    checks.ok(f"its loss is told: {error['message']}", error["kind"] == "port" and took < TIMEOUT, f"{took:.2f} s")
    desk.air.do("come_back")
    took = shell.until("pose", lambda answer: "x" in answer)
    checks.ok("it is found again", took < TIMEOUT, f"{took:.2f} s")
    checks.equal("connected to once each time", desk.air.seen()["asked"].count("connect"), 2)
    desk.air.do("power", on=False)
    kinds.clear()
    shell.until("pose", lambda answer: kinds.append(answer) or "error" in answer)
    checks.equal("Bluetooth switched off: told", kinds[-1]["error"]["kind"], "port")
    desk.air.do("power", on=True)
    took = shell.until("pose", lambda answer: "x" in answer)
    checks.ok("and on again: found", took < TIMEOUT, f"{took:.2f} s")
    desk.air.crash()
    kinds.clear()
    shell.until("pose", lambda answer: kinds.append(answer) or "error" in answer)
    checks.equal("BlueZ crashes: told", kinds[-1]["error"]["kind"], "port")
    desk.air.begin()
    desk.air.do("set", around=AROUND)
    took = shell.until("pose", lambda answer: "x" in answer)
    checks.ok("and is started again: found", took < TIMEOUT, f"{took:.2f} s")
    shell.close()
    checks.ok("it is let go", desk.air.let_go())


def never_twice(checks, desk):
    print("an arm that vanishes in the middle of a stream")
    desk.run("move", "210", "-30", "30", "0")
    for writes in (40, 41, 42, 43):
        desk.air.do("set", around=AROUND)
        shell = Shell(desk)
        shell.say("queue start")
        first = shell.say("enqueue WAITCmd timeout=1")["index"]
        desk.air.do("vanish_after", writes=writes)
        given, failed = [], []
        for k in range(40):
            answer = shell.say(cp(210, -30 + 0.3 * (k + 1)))
            if "index" in answer:
                given.append(answer["index"])
            else:
                failed.append(answer["error"]["kind"])
                desk.air.do("come_back")
                shell.until("pose", lambda answer: "x" in answer)
                shell.say("queue start")
            time.sleep(0.005)
        last = shell.say("enqueue WAITCmd timeout=1")["index"]
        shell.close()
        unsaid = last - first - 1 - len(given)
        checks.ok(
            f"gone at write {writes}: {len(given)} taken, {len(failed)} told as {', '.join(failed)}, {unsaid} of those taken",
            len(failed) == 1 and given == sorted(set(given)) and (unsaid == 0 or (unsaid, failed) == (1, ["uncertain"])),
        )


def refusals(checks, desk):
    print("what cannot be")
    air = desk.air
    air.do("set", around=AROUND)
    status, message, seconds = desk.error("pose", port="ble:Dobot")
    named = "Magician (C0:FF:EE:00:00:01)" in message and "Pulse 5 (AA:00:00:00:00:01)" in message and "AA:00:00:00:00:02 (no name)" in message
    checks.ok(f"a wrong name: {message}", status == PORT and named and seconds < TIMEOUT, f"{seconds:.1f} s")
    checks.ok("and the scan has ended", air.let_go())

    twin = ARM | {"address": "C0:FF:EE:00:00:02"}
    air.do("set", around=[*AROUND, twin])
    status, message, _ = desk.error("pose")
    checks.ok(f"two of a name: {message}", status == PORT and ARM["address"] in message and twin["address"] in message)
    checks.equal("an address decides", desk.run("pose", port="ble:C0:FF:EE:00:00:02")[0], 0)
    air.do("set", around=[*AROUND, twin | {"advertises": True}])
    checks.equal("or that only one says it is an arm", desk.run("pose")[0], 0)

    air.do("set", around=AROUND, refuse=1)
    checks.equal("a connection that breaks off at once is tried again", desk.run("pose")[0], 0)
    air.do("set", around=AROUND, refuse=5)
    status, message, _ = desk.error("pose")
    checks.ok(f"but not for ever: {message}", status == PORT and "cannot be connected" in message)

    air.do("set", forbidden=True, around=AROUND)
    status, said, _ = desk.run("pose")
    error = said[-1]["error"]
    remedies = [remedy.get("system", "") for remedy in error.get("remedies", [])]
    checks.ok(f"forbidden: {error['message']}", status == PORT and any("usermod -aG bluetooth" in remedy for remedy in remedies))

    air.do("set", powered=False, around=AROUND)
    status, message, seconds = desk.error("pose")
    checks.ok(f"Bluetooth off: {message}", status == PORT and "Bluetooth is off" in message and seconds < 9)
    checks.equal("and it is left off", air.seen()["asked"], [])

    air.do("set", adapter=False)
    status, message, seconds = desk.error("pose")
    checks.ok(f"no adapter: {message}", status == PORT and "no Bluetooth adapter" in message and seconds < 9)

    nowhere = os.environ | {"DBUS_SYSTEM_BUS_ADDRESS": "unix:path=/nonexistent"}
    status, message, _ = desk.error("pose", environment=nowhere)
    checks.ok(f"no bus: {message}", status == PORT and "D-Bus" in message)


def without_bluez(checks, magician, tcp):
    print("no BlueZ")
    with tempfile.TemporaryDirectory(prefix="magician-ble-") as home:
        air = MockBus(home, tcp)
        air.bluez.stdin.close()
        air.bluez.wait(TIMEOUT)
        status, message, _ = ProgramRunner(air, magician, tcp).error("pose")
        checks.ok(f"it is not running: {message}", status == PORT and "does not run" in message)
        air.close()


def main():
    _, _, tcp, _, magician = sys.argv[1:]
    checks = Checks()
    help_text = subprocess.run([magician, "--port", "ble:x", "pose"], capture_output=True, text=True, check=False).stderr
    if re.search("lacks the feature", help_text):
        checks.ok("the program was built with Bluetooth", False, help_text.strip())
        checks.finish()
    with tempfile.TemporaryDirectory(prefix="magician-ble-") as home:
        air = MockBus(home, int(tcp))
        desk = ProgramRunner(air, magician, int(tcp))
        for part in (looks_and_moves, stops, either_way_round, widths, streams, rates, comes_back, never_twice, refusals):
            checks.section(part, desk)
        air.close()
    checks.section(without_bluez, magician, int(tcp))
    checks.finish()


if __name__ == "__main__":
    main()
