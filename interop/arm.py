"""Independent model of the arm in plain Python: kinematics and move times.

Nothing here is taken from the Rust code. The numbers come from the published geometry of the arm
and from the speed law of its controller, so that a mistake would have to be made twice to remain
unnoticed. Lengths are in mm, angles in degrees, times in seconds.
"""

import math
import struct

REAR_ARM = 135.0
FOREARM = 147.0

JUMP_XYZ, MOVJ_XYZ, MOVL_XYZ, JUMP_ANGLE, MOVJ_ANGLE, MOVL_ANGLE = range(6)
MOVJ_INC, MOVL_INC, MOVJ_XYZ_INC, JUMP_MOVL_XYZ = range(6, 10)

POWER_UP_JOINTS = (0.0, 45.0, 45.0, 0.0)
# Index of the first queued command after power-up (model section 14).
FIRST_INDEX = 2
# Distance from the flange to the suction cup: 59.7, rounded to binary32 as on the wire.
SUCTION_CUP = struct.unpack("<f", struct.pack("<f", 59.7))[0]
# Control period of the controller, s (model section 7).
PERIOD = 0.02


def forward(joints, bias_x=SUCTION_CUP):
    """Returns x, y, z and r for four joint angles."""
    j1, j2, j3, j4 = joints
    a1, a2, a3 = math.radians(j1), math.radians(j2), math.radians(j3)
    reach = REAR_ARM * math.sin(a2) + FOREARM * math.cos(a3) + bias_x
    height = REAR_ARM * math.cos(a2) - FOREARM * math.sin(a3)
    return reach * math.cos(a1), reach * math.sin(a1), height, j1 + j4


def inverse(pose, bias_x=SUCTION_CUP):
    """Returns the four joint angles for x, y, z and r, with the elbow up."""
    x, y, z, r = pose
    out = math.hypot(x, y) - bias_x
    dist = math.hypot(out, z)
    cosine = (REAR_ARM**2 + dist**2 - FOREARM**2) / (2 * REAR_ARM * dist)
    if abs(cosine) > 1:
        raise ValueError(f"{pose} is out of reach")
    elevation = math.atan2(z, out) + math.acos(cosine)
    j1 = math.degrees(math.atan2(y, x))
    j3 = math.degrees(math.atan2(REAR_ARM * math.sin(elevation) - z, out - REAR_ARM * math.cos(elevation)))
    return j1, 90 - math.degrees(elevation), j3, r - j1


def within_limits(joints):
    """True if the controller permits these joint angles."""
    j1, j2, j3, j4 = joints
    return abs(j1) <= 135 and -5 <= j2 <= 90 and -15 <= j3 <= 90 and abs(j4) <= 150 and -70 <= j2 - j3 <= 55


def trapezoid(distance, velocity, acceleration):
    """Returns the duration of a move between two rests, in whole control periods."""
    distance = abs(distance)
    if distance > velocity**2 / acceleration:
        seconds = distance / velocity + velocity / acceleration
    else:
        seconds = 2 * math.sqrt(distance / acceleration)
    return math.ceil(seconds / PERIOD - 1e-7) * PERIOD


def arc_length(a, via, b):
    """Returns the length of the circular arc from a through via to b (points in space)."""
    u, v, w = ([q - p for p, q in zip(*ends)] for ends in ((a, via), (via, b), (a, b)))
    side_u, side_v, side_w = math.hypot(*u), math.hypot(*v), math.hypot(*w)
    cross = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    radius = side_u * side_v * side_w / (2 * math.hypot(*cross))

    def angle_at(left, right, opposite):
        return math.acos((left**2 + right**2 - opposite**2) / (2 * left * right))

    # An inscribed angle is half of its central angle. The two arcs add up to the whole path.
    at_a, at_b = angle_at(side_u, side_w, side_v), angle_at(side_v, side_w, side_u)
    return 2 * radius * (at_a + at_b)


class Arm:
    """State of the arm, and the durations of its point-to-point moves."""

    def __init__(self):
        self.joints = POWER_UP_JOINTS
        self.joint_speed = [(200.0, 200.0)] * 4
        self.xyz_speed = (200.0, 200.0)
        self.r_speed = (100.0, 100.0)
        self.ratio = (0.5, 0.5)
        self.jump_height, self.jump_limit = 20.0, 100.0

    @property
    def pose(self):
        return forward(self.joints)

    def _time(self, distance, speed):
        return trapezoid(distance, speed[0] * self.ratio[0], speed[1] * self.ratio[1])

    def _movj(self, start, end):
        return max(self._time(b - a, s) for a, b, s in zip(start, end, self.joint_speed))

    def _movl(self, start, end):
        return max(
            self._time(math.dist(start[:3], end[:3]), self.xyz_speed),
            self._time(end[3] - start[3], self.r_speed),
        )

    def _vertical(self, start, end):
        straight = math.hypot(start[0], start[1]) > FOREARM + SUCTION_CUP
        return self._movl(start, end) if straight else self._movj(inverse(start), inverse(end))

    def _jump(self, start, end, straight):
        top = min(max(start[2], end[2]) + self.jump_height, self.jump_limit)
        lifted, above = (*start[:2], top, start[3]), (*end[:2], top, end[3])
        across = self._movl(lifted, above) if straight else self._movj(inverse(lifted), inverse(above))
        return self._vertical(start, lifted) + across + self._vertical(above, end)

    def move(self, mode, *args):
        """Moves to a target and returns the duration in seconds."""
        start, start_pose = self.joints, self.pose
        if mode in (JUMP_ANGLE, MOVJ_ANGLE, MOVL_ANGLE):
            end = tuple(args)
        elif mode == MOVJ_INC:
            end = tuple(a + b for a, b in zip(start, args))
        elif mode in (MOVL_INC, MOVJ_XYZ_INC):
            end = inverse([a + b for a, b in zip(start_pose, args)])
        else:
            end = inverse(args)
        if not within_limits(end):
            raise ValueError(f"a test wants a target beyond the limits: mode {mode}, {args}, joints {end}")
        self.joints = end
        if mode in (MOVL_XYZ, MOVL_ANGLE, MOVL_INC):
            return self._movl(start_pose, self.pose)
        if mode in (JUMP_XYZ, JUMP_ANGLE, JUMP_MOVL_XYZ):
            return self._jump(start_pose, self.pose, mode == JUMP_MOVL_XYZ)
        return self._movj(start, end)
