"""Our DobotDllType.py as programs use it: session_dobottype.py PTY UDP TCP SPEED MAGICIAN FAMILY

Checks the contract of the stock files (names, parameters, shapes of results) and the errors that
replace their endless waits. Compares the functions with the exports of the library. Runs a script
of DobotStudio by `studio.py`, and a pick-and-place program as its user starts it.
"""

import ast
import ctypes
import importlib.util
import inspect
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import arm as model
import headers
from checks import TIMEOUT, Checks
from dobotdll import exported, library
from sim import Sim

POWER_UP_POSE = (*model.forward(model.POWER_UP_JOINTS), *model.POWER_UP_JOINTS)
# Functions that programs in the field call most often, as the stock files declare them after `api`
# and the ids.
COMMON = """
ConnectDobot(portName, baudrate)  SearchDobot(maxLen=1000)  SetQueuedCmdStartExec()  SetQueuedCmdClear()
SetPTPCmd(ptpMode, x, y, z, rHead, isQueued=0)  SetPTPCmdEx(ptpMode, x, y, z, rHead, isQueued=0)
SetPTPJointParams(j1Velocity, j1Acceleration, j2Velocity, j2Acceleration, j3Velocity, j3Acceleration, j4Velocity,
    j4Acceleration, isQueued=0)
SetPTPCommonParams(velocityRatio, accelerationRatio, isQueued=0)  SetHOMEParams(x, y, z, r, isQueued=0)
SetHOMECmd(temp, isQueued=0)  SetHOMECmdEx(temp, isQueued=0)  SetEndEffectorSuctionCup(enableCtrl, on, isQueued=0)
SetPTPCoordinateParams(xyzVelocity, xyzAcceleration, rVelocity, rAcceleration, isQueued=0)
SetPTPJumpParams(jumpHeight, zLimit, isQueued=0)  SetPTPJumpParamsEx(jumpHeight, maxJumpHeight, isQueued=0)
SetWAITCmd(waitTime, isQueued=0)  SetWAITCmdEx(waitTime, isQueued=0)
SetEndEffectorParams(xBias, yBias, zBias, isQueued=0)
SetEndEffectorGripper(enableCtrl, on, isQueued=0)  SetEndEffectorLaser(enableCtrl, on, isQueued=0)  GetIODI(addr)
SetJOGCmd(isJoint, cmd, isQueued=0)  SetJOGCommonParams(value_velocityratio, value_accelerationratio, isQueued=0)
SetJOGCoordinateParams(xVelocity, xAcceleration, yVelocity, yAcceleration, zVelocity, zAcceleration, rVelocity,
    rAcceleration, isQueued=0)
SetARCCmd(cirPoint, toPoint, isQueued=0)  SetIOMultiplexing(address, multiplex, isQueued=0)
SetIODO(address, level, isQueued=0)
SetIOPWM(address, frequency, dutyCycle, isQueued=0)  SetEMotor(index, isEnabled, speed, isQueued=0)
SetCPParams(planAcc, juncitionVel, acc, realTimeTrack=0, isQueued=0)  SetCPCmd(cpMode, x, y, z, velocity, isQueued=0)
SetTRIGCmd(address, mode, condition, threshold, isQueued=0)  GetAlarmsState(maxLen=1000)  GetPoseEx(index)
ResetPose(manual, rearArmAngle, frontArmAngle)  SetDeviceName(str)
SetPTPWithLCmd(ptpMode, x, y, z, rHead, l, isQueued=0)
SetQueuedCmdStartDownload(totalLoop, linePerLoop)  GetInfraredSensor(infraredPort)  GetColorSensorEx(index)
SetAngleSensorStaticError(rearArmAngleError, frontArmAngleError)  SetWIFIIPAddress(dhcp, addr1, addr2, addr3, addr4)
"""
# Exports without a wrapper. Each DobotDllType has a `GetPoseEx`, but that is a function of its own.
NOT_WRAPPED = {"GetPoseEx"}


def load_module(place):
    """Imports DobotDllType.py as a module."""
    spec = importlib.util.spec_from_file_location("DobotDllType", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Program:
    """Functions of the module, called with its `api` and, in v2, the id of the arm."""

    def __init__(self, dType, family):
        self.dType, self.family, self.api, self.ids = dType, family, dType.load(), ()

    def connect(self, port):
        answer = self.dType.ConnectDobot(self.api, port, 115200)
        self.ids = (answer[3],) if self.family == "v2" else ()
        return answer

    def __getattr__(self, name):
        return lambda *arguments, **keywords: getattr(self.dType, name)(self.api, *self.ids, *arguments, **keywords)


def names(checks, dType, family):
    print("names and parameters")
    ids = ["api", "dobotId"] if family == "v2" else ["api"]
    without_id = {"ConnectDobot", "SearchDobot"}
    for declared in re.findall(r"\w+\([^)]*\)", COMMON):
        name, parameters = declared[:-1].split("(")
        wanted = [part.strip() for part in parameters.split(",") if part.strip()]
        given = [str(parameter) for parameter in inspect.signature(getattr(dType, name)).parameters.values()]
        skip = 1 if name in without_id else len(ids)
        if name == "ConnectDobot":
            given = [part.split("=")[0] for part in given]
        checks.equal(name, given, (ids[:skip]) + wanted)
    checks.equal("load()", str(inspect.signature(dType.load)), "()")
    checks.equal("enumerations are numbers", (dType.PTPMode.PTPMOVLXYZMode, dType.JC.JogENPressed), (2, 10))
    checks.equal("ctypes comes along", dType.c_uint64.__name__, "c_ulong")
    checks.ok("gettime", isinstance(dType.gettime(), float if family == "v1" else list))


def functions(checks, dType, family, path, source):
    print("functions and exports")
    exports = exported(path)
    declared = set(dType._PROTOTYPES)
    checks.equal("declared and not exported", sorted(declared - exports), [])
    checks.equal("exported and not declared", sorted(exports - declared - NOT_WRAPPED), [])
    tree = ast.parse(source.read_text())
    called = {}
    for function in (node for node in tree.body if isinstance(node, ast.FunctionDef)):
        for call in (node for node in ast.walk(function) if isinstance(node, ast.Call)):
            if getattr(call.func, "id", "") in ("_call", "_try"):
                called.setdefault(call.args[1].value if isinstance(call.args[1], ast.Constant) else "", call)
    checks.equal("declared and not called", sorted(declared - set(called) - {"MagicianLastError"}), [])
    checks.equal("called and not declared", sorted(set(called) - declared - {""}), [])
    wrong = [
        name for name, call in called.items()
        if name and len(call.args) - 2 != len(dType._PROTOTYPES[name])
    ]
    checks.equal("called with another number of arguments", wrong, [])
    checks.ok("functions", len(declared) > 110, len(declared))


def header(checks, dType, include):
    print("declarations and the C headers")
    written = headers.functions(include / "DobotDll.h")
    sizes = headers.structures(include / "DobotType.h")
    checks.equal("the functions", sorted(set(written) ^ set(dType._PROTOTYPES)), sorted(NOT_WRAPPED & set(written)))
    wrong = [
        name for name, declared in dType._PROTOTYPES.items()
        if len(written[name]) != len(declared) or not all(map(headers.is_compatible, written[name], declared))
    ]
    checks.equal("declared otherwise", wrong, [])
    # All families share one header of structures. A module contains the structures that its
    # functions need.
    mine = {name: getattr(dType, headers.PYTHON_NAMES.get(name, name), None) for name in sizes}
    mine = {name: ctypes.sizeof(kind) for name, kind in mine.items() if kind}
    checks.equal("of another size", {name for name, size in mine.items() if size != sizes[name]}, set())
    checks.ok("structures", len(mine) > 35, len(mine))


def loading(checks, dType, family, path, python):
    print("load()")
    old = os.environ.pop("MAGICIAN_DOBOTDLL")
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        shutil.copy(dType.__file__, home)
        os.mkdir(os.path.join(home, "there"))
        copied = load_module(os.path.join(home, "DobotDllType.py"))
        checks.ok("nothing to load is an error that says where it looked", refused(copied.load, "libDobotDll.so"))
        shutil.copy(path, os.path.join(home, "there", "libDobotDll.so"))
        os.environ["MAGICIAN_DOBOTDLL"] = os.path.join(home, "there")
        checks.ok("a folder in MAGICIAN_DOBOTDLL", "there" in copied.load()._name)
        shutil.copy(path, os.path.join(home, "libDobotDll.so"))
        checks.equal("beside it goes first", copied.load()._name, os.path.join(home, "libDobotDll.so"))
        other = {"v1": "v2", "v2": "v3", "v3": "v1"}[family]
        os.unlink(os.path.join(home, "libDobotDll.so"))
        os.environ["MAGICIAN_DOBOTDLL"] = str(path).replace(family, other)
        checks.ok("another family's is refused", refused(copied.load, f"family {other}"))
    os.environ["MAGICIAN_DOBOTDLL"] = old


def refused(call, word):
    try:
        call()
    except OSError as error:
        return word in str(error)
    return False


def shapes(checks, program, port):
    print("results")
    family, dType = program.family, program.dType
    occupied = dType.DobotConnect.DobotConnect_Occupied
    checks.equal("a port that is not there", program.connect("/dev/ttyNothing")[0], occupied)
    answer = program.connect(port)
    wanted = {"v1": [0, "DobotSerial", "0.0.0"], "v2": [0, "DobotSerial", "0.0.0", 0]}
    if family == "v3":
        checks.equal("ConnectDobot", (len(answer), answer[:3], answer[5:7]), (8, [0, 2, 0], [0, 0]))
    else:
        checks.equal("ConnectDobot", answer, wanted[family])
    checks.near("GetPose", program.GetPose(), POWER_UP_POSE)
    checks.equal("SearchDobot", isinstance(dType.SearchDobot(program.api), list), True)
    as_result = (lambda value: value) if family == "v1" else (lambda value: [value])
    program.SetDeviceName("a name")
    checks.equal("GetDeviceName", program.GetDeviceName(), as_result("a name"))
    checks.equal("GetDeviceWithL", program.GetDeviceWithL(), as_result(False))
    checks.equal("GetDeviceVersion", len(program.GetDeviceVersion()), 4 if family == "v3" else 3)
    checks.equal("SetQueuedCmdClear", program.SetQueuedCmdClear(), as_result(0))
    program.SetQueuedCmdStartExec()
    bits, length = program.GetAlarmsState()
    checks.equal("GetAlarmsState", (len(bits), length), (1000, 16))
    program.ClearAllAlarmsState()
    index = program.SetPTPCommonParams(50, 60)
    checks.ok("a Set answers [index], queued or not", len(index) == 1 and index[0] > 0, index)
    program.SetWAITCmdEx(0.01 if family != "v3" else 10)
    checks.equal("read back", program.GetPTPCommonParams(), [50, 60])
    program.SetJOGCoordinateParams(1, 2, 3, 4, 5, 6, 7, 8, 1)
    checks.equal("a number belongs to its axis", program.GetJOGCoordinateParams(), [1, 2, 3, 4, 5, 6, 7, 8])
    program.SetHOMEParams(200, 10, 20, 30, 1)
    checks.equal("GetHOMEParams", program.GetHOMEParams(), [200, 10, 20, 30])
    program.SetEMotor(0, 1, 2000, 1)
    program.SetEMotorEx(0, 0, 0)
    program.SetIODOEx(10, 1)
    checks.equal("GetIODO", program.GetIODO(10), [1])
    program.SetEndEffectorSuctionCupEx(1, 1)
    checks.equal("GetEndEffectorSuctionCup", program.GetEndEffectorSuctionCup(), [1])
    current = program.GetQueuedCmdCurrentIndex()
    checks.equal("GetQueuedCmdCurrentIndex", len(current), 2 if family == "v3" else 1)
    seconds = time.monotonic()
    wait_index = program.SetWAITCmd(0.2 if family == "v1" else 200)[0]
    while program.GetQueuedCmdCurrentIndex()[0] < wait_index:
        dType.dSleep(1)
    seconds = time.monotonic() - seconds
    # With a unit 1,000 times as large it would take 10 s.
    checks.ok("the unit of SetWAITCmd", seconds < 9, f"{seconds:.2f} s at 20 times")
    program.SetHOMECmdEx(0)
    program.SetPTPCmdEx(dType.PTPMode.PTPMOVLXYZMode, 220, 20, 30, 5)
    checks.near("a motion that is waited for has ended", program.GetPose()[:4], (220, 20, 30, 5))
    checks.equal("GetPoseEx", round(program.GetPoseEx(2), 2), 20.0)
    guarded_calls(checks, program)


def guarded_calls(checks, program):
    error = failure(program, lambda: program.ResetPose(1, 0, 0))
    checks.equal("what can unlearn something is refused", (error.code, error.function), (3, "ResetPose"))
    checks.ok("and it is said how to allow it", "MAGICIAN_ALLOW" in str(error), error)
    program.dType.MagicianAllow(program.api, "ResetPose")
    checks.equal("MagicianAllow", program.ResetPose(1, 0, 0), None)


def failure(program, call):
    """Returns the DobotError that a call raises."""
    try:
        value = call()
    except program.dType.DobotError as error:
        return error
    raise AssertionError(f"it should have failed, and returned {value}")


def limits(checks, program):
    print("no wait is for ever")
    dType = program.dType
    program.SetQueuedCmdClear()
    program.SetQueuedCmdStartExec()
    last = [program.SetPTPCmd(2, 220 + n % 2, 0, 30, 0)[0] for n in range(120)][-1]
    checks.ok("a full queue that runs is waited out", program.GetQueuedCmdCurrentIndex()[0] > 0, last)
    program.SetQueuedCmdStopExec()
    program.SetQueuedCmdClear()
    dType.QUEUE_STALL = 1.0
    error = failure(program, lambda: program.SetPTPCmdEx(2, 230, 0, 30, 0))
    checks.ok("a motion in a stopped queue", "SetQueuedCmdStartExec" in str(error) and error.code is None, error)

    def fill():
        while True:
            program.SetPTPCmd(2, 230, 0, 30, 0)

    begin = time.monotonic()
    error = failure(program, fill)
    checks.ok("a stopped queue that is full", "SetQueuedCmdStartExec" in str(error), error)
    checks.ok("after a while", time.monotonic() - begin < 15, f"{time.monotonic() - begin:.1f} s")
    program.SetQueuedCmdClear()
    program.SetQueuedCmdStartExec()
    program.SetPTPCmdEx(1, 220, 0, 30, 0)
    begin = time.monotonic()
    error = failure(program, lambda: program.SetPTPCmdEx(1, 900, 0, 30, 0) or program.SetPTPCmdEx(1, 220, 0, 30, 0))
    checks.ok("an alarm", re.search(r"alarm .*0x[1-9]", str(error)), error)
    checks.ok("is seen at once", time.monotonic() - begin < 15, f"{time.monotonic() - begin:.1f} s")
    checks.ok("by its name, with what to do", all(word in str(error) for word in ("PlanInvCalc", "ClearAll")), error)
    own_waiting_loop(checks, program)
    program.SetQueuedCmdClear()
    program.ClearAllAlarmsState()
    program.SetQueuedCmdStartExec()
    program.SetPTPCmdEx(1, 220, 0, 30, 0)
    checks.near("and the arm goes on", program.GetPose()[:3], (220, 0, 30))


def own_waiting_loop(checks, program):
    """Tests the waiting loop that most programs write for themselves, during an alarm."""
    dType = program.dType
    last = program.SetPTPCmd(1, 220, 0, 30, 0)[0]

    def wait(between=lambda: None, seconds=5):
        end = time.monotonic() + seconds
        while last > program.GetQueuedCmdCurrentIndex()[0] and time.monotonic() < end:
            between()
            dType.dSleep(50)

    error = failure(program, lambda: wait(seconds=TIMEOUT))
    checks.ok("a loop that asks for the index ends, too", "PlanInvCalc" in str(error), error)
    checks.equal("one that also looks at the arm goes on", wait(program.GetPose), None)
    program.SetQueuedCmdClear()
    checks.equal("and one when nothing is left to wait for", wait(), None)


def long_waits(checks, program):
    print("waits that are meant to be long, on an arm in its own time")
    program.connect("sim:1")
    program.SetQueuedCmdStartExec()
    program.dType.QUEUE_STALL = 0.5
    begin = time.monotonic()
    program.SetWAITCmd(2.5 if program.family == "v1" else 2500)
    program.SetEndEffectorSuctionCupEx(1, 0)
    checks.ok("a WAIT is no standstill", 2.4 < time.monotonic() - begin < TIMEOUT, f"{time.monotonic() - begin:.2f} s")
    index = program.SetTRIGCmd(1, 0, 0, 1)[0]
    begin = time.monotonic()
    stop = threading.Timer(2.0, program.SetQueuedCmdForceStopExec)
    stop.start()
    dType, ids = program.dType, program.ids
    # The wait of all functions that block. Only v3 has such a function for triggers.
    dType._finish(program.api, (dType.masterId, dType.slaveId) if program.family == "v3" else ids, "a trigger", index)
    stop.join()
    elapsed = time.monotonic() - begin
    checks.ok("nor is a trigger that does not come", 1.9 < elapsed < TIMEOUT, f"{elapsed:.2f} s")
    program.DisconnectDobot()
    program.dType.QUEUE_STALL = 20.0


def unplugged(checks, program, magician):
    print("an arm that is gone")
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        path = os.path.join(home, "arm")
        sim = Sim(magician, path, "20")
        checks.equal("ConnectDobot", program.connect(path)[0], 0)
        program.SetCmdTimeout(300)
        sim.end(signal.SIGKILL)
        begin = time.monotonic()
        error = failure(program, program.GetPose)
        checks.equal("GetPose", (error.code, error.function), (2, "GetPose"))
        checks.ok("with a sentence", len(error.reason) > 10, error.reason)
        error = failure(program, lambda: program.SetPTPCmdEx(1, 220, 0, 30, 0))
        checks.equal("SetPTPCmdEx", error.code, 2)
        checks.ok("in their time", time.monotonic() - begin < 5.5, f"{time.monotonic() - begin:.2f} s")
        program.DisconnectDobot()
        program.SetCmdTimeout(3000)


class Recorder:
    """An `api` that is not a library: it receives the calls, as a Python package could do."""

    def __init__(self):
        self.calls = []

    def dobot_call(self, name, arguments):
        self.calls.append(name)
        if name == "GetPose":
            arguments[-1].x = 12.5
        return 3 if name == "GetKinematics" else 0

    @staticmethod
    def dobot_last_error():
        return "because"


def api_objects(checks, dType, family):
    print("an api that is no library")
    api, ids = Recorder(), (0,) if family == "v2" else ()
    checks.equal("GetPose", dType.GetPose(api, *ids)[0], 12.5)
    try:
        dType.GetKinematics(api, *ids)
    except dType.DobotError as error:
        checks.equal("its error", str(error), "GetKinematics: invalid parameters (3): because")
    checks.equal("what was called", api.calls, ["GetPose", "GetKinematics"])


# Scripts for the shim: description, bytes, exit status, output.
ODD_SCRIPTS = [
    ("with the mark of Windows", b"\xef\xbb\xbfprint('marked')\n", 0, "marked"),
    ("in another encoding", b"# -*- coding: gbk -*-\nprint(len('\xc4\xe3'), 'character')\n", 0, "1 character"),
    ("with a mistake", b"x = (\n", 1, "SyntaxError"),
    ("that leaves", b"import sys\nsys.exit(7)\n", 7, ""),
    ("that connects by itself", b"api = dType.load()\nprint(dType.ConnectDobot(api, '', 115200)[0], 'came')\n", 0, "0 came"),
    ("that is interrupted after it has disconnected", b"DisconnectDobot = dType.DisconnectDobot(api)\nraise KeyboardInterrupt\n",
     130, "could not be told"),
]


def studio(checks, capi, family, port):
    print("a script of DobotStudio")
    if family == "v2":
        # This family's functions need a dobotId, which scripts of DobotStudio do not have.
        return
    def script(place, path=capi / "samples" / "studio_script.py"):
        command = [sys.executable, "-B", capi / "python" / "studio.py", path]
        command += ["--port", place, "--family", family]
        return subprocess.run(command, capture_output=True, text=True, timeout=5 * TIMEOUT)

    for place in ("sim", port):
        ran = script(place)
        checks.equal("it ends well", (ran.returncode, ran.stderr), (0, ""))
        start, end = ast.literal_eval("[" + ran.stdout.strip().replace("] [", "], [") + "]")
        if place == "sim":
            checks.near("where it began", start, POWER_UP_POSE[:4])
        checks.near("where it ended", end, (200, 60, 20, 0))
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        own = os.path.join(home, "own.py")
        for what, text, status, word in ODD_SCRIPTS:
            pathlib.Path(own).write_bytes(text)
            ran = script("sim", own)
            checks.equal(what, (ran.returncode, word in ran.stdout + ran.stderr), (status, True))
    ran = script("/dev/ttyNothing")
    checks.equal("without an arm", (ran.returncode, "ttyNothing" in ran.stderr), (4, True))


def pick_and_place(checks, dType, capi, family, path, port):
    if family == "v2":
        return
    print("a pick-and-place program, its module and its library in one folder, unchanged")
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        shutil.copy(dType.__file__, home)
        shutil.copy(capi / "samples" / "pick_and_place.py", home)
        shutil.copy(path, os.path.join(home, "libDobotDll.so"))
        surroundings = {**os.environ, "MAGICIAN_PORT": port, "MAGICIAN_LOG": "debug"}
        surroundings.pop("MAGICIAN_DOBOTDLL")
        command = [sys.executable, "-B", "pick_and_place.py"]
        ran = subprocess.run(command, cwd=home, env=surroundings, capture_output=True, text=True, timeout=5 * TIMEOUT)
    for line in ran.stderr.splitlines():
        print("    " + line)
    checks.equal("it ends well", ran.returncode, 0)
    lines = ran.stdout.splitlines()
    checks.equal("it prints", lines[0], "Connect status: DobotConnect_NoError")
    checks.near("where it ended", ast.literal_eval(lines[-1].split(":")[1].strip())[:3], (220, 60, 40))
    for name in ("ConnectDobot", "SetPTPCmd", "SetEndEffectorSuctionCup", "GetQueuedCmdCurrentIndex"):
        checks.ok(f"the log has {name}", name in ran.stderr)


INTERRUPTED = """
import sys, time
import DobotDllType as dType
api = dType.load()
arm = dType.ConnectDobot(api, "sim:1", 115200)[3:4] * (dType._FAMILY == "v2")
dType.SetQueuedCmdStartExec(api, *arm)
try:
    print("waiting", flush=True)
    dType.SetWAITCmd(api, *arm, 60000)
    dType.SetPTPCmdEx(api, *arm, 1, 220, 0, 30, 0)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    raise
"""


def interrupt(checks, dType):
    print("Ctrl-C")
    surroundings = {**os.environ, "PYTHONPATH": os.path.dirname(dType.__file__)}
    command = [sys.executable, "-B", "-c", INTERRUPTED]
    # A shell starts background jobs with SIGINT ignored, and the runner may be one.
    program = subprocess.Popen(
        command, env=surroundings, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    program.stdout.readline()
    time.sleep(1.0)
    begin = time.monotonic()
    program.send_signal(signal.SIGINT)
    rest, errors = program.communicate(timeout=TIMEOUT)
    checks.equal("a wait is left", (rest, errors.splitlines()[-1]), ("interrupted\n", "KeyboardInterrupt"))
    # Without an interrupt the wait would last a minute.
    checks.ok("at once", time.monotonic() - begin < 40, f"{time.monotonic() - begin:.2f} s")


def main():
    port, magician, family = sys.argv[1], sys.argv[5], sys.argv[6]
    path, capi = library(magician, family)
    os.environ["MAGICIAN_DOBOTDLL"] = str(path)
    source = capi / "python" / family / "DobotDllType.py"
    dType = load_module(pathlib.Path(source))
    checks = Checks()
    checks.section(names, dType, family)
    checks.section(functions, dType, family, path, source)
    checks.section(header, dType, capi / "include" / family)
    checks.section(loading, dType, family, path, capi / "python")
    checks.section(api_objects, dType, family)
    program = Program(dType, family)
    checks.section(shapes, program, port)
    checks.section(limits, program)
    program.DisconnectDobot()
    checks.section(studio, capi, family, port)
    checks.section(pick_and_place, dType, capi, family, path, port)
    checks.section(long_waits, program)
    checks.section(unplugged, program, magician)
    checks.section(interrupt, dType)
    checks.finish()


if __name__ == "__main__":
    main()
