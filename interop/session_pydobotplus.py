"""pydobotplus 0.1.2, unmodified, driving the virtual arm: session_pydobotplus.py PTY UDP_PORT

The library has no read timeout: a missing reply blocks it for ever. It polls the index without a
pause, waits by equality in move_to and by >= elsewhere, and reads the first four bytes of a queue
index. Poses and times are compared with the independent model in arm.py.
"""

import struct
import sys
import time

from pydobotplus import CustomPosition, Dobot
from pydobotplus.dobotplus import MODE_PTP
from pydobotplus.message import Message

import arm as model
from checks import TIMEOUT, Checks
from wire import Observer, check_durations

MULTIPLEX, IO_OUTPUT, LASER, SUCTION, GRIPPER = 130, 131, 61, 62, 63


def request(dobot, ident, ctrl=0, params=b""):
    """Sends a frame for which the library has no function, and returns the parameters of the
    reply."""
    msg = Message()
    msg.id, msg.ctrl, msg.params = ident, ctrl, bytearray(params)
    return bytes(dobot._send_command(msg).params)


def read_floats(dobot, ident):
    """Reads a parameter set back."""
    params = request(dobot, ident)
    return list(struct.unpack(f"<{len(params) // 4}f", params))


def joined(pose):
    """Flattens the library's nested pose."""
    return (*pose.position, *pose.joints)


class Picture:
    """The part of an array's interface that engrave() uses. The library lets its caller choose the
    array."""

    def __init__(self, rows):
        self.rows = rows

    def _each(self, work):
        return Picture([[work(v) for v in row] for row in self.rows])

    def astype(self, _):
        return self._each(float)

    def __rsub__(self, other):
        return self._each(lambda v: other - v)

    def __sub__(self, other):
        return self._each(lambda v: v - other)

    def __truediv__(self, other):
        return self._each(lambda v: v / other)

    def __mul__(self, other):
        return self._each(lambda v: v * other)

    def __add__(self, other):
        return self._each(lambda v: v + other)

    def min(self):
        return min(map(min, self.rows))

    def max(self):
        return max(map(max, self.rows))

    def __iter__(self):
        return iter(self.rows)


def connect(checks, dobot):
    print("connect")
    checks.near("pose at power-up", joined(dobot.get_pose()), (259.10413, 0, -8.48528, 0, 0, 45, 45, 0))
    checks.equal("the constructor's four queued sets finish", dobot._get_queued_cmd_current_index(), model.FIRST_INDEX + 3)
    checks.equal("it cleared the reset alarm", dobot.get_alarms(), set())
    checks.equal("joint speeds read back", read_floats(dobot, 80), [200.0] * 8)
    checks.equal("coordinate speeds read back", read_floats(dobot, 81), [200.0] * 4)
    checks.equal("jump height and limit read back", read_floats(dobot, 82), [10.0, 200.0])
    checks.equal("ratios read back", read_floats(dobot, 83), [100.0, 100.0])


def home(checks, dobot, observer):
    print("home()")
    dobot._set_queued_cmd_stop_exec()
    request(dobot, 110, 3, bytes(4))
    index = dobot.home()
    checks.equal("its index", index, model.FIRST_INDEX + 5)
    dobot._set_queued_cmd_start_exec()
    dobot.wait_for_cmd(index)
    checks.near("pose after homing", joined(dobot.get_pose()), (259.10413, 0, -8.48528, 0, 0, 45, 45, 0))
    time.sleep(0.1)
    least, most = observer.duration(index)
    checks.ok("homing took its time", most >= 10.0 and least <= 25.0, f"between {least:.2f} and {most:.2f} s")


MOVES = [
    (MODE_PTP.MOVJ_XYZ, (210.0, 90.0, 30.0, 25.0)),
    (MODE_PTP.MOVL_XYZ, (255.0, -30.0, 5.0, -35.0)),
    (MODE_PTP.JUMP_XYZ, (190.0, -100.0, -20.0, 40.0)),
    (MODE_PTP.JUMP_ANGLE, (15.0, 50.0, 35.0, -25.0)),
    (MODE_PTP.MOVJ_ANGLE, (-45.0, 10.0, 20.0, 60.0)),
    (MODE_PTP.MOVL_ANGLE, (5.0, 30.0, 45.0, -15.0)),
    (MODE_PTP.MOVJ_INC, (-22.5, 10.0, -5.0, 33.0)),
    (MODE_PTP.MOVL_INC, (10.0, 60.0, -20.0, 14.0)),
    (MODE_PTP.MOVJ_XYZ_INC, (-5.0, 35.0, 25.0, -50.0)),
    (MODE_PTP.JUMP_MOVL_XYZ, (225.0, -15.0, 0.0, 12.0)),
]


def moves(checks, dobot, arm):
    print("every PTP mode through move_to(), waited for by equality")
    first = dobot._get_queued_cmd_current_index() + 1
    for number, (mode, target) in enumerate(MOVES):
        arm.move(int(mode), *target)
        checks.equal(f"{mode.name} index", dobot.move_to(*target, wait=True, mode=mode), first + number)
        checks.near(f"{mode.name} ends at", joined(dobot.get_pose()), (*arm.pose, *arm.joints))
    dobot.move_rel(x=-10, y=20, z=15, r=0)
    arm.move(model.MOVJ_XYZ_INC, -10, 20, 15, 0)
    checks.near("move_rel ends at", joined(dobot.get_pose()), (*arm.pose, *arm.joints), 2e-3)
    dobot.move_to(position=CustomPosition(220.0, 10.0, 20.0, 0.0))
    arm.move(model.MOVJ_XYZ, 220.0, 10.0, 20.0, 0.0)
    checks.near("a position object ends at", joined(dobot.get_pose()), (*arm.pose, *arm.joints))


def timed_batch(checks, dobot, arm, observer):
    print("times: a stopped queue filled, then started")
    dobot._set_queued_cmd_stop_exec()
    before = dobot._get_queued_cmd_current_index()
    timed = []
    request(dobot, 110, 3, struct.pack("<I", 200))
    for mode, target in MOVES:
        index = dobot.move_to(*target, wait=False, mode=mode)
        timed.append((mode.name, index, arm.move(int(mode), *target)))
    via, end = (200.0, 60.0, 20.0, 0.0), (170.0, 110.0, 10.0, 30.0)
    index = dobot.go_arc(*end, *via)
    start = arm.pose
    arm.joints = model.inverse(end)
    length = model.arc_length(start[:3], via[:3], end[:3])
    seconds = max(model.trapezoid(length, 200, 200), model.trapezoid(end[3] - start[3], 200, 200))
    checks.equal("a stopped queue runs nothing", dobot._get_queued_cmd_current_index(), before)
    checks.equal("indices over the batch", index, before + len(MOVES) + 2)
    dobot._set_queued_cmd_start_exec()
    dobot.wait_for_cmd(index)
    time.sleep(0.1)
    check_durations(checks, observer, timed)
    check_durations(checks, observer, [(f"go_arc over {length:.1f} mm", index, seconds)])
    checks.near("pose after the arc", joined(dobot.get_pose()), (*arm.pose, *arm.joints))


def tools(checks, dobot):
    print("tools, EIO, sensors, steppers")
    index = dobot._get_queued_cmd_current_index()
    steps = [
        ("suck(True)", lambda: dobot.suck(True), SUCTION, b"\x01\x01"),
        ("suck(False)", lambda: dobot.suck(False), SUCTION, b"\x01\x00"),
        ("grip(True)", lambda: dobot.grip(True), GRIPPER, b"\x01\x01"),
        ("grip(False)", lambda: dobot.grip(False), GRIPPER, b"\x01\x00"),
        ("laze(0, True)", lambda: dobot.laze(0, True), LASER, b"\x01\x00"),
        ("laze(0, False)", lambda: dobot.laze(0, False), LASER, b"\x00\x00"),
    ]
    for name, act, ident, want in steps:
        index += 1
        checks.equal(f"{name} index", act(), index)
        dobot.wait_for_cmd(index)
        checks.equal(f"{name} read back", request(dobot, ident), want)
    request(dobot, MULTIPLEX, 1, b"\x11\x01")
    for level in (True, False):
        dobot.set_io(17, level)
        index += 1
        checks.equal(f"set_io(17, {level}) read back", request(dobot, IO_OUTPUT, 0, b"\x11"), bytes([17, level]))
    checks.equal("set_color() with its third byte", dobot.set_color(True, dobot.PORT_GP2, 1), index + 1)
    checks.equal("set_ir() with Ctrl 2", dobot.set_ir(True, dobot.PORT_GP4), index + 2)
    checks.equal("get_color() with its three bytes", len(dobot.get_color(dobot.PORT_GP2, 1)), 3)
    checks.ok("get_ir() answers one byte", dobot.get_ir(dobot.PORT_GP4) in (True, False))
    dobot.set_hht_trig_output(True)
    dobot.wait_for_cmd(index + 3)
    checks.equal("set_hht_trig_output() with Ctrl 2 is queued", dobot._get_queued_cmd_current_index(), index + 3)
    checks.equal("get_hht_trig_output()", dobot.get_hht_trig_output(), True)
    dobot.conveyor_belt(0.5)
    dobot.conveyor_belt(0.0)
    checks.equal("conveyor_belt_distance()", dobot.conveyor_belt_distance(50, 10), index + 6)
    # This command finishes when the belt has travelled its distance.
    dobot.wait_for_cmd(index + 6)


def speeds(checks, dobot):
    print("speed()")
    before = dobot._get_queued_cmd_current_index()
    dobot.speed(60, 70)
    checks.equal("ratios", read_floats(dobot, 83), [60.0, 70.0])
    checks.equal("coordinate speeds", read_floats(dobot, 81), [60.0, 60.0, 70.0, 70.0])
    checks.equal("two queued commands", dobot._get_queued_cmd_current_index(), before + 2)
    dobot.speed(100, 100)


def jog(checks, dobot):
    print("jog: the index completes at once, the motion goes on until it is stopped")
    dobot.move_to(200.0, 0.0, 20.0, 0.0)
    for axis, start in ((0, dobot.jog_x), (2, dobot.jog_z)):
        name = "xyzr"[axis]
        begin = dobot.get_pose().position
        start(-2.0)
        index = dobot._get_queued_cmd_current_index()
        deadline = time.monotonic() + TIMEOUT
        while begin[axis] - dobot.get_pose().position[axis] < 5 and time.monotonic() < deadline:
            time.sleep(0.01)
        checks.equal(f"jog_{name}: the index stands while it moves", dobot._get_queued_cmd_current_index(), index)
        start(0)
        last, pose = None, dobot.get_pose().position
        while last != pose and time.monotonic() < deadline:
            time.sleep(0.05)
            last, pose = pose, dobot.get_pose().position
        checks.ok(f"jog_{name}(-2) moved and stopped", begin[axis] - pose[axis] >= 5 and last == pose, pose)
        others = [n for n in range(4) if n != axis]
        checks.near(f"jog_{name} keeps the others", [pose[n] for n in others], [begin[n] for n in others], 0.01)
    checks.equal("no alarm", dobot.get_alarms(), set())


def engrave(checks, dobot, observer):
    print("engrave(): 64 pixels through a queue of 32, filled to the last place before it starts")
    dobot.move_to(200.0, 0.0, 10.0, 0.0)
    x, y, z = dobot.get_pose().position[:3]
    before = dobot._get_queued_cmd_current_index()
    rows = [[(37 * row + 11 * col) % 256 for col in range(16)] for row in range(4)]
    dobot.engrave(Picture(rows), 0.5)
    dobot.wait_for_cmd(before + 67)
    time.sleep(0.1)
    checks.equal("laser off, parameters, 64 segments, laser off", dobot._get_queued_cmd_current_index(), before + 67)
    checks.near("ends at the last pixel", dobot.get_pose().position[:3], (x + 1.5, y, z), 2e-3)
    checks.equal("CP parameters read back", request(dobot, 90), struct.pack("<fffB", 5, 5, 5, 0))
    checks.equal("laser is off", request(dobot, LASER), b"\x00\x00")
    least, most = observer.reached(before + 2)[1], observer.reached(before + 66)[0]
    path = 63 * 0.5
    checks.ok(f"{path} mm at 5 mm/s or less", (most - least) / 1000 >= path / 5 - 0.005, f"{(most - least) / 1000:.2f} s")


def reopen(checks, port, dobot):
    print("close and open again")
    pose, index = joined(dobot.get_pose()), dobot._get_queued_cmd_current_index()
    dobot.close()
    again = Dobot(port)
    checks.equal("pose is kept", joined(again.get_pose()), pose)
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
    tools(checks, dobot)
    speeds(checks, dobot)
    jog(checks, dobot)
    engrave(checks, dobot, observer)
    reopen(checks, port, dobot)
    observer.close()
    checks.equal("nothing disturbed the observer on UDP", observer.error, None)
    checks.finish()


if __name__ == "__main__":
    main()
