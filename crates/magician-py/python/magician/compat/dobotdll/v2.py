"""DobotDllType for several arms, each with a dobotId: family v2 of the DobotDll interface.

    import DobotDllType as dType

    api = dType.load()
    if dType.ConnectDobot(api, "", 115200)[0] == dType.DobotConnect.DobotConnect_NoError:
        print(dType.GetPose(api, 0))

Names, parameters, defaults and results are those of the file that it stands in for. Other than that one it works on
Linux and macOS as on Windows, and no function waits for ever: one that fails raises DobotError.

Ctrl-C leaves a wait at once, and a call that an arm does not answer when its time is over (SetCmdTimeout). Nothing is
sent to the arm then: it goes on with what it was told. SetQueuedCmdForceStopExec stops it.

Made by generate.py: do not edit.
"""

import os
import platform
import re
import threading
import time
import weakref
from ctypes import *

_FAMILY = "v2"
# How many ids the functions begin with.
_IDS = 1

# --- Enumerations ----------------------------------------------------------------------------------------------------


class EndType:
    EndTypeCustom = 0
    EndTypeSuctionCup = 1
    EndTypeGripper = 2
    EndTypeLaser = 3
    EndTypePen = 4
    EndTypeMax = 5


class ArmOrientation:
    LeftyArmOrientation = 0
    RightyArmOrientation = 1


class JC:
    JogIdle = 0
    JogAPPressed = 1
    JogANPressed = 2
    JogBPPressed = 3
    JogBNPressed = 4
    JogCPPressed = 5
    JogCNPressed = 6
    JogDPPressed = 7
    JogDNPressed = 8
    JogEPPressed = 9
    JogENPressed = 10


class PTPMode:
    PTPJUMPXYZMode = 0
    PTPMOVJXYZMode = 1
    PTPMOVLXYZMode = 2
    PTPJUMPANGLEMode = 3
    PTPMOVJANGLEMode = 4
    PTPMOVLANGLEMode = 5
    PTPMOVJANGLEINCMode = 6
    PTPMOVLXYZINCMode = 7
    PTPMOVJXYZINCMode = 8
    PTPJUMPMOVLXYZMode = 9


class InputPin:
    InputPinNone = 0
    InputPin1 = 1
    InputPin2 = 2
    InputPin3 = 3
    InputPin4 = 4
    InputPin5 = 5
    InputPin6 = 6
    InputPin7 = 7
    InputPin8 = 8


class InputLevel:
    InputLevelBoth = 0
    InputLevelLow = 1
    InputLevelHigh = 2


class OutputPin:
    SIGNALS_O1 = 1
    SIGNALS_O2 = 2
    SIGNALS_O3 = 3
    SIGNALS_O4 = 4
    SIGNALS_O5 = 5
    SIGNALS_O6 = 6
    SIGNALS_O7 = 7
    SIGNALS_O8 = 8


class ContinuousPathMode:
    CPRelativeMode = 0
    CPAbsoluteMode = 1


class TRIGMode:
    TRIGInputIOMode = 0
    TRIGADCMode = 1


class TRIGInputIOCondition:
    TRIGInputIOEqual = 0
    TRIGInputIONotEqual = 1


class TRIGADCCondition:
    TRIGADCLT = 0
    TRIGADCLE = 1
    TRIGADCGE = 2
    TRIGADCGT = 3


class GPIOType:
    GPIOTypeDummy = 0
    GPIOTypeDO = 1
    GPIOTypePWM = 2
    GPIOTypeDI = 3
    GPIOTypeADC = 4


class ZDFCalibStatus:
    ZDFCalibNotFinished = 0
    ZDFCalibFinished = 1


class ColorPort:
    PORT_GP1 = 0
    PORT_GP2 = 1
    PORT_GP4 = 2
    PORT_GP5 = 3


class InfraredPort:
    PORT_GP1 = 0
    PORT_GP2 = 1
    PORT_GP4 = 2
    PORT_GP5 = 3


class DobotConnect:
    DobotConnect_NoError = 0
    DobotConnect_NotFound = 1
    DobotConnect_Occupied = 2


class DobotCommunicate:
    DobotCommunicate_NoError = 0
    DobotCommunicate_BufferFull = 1
    DobotCommunicate_Timeout = 2
    DobotCommunicate_InvalidParams = 3
    DobotCommunicate_InvalidDevice = 4


# --- Structures ------------------------------------------------------------------------------------------------------


class EndTypeParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("xBias", c_float),
        ("yBias", c_float),
        ("zBias", c_float),
    ]


class Pose(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("x", c_float),
        ("y", c_float),
        ("z", c_float),
        ("rHead", c_float),
        ("joint1Angle", c_float),
        ("joint2Angle", c_float),
        ("joint3Angle", c_float),
        ("joint4Angle", c_float),
    ]


class Kinematics(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocity", c_float),
        ("acceleration", c_float),
    ]


class AlarmsState(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("alarmsState", c_int32),
    ]


class HOMEParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("x", c_float),
        ("y", c_float),
        ("z", c_float),
        ("r", c_float),
    ]


class HOMECmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("temp", c_float),
    ]


class AutoLevelingCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("controlFlag", c_uint8),
        ("precision", c_float),
    ]


class EMotor(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("index", c_uint8),
        ("isEnabled", c_uint8),
        ("speed", c_int32),
    ]


class EMotorS(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("index", c_uint8),
        ("isEnabled", c_uint8),
        ("speed", c_int32),
        ("distance", c_uint32),
    ]


class JOGJointParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("joint1Velocity", c_float),
        ("joint2Velocity", c_float),
        ("joint3Velocity", c_float),
        ("joint4Velocity", c_float),
        ("joint1Acceleration", c_float),
        ("joint2Acceleration", c_float),
        ("joint3Acceleration", c_float),
        ("joint4Acceleration", c_float),
    ]


class JOGCoordinateParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("xVelocity", c_float),
        ("yVelocity", c_float),
        ("zVelocity", c_float),
        ("rVelocity", c_float),
        ("xAcceleration", c_float),
        ("yAcceleration", c_float),
        ("zAcceleration", c_float),
        ("rAcceleration", c_float),
    ]


class JOGCommonParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocityRatio", c_float),
        ("accelerationRatio", c_float),
    ]


class JOGLParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocity", c_float),
        ("acceleration", c_float),
    ]


class JOGCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("isJoint", c_uint8),
        ("cmd", c_uint8),
    ]


class PTPJointParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("joint1Velocity", c_float),
        ("joint2Velocity", c_float),
        ("joint3Velocity", c_float),
        ("joint4Velocity", c_float),
        ("joint1Acceleration", c_float),
        ("joint2Acceleration", c_float),
        ("joint3Acceleration", c_float),
        ("joint4Acceleration", c_float),
    ]


class PTPCoordinateParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("xyzVelocity", c_float),
        ("rVelocity", c_float),
        ("xyzAcceleration", c_float),
        ("rAcceleration", c_float),
    ]


class PTPLParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocity", c_float),
        ("acceleration", c_float),
    ]


class PTPJumpParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("jumpHeight", c_float),
        ("zLimit", c_float),
    ]


class PTPJump2Params(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("startJumpHeight", c_float),
        ("endJumpHeight", c_float),
        ("zLimit", c_float),
    ]


class PTPCommonParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocityRatio", c_float),
        ("accelerationRatio", c_float),
    ]


class PTPCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("ptpMode", c_uint8),
        ("x", c_float),
        ("y", c_float),
        ("z", c_float),
        ("rHead", c_float),
    ]


class PTPWithLCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("ptpMode", c_uint8),
        ("x", c_float),
        ("y", c_float),
        ("z", c_float),
        ("rHead", c_float),
        ("l", c_float),
    ]


class ParallelOutputCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("ratio", c_uint8),
        ("address", c_uint16),
        ("level", c_uint8),
    ]


class CPParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("planAcc", c_float),
        ("juncitionVel", c_float),
        ("acc", c_float),
        ("realTimeTrack", c_uint8),
    ]


class CPCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("cpMode", c_uint8),
        ("x", c_float),
        ("y", c_float),
        ("z", c_float),
        ("velocity", c_float),
    ]


class ARCPoint(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("x", c_float),
        ("y", c_float),
        ("z", c_float),
        ("rHead", c_float),
    ]


class ARCParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("xyzVelocity", c_float),
        ("rVelocity", c_float),
        ("xyzAcceleration", c_float),
        ("rAcceleration", c_float),
    ]


class ARCCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("cirPoint", ARCPoint),
        ("toPoint", ARCPoint),
    ]


class CircleCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("cirPoint", ARCPoint),
        ("toPoint", ARCPoint),
        ("count", c_uint32),
    ]


class WAITParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("unitType", c_uint8),
    ]


class WAITCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("waitTime", c_uint32),
    ]


class TRIGCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("address", c_uint8),
        ("mode", c_uint8),
        ("condition", c_uint8),
        ("threshold", c_uint16),
    ]


class IOMultiplexing(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("address", c_uint8),
        ("multiplex", c_uint8),
    ]


class IODO(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("address", c_uint8),
        ("level", c_uint8),
    ]


class IOPWM(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("address", c_uint8),
        ("frequency", c_float),
        ("dutyCycle", c_float),
    ]


class IODI(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("address", c_uint8),
        ("level", c_uint8),
    ]


class IOADC(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("address", c_uint8),
        ("value", c_uint16),
    ]


class UserParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("params1", c_float),
        ("params2", c_float),
        ("params3", c_float),
        ("params4", c_float),
        ("params5", c_float),
        ("params6", c_float),
        ("params7", c_float),
        ("params8", c_float),
    ]


class WIFIIPAddress(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("dhcp", c_uint8),
        ("addr1", c_uint8),
        ("addr2", c_uint8),
        ("addr3", c_uint8),
        ("addr4", c_uint8),
    ]


class WIFINetmask(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("addr1", c_uint8),
        ("addr2", c_uint8),
        ("addr3", c_uint8),
        ("addr4", c_uint8),
    ]


class WIFIGateway(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("addr1", c_uint8),
        ("addr2", c_uint8),
        ("addr3", c_uint8),
        ("addr4", c_uint8),
    ]


class WIFIDNS(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("addr1", c_uint8),
        ("addr2", c_uint8),
        ("addr3", c_uint8),
        ("addr4", c_uint8),
    ]


class FirmwareParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("mode", c_uint8),
    ]


class FirmwareMode(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("mode", c_uint8),
        ("ctl", c_uint8),
    ]


class PID(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("index", c_uint8),
        ("controlLoop", c_uint8),
        ("p", c_float),
        ("i", c_float),
        ("d", c_float),
        ("v", c_float),
        ("a", c_float),
    ]


# --- Errors ----------------------------------------------------------------------------------------------------------


class DobotError(RuntimeError):
    """A function that did not do what it was asked to.

    `function` is its name, `code` what the library returned (a member of DobotCommunicate, or None if it was this
    module that gave up waiting), `reason` a sentence.
    """

    def __init__(self, function, code, reason):
        # The library's own sentence may begin with the name, too.
        reason = reason[len(function) + 2 :] if reason.startswith(f"{function}: ") else reason
        self.function, self.code, self.reason = function, code, reason
        said = [function] if code is None else [function, _CODES.get(code, f"code {code}")]
        super().__init__(": ".join([*said, reason]))

    def __reduce__(self):
        return DobotError, (self.function, self.code, self.reason)


_CODES = {1: "buffer full (1)", 2: "timeout (2)", 3: "invalid parameters (3)", 4: "invalid device (4)"}

# --- The library -----------------------------------------------------------------------------------------------------

_FILES = {
    "Windows": ("DobotDll.dll", f"dobotdll_{_FAMILY}.dll"),
    "Darwin": ("libDobotDll.dylib", "libDobotDll.1.0.0.dylib", f"libdobotdll_{_FAMILY}.dylib"),
}.get(platform.system(), ("libDobotDll.so", "libDobotDll.so.1", f"libdobotdll_{_FAMILY}.so"))


def load():
    """The library, as a handle for all the other functions.

    It is looked for beside this file, then at MAGICIAN_DOBOTDLL (a file, or a folder with it), then where the system
    looks for libraries.
    """
    tried = []
    for place in _places():
        try:
            handle = CDLL(place)
        except OSError as error:
            tried.append(f"{place}: {error}")
            continue
        _check_family(handle, place)
        return handle
    python = f"This is Python for {platform.machine()}, {platform.architecture()[0]}."
    advice = f"Put {_FILES[0]} beside {os.path.abspath(__file__)}, or name it, or its folder, in MAGICIAN_DOBOTDLL. "
    tries = "".join(f"\n  {t}" for t in tried)
    raise OSError("there is no DobotDll library that can be loaded. " + advice + python + tries)


def _places():
    """Where the library can be: files that exist, then bare names for the system to look up."""
    folders = [os.path.dirname(os.path.abspath(__file__))]
    named = os.environ.get("MAGICIAN_DOBOTDLL")
    places = []
    if named and os.path.isdir(named):
        folders.append(os.path.abspath(named))
    elif named:
        places.append(os.path.abspath(named))
    inside = [os.path.join(folder, file) for folder in folders for file in _FILES]
    return [place for place in inside if os.path.exists(place)] + places + list(_FILES)


def _check_family(handle, place):
    """Refuse the library of another family: its functions have the same names and other arguments."""
    if hasattr(handle, "GetDeviceID"):
        family = "v3"
    elif hasattr(handle, "SendPluse"):
        family = "v1"
    elif hasattr(handle, "MagicianLastError"):
        family = "v2"
    else:
        return
    if family != _FAMILY:
        raise OSError(f"{place} is a library of family {family}, and this DobotDllType.py is for {_FAMILY}")


class _Library:
    """How the functions of a shared library are called: the only part of this module that knows.

    An `api` that has a method `dobot_call(name, arguments)` answers the calls itself: it gets the ctypes values in
    their C order and returns the code; `dobot_last_error()`, if it has one, says why the code is not 0.
    """

    def __init__(self, handle):
        self.handle, self.functions = handle, {}

    def dobot_call(self, name, arguments):
        function = self.functions.get(name)
        if function is None:
            function = self.functions[name] = self.declared(name)
        return function(*[byref(value) if isinstance(value, _BY_REFERENCE) else value for value in arguments])

    def declared(self, name):
        # handle[name] is a function object of our own: programs that call `api.Name(...)` with whatever ctypes makes
        # of their arguments are not bound by these declarations.
        try:
            function = self.handle[name]
        except AttributeError:
            raise DobotError(name, None, "this library has no such function") from None
        function.argtypes, function.restype = _PROTOTYPES[name], c_int
        return function

    def dobot_last_error(self):
        if not hasattr(self.handle, "MagicianLastError"):
            return ""
        text = create_string_buffer(max(self.dobot_call("MagicianLastError", (None, 0)), 0) + 1)
        self.dobot_call("MagicianLastError", (text, len(text)))
        return _string(text)


class _Arms:
    """What is known of an `api`: how it is called, the last queued command, and which of them may take long."""

    known = weakref.WeakKeyDictionary()

    def __init__(self, api):
        self.door = api if hasattr(api, "dobot_call") else _Library(api)
        self.slow, self.last = {}, {}
        # What a thread does that does nothing but ask for the index.
        self.waits = threading.local()

    @classmethod
    def of(cls, api):
        found = cls.known.get(api)
        if found is None:
            found = cls.known.setdefault(api, cls(api))
        return found


def _call(api, name, *arguments):
    """One function, once; while the arm's queue is full, again. Anything but success is a DobotError."""
    arms = _Arms.of(api)
    code = arms.door.dobot_call(name, arguments)
    if code == DobotCommunicate.DobotCommunicate_BufferFull:
        watch = _Watch(arms, arguments[:_IDS], name, "there is no room in the arm's queue")
        while code == DobotCommunicate.DobotCommunicate_BufferFull:
            watch.look()
            time.sleep(ROOM_INTERVAL)
            code = arms.door.dobot_call(name, arguments)
    if code != DobotCommunicate.DobotCommunicate_NoError:
        raise DobotError(name, code, _reason(arms.door))
    if name != "GetQueuedCmdCurrentIndex":
        arms.waits.watch = None
        if name == "SetQueuedCmdClear":
            arms.last.pop(_key(arguments), None)
        elif arguments and isinstance(arguments[-1], c_uint64) and arguments[-1].value:
            arms.last[_key(arguments[:_IDS])] = arguments[-1].value


def _reason(door):
    said = getattr(door, "dobot_last_error", str)()
    return said or "the library does not say why"


# --- Waiting ---------------------------------------------------------------------------------------------------------

# Seconds. Between two looks at a queue that is full, or at a command that is not finished.
ROOM_INTERVAL = 0.02
FINISH_INTERVAL = 0.005
# How long neither the queue nor the arm has to move before a wait gives up, if it is not known why they stand.
QUEUE_STALL = 20.0
# The same with an alarm set that keeps the queue from running.
ALARM_STALL = 1.5
# How much longer the arm may seem to stand while it homes.
HOMING = 60.0
FOR_EVER = float("inf")


def _expect(api, arm, index, seconds):
    """Remember that a queued command may leave the arm standing so long (a WAIT), or for ever (a trigger)."""
    if index:
        slow = _Arms.of(api).slow.setdefault(_key(arm), {})
        slow[index] = seconds
        if len(slow) > 4096:
            del slow[min(slow)]


def _finish(api, arm, name, index):
    """Wait until the queued command with this index is finished. Index 0: it was not queued."""
    if not index:
        return
    watch = _Watch(_Arms.of(api), arm, name, f"command {index} of the queue is not finished")
    while watch.look() < index:
        time.sleep(FINISH_INTERVAL)


def _waited(api, arm, index):
    """The program has asked for the index. If that is all it does, it waits: not for ever under an alarm."""
    arms = _Arms.of(api)
    watch = getattr(arms.waits, "watch", None)
    last = arms.last.get(_key(arm), 0)
    if index >= last:
        arms.waits.watch = None
        return
    if watch is None or _key(watch.arm) != _key(arm):
        what = f"command {last} of the queue is not finished"
        watch = arms.waits.watch = _Watch(arms, arm, "GetQueuedCmdCurrentIndex", what, stall=FOR_EVER)
    try:
        watch.saw(index)
    except DobotError:
        arms.waits.watch = None
        raise


def _key(arm):
    return tuple(getattr(number, "value", number) for number in arm)


class _Watch:
    """Checks whether a queue moves, so that no call waits for ever."""

    def __init__(self, arms, arm, name, what, stall=None):
        self.arms, self.arm, self.name, self.what, self.stall = arms, arm, name, what, stall
        self.index = self.pose = None
        self.since = self.looked = time.monotonic()

    def look(self):
        """The index that ended last; a DobotError if queue and arm have stood for too long."""
        index = c_uint64(0)
        self.read("GetQueuedCmdCurrentIndex", index)
        return self.saw(index.value)

    def saw(self, index):
        """The index was read."""
        now = time.monotonic()
        if index != self.index:
            self.index, self.pose, self.since = index, None, now
        elif now - self.since > 0.5 and now - self.looked > 0.2:
            self.looked = now
            self.look_closer(now)
        return self.index

    def look_closer(self, now):
        pose = Pose()
        self.read("GetPose", pose)
        values = [getattr(pose, name) for name, _ in Pose._fields_]
        if self.pose is None or any(abs(a - b) > 0.01 for a, b in zip(values, self.pose)):
            self.pose, self.since = values, now if self.pose is not None else self.since
            return
        stood = now - self.since
        more = self.arms.slow.get(_key(self.arm), {}).get(self.index + 1, 0)
        alarms = self.alarms()
        # Homing goes on under an alarm.
        if alarms and more != HOMING:
            if stood > ALARM_STALL:
                self.give_up_under(alarms)
            return
        if stood > (QUEUE_STALL if self.stall is None else self.stall) + more:
            self.give_up(
                f"for {stood:.0f} s neither the queue nor the arm has moved: was the queue started"
                " (SetQueuedCmdStartExec)? A limit that was touched also stops it, until ClearAllAlarmsState"
            )

    def give_up_under(self, alarms):
        names = [f"0x{alarm:02X}" for alarm in alarms]
        said = _reason(self.arms.door)
        # The library knows their names, and reported them to the call that read the index then.
        if said.startswith("GetQueuedCmdCurrentIndex: ") and all(name in said for name in names):
            raise DobotError(self.name, None, said.partition(": ")[2])
        names = ", ".join(names)
        self.give_up(f"alarm {names} keeps the queue from running (ClearAllAlarmsState, once the cause is gone)")

    def alarms(self):
        """Alarms that keep a queue from running: all but the first byte."""
        bits, length = create_string_buffer(32), c_uint32(0)
        self.read("GetAlarmsState", bits, length, 32)
        return [8 * n + bit for n in range(1, 32) for bit in range(8) if bits.raw[n] >> bit & 1]

    def read(self, name, *arguments):
        code = self.arms.door.dobot_call(name, (*self.arm, *arguments))
        if code != DobotCommunicate.DobotCommunicate_NoError:
            raise DobotError(self.name, code, f"{self.what}, and {name} failed: {_reason(self.arms.door)}")

    def give_up(self, why):
        raise DobotError(self.name, None, f"{self.what}; index {self.index} was the last to end, and {why}")


# --- Values ----------------------------------------------------------------------------------------------------------

_BY_REFERENCE = (Structure, c_uint8, c_uint16, c_uint32, c_uint64, c_int32, c_float)


def _byte(value):
    return int(value) & 0xFF


def _text(value):
    return value.encode("utf-8") if isinstance(value, str) else bytes(value)


def _decimal(value):
    return _text(str(int(value)))


def _string(buffer):
    return buffer.value.decode("utf-8", "replace")


def _filled(structure, value):
    """A structure, from one or from its values."""
    return value if isinstance(value, structure) else structure(*value)


def _outputs(given):
    """The outputs that a motion switches on its way, as a C array."""
    made = [_filled(ParallelOutputCmd, value) for value in given]
    return (ParallelOutputCmd * max(len(made), 1))(*made), len(made)


def _try(api, name, *arguments):
    """One function, whatever it returns: the code is the caller's business."""
    if name == "ConnectDobot":
        _Arms.of(api).last.clear()
    return _Arms.of(api).door.dobot_call(name, arguments)


# --- Session ---------------------------------------------------------------------------------------------------------


def dSleep(ms):
    time.sleep(ms / 1000)


def MagicianLastError(api):
    """Why the last call of this thread failed, in a sentence; empty if none has."""
    return _Arms.of(api).door.dobot_last_error()


def MagicianAllow(api, names):
    """Allow functions that can brick, unlearn or unlock something: their names with commas, or "all"."""
    _call(api, "MagicianAllow", _text(names))


def output(str):
    """Does nothing, as ever."""


def SearchDobot(api, maxLen=1000):
    """Where arms could be, as a list of names for ConnectDobot."""
    found = create_string_buffer(max(maxLen, 1))
    if not _try(api, "SearchDobot", found, maxLen):
        return []
    # A name may end with words in parentheses.
    return re.findall(r"(?:[^\s(]|\([^)]*\))+(?: \([^)]*\))?", _string(found))


def gettime():
    return [time.time()]


def ConnectDobot(api, portName="", baudrate=115200):
    """[result, firmware, version, dobotId]; result is one of DobotConnect."""
    firmware, version, dobotId = create_string_buffer(100), create_string_buffer(100), c_int32(0)
    result = _try(api, "ConnectDobot", _text(portName), baudrate, firmware, version, dobotId)
    return [result, _string(firmware), _string(version), dobotId.value]


def DisconnectDobot(api, dobotId):
    _try(api, "DisconnectDobot", dobotId)


def SetCmdTimeout(api, dobotId, times):
    """Milliseconds."""
    _try(api, "SetCmdTimeout", dobotId, times)


def DobotExec(api):
    return [_try(api, "DobotExec")]


def PeriodicTask(api):
    _try(api, "PeriodicTask")


# --- Queue -----------------------------------------------------------------------------------------------------------


def GetQueuedCmdCurrentIndex(api, dobotId):
    found = c_uint64()
    _call(api, "GetQueuedCmdCurrentIndex", dobotId, found)
    _waited(api, (dobotId,), found.value)
    return [found.value]


def SetQueuedCmdStartExec(api, dobotId):
    _call(api, "SetQueuedCmdStartExec", dobotId)


def SetQueuedCmdStopExec(api, dobotId):
    _call(api, "SetQueuedCmdStopExec", dobotId)


def SetQueuedCmdForceStopExec(api, dobotId):
    _call(api, "SetQueuedCmdForceStopExec", dobotId)


def SetQueuedCmdStartDownload(api, dobotId, totalLoop, linePerLoop):
    _call(api, "SetQueuedCmdStartDownload", dobotId, totalLoop, linePerLoop)


def SetQueuedCmdStopDownload(api, dobotId):
    _call(api, "SetQueuedCmdStopDownload", dobotId)


def SetQueuedCmdClear(api, dobotId):
    _call(api, "SetQueuedCmdClear", dobotId)
    return [DobotCommunicate.DobotCommunicate_NoError]


# --- Device ----------------------------------------------------------------------------------------------------------


def SetDeviceSN(api, dobotId, str):
    _call(api, "SetDeviceSN", dobotId, _text(str))


def GetDeviceSN(api, dobotId):
    found = create_string_buffer(64)
    _call(api, "GetDeviceSN", dobotId, found, 64)
    return [_string(found)]


def SetDeviceName(api, dobotId, str):
    _call(api, "SetDeviceName", dobotId, _text(str))


def SetDeviceNumName(api, dobotId, num):
    _call(api, "SetDeviceName", dobotId, _decimal(num))


def GetDeviceName(api, dobotId):
    found = create_string_buffer(100)
    _call(api, "GetDeviceName", dobotId, found, 100)
    return [_string(found)]


def GetDeviceVersion(api, dobotId):
    major = c_uint8()
    minor = c_uint8()
    revision = c_uint8()
    _call(api, "GetDeviceVersion", dobotId, major, minor, revision)
    return [major.value, minor.value, revision.value]


def SetDeviceWithL(api, dobotId, isWithL):
    _call(api, "SetDeviceWithL", dobotId, _byte(isWithL))


def GetDeviceWithL(api, dobotId):
    found = c_uint8()
    _call(api, "GetDeviceWithL", dobotId, found)
    return [bool(found.value)]


def GetDeviceTime(api, dobotId):
    found = c_uint32()
    _call(api, "GetDeviceTime", dobotId, found)
    return [found.value]


def GetUserParams(api, dobotId):
    found = UserParams()
    _call(api, "GetUserParams", dobotId, found)
    return [
        found.params1, found.params2, found.params3, found.params4, found.params5, found.params6, found.params7,
        found.params8
    ]


# --- Pose and alarms -------------------------------------------------------------------------------------------------


def GetPose(api, dobotId):
    pose = Pose()
    _call(api, "GetPose", dobotId, pose)
    return [pose.x, pose.y, pose.z, pose.rHead, pose.joint1Angle, pose.joint2Angle, pose.joint3Angle, pose.joint4Angle]


def GetPoseL(api, dobotId):
    found = c_float()
    _call(api, "GetPoseL", dobotId, found)
    return [found.value]


def ResetPose(api, dobotId, manual, rearArmAngle, frontArmAngle):
    _call(api, "ResetPose", dobotId, _byte(manual), rearArmAngle, frontArmAngle)


def GetKinematics(api, dobotId):
    found = Kinematics()
    _call(api, "GetKinematics", dobotId, found)
    return [found.velocity, found.acceleration]


def GetAlarmsState(api, dobotId, maxLen=1000):
    alarmsState, length = create_string_buffer(maxLen), c_uint32(0)
    _call(api, "GetAlarmsState", dobotId, alarmsState, length, maxLen)
    return [alarmsState.raw, length.value]


def ClearAllAlarmsState(api, dobotId):
    _call(api, "ClearAllAlarmsState", dobotId)


# --- Homing and levelling --------------------------------------------------------------------------------------------


def SetHOMEParams(api, dobotId, x, y, z, r, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetHOMEParams", dobotId, HOMEParams(x, y, z, r), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetHOMEParams(api, dobotId):
    found = HOMEParams()
    _call(api, "GetHOMEParams", dobotId, found)
    return [found.x, found.y, found.z, found.r]


def SetHOMECmd(api, dobotId, temp, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetHOMECmd", dobotId, HOMECmd(temp), _byte(isQueued), queuedCmdIndex)
    _expect(api, (dobotId,), queuedCmdIndex.value, HOMING)
    return [queuedCmdIndex.value]


def SetAutoLevelingCmd(api, dobotId, controlFlag, precision, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetAutoLevelingCmd", dobotId, AutoLevelingCmd(controlFlag, precision), _byte(isQueued), queuedCmdIndex)
    _expect(api, (dobotId,), queuedCmdIndex.value, HOMING)
    return [queuedCmdIndex.value]


def GetAutoLevelingResult(api, dobotId):
    found = c_float()
    _call(api, "GetAutoLevelingResult", dobotId, found)
    return [found.value]


def SetArmOrientation(api, dobotId, armOrientation, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetArmOrientation", dobotId, armOrientation, _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetArmOrientation(api, dobotId):
    found = c_int32()
    _call(api, "GetArmOrientation", dobotId, found)
    return [found.value]


# --- Hand-hold teaching ----------------------------------------------------------------------------------------------


def SetHHTTrigMode(api, dobotId, hhtTrigMode):
    _call(api, "SetHHTTrigMode", dobotId, hhtTrigMode)


def GetHHTTrigMode(api, dobotId):
    found = c_int32()
    _call(api, "GetHHTTrigMode", dobotId, found)
    return [found.value]


def SetHHTTrigOutputEnabled(api, dobotId, isEnabled):
    _call(api, "SetHHTTrigOutputEnabled", dobotId, _byte(isEnabled))


def GetHHTTrigOutputEnabled(api, dobotId):
    found = c_uint8()
    _call(api, "GetHHTTrigOutputEnabled", dobotId, found)
    return [found.value]


def GetHHTTrigOutput(api, dobotId):
    found = c_uint8()
    _call(api, "GetHHTTrigOutput", dobotId, found)
    return [bool(found.value)]


# --- End effector ----------------------------------------------------------------------------------------------------


def SetEndEffectorParams(api, dobotId, xBias, yBias, zBias, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorParams", dobotId, EndTypeParams(xBias, yBias, zBias), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorParams(api, dobotId):
    found = EndTypeParams()
    _call(api, "GetEndEffectorParams", dobotId, found)
    return [found.xBias, found.yBias, found.zBias]


def SetEndEffectorLaser(api, dobotId, enableCtrl, on, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorLaser", dobotId, _byte(enableCtrl), _byte(on), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorLaser(api, dobotId):
    isCtrlEnabled = c_uint8()
    isOn = c_uint8()
    _call(api, "GetEndEffectorLaser", dobotId, isCtrlEnabled, isOn)
    return [isCtrlEnabled.value, isOn.value]


def SetEndEffectorSuctionCup(api, dobotId, enableCtrl, on, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorSuctionCup", dobotId, _byte(enableCtrl), _byte(on), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorSuctionCup(api, dobotId):
    isCtrlEnabled = c_uint8()
    isOn = c_uint8()
    _call(api, "GetEndEffectorSuctionCup", dobotId, isCtrlEnabled, isOn)
    return [isOn.value]


def SetEndEffectorGripper(api, dobotId, enableCtrl, on, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorGripper", dobotId, _byte(enableCtrl), _byte(on), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorGripper(api, dobotId):
    isCtrlEnabled = c_uint8()
    isOn = c_uint8()
    _call(api, "GetEndEffectorGripper", dobotId, isCtrlEnabled, isOn)
    return [isOn.value]


# --- Jog -------------------------------------------------------------------------------------------------------------


def SetJOGJointParams(
        api, dobotId, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued=0
):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetJOGJointParams", dobotId, JOGJointParams(j1Velocity, j2Velocity, j3Velocity, j4Velocity,
        j1Acceleration, j2Acceleration, j3Acceleration, j4Acceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetJOGJointParams(api, dobotId):
    found = JOGJointParams()
    _call(api, "GetJOGJointParams", dobotId, found)
    return [
        found.joint1Velocity, found.joint1Acceleration, found.joint2Velocity, found.joint2Acceleration,
        found.joint3Velocity, found.joint3Acceleration, found.joint4Velocity, found.joint4Acceleration
    ]


def SetJOGCoordinateParams(
        api, dobotId, xVelocity, xAcceleration, yVelocity, yAcceleration, zVelocity, zAcceleration, rVelocity,
        rAcceleration, isQueued=0
):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetJOGCoordinateParams", dobotId, JOGCoordinateParams(xVelocity, yVelocity, zVelocity, rVelocity,
        xAcceleration, yAcceleration, zAcceleration, rAcceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetJOGCoordinateParams(api, dobotId):
    found = JOGCoordinateParams()
    _call(api, "GetJOGCoordinateParams", dobotId, found)
    return [
        found.xVelocity, found.xAcceleration, found.yVelocity, found.yAcceleration, found.zVelocity,
        found.zAcceleration, found.rVelocity, found.rAcceleration
    ]


def SetJOGLParams(api, dobotId, velocity, acceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetJOGLParams", dobotId, JOGLParams(velocity, acceleration), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetJOGLParams(api, dobotId):
    found = JOGLParams()
    _call(api, "GetJOGLParams", dobotId, found)
    return [found.velocity, found.acceleration]


def SetJOGCommonParams(api, dobotId, value_velocityratio, value_accelerationratio, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetJOGCommonParams", dobotId, JOGCommonParams(value_velocityratio, value_accelerationratio),
        _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetJOGCommonParams(api, dobotId):
    found = JOGCommonParams()
    _call(api, "GetJOGCommonParams", dobotId, found)
    return [found.velocityRatio, found.accelerationRatio]


def SetJOGCmd(api, dobotId, isJoint, cmd, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetJOGCmd", dobotId, JOGCmd(isJoint, cmd), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- Point to point --------------------------------------------------------------------------------------------------


def SetPTPJointParams(
        api, dobotId, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued=0
):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPJointParams", dobotId, PTPJointParams(j1Velocity, j2Velocity, j3Velocity, j4Velocity,
        j1Acceleration, j2Acceleration, j3Acceleration, j4Acceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPJointParams(api, dobotId):
    found = PTPJointParams()
    _call(api, "GetPTPJointParams", dobotId, found)
    return [
        found.joint1Velocity, found.joint1Acceleration, found.joint2Velocity, found.joint2Acceleration,
        found.joint3Velocity, found.joint3Acceleration, found.joint4Velocity, found.joint4Acceleration
    ]


def SetPTPCoordinateParams(api, dobotId, xyzVelocity, xyzAcceleration, rVelocity, rAcceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPCoordinateParams", dobotId, PTPCoordinateParams(xyzVelocity, rVelocity, xyzAcceleration,
        rAcceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPCoordinateParams(api, dobotId):
    found = PTPCoordinateParams()
    _call(api, "GetPTPCoordinateParams", dobotId, found)
    return [found.xyzVelocity, found.rVelocity, found.xyzAcceleration, found.rAcceleration]


def SetPTPLParams(api, dobotId, velocity, acceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPLParams", dobotId, PTPLParams(velocity, acceleration), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetPTPLParams(api, dobotId):
    found = PTPLParams()
    _call(api, "GetPTPLParams", dobotId, found)
    return [found.velocity, found.acceleration]


def SetPTPJumpParams(api, dobotId, jumpHeight, zLimit, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPJumpParams", dobotId, PTPJumpParams(jumpHeight, zLimit), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetPTPJumpParams(api, dobotId):
    found = PTPJumpParams()
    _call(api, "GetPTPJumpParams", dobotId, found)
    return [found.jumpHeight, found.zLimit]


def SetPTPJump2Params(api, dobotId, startJumpHeight, endJumpHeight, zLimit, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPJump2Params", dobotId, PTPJump2Params(startJumpHeight, endJumpHeight, zLimit), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPJump2Params(api, dobotId):
    found = PTPJump2Params()
    _call(api, "GetPTPJump2Params", dobotId, found)
    return [found.startJumpHeight, found.endJumpHeight, found.zLimit]


def SetPTPCommonParams(api, dobotId, velocityRatio, accelerationRatio, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPCommonParams", dobotId, PTPCommonParams(velocityRatio, accelerationRatio), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPCommonParams(api, dobotId):
    found = PTPCommonParams()
    _call(api, "GetPTPCommonParams", dobotId, found)
    return [found.velocityRatio, found.accelerationRatio]


def SetPTPCmd(api, dobotId, ptpMode, x, y, z, rHead, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPCmd", dobotId, PTPCmd(ptpMode, x, y, z, rHead), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetPTPWithLCmd(api, dobotId, ptpMode, x, y, z, rHead, l, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPWithLCmd", dobotId, PTPWithLCmd(ptpMode, x, y, z, rHead, l), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetPTPPOCmd(api, dobotId, ptpMode, x, y, z, rHead, parallelCmd, isQueued=0):
    """parallelCmd: (ratio, address, level) of every output on the way."""
    outputs, count = _outputs(parallelCmd)
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPPOCmd", dobotId, PTPCmd(ptpMode, x, y, z, rHead), outputs, count, _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetPTPPOWithLCmd(api, dobotId, ptpMode, x, y, z, rHead, l, parallelCmd, isQueued=0):
    """parallelCmd: (ratio, address, level) of every output on the way."""
    outputs, count = _outputs(parallelCmd)
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPPOWithLCmd", dobotId, PTPWithLCmd(ptpMode, x, y, z, rHead, l), outputs, count, _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPTime(api, dobotId, ptpMode, x, y, z, rHead):
    found = c_uint32()
    _call(api, "GetPTPTime", dobotId, PTPCmd(ptpMode, x, y, z, rHead), found)
    return [found.value]


# --- Continuous path -------------------------------------------------------------------------------------------------


def SetCPParams(api, dobotId, planAcc, juncitionVel, acc, realTimeTrack=0, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetCPParams", dobotId, CPParams(planAcc, juncitionVel, acc, realTimeTrack), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetCPParams(api, dobotId):
    found = CPParams()
    _call(api, "GetCPParams", dobotId, found)
    return [found.planAcc, found.juncitionVel, found.acc]


def SetCPCmd(api, dobotId, cpMode, x, y, z, velocity, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetCPCmd", dobotId, CPCmd(cpMode, x, y, z, velocity), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetCPLECmd(api, dobotId, cpMode, x, y, z, power, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetCPLECmd", dobotId, CPCmd(cpMode, x, y, z, power), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- Arc and circle --------------------------------------------------------------------------------------------------


def SetARCParams(api, dobotId, xyzVelocity, rVelocity, xyzAcceleration, rAcceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetARCParams", dobotId, ARCParams(xyzVelocity, rVelocity, xyzAcceleration, rAcceleration),
        _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetARCParams(api, dobotId):
    found = ARCParams()
    _call(api, "GetARCParams", dobotId, found)
    return [found.xyzVelocity, found.rVelocity, found.xyzAcceleration, found.rAcceleration]


def SetARCCmd(api, dobotId, cirPoint, toPoint, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetARCCmd", dobotId, ARCCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint)), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetCircleCmd(api, dobotId, cirPoint, toPoint, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetCircleCmd", dobotId, CircleCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint), 1), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


# --- Wait and trigger ------------------------------------------------------------------------------------------------


def SetWAITCmd(api, dobotId, waitTime, isQueued=0):
    """waitTime: milliseconds."""
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetWAITCmd", dobotId, WAITCmd(int(waitTime)), _byte(isQueued), queuedCmdIndex)
    _expect(api, (dobotId,), queuedCmdIndex.value, waitTime / 1000)
    return [queuedCmdIndex.value]


def SetTRIGCmd(api, dobotId, address, mode, condition, threshold, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetTRIGCmd", dobotId, TRIGCmd(address, mode, condition, threshold), _byte(isQueued), queuedCmdIndex)
    _expect(api, (dobotId,), queuedCmdIndex.value, FOR_EVER)
    return [queuedCmdIndex.value]


# --- Extended I/O ----------------------------------------------------------------------------------------------------


def SetIOMultiplexing(api, dobotId, address, multiplex, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetIOMultiplexing", dobotId, IOMultiplexing(address, multiplex), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetIODO(api, dobotId, address, level, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetIODO", dobotId, IODO(address, level), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetIOPWM(api, dobotId, address, frequency, dutyCycle, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetIOPWM", dobotId, IOPWM(address, frequency, dutyCycle), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetIOMultiplexing(api, dobotId, addr):
    found = IOMultiplexing(addr)
    _call(api, "GetIOMultiplexing", dobotId, found)
    return [found.multiplex]


def GetIODO(api, dobotId, addr):
    found = IODO(addr)
    _call(api, "GetIODO", dobotId, found)
    return [found.level]


def GetIOPWM(api, dobotId, addr):
    found = IOPWM(addr)
    _call(api, "GetIOPWM", dobotId, found)
    return [found.frequency, found.dutyCycle]


def GetIODI(api, dobotId, addr):
    found = IODI(addr)
    _call(api, "GetIODI", dobotId, found)
    return [found.level]


def GetIOADC(api, dobotId, addr):
    found = IOADC(addr)
    _call(api, "GetIOADC", dobotId, found)
    return [found.value]


def SetEMotor(api, dobotId, index, isEnabled, speed, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEMotor", dobotId, EMotor(index, isEnabled, speed), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetEMotorS(api, dobotId, index, isEnabled, speed, distance, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEMotorS", dobotId, EMotorS(index, isEnabled, speed, distance), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- Sensors ---------------------------------------------------------------------------------------------------------


def SetColorSensor(api, dobotId, isEnable, colorPort):
    _call(api, "SetColorSensor", dobotId, _byte(isEnable), colorPort)


def GetColorSensor(api, dobotId):
    r = c_uint8()
    g = c_uint8()
    b = c_uint8()
    _call(api, "GetColorSensor", dobotId, r, g, b)
    return [r.value, g.value, b.value]


def SetInfraredSensor(api, dobotId, isEnable, infraredPort):
    _call(api, "SetInfraredSensor", dobotId, _byte(isEnable), infraredPort)


def GetInfraredSensor(api, dobotId, infraredPort):
    found = c_uint8()
    _call(api, "GetInfraredSensor", dobotId, infraredPort, found)
    return [found.value]


# --- Calibration -----------------------------------------------------------------------------------------------------


def SetAngleSensorStaticError(api, dobotId, rearArmAngleError, frontArmAngleError):
    _call(api, "SetAngleSensorStaticError", dobotId, rearArmAngleError, frontArmAngleError)


def GetAngleSensorStaticError(api, dobotId):
    rear = c_float()
    front = c_float()
    _call(api, "GetAngleSensorStaticError", dobotId, rear, front)
    return [rear.value, front.value]


def SetAngleSensorCoef(api, dobotId, rearArmAngleCoef, frontArmAngleCoef):
    _call(api, "SetAngleSensorCoef", dobotId, rearArmAngleCoef, frontArmAngleCoef)


def GetAngleSensorCoef(api, dobotId):
    rear = c_float()
    front = c_float()
    _call(api, "GetAngleSensorCoef", dobotId, rear, front)
    return [rear.value, front.value]


def SetBaseDecoderStaticError(api, dobotId, baseDecoderError):
    _call(api, "SetBaseDecoderStaticError", dobotId, baseDecoderError)


def GetBaseDecoderStaticError(api, dobotId):
    found = c_float()
    _call(api, "GetBaseDecoderStaticError", dobotId, found)
    return [found.value]


def SetLRHandCalibrateValue(api, dobotId, lrHandCalibrateValue):
    _call(api, "SetLRHandCalibrateValue", dobotId, lrHandCalibrateValue)


def GetLRHandCalibrateValue(api, dobotId):
    found = c_float()
    _call(api, "GetLRHandCalibrateValue", dobotId, found)
    return [found.value]


# --- Wi-Fi -----------------------------------------------------------------------------------------------------------


def GetWIFIConnectStatus(api, dobotId):
    found = c_uint8()
    _call(api, "GetWIFIConnectStatus", dobotId, found)
    return [bool(found.value)]


def SetWIFIConfigMode(api, dobotId, enable):
    _call(api, "SetWIFIConfigMode", dobotId, _byte(enable))


def GetWIFIConfigMode(api, dobotId):
    found = c_uint8()
    _call(api, "GetWIFIConfigMode", dobotId, found)
    return [bool(found.value)]


def SetWIFISSID(api, dobotId, ssid):
    _call(api, "SetWIFISSID", dobotId, _text(ssid))


def GetWIFISSID(api, dobotId):
    found = create_string_buffer(100)
    _call(api, "GetWIFISSID", dobotId, found, 100)
    return [_string(found)]


def SetWIFIPassword(api, dobotId, password):
    _call(api, "SetWIFIPassword", dobotId, _text(password))


def GetWIFIPassword(api, dobotId):
    found = create_string_buffer(100)
    _call(api, "GetWIFIPassword", dobotId, found, 100)
    return [_string(found)]


def SetWIFIIPAddress(api, dobotId, dhcp, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFIIPAddress", dobotId, WIFIIPAddress(dhcp, addr1, addr2, addr3, addr4))


def GetWIFIIPAddress(api, dobotId):
    found = WIFIIPAddress()
    _call(api, "GetWIFIIPAddress", dobotId, found)
    return [found.dhcp, found.addr1, found.addr2, found.addr3, found.addr4]


def SetWIFINetmask(api, dobotId, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFINetmask", dobotId, WIFINetmask(addr1, addr2, addr3, addr4))


def GetWIFINetmask(api, dobotId):
    found = WIFINetmask()
    _call(api, "GetWIFINetmask", dobotId, found)
    return [found.addr1, found.addr2, found.addr3, found.addr4]


def SetWIFIGateway(api, dobotId, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFIGateway", dobotId, WIFIGateway(addr1, addr2, addr3, addr4))


def GetWIFIGateway(api, dobotId):
    found = WIFIGateway()
    _call(api, "GetWIFIGateway", dobotId, found)
    return [found.addr1, found.addr2, found.addr3, found.addr4]


def SetWIFIDNS(api, dobotId, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFIDNS", dobotId, WIFIDNS(addr1, addr2, addr3, addr4))


def GetWIFIDNS(api, dobotId):
    found = WIFIDNS()
    _call(api, "GetWIFIDNS", dobotId, found)
    return [found.addr1, found.addr2, found.addr3, found.addr4]


# --- Firmware --------------------------------------------------------------------------------------------------------


def UpdateFirmware(api, dobotId, mode):
    _call(api, "UpdateFirmware", dobotId, FirmwareParams(mode))


def SetFirmwareMode(api, dobotId, mode, ctl=0):
    _call(api, "SetFirmwareMode", dobotId, FirmwareMode(mode, ctl))


def GetFirmwareMode(api, dobotId):
    found = FirmwareMode()
    _call(api, "GetFirmwareMode", dobotId, found)
    return [found.mode, found.ctl]


# --- Lost steps ------------------------------------------------------------------------------------------------------


def SetLostStepParams(api, dobotId, threshold):
    _call(api, "SetLostStepParams", dobotId, threshold)


def SetLostStepCmd(api, dobotId, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetLostStepCmd", dobotId, _byte(isQueued), queuedCmdIndex)
    _expect(api, (dobotId,), queuedCmdIndex.value, HOMING)
    return [queuedCmdIndex.value]


# --- What this arm has not -------------------------------------------------------------------------------------------


def GetServoPIDParams(api, dobotId, index, controlLoop):
    found = PID(index, controlLoop)
    _call(api, "GetServoPIDParams", dobotId, found)
    return [found.p, found.i, found.d, found.v, found.a]


def SetServoPIDParams(api, dobotId, pid, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetServoPIDParams", dobotId, _filled(PID, pid), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetServoControlLoop(api, dobotId, index):
    found = c_uint8()
    _call(api, "GetServoControlLoop", dobotId, _byte(index), found)
    return [found.value]


def SetServoControlLoop(api, dobotId, p_index, controlLoop, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetServoControlLoop", dobotId, _byte(p_index), _byte(controlLoop), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SaveServoPIDParams(api, dobotId, p_index, controlLoop, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SaveServoPIDParams", dobotId, _byte(p_index), _byte(controlLoop), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- And wait --------------------------------------------------------------------------------------------------------


def SetHOMECmdEx(api, dobotId, temp, isQueued=0):
    queued = SetHOMECmd(api, dobotId, temp, isQueued)[0]
    _finish(api, (dobotId,), "SetHOMECmdEx", queued)


def SetEndEffectorParamsEx(api, dobotId, xBias, yBias, zBias, isQueued=0):
    queued = SetEndEffectorParams(api, dobotId, xBias, yBias, zBias, isQueued)[0]
    _finish(api, (dobotId,), "SetEndEffectorParamsEx", queued)


def SetPTPJointParamsEx(
        api, dobotId, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued=0
):
    queued = SetPTPJointParams(
        api, dobotId, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued
    )[0]
    _finish(api, (dobotId,), "SetPTPJointParamsEx", queued)


def SetPTPLParamsEx(api, dobotId, lVelocity, lAcceleration, isQueued=0):
    queued = SetPTPLParams(api, dobotId, lVelocity, lAcceleration, isQueued)[0]
    _finish(api, (dobotId,), "SetPTPLParamsEx", queued)


def SetPTPCommonParamsEx(api, dobotId, velocityRatio, accelerationRatio, isQueued=0):
    queued = SetPTPCommonParams(api, dobotId, velocityRatio, accelerationRatio, isQueued)[0]
    _finish(api, (dobotId,), "SetPTPCommonParamsEx", queued)


def SetPTPJumpParamsEx(api, dobotId, jumpHeight, maxJumpHeight, isQueued=0):
    queued = SetPTPJumpParams(api, dobotId, jumpHeight, maxJumpHeight, isQueued)[0]
    _finish(api, (dobotId,), "SetPTPJumpParamsEx", queued)


def SetPTPCmdEx(api, dobotId, ptpMode, x, y, z, rHead, isQueued=0):
    queued = SetPTPCmd(api, dobotId, ptpMode, x, y, z, rHead, isQueued)[0]
    _finish(api, (dobotId,), "SetPTPCmdEx", queued)


def SetPTPWithLCmdEx(api, dobotId, ptpMode, x, y, z, rHead, l, isQueued=0):
    queued = SetPTPWithLCmd(api, dobotId, ptpMode, x, y, z, rHead, l, isQueued)[0]
    _finish(api, (dobotId,), "SetPTPWithLCmdEx", queued)


def SetIOMultiplexingEx(api, dobotId, address, multiplex, isQueued=0):
    queued = SetIOMultiplexing(api, dobotId, address, multiplex, isQueued)[0]
    _finish(api, (dobotId,), "SetIOMultiplexingEx", queued)


def SetIODOEx(api, dobotId, address, level, isQueued=0):
    queued = SetIODO(api, dobotId, address, level, isQueued)[0]
    _finish(api, (dobotId,), "SetIODOEx", queued)


def SetIOPWMEx(api, dobotId, address, frequency, dutyCycle, isQueued=0):
    queued = SetIOPWM(api, dobotId, address, frequency, dutyCycle, isQueued)[0]
    _finish(api, (dobotId,), "SetIOPWMEx", queued)


def SetEMotorEx(api, dobotId, index, isEnabled, speed, isQueued=0):
    queued = SetEMotor(api, dobotId, index, isEnabled, speed, isQueued)[0]
    _finish(api, (dobotId,), "SetEMotorEx", queued)


def SetEMotorSEx(api, dobotId, index, isEnabled, speed, distance, isQueued=0):
    queued = SetEMotorS(api, dobotId, index, isEnabled, speed, distance, isQueued)[0]
    _finish(api, (dobotId,), "SetEMotorSEx", queued)


def SetEndEffectorSuctionCupEx(api, dobotId, enableCtrl, on, isQueued=0):
    queued = SetEndEffectorSuctionCup(api, dobotId, enableCtrl, on, isQueued)[0]
    _finish(api, (dobotId,), "SetEndEffectorSuctionCupEx", queued)


def SetEndEffectorGripperEx(api, dobotId, enableCtrl, on, isQueued=0):
    queued = SetEndEffectorGripper(api, dobotId, enableCtrl, on, isQueued)[0]
    _finish(api, (dobotId,), "SetEndEffectorGripperEx", queued)


def SetAutoLevelingCmdEx(api, dobotId, controlFlag, precision, isQueued=1):
    queued = SetAutoLevelingCmd(api, dobotId, controlFlag, precision, isQueued)[0]
    _finish(api, (dobotId,), "SetAutoLevelingCmdEx", queued)


def SetLostStepCmdEx(api, dobotId, isQueued=1):
    queued = SetLostStepCmd(api, dobotId, isQueued)[0]
    _finish(api, (dobotId,), "SetLostStepCmdEx", queued)


def SetWAITCmdEx(api, dobotId, waitTime, isQueued=0):
    """Sleeps here; waitTime: seconds."""
    dSleep(waitTime * 1000)


def GetPoseEx(api, dobotId, index):
    """One number of the pose: 1 to 8 as in GetPose, 0 is the position on the rail."""
    if index == 0:
        if not GetDeviceWithL(api, dobotId)[0]:
            print("the arm is not on a rail")
            return None
        return round(GetPoseL(api, dobotId)[0], 4)
    return round(GetPose(api, dobotId)[index - 1], 4)


def GetColorSensorEx(api, dobotId, index):
    """One of red, green and blue."""
    return GetColorSensor(api, dobotId)[index]


def SetEndEffectorLaserEx(api, dobotId, enableCtrl, power, isQueued=0):
    """The laser on the outputs 2 and 4: switched, and its power (0 to 100)."""
    SetIOMultiplexingEx(api, dobotId, 2, 1, isQueued)
    SetIOMultiplexingEx(api, dobotId, 4, 2, isQueued)
    SetIODOEx(api, dobotId, 2, enableCtrl, isQueued)
    SetIOPWMEx(api, dobotId, 4, 10000, power, isQueued)


# --- Prototypes ------------------------------------------------------------------------------------------------------

# The arguments of the C functions; all return an int.
_PROTOTYPES = {
    "SearchDobot": (c_char_p, c_uint32),
    "DobotExec": (),
    "PeriodicTask": (),
    "MagicianLastError": (c_char_p, c_uint32),
    "MagicianAllow": (c_char_p,),
    "ConnectDobot": (c_char_p, c_uint32, c_char_p, c_char_p, POINTER(c_int32)),
    "DisconnectDobot": (c_int32,),
    "SetCmdTimeout": (c_int32, c_uint32),
    "GetQueuedCmdCurrentIndex": (c_int32, POINTER(c_uint64)),
    "SetQueuedCmdStartExec": (c_int32,),
    "SetQueuedCmdStopExec": (c_int32,),
    "SetQueuedCmdForceStopExec": (c_int32,),
    "SetQueuedCmdStartDownload": (c_int32, c_uint32, c_uint32),
    "SetQueuedCmdStopDownload": (c_int32,),
    "SetQueuedCmdClear": (c_int32,),
    "SetDeviceSN": (c_int32, c_char_p),
    "GetDeviceSN": (c_int32, c_char_p, c_uint32),
    "SetDeviceName": (c_int32, c_char_p),
    "GetDeviceName": (c_int32, c_char_p, c_uint32),
    "GetDeviceVersion": (c_int32, POINTER(c_uint8), POINTER(c_uint8), POINTER(c_uint8)),
    "SetDeviceWithL": (c_int32, c_uint8),
    "GetDeviceWithL": (c_int32, POINTER(c_uint8)),
    "GetDeviceTime": (c_int32, POINTER(c_uint32)),
    "GetUserParams": (c_int32, POINTER(UserParams)),
    "GetPose": (c_int32, POINTER(Pose)),
    "GetPoseL": (c_int32, POINTER(c_float)),
    "ResetPose": (c_int32, c_uint8, c_float, c_float),
    "GetKinematics": (c_int32, POINTER(Kinematics)),
    "GetAlarmsState": (c_int32, c_char_p, POINTER(c_uint32), c_uint32),
    "ClearAllAlarmsState": (c_int32,),
    "SetHOMEParams": (c_int32, POINTER(HOMEParams), c_uint8, POINTER(c_uint64)),
    "GetHOMEParams": (c_int32, POINTER(HOMEParams)),
    "SetHOMECmd": (c_int32, POINTER(HOMECmd), c_uint8, POINTER(c_uint64)),
    "SetAutoLevelingCmd": (c_int32, POINTER(AutoLevelingCmd), c_uint8, POINTER(c_uint64)),
    "GetAutoLevelingResult": (c_int32, POINTER(c_float)),
    "SetArmOrientation": (c_int32, c_int32, c_uint8, POINTER(c_uint64)),
    "GetArmOrientation": (c_int32, POINTER(c_int32)),
    "SetHHTTrigMode": (c_int32, c_int32),
    "GetHHTTrigMode": (c_int32, POINTER(c_int32)),
    "SetHHTTrigOutputEnabled": (c_int32, c_uint8),
    "GetHHTTrigOutputEnabled": (c_int32, POINTER(c_uint8)),
    "GetHHTTrigOutput": (c_int32, POINTER(c_uint8)),
    "SetEndEffectorParams": (c_int32, POINTER(EndTypeParams), c_uint8, POINTER(c_uint64)),
    "GetEndEffectorParams": (c_int32, POINTER(EndTypeParams)),
    "SetEndEffectorLaser": (c_int32, c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "GetEndEffectorLaser": (c_int32, POINTER(c_uint8), POINTER(c_uint8)),
    "SetEndEffectorSuctionCup": (c_int32, c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "GetEndEffectorSuctionCup": (c_int32, POINTER(c_uint8), POINTER(c_uint8)),
    "SetEndEffectorGripper": (c_int32, c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "GetEndEffectorGripper": (c_int32, POINTER(c_uint8), POINTER(c_uint8)),
    "SetJOGJointParams": (c_int32, POINTER(JOGJointParams), c_uint8, POINTER(c_uint64)),
    "GetJOGJointParams": (c_int32, POINTER(JOGJointParams)),
    "SetJOGCoordinateParams": (c_int32, POINTER(JOGCoordinateParams), c_uint8, POINTER(c_uint64)),
    "GetJOGCoordinateParams": (c_int32, POINTER(JOGCoordinateParams)),
    "SetJOGLParams": (c_int32, POINTER(JOGLParams), c_uint8, POINTER(c_uint64)),
    "GetJOGLParams": (c_int32, POINTER(JOGLParams)),
    "SetJOGCommonParams": (c_int32, POINTER(JOGCommonParams), c_uint8, POINTER(c_uint64)),
    "GetJOGCommonParams": (c_int32, POINTER(JOGCommonParams)),
    "SetJOGCmd": (c_int32, POINTER(JOGCmd), c_uint8, POINTER(c_uint64)),
    "SetPTPJointParams": (c_int32, POINTER(PTPJointParams), c_uint8, POINTER(c_uint64)),
    "GetPTPJointParams": (c_int32, POINTER(PTPJointParams)),
    "SetPTPCoordinateParams": (c_int32, POINTER(PTPCoordinateParams), c_uint8, POINTER(c_uint64)),
    "GetPTPCoordinateParams": (c_int32, POINTER(PTPCoordinateParams)),
    "SetPTPLParams": (c_int32, POINTER(PTPLParams), c_uint8, POINTER(c_uint64)),
    "GetPTPLParams": (c_int32, POINTER(PTPLParams)),
    "SetPTPJumpParams": (c_int32, POINTER(PTPJumpParams), c_uint8, POINTER(c_uint64)),
    "GetPTPJumpParams": (c_int32, POINTER(PTPJumpParams)),
    "SetPTPJump2Params": (c_int32, POINTER(PTPJump2Params), c_uint8, POINTER(c_uint64)),
    "GetPTPJump2Params": (c_int32, POINTER(PTPJump2Params)),
    "SetPTPCommonParams": (c_int32, POINTER(PTPCommonParams), c_uint8, POINTER(c_uint64)),
    "GetPTPCommonParams": (c_int32, POINTER(PTPCommonParams)),
    "SetPTPCmd": (c_int32, POINTER(PTPCmd), c_uint8, POINTER(c_uint64)),
    "SetPTPWithLCmd": (c_int32, POINTER(PTPWithLCmd), c_uint8, POINTER(c_uint64)),
    "SetPTPPOCmd": (c_int32, POINTER(PTPCmd), POINTER(ParallelOutputCmd), c_int32, c_uint8, POINTER(c_uint64)),
    "SetPTPPOWithLCmd": (
        c_int32, POINTER(PTPWithLCmd), POINTER(ParallelOutputCmd), c_int32, c_uint8, POINTER(c_uint64)
    ),
    "GetPTPTime": (c_int32, POINTER(PTPCmd), POINTER(c_uint32)),
    "SetCPParams": (c_int32, POINTER(CPParams), c_uint8, POINTER(c_uint64)),
    "GetCPParams": (c_int32, POINTER(CPParams)),
    "SetCPCmd": (c_int32, POINTER(CPCmd), c_uint8, POINTER(c_uint64)),
    "SetCPLECmd": (c_int32, POINTER(CPCmd), c_uint8, POINTER(c_uint64)),
    "SetARCParams": (c_int32, POINTER(ARCParams), c_uint8, POINTER(c_uint64)),
    "GetARCParams": (c_int32, POINTER(ARCParams)),
    "SetARCCmd": (c_int32, POINTER(ARCCmd), c_uint8, POINTER(c_uint64)),
    "SetCircleCmd": (c_int32, POINTER(CircleCmd), c_uint8, POINTER(c_uint64)),
    "SetWAITCmd": (c_int32, POINTER(WAITCmd), c_uint8, POINTER(c_uint64)),
    "SetTRIGCmd": (c_int32, POINTER(TRIGCmd), c_uint8, POINTER(c_uint64)),
    "SetIOMultiplexing": (c_int32, POINTER(IOMultiplexing), c_uint8, POINTER(c_uint64)),
    "SetIODO": (c_int32, POINTER(IODO), c_uint8, POINTER(c_uint64)),
    "SetIOPWM": (c_int32, POINTER(IOPWM), c_uint8, POINTER(c_uint64)),
    "GetIOMultiplexing": (c_int32, POINTER(IOMultiplexing)),
    "GetIODO": (c_int32, POINTER(IODO)),
    "GetIOPWM": (c_int32, POINTER(IOPWM)),
    "GetIODI": (c_int32, POINTER(IODI)),
    "GetIOADC": (c_int32, POINTER(IOADC)),
    "SetEMotor": (c_int32, POINTER(EMotor), c_uint8, POINTER(c_uint64)),
    "SetEMotorS": (c_int32, POINTER(EMotorS), c_uint8, POINTER(c_uint64)),
    "SetColorSensor": (c_int32, c_uint8, c_int32),
    "GetColorSensor": (c_int32, POINTER(c_uint8), POINTER(c_uint8), POINTER(c_uint8)),
    "SetInfraredSensor": (c_int32, c_uint8, c_int32),
    "GetInfraredSensor": (c_int32, c_int32, POINTER(c_uint8)),
    "SetAngleSensorStaticError": (c_int32, c_float, c_float),
    "GetAngleSensorStaticError": (c_int32, POINTER(c_float), POINTER(c_float)),
    "SetAngleSensorCoef": (c_int32, c_float, c_float),
    "GetAngleSensorCoef": (c_int32, POINTER(c_float), POINTER(c_float)),
    "SetBaseDecoderStaticError": (c_int32, c_float),
    "GetBaseDecoderStaticError": (c_int32, POINTER(c_float)),
    "SetLRHandCalibrateValue": (c_int32, c_float),
    "GetLRHandCalibrateValue": (c_int32, POINTER(c_float)),
    "GetWIFIConnectStatus": (c_int32, POINTER(c_uint8)),
    "SetWIFIConfigMode": (c_int32, c_uint8),
    "GetWIFIConfigMode": (c_int32, POINTER(c_uint8)),
    "SetWIFISSID": (c_int32, c_char_p),
    "GetWIFISSID": (c_int32, c_char_p, c_uint32),
    "SetWIFIPassword": (c_int32, c_char_p),
    "GetWIFIPassword": (c_int32, c_char_p, c_uint32),
    "SetWIFIIPAddress": (c_int32, POINTER(WIFIIPAddress)),
    "GetWIFIIPAddress": (c_int32, POINTER(WIFIIPAddress)),
    "SetWIFINetmask": (c_int32, POINTER(WIFINetmask)),
    "GetWIFINetmask": (c_int32, POINTER(WIFINetmask)),
    "SetWIFIGateway": (c_int32, POINTER(WIFIGateway)),
    "GetWIFIGateway": (c_int32, POINTER(WIFIGateway)),
    "SetWIFIDNS": (c_int32, POINTER(WIFIDNS)),
    "GetWIFIDNS": (c_int32, POINTER(WIFIDNS)),
    "UpdateFirmware": (c_int32, POINTER(FirmwareParams)),
    "SetFirmwareMode": (c_int32, POINTER(FirmwareMode)),
    "GetFirmwareMode": (c_int32, POINTER(FirmwareMode)),
    "SetLostStepParams": (c_int32, c_float),
    "SetLostStepCmd": (c_int32, c_uint8, POINTER(c_uint64)),
    "GetServoPIDParams": (c_int32, POINTER(PID)),
    "SetServoPIDParams": (c_int32, POINTER(PID), c_uint8, POINTER(c_uint64)),
    "GetServoControlLoop": (c_int32, c_uint8, POINTER(c_uint8)),
    "SetServoControlLoop": (c_int32, c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "SaveServoPIDParams": (c_int32, c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
}
