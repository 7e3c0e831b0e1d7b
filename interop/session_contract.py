"""Behaviour that programs in the field rely on, as raw bytes: session_contract.py PTY UDP_PORT
TCP_PORT SPEED

No robot library is involved. Every expectation is written here as bytes, or as numbers from the
independent model in arm.py. The sections carry the numbers of the facts they check:

 1 one reply per request, in order, echoed, in one piece, nothing unsolicited, soon
 2 wrong checksum: no answer, no effect, the next frame is answered
 3 resynchronisation after noise and after a truncated frame, without a flush
 4 the terminal: raw from creation, can be reopened, modem lines, a killed client, old bytes
 5 queued replies hold exactly the index; indices step by one
 6 current index = last finished, the pose is final when it is reported, also with rw = 1
 7 moves take time
 8 immediate motion moves and is answered empty
 9 a queued jog is finished at once and continues until command 0
10 the short, long and odd forms that hosts send
11 UDP answers the sender's current port; terminal, UDP and TCP serve the same arm
"""

import errno
import fcntl
import math
import os
import signal
import statistics
import struct
import subprocess
import sys
import termios
import time

import arm as model
from checks import TIMEOUT, Checks
from wire import ALARMS, GET, INDEX, POSE, QUEUED, SET, TIME, Observer, Pty, Tcp, Udp
from wire import check_durations, floats, frame, open_eventually, split

PTP, PTPPO, PTPPO_L, CP, HOME, HOME_PARAMS, JOG, WAIT = 84, 88, 89, 91, 31, 30, 73, 110
NAME, RAIL, START, STOP, CLEAR = 1, 3, 240, 241, 245
MULTIPLEX, OUTPUT, PWM, INPUT, ADC, COLOUR, INFRARED = 130, 131, 132, 133, 134, 137, 138


def ptp(mode, *target):
    """Parameters of a point-to-point command."""
    return struct.pack("<B4f", mode, *target)


def cp(x, y, z, power=None, mode=1):
    """Parameters of a CP command; without the last float as the short form of 14 bytes."""
    return struct.pack("<B3f", mode, x, y, z) + (b"\0" if power is None else struct.pack("<f", power))


def go(link, *target, mode=model.MOVJ_XYZ):
    """Moves, waits, and returns the pose afterwards."""
    link.wait(link.queue(PTP, ptp(mode, *target)))
    return link.pose()


def rest(link, timeout=TIMEOUT):
    """Waits until two consecutive poses are equal."""
    end, last, pose = time.monotonic() + timeout, None, link.pose()
    while pose != last:
        if time.monotonic() > end:
            raise AssertionError("the arm does not come to rest")
        time.sleep(0.05)
        last, pose = pose, link.pose()
    return pose


# ---------------------------------------------------------------------------------------------------------- 4, first


def untouched_terminal(checks, path):
    print("4 the terminal as it is created")
    checks.ok("the path is a symbolic link to a terminal", os.path.islink(path), os.readlink(path))
    link = Pty(path, raw=False)
    mode = termios.tcgetattr(link.fd)
    cooked = mode[3] & (termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN)
    mapped = mode[0] & (termios.ICRNL | termios.INLCR | termios.IGNCR | termios.IXON | termios.ISTRIP)
    checks.equal("raw: no echo, no lines, no signals, no mapping", (cooked, mapped, mode[1] & termios.OPOST), (0, 0, 0))
    checks.near("a client that sets nothing is answered", link.pose(), (259.10413, 0, -8.48528, 0, 0, 45, 45, 0))
    saved, wrong = link.ask(HOME_PARAMS), []
    for start in range(0, 256, 16):
        block = bytes(range(start, start + 16))
        link.ask(HOME_PARAMS, SET, block)
        if link.ask(HOME_PARAMS) != block:
            wrong.append(start)
    checks.equal("all 256 byte values pass both ways", wrong, [])
    link.ask(HOME_PARAMS, SET, saved)
    link.close()


def power_up(checks, link, speed):
    print("power-up, before anything was sent")
    checks.equal("current index", link.index(), 0)
    checks.equal("alarms: 16 bytes, only the reset alarm", link.ask(ALARMS), b"\x01" + bytes(15))
    checks.near("home parameters", floats(link.ask(HOME_PARAMS)), (259.10413, 0, -8.48528, 0))
    first = link.queue(WAIT, struct.pack("<I", 1))
    checks.equal("the first queue index", first, model.FIRST_INDEX)
    checks.equal("the queue is stopped until it is started", link.index(), 0)
    link.ask(START, SET)
    checks.equal("started", link.wait(first), first)
    for ident in (20, 21):
        checks.equal(f"alarms cleared with id {ident}", link.ask(ident, SET), b"")
    checks.equal("no alarm is left", link.ask(ALARMS), bytes(16))

    begin = time.monotonic()
    early = link.time()
    begun = time.monotonic()
    time.sleep(0.4)
    ending = time.monotonic()
    late = link.time()
    end = time.monotonic()
    took, slack = (late - early) / 1000, 0.005 * speed
    checks.ok(
        f"the arm's clock runs {speed:g} times as fast",
        speed * (ending - begun) - slack <= took <= speed * (end - begin) + slack,
        f"{took:.3f} s in {ending - begun:.3f} to {end - begin:.3f} s",
    )


# ------------------------------------------------------------------------------------------------------------- 1 to 3


def one_reply(checks, link):
    print("1 one reply per request")
    link.send(frame(POSE) + frame(TIME) + frame(ALARMS) + frame(83) + frame(INDEX))
    got = link.replies(5)
    checks.equal("five requests in one write: five replies in order", [g[0] for g in got], [POSE, TIME, ALARMS, 83, INDEX])
    checks.equal("their lengths", [len(g[2]) for g in got], [32, 4, 16, 8, 8])
    while not link.send_apart([bytes([byte]) for byte in frame(83)]):
        link.quiet(0.2)
    checks.equal("a request sent byte by byte", link.replies(1), [(83, 0, struct.pack("<2f", 50, 50))])
    for ctrl in (0x00, 0x10, 0x40):
        checks.equal(f"Ctrl {ctrl:#04x} is echoed", len(link.ask(POSE, ctrl)), 32)
    checks.equal("an immediate set is answered empty", link.ask(83, SET, struct.pack("<2f", 50, 50)), b"")

    pieces, times = 0, []
    for _ in range(200):
        begin = time.monotonic()
        link.send(frame(POSE))
        data = link.read(3)
        times.append(time.monotonic() - begin)
        pieces += split(data)[1] != b"" or len(data) != 38
    checks.equal("200 replies, each in one read", pieces, 0)
    typical = statistics.median(times)
    checks.ok("typically far within 50 ms", typical < 0.05, f"median {typical * 1e3:.2f} ms, worst {max(times) * 1e3:.2f} ms")
    link.queue(PTP, ptp(model.MOVJ_XYZ, 220, 40, 20, 0))
    link.queue(PTP, ptp(model.MOVJ_XYZ, 220, -40, 20, 0))
    checks.equal("nothing unsolicited while it moves", link.quiet(0.4), b"")
    rest(link)


def wrong_checksum(checks, link):
    print("2 wrong checksum")
    before = link.index()
    bad = bytearray(frame(WAIT, QUEUED, struct.pack("<I", 5)))
    bad[-1] ^= 1
    link.send(bytes(bad) + frame(INDEX))
    checks.equal("only the good frame is answered", link.replies(1), [(INDEX, 0, struct.pack("<Q", before))])
    for total, modulo_255 in ((143, 1), (144, 0)):
        good = frame(WAIT, QUEUED, struct.pack("<I", total))
        link.send(good[:-1] + bytes([modulo_255]) + frame(INDEX))
        name = f"checksum modulo 255 of a sum of {(WAIT + QUEUED + total) & 255}"
        checks.equal(name, link.replies(1), [(INDEX, 0, struct.pack("<Q", before))])
    checks.equal("no index was spent", link.queue(WAIT, struct.pack("<I", 0)), before + 1)
    link.send(b"\xaa\xaa\x01\x0a\xf6" + frame(83))
    checks.equal("a length below 2", [g[0] for g in link.replies(1)], [83])
    checks.equal("nothing more comes", link.quiet(0.1), b"")
    unknown = frame(0xEE)
    link.send(unknown + frame(ALARMS))
    checks.equal("an unknown id: silence, alarm 0x01", link.replies(1), [(ALARMS, 0, b"\x02" + bytes(15))])
    link.ask(20, SET)


def resynchronisation(checks, link):
    print("3 noise and truncated frames")
    good = frame(83)
    want = [(83, 0, struct.pack("<2f", 50, 50))]
    command = frame(PTP, QUEUED, ptp(model.MOVJ_XYZ, 200, 0, 0, 0))
    cases = [
        ("the probe M10", b"M10\r\n"),
        ("zeros", bytes(40)),
        ("a lone AA", b"\xaa"),
        ("AA AA and a length of nothing", b"\xaa\xaa\x00"),
        ("text with AA inside", b"Wrong \xaa data \xaa\xaa\r\n"),
    ]
    cases += [(f"a frame cut after {cut} bytes", command[:cut]) for cut in (2, 3, 5, 10, len(command) - 1)]
    before = link.index()
    for name, noise in cases:
        link.send(noise + good)
        checks.equal(name, link.replies(1), want)
    link.send(command[:10])
    time.sleep(0.3)
    link.send(good)
    checks.equal("a frame cut off, then a pause", link.replies(1), want)
    checks.equal("nothing late", link.quiet(0.3), b"")
    checks.equal("none of it was taken for a command", link.index(), before)


# ---------------------------------------------------------------------------------------------------------- 4, second

CLIENT = """
import fcntl, os, sys, termios, time
fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
fcntl.ioctl(fd, termios.TIOCEXCL)
os.write(fd, bytes.fromhex(sys.argv[2]))
print("open", flush=True)
time.sleep(60)
"""


def exclusive_flag_bites():
    """True if the exclusive flag affects this process. A privileged process may ignore it, and the
    check would prove nothing."""
    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCEXCL)
    try:
        os.close(os.open(os.ttyname(slave), os.O_RDWR | os.O_NOCTTY))
        return False
    except OSError as error:
        return error.errno == errno.EBUSY
    finally:
        os.close(slave)
        os.close(master)


def killed_client(path, data):
    """Runs a client that opens the port exclusively, sends, reads nothing, and is killed."""
    child = subprocess.Popen([sys.executable, "-c", CLIENT, path, data.hex()], stdout=subprocess.PIPE, text=True)
    if child.stdout.readline().strip() != "open":
        raise AssertionError("the client could not open the port")
    time.sleep(0.2)
    child.send_signal(signal.SIGKILL)
    child.wait()
    child.stdout.close()


def terminal(checks, path):
    print("4 the terminal in use")
    link = Pty(path)
    index = link.queue(PTP, ptp(model.MOVJ_XYZ, 230, 25, 15, 5))
    link.wait(index)
    pose = link.pose()
    link.close()
    same = True
    for _ in range(20):
        link = open_eventually(path)
        same = same and link.pose() == pose and link.index() == index
        link.close()
    checks.ok("closed and opened 20 times, state kept", same)

    link = Pty(path)
    for name, line in (("DTR", termios.TIOCM_DTR), ("RTS", termios.TIOCM_RTS)):
        for request in (termios.TIOCMBIS, termios.TIOCMBIC):
            try:
                fcntl.ioctl(link.fd, request, struct.pack("I", line))
            except OSError as error:
                if error.errno not in (errno.ENOTTY, errno.EINVAL):
                    raise
        checks.equal(f"{name} on and off does no harm", link.index(), index)
    link.send(frame(POSE) * 4)
    time.sleep(0.1)
    termios.tcflush(link.fd, termios.TCIOFLUSH)
    checks.equal("a flush empties the input", link.quiet(0.1), b"")
    termios.tcdrain(link.fd)
    checks.equal("and the port goes on", link.index(), index)
    link.close()

    checks.ok("this user is bound by the exclusive flag", exclusive_flag_bites())
    for round_ in range(1, 4):
        killed_client(path, frame(POSE))
        try:
            link = open_eventually(path)
            checks.equal(f"killed with the flag set, {round_}: the next one gets in", link.index(), index)
            link.close()
        except OSError as error:
            checks.ok(f"killed with the flag set, {round_}: the next one gets in", False, error)
    killed_client(path, frame(POSE) * 100)
    time.sleep(0.2)
    link = open_eventually(path)
    link.send(frame(INDEX))
    try:
        checks.equal("100 replies nobody read are gone", link.replies(1), [(INDEX, 0, struct.pack("<Q", index))])
    except AssertionError as error:
        checks.ok("100 replies nobody read are gone", False, error)
    link.close()
    killed_client(path, frame(PTP, QUEUED, ptp(model.MOVJ_XYZ, 200, 0, 0, 0))[:10])
    link = open_eventually(path)
    checks.equal("half a frame of a killed client does no harm", link.index(), index)
    link.close()

    flood = Pty(path)
    os.set_blocking(flood.fd, False)
    sent = 0
    while sent < 200_000:
        try:
            sent += os.write(flood.fd, frame(POSE) * 50)
        except BlockingIOError:
            time.sleep(0.005)
            if not flood.read(0):
                break
    flood.close()
    time.sleep(0.2)
    link = open_eventually(path)
    checks.near("a client that floods and reads little does no harm", link.pose(), pose)
    link.close()


# ------------------------------------------------------------------------------------------------------------- 5 to 9


def queued_replies(checks, link):
    print("5 queued replies and indices")
    index = link.index()
    sets = [
        ("80 PTPJointParams", 80, struct.pack("<8f", *[200] * 8), QUEUED),
        ("81 PTPCoordinateParams", 81, struct.pack("<4f", 200, 100, 200, 100), QUEUED),
        ("82 PTPJumpParams", 82, struct.pack("<2f", 20, 100), QUEUED),
        ("83 PTPCommonParams", 83, struct.pack("<2f", 50, 50), QUEUED),
        ("70 JOGJointParams", 70, struct.pack("<8f", 15, 15, 15, 30, 50, 50, 50, 50), QUEUED),
        ("72 JOGCommonParams", 72, struct.pack("<2f", 50, 50), QUEUED),
        ("90 CPParams", 90, struct.pack("<3fB", 100, 100, 100, 0), QUEUED),
        ("100 ARCParams", 100, struct.pack("<4f", 200, 200, 200, 200), QUEUED),
        ("60 EndEffectorParams", 60, struct.pack("<3f", model.SUCTION_CUP, 0, 0), QUEUED),
        ("62 suction", 62, b"\1\0", QUEUED),
        ("63 gripper", 63, b"\1\0", QUEUED),
        ("61 laser", 61, b"\0\0", QUEUED),
        ("110 WAIT", WAIT, struct.pack("<I", 10), QUEUED),
        ("130 IOMultiplexing", MULTIPLEX, b"\x12\1", QUEUED),
        ("131 IODO", OUTPUT, b"\x12\0", QUEUED),
        ("135 EMotor", 135, struct.pack("<BBi", 0, 0, 0), QUEUED),
        ("84 PTPCmd", PTP, ptp(model.MOVJ_XYZ, 210, 0, 0, 0), QUEUED),
        ("3 DeviceWithL, Ctrl 2", RAIL, b"\0\0", 2),
        ("41 HHTTrigOutputEnabled, Ctrl 2", 41, b"\0", 2),
        ("138 infrared, Ctrl 2", INFRARED, b"\0\2", 2),
    ]
    for name, ident, params, ctrl in sets:
        reply = link.ask(ident, ctrl, params)
        index += 1
        checks.equal(name, reply, struct.pack("<Q", index))
    checks.equal("all of them finish", link.wait(index), index)
    for ident in (START, STOP, START):
        checks.equal(f"{ident} acts at once and spends no index", link.ask(ident, SET), b"")
    checks.equal("the next index", link.queue(WAIT, struct.pack("<I", 0)), index + 1)


def current_index(checks, link):
    print("6 the current index")
    go(link, 200, 60, 20, 0)
    early, late, poses = 0, 0, 0
    base = link.index()
    targets = [(200 + 5 * n, 60 - 20 * n, 20, 0) for n in range(1, 5)]
    indices = [link.queue(PTP, ptp(model.MOVL_XYZ, *target)) for target in targets]
    seen = base
    while seen < indices[-1]:
        link.send(frame(INDEX) + frame(POSE))
        (_, _, index), (_, _, pose) = link.replies(2)
        seen, pose = struct.unpack("<Q", index)[0], floats(pose)
        poses += 1
        if seen == base:
            continue
        done = targets[indices.index(seen)]
        # After a finished target the arm is between that target and the next, in order along y.
        after = targets[indices.index(seen) + 1] if seen < indices[-1] else done
        late += pose[1] > done[1] + 1e-3
        early += pose[1] < after[1] - 1e-3
    checks.equal("when an index shows, the pose is at its target or on the way to the next", (late, early), (0, 0))
    checks.near("the last target", link.pose()[:4], targets[-1])
    time.sleep(0.2)
    checks.equal("the index stays while nothing follows", link.index(), indices[-1])
    checks.equal("asked with rw = 1", link.ask(INDEX, SET), struct.pack("<Q", indices[-1]))
    link.ask(STOP, SET)
    waiting = [link.queue(WAIT, struct.pack("<I", 10)) for _ in range(3)]
    checks.equal("left space: 32 less what waits, as 4 bytes", link.ask(247), struct.pack("<I", 29))
    link.ask(CLEAR, SET)
    checks.equal("left space after clear", link.ask(247), struct.pack("<I", 32))
    checks.equal("clear leaves the current index", link.index(), indices[-1])
    link.ask(START, SET)
    following = link.queue(WAIT, struct.pack("<I", 10))
    checks.equal("clear does not turn the numbering back", following, waiting[-1] + 1)
    checks.equal("and it is reached over the dropped ones", link.wait(following), following)


def moves_take_time(checks, link, udp):
    print("7 moves take time")
    go(link, 200, 0, 0, 0)
    link.ask(83, SET, struct.pack("<2f", 5, 50))
    index = link.queue(PTP, ptp(model.MOVL_XYZ, 250, 0, 0, 0))
    checks.equal("just queued: not finished", link.index(), index - 1)
    between = 0
    while link.index() < index:
        between += 200.001 < link.pose()[0] < 249.999
    checks.ok("seen on its way", between > 0, f"{between} poses")
    link.ask(83, SET, struct.pack("<2f", 50, 50))

    observer, arm = Observer(udp), model.Arm()
    arm.joints = model.inverse((250, 0, 0, 0))
    link.ask(STOP, SET)
    link.queue(WAIT, struct.pack("<I", 300))
    timed = []
    for name, mode, target in (
        ("MOVL of 50 mm", model.MOVL_XYZ, (200, 0, 0, 0)),
        ("MOVL of 60 mm", model.MOVL_INC, (0, 60, 0, 0)),
        ("MOVJ of 90 degrees", model.MOVJ_INC, (90, 0, 0, 0)),
        ("r alone", model.MOVL_INC, (0, 0, 0, -120)),
        ("a move to where it stands", model.MOVJ_INC, (0, 0, 0, 0)),
        ("JUMP", model.JUMP_XYZ, (120, 180, 30, 0)),
        ("JUMP from near the base", model.JUMP_XYZ, (0, 190, 10, 0)),
        ("JUMP to near the base", model.JUMP_MOVL_XYZ, (60, 185, 0, 0)),
    ):
        timed.append((name, link.queue(PTP, ptp(mode, *target)), arm.move(mode, *target)))
    timed.append(("WAIT of 1234 ms", link.queue(WAIT, struct.pack("<I", 1234)), 1.234))
    link.ask(START, SET)
    link.wait(timed[-1][1])
    time.sleep(0.1)
    check_durations(checks, observer, timed)
    checks.near("where they end", link.pose(), (*arm.pose, *arm.joints))
    observer.close()


def immediate_motion(checks, link):
    print("8 immediate motion")
    before = go(link, 200, 0, 0, 0) and link.index()
    checks.equal("PTP is answered empty", link.ask(PTP, SET, ptp(model.MOVL_XYZ, 230, 30, 20, 10)), b"")
    checks.near("and moves", rest(link)[:4], (230, 30, 20, 10))
    checks.equal("CP is answered empty", link.ask(CP, SET, cp(240, 20, 15, 0.0)), b"")
    checks.near("and moves", rest(link)[:3], (240, 20, 15))
    checks.equal("a short CP is answered empty", link.ask(CP, SET, cp(235, 10, 10)), b"")
    checks.near("and moves", rest(link)[:3], (235, 10, 10))
    checks.equal("home is answered empty", link.ask(HOME, SET), b"")
    time.sleep(0.3)
    end = time.monotonic() + TIMEOUT
    while math.dist(link.pose()[:3], (259.10413, 0, -8.48528)) > 1e-2 and time.monotonic() < end:
        time.sleep(0.05)
    checks.near("and homes", rest(link), (259.10413, 0, -8.48528, 0, 0, 45, 45, 0), 1e-2)
    checks.equal("no index was spent", link.index(), before)
    checks.equal("the next queued one", link.queue(WAIT, struct.pack("<I", 0)), before + 1)


def jog(checks, link):
    print("9 queued jog")
    go(link, 200, 0, 30, 0)
    link.ask(71, SET, struct.pack("<8f", 4, 4, 4, 4, 100, 100, 100, 100))
    link.ask(70, SET, struct.pack("<8f", 1, 1, 1, 1, 50, 50, 50, 50))
    index = link.queue(JOG, b"\0\2")
    checks.equal("its index is finished at once", link.wait(index), index)
    end = time.monotonic() + TIMEOUT
    while link.pose()[0] > 195 and time.monotonic() < end:
        time.sleep(0.01)
    first, second = link.pose(), (time.sleep(0.1), link.pose())[1]
    checks.ok("the motion goes on", first[0] <= 195 and second[0] < first[0], f"x {first[0]:.2f}, then {second[0]:.2f}")
    link.queue(JOG, b"\0\0")
    stopped = rest(link)
    checks.near("it stops on command 0, on its line", stopped[1:4], (0, 30, 0), 0.01)
    link.queue(JOG, b"\1\1")
    end = time.monotonic() + TIMEOUT
    while link.pose()[4] < 2 and time.monotonic() < end:
        time.sleep(0.01)
    link.ask(JOG, SET, b"\1\0")
    turned = rest(link)
    checks.ok("a joint jog turns J1, stopped by an immediate 0", turned[4] >= 2, f"J1 {turned[4]:.2f}")
    checks.near("and nothing else", turned[5:], stopped[5:])


# ---------------------------------------------------------------------------------------------------------------- 10


def motion_forms(checks, link):
    print("10 forms of motion commands")
    for name, params in (("empty", b""), ("with four bytes", bytes(4))):
        go(link, 220, 20, 20, 0)
        link.wait(link.queue(HOME, params))
        checks.near(f"home {name}", link.pose(), (259.10413, 0, -8.48528, 0, 0, 45, 45, 0))
    go(link, 200, 0, 0, 0)
    link.wait(link.queue(CP, cp(205, 5, 0)))
    checks.near("CP with 14 bytes", link.pose()[:3], (205, 5, 0))
    link.wait(link.queue(CP, cp(210, 0, 5, 0.0)))
    checks.near("CP with 17 bytes", link.pose()[:3], (210, 0, 5))
    link.wait(link.queue(CP, cp(-10, 0, -5, mode=0)))
    checks.near("CP relative with 14 bytes", link.pose()[:3], (200, 0, 0))
    link.ask(MULTIPLEX, SET, b"\x12\1")
    order = struct.pack("<BHB", 50, 18, 1), struct.pack("<BHB", 100, 18, 0)
    for name, ident, extra, count, want in (
        ("PTPPO without a count", PTPPO, b"", b"", 1),
        ("PTPPO with a count", PTPPO, b"", b"\1", 1),
        ("PTPPOWithL without a count", PTPPO_L, bytes(4), b"", 1),
        ("PTPPOWithL with a count", PTPPO_L, bytes(4), b"\1", 1),
    ):
        link.ask(OUTPUT, SET, b"\x12\0")
        x = 215 if link.pose()[0] < 210 else 205
        link.wait(link.queue(ident, ptp(model.MOVL_XYZ, x, 0, 0, 0) + extra + count + order[0]))
        checks.near(f"{name} moves", link.pose()[:3], (x, 0, 0))
        checks.equal(f"{name} switches", link.ask(OUTPUT, GET, b"\x12"), bytes([18, want]))
    link.wait(link.queue(PTPPO, ptp(model.MOVL_XYZ, 200, 0, 0, 0) + b"\2" + order[0] + order[1]))
    checks.equal("PTPPO with two entries ends with the second", link.ask(OUTPUT, GET, b"\x12"), b"\x12\0")


def surplus_and_missing(checks, link):
    print("10 surplus bytes, set-only and get-only ids")
    link.ask(83, SET, struct.pack("<2f", 61, 62) + b"\1\2\3")
    checks.equal("a set with surplus bytes", floats(link.ask(83)), (61, 62))
    link.ask(82, QUEUED, struct.pack("<2fI", 25, 110, 1))
    checks.equal("jump parameters with four more", floats(link.ask(82)), (25, 110))
    checks.equal("a get with a surplus byte", floats(link.ask(83, GET, b"\0")), (61, 62))
    link.ask(83, SET, struct.pack("<2f", 50, 50))
    link.ask(82, SET, struct.pack("<2f", 20, 100))
    before, pose = link.index(), link.pose()
    for ident, params in ((PTP, ptp(2, 250, 0, 0, 0)), (HOME, b""), (CP, cp(250, 0, 0)), (WAIT, bytes(4)), (JOG, b"\1\1")):
        checks.equal(f"set-only {ident} with rw = 0 is answered empty", link.ask(ident, GET, params), b"")
    checks.equal("and does nothing", (rest(link), link.index()), (pose, before))
    link.ask(STOP, SET)
    checks.equal("start with rw = 0 is answered empty", link.ask(START, GET), b"")
    index = link.queue(WAIT, struct.pack("<I", 0))
    time.sleep(0.1)
    checks.equal("and does not start", link.index(), before)
    link.ask(START, SET)
    checks.equal("start with rw = 1 does", link.wait(index), index)
    checks.equal("246 with rw = 1", link.ask(INDEX, SET), struct.pack("<Q", index))
    checks.equal("246 with Ctrl 3", link.ask(INDEX, QUEUED), struct.pack("<Q", index))


def io_forms(checks, link):
    print("10 IO, sensors, rail with and without the odd byte")
    link.ask(MULTIPLEX, SET, b"\x0a\1")
    link.ask(OUTPUT, SET, b"\x0a\1")
    checks.equal("IODO with the address", link.ask(OUTPUT, GET, b"\x0a"), b"\x0a\1")
    checks.equal("IODO without: the last pin", link.ask(OUTPUT), b"\x0a\1")
    checks.equal("IOMultiplexing with the address", link.ask(MULTIPLEX, GET, b"\x0a"), b"\x0a\1")
    checks.equal("IOMultiplexing without", len(link.ask(MULTIPLEX)), 2)
    link.ask(MULTIPLEX, SET, b"\x04\2")
    link.ask(PWM, SET, struct.pack("<Bff", 4, 1000, 25))
    checks.equal("IOPWM with the address", link.ask(PWM, GET, b"\4"), struct.pack("<Bff", 4, 1000, 25))
    checks.equal("IOPWM without", link.ask(PWM), struct.pack("<Bff", 4, 1000, 25))
    link.ask(MULTIPLEX, SET, b"\x05\3")
    checks.equal("IODI with the address", link.ask(INPUT, GET, b"\5"), b"\5\0")
    checks.equal("IODI without", len(link.ask(INPUT)), 2)
    link.ask(MULTIPLEX, SET, b"\x07\4")
    checks.equal("IOADC with the address", link.ask(ADC, GET, b"\7")[:1], b"\7")
    checks.equal("IOADC without", len(link.ask(ADC)), 3)
    for name, params in (("one byte", b"\1"), ("two bytes", b"\1\1"), ("one byte", b"\0")):
        checks.equal(f"rail set with {name}", link.ask(RAIL, SET, params), b"")
        checks.equal("and read back", link.ask(RAIL), params[:1])
    for name, ident in (("colour", COLOUR), ("infrared", INFRARED)):
        for params in (b"\1\1", b"\1\1\1"):
            checks.equal(f"{name} sensor set with {len(params)} bytes", link.ask(ident, SET, params), b"")
            checks.equal("queued", len(link.ask(ident, QUEUED, params)), 8)
    for params in (b"", b"\1", b"\1\1\1"):
        checks.equal(f"colour read with {len(params)} bytes", len(link.ask(COLOUR, GET, params)), 3)
    for params in (b"", b"\1"):
        checks.equal(f"infrared read with {len(params)} bytes", len(link.ask(INFRARED, GET, params)), 1)
    checks.equal("EMotor with an integer speed", link.ask(135, SET, struct.pack("<BBi", 0, 1, 1000)), b"")
    checks.equal("EMotor stopped", link.ask(135, SET, struct.pack("<BBi", 0, 0, 0)), b"")


def strings(checks, link):
    print("10 strings")
    for name, params in (("without NUL", b"arm one"), ("with NUL", b"arm two\0"), ("with bytes after NUL", b"arm\0x")):
        checks.equal(f"name set {name}", link.ask(NAME, SET, params), b"")
        checks.equal("read back with one NUL", link.ask(NAME), params.split(b"\0")[0] + b"\0")
    checks.equal("version: three bytes", len(link.ask(2)), 3)
    checks.equal("the device's id: three words, and not the clock", len(link.ask(5)), 12)


# ---------------------------------------------------------------------------------------------------------------- 11


def several_links(checks, link, udp, tcp):
    print("11 several links, one arm")
    first, second, stream = Udp(udp), Udp(udp), Tcp(tcp)
    pose = link.pose()
    for name, other in (("UDP", first), ("a second UDP port", second), ("TCP", stream)):
        checks.equal(f"{name} sees the pose of the terminal", other.pose(), pose)
    first.send(frame(83))
    second.send(frame(82))
    checks.equal("answers go to who asked, first", [g[0] for g in first.replies(1)], [83])
    checks.equal("answers go to who asked, second", [g[0] for g in second.replies(1)], [82])
    first.close()
    third = Udp(udp)
    checks.equal("a host that comes back from a new port", third.pose(), pose)
    third.send(frame(POSE) + frame(TIME))
    checks.equal("two frames in a datagram", [g[0] for g in third.replies(2)], [POSE, TIME])
    whole = frame(83)
    while not third.send_apart([whole[:4], whole[4:]]):
        third.quiet(0.2)
    checks.equal("a frame in two datagrams", [g[0] for g in third.replies(1)], [83])
    third.send(b"\xaa\xaa\x13\x54")
    checks.equal("half a frame from one does not disturb another", len(second.ask(POSE)), 32)
    index = third_index = link.index()
    for other in (second, link, stream, second):
        index += 1
        third_index = other.queue(WAIT, struct.pack("<I", 0))
        if third_index != index:
            break
    checks.equal("indices are counted over all links", third_index, index)
    checks.equal("a name set over UDP", second.ask(NAME, SET, b"shared"), b"")
    checks.equal("is read on the terminal", link.ask(NAME), b"shared\0")
    checks.equal("and over TCP", stream.ask(NAME), b"shared\0")
    checks.equal("nothing goes to who did not ask", (link.quiet(0.1), second.quiet(0.05), stream.quiet(0.05)), (b"", b"", b""))
    for other in (second, third, stream):
        other.close()
    checks.equal("the terminal goes on when they are gone", link.pose(), pose)


def main():
    path, udp, tcp, speed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4])
    checks = Checks()
    checks.section(untouched_terminal, path)

    def each(part, *more):
        link = open_eventually(path)
        link.quiet(0.02)
        try:
            checks.section(part, link, *more)
        finally:
            link.close()

    each(power_up, speed)
    for part in (one_reply, wrong_checksum, resynchronisation):
        each(part)
    checks.section(terminal, path)
    for part in (queued_replies, current_index):
        each(part)
    each(moves_take_time, udp)
    for part in (immediate_motion, jog, motion_forms, surplus_and_missing, io_forms, strings):
        each(part)
    each(several_links, udp, tcp)
    each(lambda checks, link: checks.equal("no alarm at the end", link.ask(ALARMS), bytes(16)))
    checks.finish()


if __name__ == "__main__":
    main()
