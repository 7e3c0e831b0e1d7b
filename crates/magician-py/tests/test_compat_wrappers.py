"""Programs that have the vendor's wrapper in their own way, or that load the C library themselves."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
from pathlib import Path

import pytest


def run(folder: Path, files: dict[str, str], main: str = "main.py") -> subprocess.CompletedProcess[str]:
    """A program of these files through the runner."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", main]
    # Python 3.14 warns about structures with _pack_ and without _layout_.
    environment = {"PATH": "", "PYTHONWARNINGS": "ignore::DeprecationWarning"}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, timeout=300)


LOADS = """
import os
from ctypes import *
class Move(Structure):
    _pack_ = 1
    _fields_ = [("mode", c_byte), ("x", c_float), ("y", c_float), ("z", c_float), ("r", c_float)]
class Pose(Structure):
    _pack_ = 1
    _fields_ = [("x", c_float), ("y", c_float), ("z", c_float), ("r", c_float), ("joints", c_float * 4)]
api = {load}
kind, version = create_string_buffer(60), create_string_buffer(60)
api.ConnectDobot.restype = c_int
assert api.ConnectDobot(c_char_p(b"COM3"), 115200, kind, version) == 0, "not connected"
move, index, done = Move(1, 220, 30, 20, 5), c_uint64(), c_uint64()
assert api.SetPTPCmd(byref(move), True, byref(index)) == 0
while done.value < index.value:
    assert api.GetQueuedCmdCurrentIndex(pointer(done)) == 0
pose, on, held = Pose(), c_bool(), c_bool()
api.SetEndEffectorSuctionCup(c_bool(True), c_bool(True), c_bool(True), byref(index))
while done.value < index.value:
    api["GetQueuedCmdCurrentIndex"](byref(done))
api.GetEndEffectorSuctionCup(byref(on), byref(held))
api.GetPose(byref(pose))
print(kind.value.decode(), round(pose.x), round(pose.y), round(pose.r), on.value, held.value)
"""


@pytest.mark.parametrize(
    "load",
    [
        'cdll.LoadLibrary(os.path.dirname(os.path.abspath(__file__)) + "/libDobotDll.so.1.0.0")',
        'CDLL("DobotDll.dll")',
        'CDLL("./lib/Dobot0.dll", RTLD_GLOBAL)',
        'cdll.LoadLibrary(r"C:\\work\\DobotDll.dll")',
    ],
)
def test_a_program_that_loads_the_c_library_itself_gets_the_arm(tmp_path: Path, load: str) -> None:
    done = run(tmp_path, {"main.py": LOADS.replace("{load}", load)})
    assert (done.returncode, done.stdout, done.stderr) == (0, "DobotSerial 220 30 5 True True\n", "")


CHILDREN = """
import multiprocessing
import DobotDllType as dType
def drive():
    api = dType.load()
    print(dType.ConnectDobot(api, "COM3", 115200)[0], flush=True)
    last = dType.SetPTPCmd(api, 2, 220, 40, 30, 0, isQueued=1)[0]
    dType.SetQueuedCmdStartExec(api)
    while last > dType.GetQueuedCmdCurrentIndex(api)[0]:
        dType.dSleep(5)
    print(round(dType.GetPose(api)[1], 2), flush=True)
if __name__ == "__main__":
    child = multiprocessing.get_context("{method}").Process(target=drive)
    child.start()
    child.join()
    print(child.exitcode)
"""


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes_that_a_program_starts_get_the_stand_ins_too(tmp_path: Path, method: str) -> None:
    done = run(tmp_path, {"main.py": CHILDREN.replace("{method}", method)})
    assert (done.returncode, done.stdout, done.stderr) == (0, "0\n40.0\n0\n", "")


def test_other_libraries_are_loaded_as_ever(tmp_path: Path) -> None:
    script = "import ctypes, DobotDllType\nassert ctypes.PyDLL(None).Py_IsInitialized() == 1\nctypes.CDLL('dobby.so')"
    done = run(tmp_path, {"main.py": script})
    assert done.returncode == 1 and "dobby.so" in done.stderr.splitlines()[-1]


def test_functions_of_the_library_are_called_beside_the_wrapper(tmp_path: Path) -> None:
    script = """
import ctypes
import DobotDllType as dType
api = dType.load()
dType.ConnectDobot(api, "COM3", 115200)
on = ctypes.c_bool(False)
api.GetEndEffectorGripper.argtypes = [ctypes.POINTER(ctypes.c_bool), ctypes.POINTER(ctypes.c_bool)]
print(api.GetEndEffectorGripper(ctypes.byref(ctypes.c_bool()), ctypes.byref(on)), on.value)
"""
    done = run(tmp_path, {"main.py": script})
    assert (done.returncode, done.stdout, done.stderr) == (0, "0 False\n", "")


def test_names_of_a_changed_copy_of_the_wrapper_come_from_it(tmp_path: Path) -> None:
    copy = """
import ctypes
class InfraredPort: PORT_GP2 = 1
def GetPose(api): raise SystemExit("the copy of the wrapper")
def depth(api):
    pose = (ctypes.c_float * 8)()
    api.GetPose(ctypes.byref(pose))
    return round(pose[2], 3)
"""
    script = """
import lib.DobotDllType as dType
from lib.DobotDllType import InfraredPort
api = dType.load()
dType.ConnectDobot(api, "", 115200)
print(InfraredPort.PORT_GP2, dType.depth(api), round(dType.GetPose(api)[2], 3))
dType.nothing
"""
    done = run(tmp_path, {"main.py": script, "lib/DobotDllType.py": copy})
    assert done.stdout == "1 -8.485 -8.485\n"
    assert done.stderr.splitlines()[-1].startswith("AttributeError: module 'DobotDllType' has no attribute 'nothing'")


def test_each_name_of_the_wrapper_has_its_own_arm(tmp_path: Path) -> None:
    script = """
import DobotDllType, DobotDllType2
for wrapper, x in ((DobotDllType, 200), (DobotDllType2, 230)):
    api = wrapper.load()
    wrapper.ConnectDobot(api, "COM3", 115200)
    index = wrapper.SetPTPCmd(api, 1, x, 0, 0, 0, 1)[0]
    while wrapper.GetQueuedCmdCurrentIndex(api)[0] < index: pass
    print(round(wrapper.GetPose(api)[0]))
print(DobotDllType is not DobotDllType2, DobotDllType.SearchDobot(api))
"""
    done = run(tmp_path, {"main.py": script})
    assert (done.stdout, done.stderr) == ("200\n230\nTrue ['COM1']\n", "")


FORK = """
import serial
class Dobot:
    def __init__(self, port):
        self.port = serial.Serial(port, 115200)
    def get_pose(self): return "the copy's"
    def dance(self): return "dances"
"""


@pytest.mark.parametrize(("call", "said"), [("dance()", "dances"), ("get_pose().joints.j3", "45.0")])
def test_a_copy_of_pydobot_is_run_where_only_it_has_a_method(tmp_path: Path, call: str, said: str) -> None:
    files = {"pydobot/__init__.py": "from .dobot import Dobot", "pydobot/dobot.py": FORK}
    script = (
        f"import pydobot\nclass Arm:\n  def __init__(s): s.robot = pydobot.Dobot('COM3')\nprint(Arm().robot.{call})"
    )
    done = run(tmp_path, {"main.py": script, **files})
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{said}\n", "")


LATE = """
import DobotDllType as dType
api = dType.load()
try:
    dType.GetPose(api)
except dType.DobotError as error:
    print("no connection" in str(error))
assert dType.ConnectDobot(api, "COM3", 115200)[0] == 0
last = dType.SetPTPCmd(api, 1, 210, 0, 30, 0, 1)[0]
dType.DisconnectDobot(api)
while last > dType.GetQueuedCmdCurrentIndex(api)[0]:
    dType.dSleep(5)
class Tool:
    def __del__(self):
        dType.SetEndEffectorSuctionCupEx(api, 0, 1)
        print("released")
        try:
            dType.GetPose(api)
        except dType.DobotError as error:
            print("no connection" in str(error))
tool = Tool()
"""


@pytest.mark.parametrize("family", ["v1", "v3"])
def test_calls_after_a_disconnect_do_nothing_and_end(tmp_path: Path, family: str) -> None:
    (tmp_path / "main.py").write_text(LATE)
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", "--dobotdll", family, "main.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={"PATH": ""}, timeout=300)
    assert (done.returncode, done.stdout) == (0, "True\nreleased\nTrue\n")
    assert done.stderr.splitlines() == [
        f"magician: {name} after DisconnectDobot: nothing was done"
        for name in ("GetQueuedCmdCurrentIndex", "SetEndEffectorSuctionCup")
    ]


DESTRUCTOR = """
import DobotDllType as dType
class Robot:
    def __init__(self):
        self.api = dType.load()
        dType.ConnectDobot(self.api, "COM3", 115200)
    def __del__(self):
        dType.SetPTPCmd(self.api, 1, 210, 0, 30, 0, 1)
        while dType.GetPose(self.api)[0] != 210: dType.dSleep(1)
        print("home")
        dType.DisconnectDobot(self.api)
robot = Robot()
"""


def test_a_destructor_speaks_to_the_arm_at_the_end_of_a_program(tmp_path: Path) -> None:
    done = run(tmp_path, {"main.py": DESTRUCTOR})
    assert (done.returncode, done.stdout, done.stderr) == (0, "home\n", "")


def test_a_destructor_after_an_exception_says_nothing_of_the_end_of_python(tmp_path: Path) -> None:
    # A destructor at this point cannot import, so the native part cannot create its exceptions.
    done = run(tmp_path, {"main.py": DESTRUCTOR + "robot.unknown"})
    assert done.returncode == 1 and "no attribute 'unknown'" in done.stderr and "home" not in done.stdout
    assert "SetPTPCmd after the end of the program: nothing was done" in done.stderr
    assert "ImportError" not in done.stderr


def test_a_late_call_of_pydobot_finds_the_connection_closed(tmp_path: Path) -> None:
    program = """
from pydobot import Dobot
class Robot:
    def __init__(self): self.arm = Dobot("COM3")
    def __del__(self): self.arm.move_to(210, 0, 30, 0, wait=True)
robot = Robot()
robot.unknown
"""
    done = run(tmp_path, {"main.py": program})
    assert done.returncode == 1 and "the connection is closed" in done.stderr and "ImportError" not in done.stderr
