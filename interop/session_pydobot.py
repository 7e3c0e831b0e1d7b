"""pydobot 1.3.2, unmodified, driving the virtual arm: session_pydobot.py PTY UDP_PORT

The library sleeps 100 ms around every frame, reads once, never resynchronises, and waits until the
current index equals that of its command. Poses and times are compared with the independent model in
arm.py.
"""

import struct
import sys
import time

import whole_frames  # noqa: F401  patches pyserial before the library opens a port
from pydobot import Dobot
from pydobot.enums import PTPMode
from pydobot.message import Message

import arm as model
from checks import TIMEOUT, Checks
from wire import Observer, check_durations

HOME, WAIT, GRIPPER, SUCTION, MULTIPLEX = 31, 110, 63, 62, 130


def message(ident, ctrl=0, params=b""):
    """Returns a frame for which the library has no function."""
    msg = Message()
    msg.id, msg.ctrl, msg.params = ident, ctrl, bytearray(params)
    return msg


def index_of(reply):
    """Returns the queue index in the reply to a queued command. The reply must contain exactly
    that."""
    if len(reply.params) != 8:
        raise AssertionError(f"queued reply with {len(reply.params)} parameter bytes")
    return struct.unpack("<Q", bytes(reply.params))[0]


def read_floats(dobot, ident):
    """Reads a parameter set back."""
    params = bytes(dobot._send_command(message(ident)).params)
    return list(struct.unpack(f"<{len(params) // 4}f", params))


def until(dobot, index):
    """Polls the index as the library does, after commands for which the library has no wait."""
    end = time.monotonic() + 2 * TIMEOUT
    while (now := dobot._get_queued_cmd_current_index()) != index:
        if time.monotonic() > end:
            raise AssertionError(f"waited for index {index}, stands at {now}")


def connect(checks, dobot):
    print("connect")
    standing = model.forward(model.POWER_UP_JOINTS) + model.POWER_UP_JOINTS
    checks.near("pose at power-up", (*standing,), (259.104, 0, -8.485, 0, 0, 45, 45, 0))
    checks.near("pose() after the constructor", dobot.pose(), standing)
    checks.near("the attributes it keeps", (dobot.x, dobot.y, dobot.z, dobot.r), standing[:4])
    checks.equal("the constructor's four queued sets finish", dobot._get_queued_cmd_current_index(), model.FIRST_INDEX + 3)
    checks.equal("joint speeds read back", read_floats(dobot, 80), [200.0] * 8)
    checks.equal("coordinate speeds read back", read_floats(dobot, 81), [200.0] * 4)
    checks.equal("jump height and limit read back", read_floats(dobot, 82), [10.0, 200.0])
    checks.equal("ratios read back", read_floats(dobot, 83), [100.0, 100.0])


def home(checks, dobot, observer):
    print("home, as a hand-built frame without parameters")
    dobot._set_queued_cmd_stop_exec()
    dobot.wait(0)
    index = index_of(dobot._send_command(message(HOME, 3)))
    checks.equal("its index", index, model.FIRST_INDEX + 5)
    dobot._set_queued_cmd_start_exec()
    until(dobot, index)
    least, most = observer.duration(index)
    checks.ok("homing took its time", most >= 10.0 and least <= 25.0, f"between {least:.2f} and {most:.2f} s")
    checks.near("pose after homing", dobot.pose(), (*model.forward(model.POWER_UP_JOINTS), *model.POWER_UP_JOINTS))


MOVES = [
    (PTPMode.MOVJ_XYZ, (220.0, 60.0, 40.0, 15.0)),
    (PTPMode.MOVL_XYZ, (240.0, -50.0, 10.0, -20.0)),
    (PTPMode.JUMP_XYZ, (200.0, 80.0, 20.0, 0.0)),
    (PTPMode.JUMP_ANGLE, (-20.0, 40.0, 30.0, 10.0)),
    (PTPMode.MOVJ_ANGLE, (30.0, 20.0, 25.0, -40.0)),
    (PTPMode.MOVL_ANGLE, (10.0, 35.0, 40.0, 5.0)),
    (PTPMode.MOVJ_INC, (12.5, -5.0, 7.5, 20.0)),
    (PTPMode.MOVL_INC, (-15.0, 25.0, 30.0, -10.0)),
    (PTPMode.MOVJ_XYZ_INC, (20.0, -40.0, -12.0, 8.0)),
    (PTPMode.JUMP_MOVL_XYZ, (230.0, 0.0, 15.0, 0.0)),
]


def moves(checks, dobot, arm):
    print("every PTP mode, waited for by equality")
    first = dobot._get_queued_cmd_current_index() + 1
    for number, (mode, target) in enumerate(MOVES):
        arm.move(mode.value, *target)
        index = index_of(dobot._set_ptp_cmd(*target, mode=mode, wait=True))
        checks.equal(f"{mode.name} index", index, first + number)
        checks.near(f"{mode.name} ends at", dobot.pose(), (*arm.pose, *arm.joints))


def timed_batch(checks, dobot, arm, observer):
    print("times: a stopped queue filled, then started")
    dobot._set_queued_cmd_stop_exec()
    before = dobot._get_queued_cmd_current_index()
    index = index_of(dobot._set_wait_cmd(200))
    checks.equal("index goes on by one", index, before + 1)
    timed = []
    for mode, target in MOVES:
        index = index_of(dobot._set_ptp_cmd(*target, mode=mode, wait=False))
        timed.append((mode.name, index, arm.move(mode.value, *target)))
    index = index_of(dobot._set_wait_cmd(1500))
    timed.append(("wait(1500)", index, 1.5))
    checks.equal("a stopped queue runs nothing", dobot._get_queued_cmd_current_index(), before)
    checks.equal("indices over the batch", index, before + len(MOVES) + 2)
    dobot._set_queued_cmd_start_exec()
    until(dobot, index)
    check_durations(checks, observer, timed)
    checks.near("pose after the batch", dobot.pose(), (*arm.pose, *arm.joints))


def slower(checks, dobot, arm, observer):
    print("speed(), move_to(), wait() and go()")
    before = dobot._get_queued_cmd_current_index()
    dobot.speed(50, 40)
    until(dobot, before + 2)
    checks.equal("ratios after speed(50, 40)", read_floats(dobot, 83), [50.0, 40.0])
    checks.equal("coordinate speeds after speed(50, 40)", read_floats(dobot, 81), [50.0, 50.0, 40.0, 40.0])
    checks.equal("speed() is two queued commands", dobot._get_queued_cmd_current_index(), before + 2)
    arm.ratio, arm.xyz_speed, arm.r_speed = (0.5, 0.4), (50.0, 40.0), (50.0, 40.0)

    dobot._set_queued_cmd_stop_exec()
    dobot.wait(100)
    dobot.move_to(250.0, 40.0, 30.0, 0.0)
    seconds = arm.move(model.MOVL_XYZ, 250.0, 40.0, 30.0, 0.0)
    dobot.wait(2000)
    dobot._set_queued_cmd_start_exec()
    until(dobot, before + 5)
    check_durations(checks, observer, [("move_to", before + 4, seconds), ("wait(2000)", before + 5, 2.0)])
    checks.near("move_to() ends at", dobot.pose(), (*arm.pose, *arm.joints))

    dobot.speed(100, 100)
    dobot.go(230.0, 0.0, 20.0, 10.0)
    arm.ratio, arm.xyz_speed, arm.r_speed = (1.0, 1.0), (100.0, 100.0), (100.0, 100.0)
    arm.move(model.MOVL_XYZ, 230.0, 0.0, 20.0, 10.0)
    until(dobot, before + 8)
    checks.near("go() ends at", dobot.pose(), (*arm.pose, *arm.joints))


def tools(checks, dobot):
    print("suction, gripper, EIO")
    before = dobot._get_queued_cmd_current_index()
    steps = [
        ("suck(True)", lambda: dobot.suck(True), SUCTION, b"\x01\x01"),
        ("suck(False)", lambda: dobot.suck(False), SUCTION, b"\x01\x00"),
        ("grip(True)", lambda: dobot.grip(True), GRIPPER, b"\x01\x01"),
        ("grip(False)", lambda: dobot.grip(False), GRIPPER, b"\x01\x00"),
    ]
    for number, (name, act, ident, want) in enumerate(steps):
        act()
        until(dobot, before + number + 1)
        checks.equal(f"{name} read back", bytes(dobot._send_command(message(ident)).params), want)
    dobot._send_command(message(MULTIPLEX, 1, b"\x10\x01"))
    for level in (1, 0):
        checks.equal(f"set_eio(16, {level}) is answered empty", bytes(dobot.set_eio(16, level).params), b"")
        checks.equal(f"get_eio(16) after {level}", bytes(dobot.get_eio(16).params), bytes([16, level]))


def wrong_checksums(checks, dobot):
    before = dobot._get_queued_cmd_current_index()
    if Message.__module__.startswith("magician."):
        print("what stands in for it has the right checksum")
        for milliseconds in (143, 144):
            msg = message(WAIT, 3, struct.pack("<I", milliseconds))
            checks.equal(f"wait({milliseconds}) sums up to 0", sum(msg.bytes()[3:]) & 0xFF, 0)
            before += 1
            checks.equal(f"wait({milliseconds}) index", index_of(dobot._set_wait_cmd(milliseconds)), before)
        until(dobot, before)
        return
    print("its checksum is modulo 255: frames whose sum is 0 or 1 go out wrong")
    for milliseconds, wrong in ((143, 1), (144, 0)):
        msg = message(WAIT, 3, struct.pack("<I", milliseconds))
        checks.equal(f"wait({milliseconds}) goes out with checksum", msg.bytes()[-1], wrong)
        checks.equal(f"wait({milliseconds}) gets no answer", dobot._set_wait_cmd(milliseconds), None)
        checks.equal("the next request gets its own", dobot._get_queued_cmd_current_index(), before)
    checks.equal("no index was spent", index_of(dobot._set_wait_cmd(0)), before + 1)


def cp(checks, dobot, arm):
    print("CP with 14 bytes")
    before = dobot._get_queued_cmd_current_index()
    x, y, z, _ = arm.pose
    for number in range(1, 4):
        index = index_of(dobot._set_cp_cmd(x + 4 * number, y + 3 * number, z))
        checks.equal(f"segment {number} index", index, before + number)
    until(dobot, before + 3)
    checks.near("the line ends at", dobot.pose()[:3], (x + 12, y + 9, z))


def reopen(checks, port, dobot):
    print("close and open again")
    pose, index = dobot.pose(), dobot._get_queued_cmd_current_index()
    dobot.close()
    again = Dobot(port)
    checks.equal("pose is kept", again.pose(), pose)
    checks.equal("indices go on", again._get_queued_cmd_current_index(), index + 4)
    again.close()


def main():
    port, udp = sys.argv[1], int(sys.argv[2])
    checks = Checks()
    observer = Observer(udp)
    dobot = Dobot(port)
    arm = model.Arm()
    arm.ratio, arm.r_speed = (1.0, 1.0), (200.0, 200.0)
    arm.jump_height, arm.jump_limit = 10.0, 200.0

    connect(checks, dobot)
    home(checks, dobot, observer)
    moves(checks, dobot, arm)
    timed_batch(checks, dobot, arm, observer)
    slower(checks, dobot, arm, observer)
    tools(checks, dobot)
    wrong_checksums(checks, dobot)
    cp(checks, dobot, arm)
    reopen(checks, port, dobot)
    observer.close()
    checks.equal("nothing disturbed the observer on UDP", observer.error, None)
    checks.finish()


if __name__ == "__main__":
    main()
