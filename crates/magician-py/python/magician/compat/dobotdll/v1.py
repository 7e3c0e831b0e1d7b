"""DobotDllType for one arm, no ids (the DobotDemo of 2016 to 2020): family v1 of the DobotDll interface.

    import DobotDllType as dType

    api = dType.load()
    if dType.ConnectDobot(api, "", 115200)[0] == dType.DobotConnect.DobotConnect_NoError:
        print(dType.GetPose(api))

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

_FAMILY = "v1"
# How many ids the functions begin with.
_IDS = 0

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


class UART4PeripheralsType:
    UART4PeripheralsUART = 0
    UART4PeripheralsWIFI = 1
    UART4PeripheralsBLE = 2
    UART4PeripheralsCH375 = 3


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


class DeviceCountInfo(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("deviceRunTime", c_uint64),
        ("devicePowerOn", c_uint32),
        ("devicePowerOff", c_uint32),
    ]


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
        ("deltaPulse", c_uint32),
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


class CPCommonParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocityRatio", c_float),
        ("accelerationRatio", c_float),
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


class ARCCommonParams(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("velocityRatio", c_float),
        ("accelerationRatio", c_float),
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


class PluseCmd(Structure):
    _layout_, _pack_ = "ms", 1
    _fields_ = [
        ("j1", c_float),
        ("j2", c_float),
        ("j3", c_float),
        ("j4", c_float),
        ("e1", c_float),
        ("e2", c_float),
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
    return time.time()


def ConnectDobot(api, portName="", baudrate=115200):
    """[result, firmware, version]; result is one of DobotConnect."""
    firmware, version = create_string_buffer(100), create_string_buffer(100)
    result = _try(api, "ConnectDobot", _text(portName), baudrate, firmware, version)
    return [result, _string(firmware), _string(version)]


def DisconnectDobot(api):
    _try(api, "DisconnectDobot")


def SetCmdTimeout(api, times):
    """Milliseconds, for every arm."""
    _try(api, "SetCmdTimeout", times)


def DobotExec(api):
    return _try(api, "DobotExec")


def PeriodicTask(api):
    _try(api, "PeriodicTask")


def SetDebugEnable(api, flag=False):
    _try(api, "SetDebugEnable", _byte(flag))


# --- Queue -----------------------------------------------------------------------------------------------------------


def GetQueuedCmdCurrentIndex(api):
    found = c_uint64()
    _call(api, "GetQueuedCmdCurrentIndex", found)
    _waited(api, (), found.value)
    return [found.value]


def GetQueuedCmdMotionFinish(api):
    found = c_uint8()
    _call(api, "GetQueuedCmdMotionFinish", found)
    return [bool(found.value)]


def SetQueuedCmdStartExec(api):
    _call(api, "SetQueuedCmdStartExec")


def SetQueuedCmdStopExec(api):
    _call(api, "SetQueuedCmdStopExec")


def SetQueuedCmdForceStopExec(api):
    _call(api, "SetQueuedCmdForceStopExec")


def SetQueuedCmdStartDownload(api, totalLoop, linePerLoop):
    _call(api, "SetQueuedCmdStartDownload", totalLoop, linePerLoop)


def SetQueuedCmdStopDownload(api):
    _call(api, "SetQueuedCmdStopDownload")


def SetQueuedCmdClear(api):
    _call(api, "SetQueuedCmdClear")
    return DobotCommunicate.DobotCommunicate_NoError


# --- Device ----------------------------------------------------------------------------------------------------------


def SetDeviceSN(api, str):
    _call(api, "SetDeviceSN", _text(str))


def GetDeviceSN(api):
    found = create_string_buffer(64)
    _call(api, "GetDeviceSN", found, 64)
    return _string(found)


def SetDeviceName(api, str):
    _call(api, "SetDeviceName", _text(str))


def GetDeviceName(api):
    found = create_string_buffer(100)
    _call(api, "GetDeviceName", found, 100)
    return _string(found)


def GetDeviceVersion(api):
    major = c_uint8()
    minor = c_uint8()
    revision = c_uint8()
    _call(api, "GetDeviceVersion", major, minor, revision)
    return [major.value, minor.value, revision.value]


def SetDeviceWithL(api, isWithL, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetDeviceWithL", _byte(isWithL), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetDeviceWithL(api):
    found = c_uint8()
    _call(api, "GetDeviceWithL", found)
    return bool(found.value)


def GetDeviceTime(api):
    found = c_uint32()
    _call(api, "GetDeviceTime", found)
    return [found.value]


def GetDeviceInfo(api):
    found = DeviceCountInfo()
    _call(api, "GetDeviceInfo", found)
    return [found.deviceRunTime, found.devicePowerOn, found.devicePowerOff]


def GetMarlinVersion(api):
    _call(api, "GetMarlinVersion")


def GetUserParams(api):
    found = UserParams()
    _call(api, "GetUserParams", found)
    return [
        found.params1, found.params2, found.params3, found.params4, found.params5, found.params6, found.params7,
        found.params8
    ]


# --- Pose and alarms -------------------------------------------------------------------------------------------------


def GetPose(api):
    pose = Pose()
    _call(api, "GetPose", pose)
    return [pose.x, pose.y, pose.z, pose.rHead, pose.joint1Angle, pose.joint2Angle, pose.joint3Angle, pose.joint4Angle]


def GetPoseL(api):
    found = c_float()
    _call(api, "GetPoseL", found)
    return [found.value]


def ResetPose(api, manual, rearArmAngle, frontArmAngle):
    _call(api, "ResetPose", _byte(manual), rearArmAngle, frontArmAngle)


def GetKinematics(api):
    found = Kinematics()
    _call(api, "GetKinematics", found)
    return [found.velocity, found.acceleration]


def GetAlarmsState(api, maxLen=1000):
    alarmsState, length = create_string_buffer(maxLen), c_uint32(0)
    _call(api, "GetAlarmsState", alarmsState, length, maxLen)
    return [alarmsState.raw, length.value]


def ClearAllAlarmsState(api):
    _call(api, "ClearAllAlarmsState")


# --- Homing and levelling --------------------------------------------------------------------------------------------


def SetHOMEParams(api, x, y, z, r, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetHOMEParams", HOMEParams(x, y, z, r), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetHOMEParams(api):
    found = HOMEParams()
    _call(api, "GetHOMEParams", found)
    return [found.x, found.y, found.z, found.r]


def SetHOMECmd(api, temp, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetHOMECmd", HOMECmd(temp), _byte(isQueued), queuedCmdIndex)
    _expect(api, (), queuedCmdIndex.value, HOMING)
    return [queuedCmdIndex.value]


def SetAutoLevelingCmd(api, controlFlag, precision, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetAutoLevelingCmd", AutoLevelingCmd(controlFlag, precision), _byte(isQueued), queuedCmdIndex)
    _expect(api, (), queuedCmdIndex.value, HOMING)
    return [queuedCmdIndex.value]


def GetAutoLevelingResult(api):
    found = c_float()
    _call(api, "GetAutoLevelingResult", found)
    return [found.value]


def SetArmOrientation(api, armOrientation, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetArmOrientation", armOrientation, _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetArmOrientation(api):
    found = c_int32()
    _call(api, "GetArmOrientation", found)
    return [found.value]


# --- Hand-hold teaching ----------------------------------------------------------------------------------------------


def SetHHTTrigMode(api, hhtTrigMode):
    _call(api, "SetHHTTrigMode", hhtTrigMode)


def GetHHTTrigMode(api):
    found = c_int32()
    _call(api, "GetHHTTrigMode", found)
    return [found.value]


def SetHHTTrigOutputEnabled(api, isEnabled):
    _call(api, "SetHHTTrigOutputEnabled", _byte(isEnabled))


def GetHHTTrigOutputEnabled(api):
    found = c_uint8()
    _call(api, "GetHHTTrigOutputEnabled", found)
    return [found.value]


def GetHHTTrigOutput(api):
    found = c_uint8()
    _call(api, "GetHHTTrigOutput", found)
    return bool(found.value)


# --- End effector ----------------------------------------------------------------------------------------------------


def SetEndEffectorParams(api, xBias, yBias, zBias, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorParams", EndTypeParams(xBias, yBias, zBias), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorParams(api):
    found = EndTypeParams()
    _call(api, "GetEndEffectorParams", found)
    return [found.xBias, found.yBias, found.zBias]


def SetEndEffectorLaser(api, enableCtrl, on, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorLaser", _byte(enableCtrl), _byte(on), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorLaser(api):
    isCtrlEnabled = c_uint8()
    isOn = c_uint8()
    _call(api, "GetEndEffectorLaser", isCtrlEnabled, isOn)
    return [isCtrlEnabled.value, isOn.value]


def SetEndEffectorSuctionCup(api, enableCtrl, on, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorSuctionCup", _byte(enableCtrl), _byte(on), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorSuctionCup(api):
    isCtrlEnabled = c_uint8()
    isOn = c_uint8()
    _call(api, "GetEndEffectorSuctionCup", isCtrlEnabled, isOn)
    return [isOn.value]


def SetEndEffectorGripper(api, enableCtrl, on, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEndEffectorGripper", _byte(enableCtrl), _byte(on), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetEndEffectorGripper(api):
    isCtrlEnabled = c_uint8()
    isOn = c_uint8()
    _call(api, "GetEndEffectorGripper", isCtrlEnabled, isOn)
    return [isOn.value]


# --- Jog -------------------------------------------------------------------------------------------------------------


def SetJOGJointParams(
        api, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued=0
):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetJOGJointParams", JOGJointParams(j1Velocity, j2Velocity, j3Velocity, j4Velocity, j1Acceleration,
        j2Acceleration, j3Acceleration, j4Acceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetJOGJointParams(api):
    found = JOGJointParams()
    _call(api, "GetJOGJointParams", found)
    return [
        found.joint1Velocity, found.joint1Acceleration, found.joint2Velocity, found.joint2Acceleration,
        found.joint3Velocity, found.joint3Acceleration, found.joint4Velocity, found.joint4Acceleration
    ]


def SetJOGCoordinateParams(
        api, xVelocity, xAcceleration, yVelocity, yAcceleration, zVelocity, zAcceleration, rVelocity, rAcceleration,
        isQueued=0
):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetJOGCoordinateParams", JOGCoordinateParams(xVelocity, yVelocity, zVelocity, rVelocity, xAcceleration,
        yAcceleration, zAcceleration, rAcceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetJOGCoordinateParams(api):
    found = JOGCoordinateParams()
    _call(api, "GetJOGCoordinateParams", found)
    return [
        found.xVelocity, found.xAcceleration, found.yVelocity, found.yAcceleration, found.zVelocity,
        found.zAcceleration, found.rVelocity, found.rAcceleration
    ]


def SetJOGLParams(api, velocity, acceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetJOGLParams", JOGLParams(velocity, acceleration), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetJOGLParams(api):
    found = JOGLParams()
    _call(api, "GetJOGLParams", found)
    return [found.velocity, found.acceleration]


def SetJOGCommonParams(api, value_velocityratio, value_accelerationratio, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetJOGCommonParams", JOGCommonParams(value_velocityratio, value_accelerationratio), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetJOGCommonParams(api):
    found = JOGCommonParams()
    _call(api, "GetJOGCommonParams", found)
    return [found.velocityRatio, found.accelerationRatio]


def SetJOGCmd(api, isJoint, cmd, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetJOGCmd", JOGCmd(isJoint, cmd), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- Point to point --------------------------------------------------------------------------------------------------


def SetPTPJointParams(
        api, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued=0
):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPJointParams", PTPJointParams(j1Velocity, j2Velocity, j3Velocity, j4Velocity, j1Acceleration,
        j2Acceleration, j3Acceleration, j4Acceleration), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPJointParams(api):
    found = PTPJointParams()
    _call(api, "GetPTPJointParams", found)
    return [
        found.joint1Velocity, found.joint1Acceleration, found.joint2Velocity, found.joint2Acceleration,
        found.joint3Velocity, found.joint3Acceleration, found.joint4Velocity, found.joint4Acceleration
    ]


def SetPTPCoordinateParams(api, xyzVelocity, xyzAcceleration, rVelocity, rAcceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPCoordinateParams", PTPCoordinateParams(xyzVelocity, rVelocity, xyzAcceleration, rAcceleration),
        _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPCoordinateParams(api):
    found = PTPCoordinateParams()
    _call(api, "GetPTPCoordinateParams", found)
    return [found.xyzVelocity, found.rVelocity, found.xyzAcceleration, found.rAcceleration]


def SetPTPLParams(api, velocity, acceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPLParams", PTPLParams(velocity, acceleration), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetPTPLParams(api):
    found = PTPLParams()
    _call(api, "GetPTPLParams", found)
    return [found.velocity, found.acceleration]


def SetPTPJumpParams(api, jumpHeight, zLimit, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPJumpParams", PTPJumpParams(jumpHeight, zLimit), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetPTPJumpParams(api):
    found = PTPJumpParams()
    _call(api, "GetPTPJumpParams", found)
    return [found.jumpHeight, found.zLimit]


def SetPTPJump2Params(api, startJumpHeight, endJumpHeight, zLimit, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPJump2Params", PTPJump2Params(startJumpHeight, endJumpHeight, zLimit), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPJump2Params(api):
    found = PTPJump2Params()
    _call(api, "GetPTPJump2Params", found)
    return [found.startJumpHeight, found.endJumpHeight, found.zLimit]


def SetPTPCommonParams(api, velocityRatio, accelerationRatio, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPCommonParams", PTPCommonParams(velocityRatio, accelerationRatio), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetPTPCommonParams(api):
    found = PTPCommonParams()
    _call(api, "GetPTPCommonParams", found)
    return [found.velocityRatio, found.accelerationRatio]


def SetPTPCmd(api, ptpMode, x, y, z, rHead, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPCmd", PTPCmd(ptpMode, x, y, z, rHead), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetPTPWithLCmd(api, ptpMode, x, y, z, rHead, l, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPWithLCmd", PTPWithLCmd(ptpMode, x, y, z, rHead, l), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetPTPPOCmd(api, ptpMode, x, y, z, rHead, parallelCmd, isQueued=0):
    """parallelCmd: (ratio, address, level) of every output on the way."""
    outputs, count = _outputs(parallelCmd)
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetPTPPOCmd", PTPCmd(ptpMode, x, y, z, rHead), outputs, count, _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetPTPPOWithLCmd(api, ptpMode, x, y, z, rHead, l, parallelCmd, isQueued=0):
    """parallelCmd: (ratio, address, level) of every output on the way."""
    outputs, count = _outputs(parallelCmd)
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetPTPPOWithLCmd", PTPWithLCmd(ptpMode, x, y, z, rHead, l), outputs, count, _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetPTPTime(api, ptpMode, x, y, z, rHead):
    found = c_uint32()
    _call(api, "GetPTPTime", PTPCmd(ptpMode, x, y, z, rHead), found)
    return [found.value]


# --- Continuous path -------------------------------------------------------------------------------------------------


def SetCPParams(api, planAcc, juncitionVel, acc, realTimeTrack=0, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetCPParams", CPParams(planAcc, juncitionVel, acc, realTimeTrack), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetCPParams(api):
    found = CPParams()
    _call(api, "GetCPParams", found)
    return [found.planAcc, found.juncitionVel, found.acc]


def SetCPCmd(api, cpMode, x, y, z, velocity, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetCPCmd", CPCmd(cpMode, x, y, z, velocity), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetCPLECmd(api, cpMode, x, y, z, power, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetCPLECmd", CPCmd(cpMode, x, y, z, power), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetCPRHoldEnable(api, isEnable):
    _call(api, "SetCPRHoldEnable", _byte(isEnable))


def GetCPRHoldEnable(api):
    found = c_uint8()
    _call(api, "GetCPRHoldEnable", found)
    return [bool(found.value)]


def SetCPCommonParams(api, velocityRatio, accelerationRatio, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetCPCommonParams", CPCommonParams(velocityRatio, accelerationRatio), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetCPCommonParams(api):
    found = CPCommonParams()
    _call(api, "GetCPCommonParams", found)
    return [found.velocityRatio, found.accelerationRatio]


# --- Arc and circle --------------------------------------------------------------------------------------------------


def SetARCParams(api, xyzVelocity, rVelocity, xyzAcceleration, rAcceleration, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetARCParams", ARCParams(xyzVelocity, rVelocity, xyzAcceleration, rAcceleration), _byte(isQueued),
        queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def GetARCParams(api):
    found = ARCParams()
    _call(api, "GetARCParams", found)
    return [found.xyzVelocity, found.rVelocity, found.xyzAcceleration, found.rAcceleration]


def SetARCCmd(api, cirPoint, toPoint, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetARCCmd", ARCCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint)), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetCircleCmd(api, cirPoint, toPoint, isQueued=0, count=1):
    queuedCmdIndex = c_uint64(0)
    _call(
        api, "SetCircleCmd", CircleCmd(ARCPoint(*cirPoint), ARCPoint(*toPoint), count), _byte(isQueued), queuedCmdIndex
    )
    return [queuedCmdIndex.value]


def SetARCCommonParams(api, velocityRatio, accelerationRatio, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetARCCommonParams", ARCCommonParams(velocityRatio, accelerationRatio), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetARCCommonParams(api):
    found = ARCCommonParams()
    _call(api, "GetARCCommonParams", found)
    return [found.velocityRatio, found.accelerationRatio]


# --- Wait and trigger ------------------------------------------------------------------------------------------------


def SetWAITCmd(api, waitTime, isQueued=0):
    """waitTime: seconds."""
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetWAITCmd", WAITCmd(int(waitTime * 1000)), _byte(isQueued), queuedCmdIndex)
    _expect(api, (), queuedCmdIndex.value, waitTime)
    return [queuedCmdIndex.value]


def SetTRIGCmd(api, address, mode, condition, threshold, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetTRIGCmd", TRIGCmd(address, mode, condition, threshold), _byte(isQueued), queuedCmdIndex)
    _expect(api, (), queuedCmdIndex.value, FOR_EVER)
    return [queuedCmdIndex.value]


# --- Extended I/O ----------------------------------------------------------------------------------------------------


def SetIOMultiplexing(api, address, multiplex, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetIOMultiplexing", IOMultiplexing(address, multiplex), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetIODO(api, address, level, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetIODO", IODO(address, level), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetIOPWM(api, address, frequency, dutyCycle, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetIOPWM", IOPWM(address, frequency, dutyCycle), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetIOMultiplexing(api, addr):
    found = IOMultiplexing(addr)
    _call(api, "GetIOMultiplexing", found)
    return [found.multiplex]


def GetIODO(api, addr):
    found = IODO(addr)
    _call(api, "GetIODO", found)
    return [found.level]


def GetIOPWM(api, addr):
    found = IOPWM(addr)
    _call(api, "GetIOPWM", found)
    return [found.frequency, found.dutyCycle]


def GetIODI(api, addr):
    found = IODI(addr)
    _call(api, "GetIODI", found)
    return [found.level]


def GetIOADC(api, addr):
    found = IOADC(addr)
    _call(api, "GetIOADC", found)
    return [found.value]


def SetEMotor(api, index, isEnabled, speed, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEMotor", EMotor(index, isEnabled, speed), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetEMotorS(api, index, isEnabled, speed, deltaPulse, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetEMotorS", EMotorS(index, isEnabled, speed, deltaPulse), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- Sensors ---------------------------------------------------------------------------------------------------------


def SetColorSensor(api, isEnable, colorPort=ColorPort.PORT_GP2):
    _call(api, "SetColorSensor", _byte(isEnable), colorPort)


def GetColorSensor(api):
    r = c_uint8()
    g = c_uint8()
    b = c_uint8()
    _call(api, "GetColorSensor", r, g, b)
    return [r.value, g.value, b.value]


def SetInfraredSensor(api, isEnable, infraredPort):
    _call(api, "SetInfraredSensor", _byte(isEnable), infraredPort)


def GetInfraredSensor(api, infraredPort):
    found = c_uint8()
    _call(api, "GetInfraredSensor", infraredPort, found)
    return [found.value]


# --- Calibration -----------------------------------------------------------------------------------------------------


def SetAngleSensorStaticError(api, rearArmAngleError, frontArmAngleError):
    _call(api, "SetAngleSensorStaticError", rearArmAngleError, frontArmAngleError)


def GetAngleSensorStaticError(api):
    rear = c_float()
    front = c_float()
    _call(api, "GetAngleSensorStaticError", rear, front)
    return [rear.value, front.value]


def SetAngleSensorCoef(api, rearArmAngleCoef, frontArmAngleCoef):
    _call(api, "SetAngleSensorCoef", rearArmAngleCoef, frontArmAngleCoef)


def GetAngleSensorCoef(api):
    rear = c_float()
    front = c_float()
    _call(api, "GetAngleSensorCoef", rear, front)
    return [rear.value, front.value]


def SetBaseDecoderStaticError(api, baseDecoderError):
    _call(api, "SetBaseDecoderStaticError", baseDecoderError)


def GetBaseDecoderStaticError(api):
    found = c_float()
    _call(api, "GetBaseDecoderStaticError", found)
    return [found.value]


def SetLRHandCalibrateValue(api, lrHandCalibrateValue):
    _call(api, "SetLRHandCalibrateValue", lrHandCalibrateValue)


def GetLRHandCalibrateValue(api):
    found = c_float()
    _call(api, "GetLRHandCalibrateValue", found)
    return [found.value]


# --- Wi-Fi -----------------------------------------------------------------------------------------------------------


def GetWIFIConnectStatus(api):
    found = c_uint8()
    _call(api, "GetWIFIConnectStatus", found)
    return bool(found.value)


def SetWIFIConfigMode(api, enable):
    _call(api, "SetWIFIConfigMode", _byte(enable))


def GetWIFIConfigMode(api):
    found = c_uint8()
    _call(api, "GetWIFIConfigMode", found)
    return bool(found.value)


def SetWIFISSID(api, ssid):
    _call(api, "SetWIFISSID", _text(ssid))


def GetWIFISSID(api):
    found = create_string_buffer(100)
    _call(api, "GetWIFISSID", found, 100)
    return _string(found)


def SetWIFIPassword(api, password):
    _call(api, "SetWIFIPassword", _text(password))


def GetWIFIPassword(api):
    found = create_string_buffer(100)
    _call(api, "GetWIFIPassword", found, 100)
    return _string(found)


def SetWIFIIPAddress(api, dhcp, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFIIPAddress", WIFIIPAddress(dhcp, addr1, addr2, addr3, addr4))


def GetWIFIIPAddress(api):
    found = WIFIIPAddress()
    _call(api, "GetWIFIIPAddress", found)
    return [found.dhcp, found.addr1, found.addr2, found.addr3, found.addr4]


def SetWIFINetmask(api, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFINetmask", WIFINetmask(addr1, addr2, addr3, addr4))


def GetWIFINetmask(api):
    found = WIFINetmask()
    _call(api, "GetWIFINetmask", found)
    return [found.addr1, found.addr2, found.addr3, found.addr4]


def SetWIFIGateway(api, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFIGateway", WIFIGateway(addr1, addr2, addr3, addr4))


def GetWIFIGateway(api):
    found = WIFIGateway()
    _call(api, "GetWIFIGateway", found)
    return [found.addr1, found.addr2, found.addr3, found.addr4]


def SetWIFIDNS(api, addr1, addr2, addr3, addr4):
    _call(api, "SetWIFIDNS", WIFIDNS(addr1, addr2, addr3, addr4))


def GetWIFIDNS(api):
    found = WIFIDNS()
    _call(api, "GetWIFIDNS", found)
    return [found.addr1, found.addr2, found.addr3, found.addr4]


# --- Firmware --------------------------------------------------------------------------------------------------------


def UpdateFirmware(api, mode):
    _call(api, "UpdateFirmware", FirmwareParams(mode))


def SetFirmwareMode(api, mode, ctl=0):
    _call(api, "SetFirmwareMode", FirmwareMode(mode, ctl))


def GetFirmwareMode(api):
    found = FirmwareMode()
    _call(api, "GetFirmwareMode", found)
    return [found.mode, found.ctl]


# --- Lost steps ------------------------------------------------------------------------------------------------------


def SetLostStepParams(api, threshold, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetLostStepParams", threshold, _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SetLostStepCmd(api, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetLostStepCmd", _byte(isQueued), queuedCmdIndex)
    _expect(api, (), queuedCmdIndex.value, HOMING)
    return [queuedCmdIndex.value]


# --- What this arm has not -------------------------------------------------------------------------------------------


def GetUART4PeripheralsType(api):
    found = c_uint8()
    _call(api, "GetUART4PeripheralsType", found)
    return [found.value]


def SetUART4PeripheralsEnable(api, isEnable):
    _call(api, "SetUART4PeripheralsEnable", _byte(isEnable))


def GetUART4PeripheralsEnable(api):
    found = c_uint8()
    _call(api, "GetUART4PeripheralsEnable", found)
    return [bool(found.value)]


def SendPluse(api, pluseCmd, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SendPluse", _filled(PluseCmd, pluseCmd), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SendPluseEx(api, pluseCmd):
    _call(api, "SendPluseEx", _filled(PluseCmd, pluseCmd))


def GetServoPIDParams(api, index, controlLoop):
    found = PID(index, controlLoop)
    _call(api, "GetServoPIDParams", found)
    return [found.p, found.i, found.d, found.v, found.a]


def SetServoPIDParams(api, pid, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetServoPIDParams", _filled(PID, pid), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def GetServoControlLoop(api, index):
    found = c_uint8()
    _call(api, "GetServoControlLoop", _byte(index), found)
    return [found.value]


def SetServoControlLoop(api, p_index, controlLoop, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SetServoControlLoop", _byte(p_index), _byte(controlLoop), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


def SaveServoPIDParams(api, p_index, controlLoop, isQueued=0):
    queuedCmdIndex = c_uint64(0)
    _call(api, "SaveServoPIDParams", _byte(p_index), _byte(controlLoop), _byte(isQueued), queuedCmdIndex)
    return [queuedCmdIndex.value]


# --- And wait --------------------------------------------------------------------------------------------------------


def SetHOMECmdEx(api, temp, isQueued=0):
    queued = SetHOMECmd(api, temp, isQueued)[0]
    _finish(api, (), "SetHOMECmdEx", queued)


def SetEndEffectorParamsEx(api, xBias, yBias, zBias, isQueued=0):
    queued = SetEndEffectorParams(api, xBias, yBias, zBias, isQueued)[0]
    _finish(api, (), "SetEndEffectorParamsEx", queued)


def SetPTPJointParamsEx(
        api, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued=0
):
    queued = SetPTPJointParams(
        api, j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
        j4Acceleration, isQueued
    )[0]
    _finish(api, (), "SetPTPJointParamsEx", queued)


def SetPTPLParamsEx(api, lVelocity, lAcceleration, isQueued=0):
    if not GetDeviceWithL(api):
        print("the arm is not on a rail")
        return None
    queued = SetPTPLParams(api, lVelocity, lAcceleration, isQueued)[0]
    _finish(api, (), "SetPTPLParamsEx", queued)


def SetPTPCommonParamsEx(api, velocityRatio, accelerationRatio, isQueued=0):
    queued = SetPTPCommonParams(api, velocityRatio, accelerationRatio, isQueued)[0]
    _finish(api, (), "SetPTPCommonParamsEx", queued)


def SetPTPJumpParamsEx(api, jumpHeight, maxJumpHeight, isQueued=0):
    queued = SetPTPJumpParams(api, jumpHeight, maxJumpHeight, isQueued)[0]
    _finish(api, (), "SetPTPJumpParamsEx", queued)


def SetPTPCmdEx(api, ptpMode, x, y, z, rHead, isQueued=0):
    queued = SetPTPCmd(api, ptpMode, x, y, z, rHead, isQueued)[0]
    _finish(api, (), "SetPTPCmdEx", queued)


def SetPTPWithLCmdEx(api, ptpMode, x, y, z, rHead, l, isQueued=0):
    if not GetDeviceWithL(api):
        print("the arm is not on a rail")
        return None
    queued = SetPTPWithLCmd(api, ptpMode, x, y, z, rHead, l, isQueued)[0]
    _finish(api, (), "SetPTPWithLCmdEx", queued)


def SetIOMultiplexingEx(api, address, multiplex, isQueued=0):
    queued = SetIOMultiplexing(api, address, multiplex, isQueued)[0]
    _finish(api, (), "SetIOMultiplexingEx", queued)


def SetIODOEx(api, address, level, isQueued=0):
    queued = SetIODO(api, address, level, isQueued)[0]
    _finish(api, (), "SetIODOEx", queued)


def SetIOPWMEx(api, address, frequency, dutyCycle, isQueued=0):
    queued = SetIOPWM(api, address, frequency, dutyCycle, isQueued)[0]
    _finish(api, (), "SetIOPWMEx", queued)


def SetEMotorEx(api, index, isEnabled, speed, isQueued=0):
    queued = SetEMotor(api, index, isEnabled, speed, isQueued)[0]
    _finish(api, (), "SetEMotorEx", queued)


def SetEMotorSEx(api, index, isEnabled, speed, deltaPulse, isQueued=0):
    queued = SetEMotorS(api, index, isEnabled, speed, deltaPulse, isQueued)[0]
    _finish(api, (), "SetEMotorSEx", queued)


def SetEndEffectorSuctionCupEx(api, enableCtrl, on, isQueued=0):
    queued = SetEndEffectorSuctionCup(api, enableCtrl, on, isQueued)[0]
    _finish(api, (), "SetEndEffectorSuctionCupEx", queued)


def SetEndEffectorGripperEx(api, enableCtrl, on, isQueued=0):
    queued = SetEndEffectorGripper(api, enableCtrl, on, isQueued)[0]
    _finish(api, (), "SetEndEffectorGripperEx", queued)


def SetAutoLevelingCmdEx(api, controlFlag, precision, isQueued=1):
    queued = SetAutoLevelingCmd(api, controlFlag, precision, isQueued)[0]
    _finish(api, (), "SetAutoLevelingCmdEx", queued)


def SetLostStepCmdEx(api, isQueued=1):
    queued = SetLostStepCmd(api, isQueued)[0]
    _finish(api, (), "SetLostStepCmdEx", queued)


def SetWAITCmdEx(api, waitTime, isQueued=0):
    """Sleeps here; waitTime: seconds."""
    dSleep(waitTime * 1000)


def GetPoseEx(api, index):
    """One number of the pose: 1 to 8 as in GetPose, 0 is the position on the rail."""
    if index == 0:
        if not GetDeviceWithL(api):
            print("the arm is not on a rail")
            return None
        return round(GetPoseL(api)[0], 4)
    return round(GetPose(api)[index - 1], 4)


def GetColorSensorEx(api, index):
    """One of red, green and blue."""
    return GetColorSensor(api)[index]


def SetEndEffectorLaserEx(api, enableCtrl, power, isQueued=0):
    """The laser on the outputs 2 and 4: switched, and its power (0 to 100)."""
    SetIOMultiplexingEx(api, 2, 1, isQueued)
    SetIOMultiplexingEx(api, 4, 2, isQueued)
    SetIODOEx(api, 2, enableCtrl, isQueued)
    SetIOPWMEx(api, 4, 10000, power, isQueued)


# --- Prototypes ------------------------------------------------------------------------------------------------------

# The arguments of the C functions; all return an int.
_PROTOTYPES = {
    "SearchDobot": (c_char_p, c_uint32),
    "DobotExec": (),
    "PeriodicTask": (),
    "SetDebugEnable": (c_uint8,),
    "MagicianLastError": (c_char_p, c_uint32),
    "MagicianAllow": (c_char_p,),
    "ConnectDobot": (c_char_p, c_uint32, c_char_p, c_char_p),
    "DisconnectDobot": (),
    "SetCmdTimeout": (c_uint32,),
    "GetQueuedCmdCurrentIndex": (POINTER(c_uint64),),
    "GetQueuedCmdMotionFinish": (POINTER(c_uint8),),
    "SetQueuedCmdStartExec": (),
    "SetQueuedCmdStopExec": (),
    "SetQueuedCmdForceStopExec": (),
    "SetQueuedCmdStartDownload": (c_uint32, c_uint32),
    "SetQueuedCmdStopDownload": (),
    "SetQueuedCmdClear": (),
    "SetDeviceSN": (c_char_p,),
    "GetDeviceSN": (c_char_p, c_uint32),
    "SetDeviceName": (c_char_p,),
    "GetDeviceName": (c_char_p, c_uint32),
    "GetDeviceVersion": (POINTER(c_uint8), POINTER(c_uint8), POINTER(c_uint8)),
    "SetDeviceWithL": (c_uint8, c_uint8, POINTER(c_uint64)),
    "GetDeviceWithL": (POINTER(c_uint8),),
    "GetDeviceTime": (POINTER(c_uint32),),
    "GetDeviceInfo": (POINTER(DeviceCountInfo),),
    "GetMarlinVersion": (),
    "GetUserParams": (POINTER(UserParams),),
    "GetPose": (POINTER(Pose),),
    "GetPoseL": (POINTER(c_float),),
    "ResetPose": (c_uint8, c_float, c_float),
    "GetKinematics": (POINTER(Kinematics),),
    "GetAlarmsState": (c_char_p, POINTER(c_uint32), c_uint32),
    "ClearAllAlarmsState": (),
    "SetHOMEParams": (POINTER(HOMEParams), c_uint8, POINTER(c_uint64)),
    "GetHOMEParams": (POINTER(HOMEParams),),
    "SetHOMECmd": (POINTER(HOMECmd), c_uint8, POINTER(c_uint64)),
    "SetAutoLevelingCmd": (POINTER(AutoLevelingCmd), c_uint8, POINTER(c_uint64)),
    "GetAutoLevelingResult": (POINTER(c_float),),
    "SetArmOrientation": (c_int32, c_uint8, POINTER(c_uint64)),
    "GetArmOrientation": (POINTER(c_int32),),
    "SetHHTTrigMode": (c_int32,),
    "GetHHTTrigMode": (POINTER(c_int32),),
    "SetHHTTrigOutputEnabled": (c_uint8,),
    "GetHHTTrigOutputEnabled": (POINTER(c_uint8),),
    "GetHHTTrigOutput": (POINTER(c_uint8),),
    "SetEndEffectorParams": (POINTER(EndTypeParams), c_uint8, POINTER(c_uint64)),
    "GetEndEffectorParams": (POINTER(EndTypeParams),),
    "SetEndEffectorLaser": (c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "GetEndEffectorLaser": (POINTER(c_uint8), POINTER(c_uint8)),
    "SetEndEffectorSuctionCup": (c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "GetEndEffectorSuctionCup": (POINTER(c_uint8), POINTER(c_uint8)),
    "SetEndEffectorGripper": (c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "GetEndEffectorGripper": (POINTER(c_uint8), POINTER(c_uint8)),
    "SetJOGJointParams": (POINTER(JOGJointParams), c_uint8, POINTER(c_uint64)),
    "GetJOGJointParams": (POINTER(JOGJointParams),),
    "SetJOGCoordinateParams": (POINTER(JOGCoordinateParams), c_uint8, POINTER(c_uint64)),
    "GetJOGCoordinateParams": (POINTER(JOGCoordinateParams),),
    "SetJOGLParams": (POINTER(JOGLParams), c_uint8, POINTER(c_uint64)),
    "GetJOGLParams": (POINTER(JOGLParams),),
    "SetJOGCommonParams": (POINTER(JOGCommonParams), c_uint8, POINTER(c_uint64)),
    "GetJOGCommonParams": (POINTER(JOGCommonParams),),
    "SetJOGCmd": (POINTER(JOGCmd), c_uint8, POINTER(c_uint64)),
    "SetPTPJointParams": (POINTER(PTPJointParams), c_uint8, POINTER(c_uint64)),
    "GetPTPJointParams": (POINTER(PTPJointParams),),
    "SetPTPCoordinateParams": (POINTER(PTPCoordinateParams), c_uint8, POINTER(c_uint64)),
    "GetPTPCoordinateParams": (POINTER(PTPCoordinateParams),),
    "SetPTPLParams": (POINTER(PTPLParams), c_uint8, POINTER(c_uint64)),
    "GetPTPLParams": (POINTER(PTPLParams),),
    "SetPTPJumpParams": (POINTER(PTPJumpParams), c_uint8, POINTER(c_uint64)),
    "GetPTPJumpParams": (POINTER(PTPJumpParams),),
    "SetPTPJump2Params": (POINTER(PTPJump2Params), c_uint8, POINTER(c_uint64)),
    "GetPTPJump2Params": (POINTER(PTPJump2Params),),
    "SetPTPCommonParams": (POINTER(PTPCommonParams), c_uint8, POINTER(c_uint64)),
    "GetPTPCommonParams": (POINTER(PTPCommonParams),),
    "SetPTPCmd": (POINTER(PTPCmd), c_uint8, POINTER(c_uint64)),
    "SetPTPWithLCmd": (POINTER(PTPWithLCmd), c_uint8, POINTER(c_uint64)),
    "SetPTPPOCmd": (POINTER(PTPCmd), POINTER(ParallelOutputCmd), c_int32, c_uint8, POINTER(c_uint64)),
    "SetPTPPOWithLCmd": (POINTER(PTPWithLCmd), POINTER(ParallelOutputCmd), c_int32, c_uint8, POINTER(c_uint64)),
    "GetPTPTime": (POINTER(PTPCmd), POINTER(c_uint32)),
    "SetCPParams": (POINTER(CPParams), c_uint8, POINTER(c_uint64)),
    "GetCPParams": (POINTER(CPParams),),
    "SetCPCmd": (POINTER(CPCmd), c_uint8, POINTER(c_uint64)),
    "SetCPLECmd": (POINTER(CPCmd), c_uint8, POINTER(c_uint64)),
    "SetCPRHoldEnable": (c_uint8,),
    "GetCPRHoldEnable": (POINTER(c_uint8),),
    "SetCPCommonParams": (POINTER(CPCommonParams), c_uint8, POINTER(c_uint64)),
    "GetCPCommonParams": (POINTER(CPCommonParams),),
    "SetARCParams": (POINTER(ARCParams), c_uint8, POINTER(c_uint64)),
    "GetARCParams": (POINTER(ARCParams),),
    "SetARCCmd": (POINTER(ARCCmd), c_uint8, POINTER(c_uint64)),
    "SetCircleCmd": (POINTER(CircleCmd), c_uint8, POINTER(c_uint64)),
    "SetARCCommonParams": (POINTER(ARCCommonParams), c_uint8, POINTER(c_uint64)),
    "GetARCCommonParams": (POINTER(ARCCommonParams),),
    "SetWAITCmd": (POINTER(WAITCmd), c_uint8, POINTER(c_uint64)),
    "SetTRIGCmd": (POINTER(TRIGCmd), c_uint8, POINTER(c_uint64)),
    "SetIOMultiplexing": (POINTER(IOMultiplexing), c_uint8, POINTER(c_uint64)),
    "SetIODO": (POINTER(IODO), c_uint8, POINTER(c_uint64)),
    "SetIOPWM": (POINTER(IOPWM), c_uint8, POINTER(c_uint64)),
    "GetIOMultiplexing": (POINTER(IOMultiplexing),),
    "GetIODO": (POINTER(IODO),),
    "GetIOPWM": (POINTER(IOPWM),),
    "GetIODI": (POINTER(IODI),),
    "GetIOADC": (POINTER(IOADC),),
    "SetEMotor": (POINTER(EMotor), c_uint8, POINTER(c_uint64)),
    "SetEMotorS": (POINTER(EMotorS), c_uint8, POINTER(c_uint64)),
    "SetColorSensor": (c_uint8, c_int32),
    "GetColorSensor": (POINTER(c_uint8), POINTER(c_uint8), POINTER(c_uint8)),
    "SetInfraredSensor": (c_uint8, c_int32),
    "GetInfraredSensor": (c_int32, POINTER(c_uint8)),
    "SetAngleSensorStaticError": (c_float, c_float),
    "GetAngleSensorStaticError": (POINTER(c_float), POINTER(c_float)),
    "SetAngleSensorCoef": (c_float, c_float),
    "GetAngleSensorCoef": (POINTER(c_float), POINTER(c_float)),
    "SetBaseDecoderStaticError": (c_float,),
    "GetBaseDecoderStaticError": (POINTER(c_float),),
    "SetLRHandCalibrateValue": (c_float,),
    "GetLRHandCalibrateValue": (POINTER(c_float),),
    "GetWIFIConnectStatus": (POINTER(c_uint8),),
    "SetWIFIConfigMode": (c_uint8,),
    "GetWIFIConfigMode": (POINTER(c_uint8),),
    "SetWIFISSID": (c_char_p,),
    "GetWIFISSID": (c_char_p, c_uint32),
    "SetWIFIPassword": (c_char_p,),
    "GetWIFIPassword": (c_char_p, c_uint32),
    "SetWIFIIPAddress": (POINTER(WIFIIPAddress),),
    "GetWIFIIPAddress": (POINTER(WIFIIPAddress),),
    "SetWIFINetmask": (POINTER(WIFINetmask),),
    "GetWIFINetmask": (POINTER(WIFINetmask),),
    "SetWIFIGateway": (POINTER(WIFIGateway),),
    "GetWIFIGateway": (POINTER(WIFIGateway),),
    "SetWIFIDNS": (POINTER(WIFIDNS),),
    "GetWIFIDNS": (POINTER(WIFIDNS),),
    "UpdateFirmware": (POINTER(FirmwareParams),),
    "SetFirmwareMode": (POINTER(FirmwareMode),),
    "GetFirmwareMode": (POINTER(FirmwareMode),),
    "SetLostStepParams": (c_float, c_uint8, POINTER(c_uint64)),
    "SetLostStepCmd": (c_uint8, POINTER(c_uint64)),
    "GetUART4PeripheralsType": (POINTER(c_uint8),),
    "SetUART4PeripheralsEnable": (c_uint8,),
    "GetUART4PeripheralsEnable": (POINTER(c_uint8),),
    "SendPluse": (POINTER(PluseCmd), c_uint8, POINTER(c_uint64)),
    "SendPluseEx": (POINTER(PluseCmd),),
    "GetServoPIDParams": (POINTER(PID),),
    "SetServoPIDParams": (POINTER(PID), c_uint8, POINTER(c_uint64)),
    "GetServoControlLoop": (c_uint8, POINTER(c_uint8)),
    "SetServoControlLoop": (c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
    "SaveServoPIDParams": (c_uint8, c_uint8, c_uint8, POINTER(c_uint64)),
}
