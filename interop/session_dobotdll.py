"""The vendor's C interface as programs call it: session_dobotdll.py PTY UDP TCP SPEED MAGICIAN
FAMILY

Raw ctypes calls as the stock wrappers make them, against the simulator behind its terminal and
against a virtual arm in this process. The wrappers themselves are tested in session_dobottype.py.
"""

import ctypes
import os
import pty
import signal
import sys
import tempfile
import threading
import time
import tty
from ctypes import byref, c_float, c_int, create_string_buffer

import arm as model
from checks import TIMEOUT, Checks
from dobotdll import NOT_CONNECTED, SENTINEL, CircleCmd, HOMECmd, IOADC, IODO, JOGCmd, PTPCmd, Stock, library
from sim import Sim
from wire import frame, split

POWER_UP_POSE = (*model.forward(model.POWER_UP_JOINTS), *model.POWER_UP_JOINTS)
PROBE = b"\nM10\n" + b"M10\n" * 4


def search(checks, stock):
    print("SearchDobot")
    api = stock.api
    names = ctypes.create_string_buffer(b"\xee" * 1000, 1000)
    count = api.SearchDobot(names, 900)
    found = names.value.decode().split(" ") if names.value else []
    checks.equal("it returns how many names there are", count, len(found))
    checks.equal("and writes no further than it may", names.raw[900:], b"\xee" * 100)
    checks.ok("bare names", not any("/" in name for name in found), found)
    names = ctypes.create_string_buffer(b"\xee" * 8, 8)
    api.SearchDobot(names, 1)
    checks.equal("one byte holds the empty list", names.raw, b"\0" + b"\xee" * 7)
    checks.equal("a null list is allowed", api.SearchDobot(None, 0) >= 0, True)


def before_connecting(checks, stock):
    print("before ConnectDobot")
    arm = stock.arm()
    begin = time.monotonic()
    code, values = arm.pose()
    checks.equal("GetPose", code, NOT_CONNECTED[stock.family])
    checks.equal("leaves its output alone", values, [SENTINEL] * 8)
    code, index = arm.move(1, 200, 0, 0, 0)
    checks.equal("SetPTPCmd and its index", (code, index), (NOT_CONNECTED[stock.family], SENTINEL))
    checks.equal("SetQueuedCmdStartExec", arm("SetQueuedCmdStartExec"), NOT_CONNECTED[stock.family])
    checks.equal("DisconnectDobot", arm.disconnect(), 0)
    # Three of these calls would wait 3 s each for an arm that does not answer.
    checks.ok("all at once", time.monotonic() - begin < 5)
    checks.equal("DobotExec returns at once", stock.api.DobotExec(), 0)
    checks.equal("and so does PeriodicTask", stock.api.PeriodicTask(), 0)
    checks.equal("a port that is not there is occupied", stock.connect("/dev/ttyNothing").result, 2)
    size = ctypes.create_string_buffer(300)
    length = stock.api.MagicianLastError(size, 300)
    checks.equal("MagicianLastError returns its length", length, len(size.value))
    checks.ok("and names the port", b"ttyNothing" in size.value, size.value.decode())


def connects(checks, stock, port):
    connected = stock.connect(port)
    checks.equal("ConnectDobot", connected.result, 0)
    if stock.family == "v3":
        checks.equal("the master is a Magician", connected.kind, 2)
    else:
        checks.equal("names of firmware and version", (connected.firmware, connected.version), ("DobotSerial", "0.0.0"))
    return stock.arm(connected.ids)


def reading(checks, arm):
    print("reading")
    code, values = arm.pose()
    checks.equal("GetPose", code, 0)
    checks.near("at power-up", values, POWER_UP_POSE)
    bits, length = create_string_buffer(b"\xee" * 1000, 1000), c_int(SENTINEL)
    checks.equal("GetAlarmsState with an int* for len", arm("GetAlarmsState", bits, byref(length), 1000), 0)
    checks.equal("16 bytes", (length.value, bits.raw[16:18]), (16, b"\xee\xee"))
    checks.equal("ClearAllAlarmsState", arm("ClearAllAlarmsState"), 0)
    arm("GetAlarmsState", bits, byref(length), 1000)
    checks.equal("no alarm is left", bits.raw[:16], bytes(16))
    name = create_string_buffer(66)
    checks.equal("SetDeviceName", arm("SetDeviceName", create_string_buffer(b"magician", 66)), 0)
    code = arm("GetDeviceName", name, 100)
    checks.equal("GetDeviceName, 66 bytes said to be 100", (code, name.value), (0, b"magician"))
    short = create_string_buffer(b"\xee" * 10, 10)
    arm("GetDeviceName", short, 5)
    checks.equal("a short buffer is cut and ended", short.raw, b"magi\0" + b"\xee" * 5)
    analog = IOADC(1, 0x55555555)
    checks.equal("GetIOADC into 5 bytes", arm("GetIOADC", byref(analog)), 0)
    checks.equal("three are written", analog.value >> 16, 0x5555)
    checks.equal("a null structure is refused", (arm("GetPose", None), arm("SetPTPCmd", None, 1, None)), (3, 3))


def queueing(checks, arm):
    print("queueing")
    arm("SetQueuedCmdClear")
    arm("SetQueuedCmdStartExec")
    code, first = arm.move(1, 220, 40, 30, 0, queued=0)
    checks.equal("SetPTPCmd with isQueued 0 is queued", code, 0)
    checks.ok("and has an index", 0 < first < SENTINEL, first)
    checks.equal("the next has the next one", arm.move(2, 220, -40, 30, 0, queued=1), (0, first + 1))
    checks.equal("a null index is allowed", arm("SetPTPCmd", byref(ptp(arm, 2, 230, 0, 40, 10)), 1, None), 0)
    nothing = HOMECmd((c_float * 1)(0))
    checks.equal("SetHOMECmd with its float", arm.queued("SetHOMECmd", byref(nothing)), (0, first + 3))
    checks.equal("an int for each bool", arm.queued("SetEndEffectorSuctionCup", 1, 1), (0, first + 4))
    checks.equal("SetJOGCmd is not forced", arm.queued("SetJOGCmd", byref(JOGCmd(1, 0))), (0, SENTINEL))
    checks.equal("SetIODO", arm.queued("SetIODO", byref(IODO(10, 1))), (0, first + 5))
    finish(arm, first + 5)
    checks.equal("the current index comes to the last", arm.index(), first + 5)
    checks.near("homed", arm.pose()[1], POWER_UP_POSE)
    enabled, on = c_int(0), c_int(0)
    checks.equal("GetEndEffectorSuctionCup into ints", arm("GetEndEffectorSuctionCup", byref(enabled), byref(on)), 0)
    checks.equal("on", (enabled.value, on.value), (1, 1))
    checks.equal("the laser with a power for its bool", arm.queued("SetEndEffectorLaser", 1, 128)[0], 0)
    arm.queued("SetEndEffectorLaser", 0, 0)
    target = (200.0, 60.0, 20.0, 5.0)
    _, last = arm.move(1, *target)
    finish(arm, last)
    checks.near("a move ends where it should", arm.pose()[1], (*target, *model.inverse(target)))
    if arm.family != "v1":
        # The wrappers of these families have no count: 32 bytes.
        circle = CircleCmd((c_float * 8)(220, 60, 20, 5, 220, 40, 20, 5))
        code, last = arm.queued("SetCircleCmd", byref(circle))
        checks.equal("SetCircleCmd with 32 bytes", code, 0)
        finish(arm, last)


def ptp(arm, mode, *target):
    """Returns a PTPCmd as the family's wrapper declares it."""
    return PTPCmd[arm.family](mode, (c_float * 4)(*target))


def finish(arm, index, timeout=2 * TIMEOUT):
    """Polls the index, as all programs do."""
    end = time.monotonic() + timeout
    while arm.index() < index:
        if time.monotonic() > end:
            raise AssertionError(f"index {index} was not reached, it stands at {arm.index()}")
        time.sleep(0.002)


def buffer_full(checks, arm):
    print("a full queue")
    arm("SetQueuedCmdStopExec")
    arm("SetQueuedCmdClear")
    begin, codes = arm.index(), []
    while not codes or codes[-1][0] == 0 and len(codes) < 1000:
        codes.append(arm.wait(10))
    checks.equal("the last is told so, without an index", codes[-1], (1, SENTINEL))
    checks.ok("after as many as fit", 8 <= len(codes) - 1 < 1000, len(codes) - 1)
    indices = [index for _, index in codes[:-1]]
    checks.equal("their indices go up by one", indices, list(range(indices[0], indices[0] + len(indices))))
    checks.equal("and again, at once", [arm.wait(10) for _ in range(3)], [(1, SENTINEL)] * 3)
    checks.equal("a stopped queue runs nothing", arm.index(), begin)
    arm("SetQueuedCmdStartExec")
    finish(arm, indices[-1])
    checks.equal("there is room again", arm.wait(10), (0, indices[-1] + 1))


def again(checks, stock, arm, port):
    print("disconnect and connect again")
    pose = arm.pose()[1]
    finish(arm, arm.wait(1)[1])
    index = arm.index()
    checks.equal("DisconnectDobot", (arm.disconnect(), arm.disconnect()), (0, 0))
    checks.equal("then there is no arm", arm.pose()[0], NOT_CONNECTED[stock.family])
    arm = connects(checks, stock, port)
    checks.near("it stands where it stood", arm.pose()[1], pose)
    checks.equal("indices go on", (arm.index(), arm.wait(1)), (index, (0, index + 1)))
    if stock.family == "v1":
        checks.equal("connecting twice opens it again", stock.connect(port).result, 0)
        checks.equal("and it answers", arm.pose()[0], 0)
    return arm


def threads(checks, arm):
    print("threads")
    indices, poses, lock = [], [], threading.Lock()

    def work():
        for _ in range(25):
            pose = arm.pose()
            while (answer := arm.wait(1))[0] == 1:
                time.sleep(0.001)
            with lock:
                poses.append(pose[0])
                indices.append(answer)

    workers = [threading.Thread(target=work) for _ in range(8)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    checks.equal("every call succeeds", (set(poses), {code for code, _ in indices}), ({0}, {0}))
    got = sorted(index for _, index in indices)
    checks.equal("every command has its own index", got, list(range(got[0], got[0] + 200)))


def session(checks, stock, port):
    """Runs all checks at one port."""
    arm = connects(checks, stock, port)
    reading(checks, arm)
    queueing(checks, arm)
    buffer_full(checks, arm)
    threads(checks, arm)
    arm = again(checks, stock, arm, port)
    arm.disconnect()


def two_arms(checks, stock, port):
    print("two arms")
    one, other = stock.connect(port), stock.connect("sim")
    checks.equal("ids", [int(getattr(ids[0], "value", ids[0])) for ids in (one.ids, other.ids)], [0, 1])
    one, other = stock.arm(one.ids), stock.arm(other.ids)
    for arm, target in ((one, (210, 30, 30, 0)), (other, (230, -30, 10, 0))):
        arm("SetQueuedCmdStartExec")
        finish(arm, arm.move(1, *target)[1])
    checks.near("each went its own way", one.pose()[1][:4] + other.pose()[1][:4], (210, 30, 30, 0, 230, -30, 10, 0))
    one.disconnect()
    checks.equal("one goes, the other stays", (one.pose()[0], other.pose()[0]), (NOT_CONNECTED[stock.family], 0))
    third = stock.connect("sim")
    checks.equal("its id is given again", int(getattr(third.ids[0], "value", third.ids[0])), 0)
    other.disconnect()
    stock.arm(third.ids).disconnect()


def silence(checks, stock, magician):
    print("an arm that stops answering")
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        path = os.path.join(home, "arm")
        sim = Sim(magician, path, "20")
        connected = stock.connect(path)
        arm = stock.arm(connected.ids)
        checks.equal("SetCmdTimeout", arm.set_timeout(300), 0)
        arm.pose()
        sim.process.send_signal(signal.SIGSTOP)
        begin = time.monotonic()
        code, values = arm.pose()
        took = time.monotonic() - begin
        checks.equal("GetPose times out", (code, values), (2, [SENTINEL] * 8))
        # The default timeout would be 3 s.
        checks.ok("in its time", 0.25 < took < 2.9, f"{took:.2f} s")
        sim.process.send_signal(signal.SIGCONT)
        arm.set_timeout(TIMEOUT * 1000)
        checks.equal("and answers when the arm does", arm.pose()[0], 0)
        checks.equal("SetQueuedCmdClear", arm("SetQueuedCmdClear"), 0)
        sim.end(signal.SIGKILL)
        arm.set_timeout(300)
        begin = time.monotonic()
        codes = {arm.pose()[0], arm.wait(1)[0], arm("SetQueuedCmdStartExec")}
        checks.equal("an arm that is gone", codes, {2})
        checks.ok("three calls in their time", time.monotonic() - begin < 8, f"{time.monotonic() - begin:.2f} s")
        checks.equal("DisconnectDobot", arm.disconnect(), 0)


class Wire(threading.Thread):
    """Far end of a terminal: records what arrives, and answers with a function."""

    def __init__(self, answer):
        super().__init__(daemon=True)
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        self.path, self.slave, self.answer, self.heard = os.ttyname(slave), slave, answer, b""
        self.start()

    def run(self):
        while True:
            try:
                data = os.read(self.master, 256)
            except OSError:
                return
            self.heard += data
            if reply := self.answer(data, self.heard):
                os.write(self.master, reply)

    def close(self):
        # No other process has this end open, so closing it ends the thread. If the master were
        # closed first, the thread might continue with the next terminal that gets the same number.
        os.close(self.slave)
        self.join(10)
        os.close(self.master)


def text_probe(checks, stock):
    print("the text probe")

    def silent(_data, _heard):
        return b""

    def printer(_data, heard):
        return b"ok\nGRBL: V1.2.3\n" if PROBE in heard else b""

    def arm(data, _heard):
        known = {0: b"number", 2: b"\x03\x07\x00", 246: bytes(8), 247: b"\x20\0\0\0"}
        return b"".join(frame(ident, ctrl, known.get(ident, bytes(32))) for ident, ctrl, _ in split(data)[0])

    wire = Wire(silent)
    begin = time.monotonic()
    connected = stock.connect(wire.path)
    took = time.monotonic() - begin
    checks.equal("nobody answers: connected all the same", connected.result, 0)
    checks.ok("the question was asked in text", PROBE in wire.heard, wire.heard)
    checks.ok("after it was asked in frames", wire.heard.startswith(b"\xaa\xaa"), wire.heard[:8])
    checks.ok("for half a second", 0.5 <= took < TIMEOUT, f"{took:.2f} s")
    nobody = stock.arm(connected.ids)
    nobody.set_timeout(200)
    checks.equal("calls then time out", nobody.pose()[0], 2)
    nobody.disconnect()
    wire.close()

    wire = Wire(printer)
    connected = stock.connect(wire.path)
    said = (connected.result, connected.firmware, connected.version)
    checks.equal("a printer's firmware", said, (0, "GRBL", "1.2.3"))
    checks.equal("its port is closed again", stock.arm(connected.ids).pose()[0], NOT_CONNECTED[stock.family])
    stock.arm(connected.ids).disconnect()
    wire.close()

    wire = Wire(arm)
    connected = stock.connect(wire.path)
    checks.equal("an arm that answers", connected.result, 0)
    checks.ok("is asked nothing in text", b"M10" not in wire.heard, wire.heard)
    stock.arm(connected.ids).disconnect()
    wire.close()


def redirected(checks, stock):
    print("names that lead elsewhere")
    os.environ["MAGICIAN_PORT_COM3"] = "sim"
    connected = stock.connect("COM3")
    checks.equal("MAGICIAN_PORT_COM3=sim", connected.result, 0)
    checks.equal("answers", stock.arm(connected.ids).pose()[0], 0)
    stock.arm(connected.ids).disconnect()
    os.environ["MAGICIAN_PORT"] = "sim"
    connected = stock.connect("")
    checks.equal("MAGICIAN_PORT=sim for an empty name", connected.result, 0)
    stock.arm(connected.ids).disconnect()
    del os.environ["MAGICIAN_PORT"], os.environ["MAGICIAN_PORT_COM3"]


def main():
    port, magician, family = sys.argv[1], sys.argv[5], sys.argv[6]
    path, _ = library(magician, family)
    checks = Checks()
    stock = Stock(family, path)
    checks.section(search, stock)
    checks.section(before_connecting, stock)
    for place in (port, "sim"):
        print(f"at {'the terminal' if place == port else 'sim'}")
        checks.section(session, stock, place)
    if family != "v1":
        checks.section(two_arms, stock, port)
    checks.section(silence, stock, magician)
    checks.section(text_probe, stock)
    checks.section(redirected, stock)
    checks.finish()


if __name__ == "__main__":
    main()
