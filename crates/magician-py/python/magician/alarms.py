# Made by `cargo xtask python` from the protocol's table, which the driver and the virtual arm are made of too.
"""The alarms of the controller, each with its cause and its remedy."""

from __future__ import annotations

from ._protocol import OpenEnum

__all__ = ["Alarm"]


class Alarm(OpenEnum):
    """An alarm. It is its code, 0x00 to 0xFF; one without a name passes through.

    ``print(alarm)`` shows the cause and the remedy.
    """

    RESET_OCCURRED = 0x00
    """The controller was reset or switched on."""
    UNDEFINED_INSTRUCTION = 0x01
    """A command that the controller does not know."""
    FILE_SYSTEM_ERROR = 0x02
    """The controller's flash memory did not open."""
    MCU_FPGA_COMM_ERROR = 0x03
    """Processor and motor logic did not find each other at start-up."""
    ANGLE_SENSOR_ERROR = 0x04
    """An angle sensor gives an impossible value."""
    PLAN_INV_SINGULARITY = 0x10
    """The target lies in a singular pose."""
    PLAN_INV_CALC = 0x11
    """The target is out of reach."""
    PLAN_INV_LIMIT = 0x12
    """The target would take a joint beyond its limit."""
    PLAN_PUSH_DATA_REPEAT = 0x13
    """Two points of an arc coincide."""
    PLAN_ARC_INPUT_PARAM = 0x14
    """The three points of an arc lie on a line."""
    PLAN_JUMP_PARAM = 0x15
    """The jump heights contradict each other."""
    PLAN_LINE_HAND = 0x16
    """A straight line changes the elbow side."""
    PLAN_LINE_OUT_SPACE = 0x17
    """A straight line leaves the workspace."""
    PLAN_ARC_OUT_SPACE = 0x18
    """An arc leaves the workspace."""
    PLAN_MOTION_TYPE = 0x19
    """An unknown kind of motion."""
    PLAN_SPEED_INPUT_PARAM = 0x1A
    """A speed or acceleration is zero, negative or not a number."""
    PLAN_CP_CALC = 0x1B
    """The continuous path could not be calculated."""
    MOVE_INV_SINGULARITY = 0x20
    """The path ran into a singular pose."""
    MOVE_INV_CALC = 0x21
    """The path left the workspace."""
    MOVE_INV_LIMIT = 0x22
    """The path took a joint to its limit."""
    OVERSPEED_AXIS1 = 0x30
    """J1 too fast."""
    OVERSPEED_AXIS2 = 0x31
    """J2 too fast."""
    OVERSPEED_AXIS3 = 0x32
    """J3 too fast."""
    OVERSPEED_AXIS4 = 0x33
    """J4 too fast."""
    LIMIT_AXIS1_POS = 0x40
    """J1 at its upper limit."""
    LIMIT_AXIS1_NEG = 0x41
    """J1 at its lower limit."""
    LIMIT_AXIS2_POS = 0x42
    """J2 at its upper limit."""
    LIMIT_AXIS2_NEG = 0x43
    """J2 at its lower limit."""
    LIMIT_AXIS3_POS = 0x44
    """J3 at its upper limit."""
    LIMIT_AXIS3_NEG = 0x45
    """J3 at its lower limit."""
    LIMIT_AXIS4_POS = 0x46
    """J4 at its upper limit."""
    LIMIT_AXIS4_NEG = 0x47
    """J4 at its lower limit."""
    LIMIT_AXIS23_POS = 0x48
    """The parallelogram of J2 and J3 stretched to its limit."""
    LIMIT_AXIS23_NEG = 0x49
    """The parallelogram of J2 and J3 folded to its limit."""
    LOSE_STEP_AXIS1 = 0x50
    """J1 lost steps."""
    LOSE_STEP_AXIS2 = 0x51
    """J2 lost steps."""
    LOSE_STEP_AXIS3 = 0x52
    """J3 lost steps."""
    LOSE_STEP_AXIS4 = 0x53
    """J4 lost steps."""
    OTHER_AXIS1_DRV_ALARM = 0x60
    """The motor driver of axis 1 reports a fault."""
    OTHER_AXIS1_OVERFLOW = 0x61
    """The position counter of axis 1 overflowed."""
    OTHER_AXIS1_FOLLOW = 0x62
    """Axis 1 does not follow."""
    OTHER_AXIS2_DRV_ALARM = 0x63
    """The motor driver of axis 2 reports a fault."""
    OTHER_AXIS2_OVERFLOW = 0x64
    """The position counter of axis 2 overflowed."""
    OTHER_AXIS2_FOLLOW = 0x65
    """Axis 2 does not follow."""
    OTHER_AXIS3_DRV_ALARM = 0x66
    """The motor driver of axis 3 reports a fault."""
    OTHER_AXIS3_OVERFLOW = 0x67
    """The position counter of axis 3 overflowed."""
    OTHER_AXIS3_FOLLOW = 0x68
    """Axis 3 does not follow."""
    OTHER_AXIS4_DRV_ALARM = 0x69
    """The motor driver of axis 4 reports a fault."""
    OTHER_AXIS4_OVERFLOW = 0x6A
    """The position counter of axis 4 overflowed."""
    OTHER_AXIS4_FOLLOW = 0x6B
    """Axis 4 does not follow."""

    @property
    def cause(self) -> str:
        """Its cause."""
        return _TEXTS.get(self, _NONE)[0]

    @property
    def cure(self) -> str:
        """Its remedy."""
        return _TEXTS.get(self, _NONE)[1]

    @property
    def holds_queue(self) -> bool:
        """Whether it holds the queue until it is cleared: all but 0x00 to 0x07."""
        return self > 0x07

    def __str__(self) -> str:
        return f"0x{int(self):02x} {self.name}: {self.cause} ({self.cure})"

    def __format__(self, spec: str) -> str:
        # Python 3.10 would write the text above in every format.
        return format(int(self), spec) if spec else str(self)


_NONE = ("unknown to this package", "look it up in the arm's manual")
_TEXTS = {
    0x00: ("the controller was reset or switched on", "home the arm"),
    0x01: ("a command that the controller does not know", "clear the alarms"),
    0x02: ("the controller's flash memory did not open", "switch the arm off and on"),
    0x03: ("processor and motor logic did not find each other at start-up", "switch the arm off and on"),
    0x04: ("an angle sensor gives an impossible value", "switch the arm off and on"),
    0x10: ("the target lies in a singular pose", "choose another target, then clear the alarms"),
    0x11: ("the target is out of reach", "choose another target, then clear the alarms"),
    0x12: ("the target would take a joint beyond its limit", "choose another target, then clear the alarms"),
    0x13: ("two points of an arc coincide", "choose another target, then clear the alarms"),
    0x14: ("the three points of an arc lie on a line", "choose another target, then clear the alarms"),
    0x15: ("the jump heights contradict each other", "set other jump heights, then clear the alarms"),
    0x16: ("a straight line changes the elbow side", "clear the alarms"),
    0x17: ("a straight line leaves the workspace", "clear the alarms"),
    0x18: ("an arc leaves the workspace", "clear the alarms"),
    0x19: ("an unknown kind of motion", "clear the alarms"),
    0x1A: ("a speed or acceleration is zero, negative or not a number", "set the speeds, then clear the alarms"),
    0x1B: ("the continuous path could not be calculated", "clear the alarms"),
    0x20: ("the path ran into a singular pose", "jog away by joints, then clear the alarms"),
    0x21: ("the path left the workspace", "move back inside, then clear the alarms"),
    0x22: ("the path took a joint to its limit", "move back inside, then clear the alarms"),
    0x30: ("J1 too fast", "lower the speed ratio, then clear the alarms"),
    0x31: ("J2 too fast", "lower the speed ratio, then clear the alarms"),
    0x32: ("J3 too fast", "lower the speed ratio, then clear the alarms"),
    0x33: ("J4 too fast", "lower the speed ratio, then clear the alarms"),
    0x40: (
        "J1 at its upper limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x41: (
        "J1 at its lower limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x42: (
        "J2 at its upper limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x43: (
        "J2 at its lower limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x44: (
        "J3 at its upper limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x45: (
        "J3 at its lower limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x46: (
        "J4 at its upper limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x47: (
        "J4 at its lower limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x48: (
        "the parallelogram of J2 and J3 stretched to its limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x49: (
        "the parallelogram of J2 and J3 folded to its limit",
        "jog the joint back into its range, where the alarm drops; then clear the alarms to release the queue",
    ),
    0x50: ("J1 lost steps", "remove the obstacle, home the arm, then clear the alarms"),
    0x51: ("J2 lost steps", "remove the obstacle, home the arm, then clear the alarms"),
    0x52: ("J3 lost steps", "remove the obstacle, home the arm, then clear the alarms"),
    0x53: ("J4 lost steps", "remove the obstacle, home the arm, then clear the alarms"),
    0x60: ("the motor driver of axis 1 reports a fault", "switch the arm off and on"),
    0x61: ("the position counter of axis 1 overflowed", "switch the arm off and on"),
    0x62: ("axis 1 does not follow", "clear the alarms"),
    0x63: ("the motor driver of axis 2 reports a fault", "switch the arm off and on"),
    0x64: ("the position counter of axis 2 overflowed", "switch the arm off and on"),
    0x65: ("axis 2 does not follow", "clear the alarms"),
    0x66: ("the motor driver of axis 3 reports a fault", "switch the arm off and on"),
    0x67: ("the position counter of axis 3 overflowed", "switch the arm off and on"),
    0x68: ("axis 3 does not follow", "clear the alarms"),
    0x69: ("the motor driver of axis 4 reports a fault", "switch the arm off and on"),
    0x6A: ("the position counter of axis 4 overflowed", "switch the arm off and on"),
    0x6B: ("axis 4 does not follow", "clear the alarms"),
}
