"""Programs for other people's libraries: what they find, what they get, what happens when something goes wrong."""

# pyright: reportPrivateUsage=false

from __future__ import annotations

import _thread
import inspect
import os
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from magician import errors
from magician.compat import _line, _program, _script, _serial, dobotdll, pydobot, pydobot2, pydobotplus
from magician.compat._message import Message
from magician.compat.pydobot.enums import PTPMode
from magician.compat.pydobotplus.dobotplus import MODE_PTP, Alarm, DobotException

START = (259.104, 0.0, -8.485, 0.0, 0.0, 45.0, 45.0, 0.0)


@pytest.fixture(autouse=True)
def switched_off() -> None:
    """No virtual arm is left on by the test before."""
    _line._slots.clear()


@pytest.fixture
def dobot() -> Iterator[pydobot.Dobot]:
    """A virtual arm of its own, behind pydobot's interface."""
    arm = pydobot.Dobot("sim")
    yield arm
    arm.close()


@pytest.fixture
def plus() -> Iterator[pydobotplus.Dobot]:
    """The same behind pydobotplus'."""
    arm = pydobotplus.Dobot("sim")
    yield arm
    arm.close()


def run(script: str, tmp_path: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A script through the runner."""
    path = tmp_path / "script.py"
    path.write_text(script)
    command = [sys.executable, "-m", "magician.compat", *arguments[:-1], str(path), *arguments[-1:]]
    return subprocess.run(command, capture_output=True, text=True, env={"PATH": "", **environment}, timeout=300)


# The interfaces.


def test_a_frame_s_bytes_are_of_the_type_that_they_ever_were() -> None:
    message = Message()
    message.id = 10
    assert type(message.bytes()) is bytes
    message.params, message.checksum = bytearray(b"\1"), None
    assert type(message.bytes()) is bytearray


SIGNATURES = {
    pydobot.Dobot: """
        __init__(port, verbose=False) close() get_eio(addr) go(x, y, z, r=0.0) grip(enable)
        move_to(x, y, z, r, wait=False) pose() set_eio(addr, val) speed(velocity=100.0, acceleration=100.0) suck(enable)
        wait(ms) _get_pose() _get_queued_cmd_current_index() _send_command(msg, wait=False) _set_cp_cmd(x, y, z)
        _set_ptp_cmd(x, y, z, r, mode, wait) _set_ptp_common_params(velocity, acceleration)
        _set_ptp_coordinate_params(velocity, acceleration) _set_ptp_jump_params(jump, limit)
        _set_ptp_joint_params(v_x, v_y, v_z, v_r, a_x, a_y, a_z, a_r) _set_queued_cmd_clear()
        _set_queued_cmd_start_exec() _set_queued_cmd_stop_exec() _set_wait_cmd(ms)
        _set_end_effector_gripper(enable=False) _set_end_effector_suction_cup(enable=False) _get_eio_level(address)
        _set_eio_level(address, level)""",
    pydobot2.Dobot: """
        __init__(port=None) close() get_pose() get_alarms() clear_alarms() wait_for_cmd(cmd_id)
        jog_x(v) jog_y(v) jog_z(v) jog_r(v) set_io(address, state) move_to(x, y, z, r=0.0, mode=1)
        go_arc(x, y, z, r, cir_x, cir_y, cir_z, cir_r) suck(enable) set_home(x, y, z, r=0.0) home() grip(enable)
        laze(power=0, enable=False) speed(velocity=100.0, acceleration=100.0)
        conveyor_belt(speed, direction=1, interface=0) conveyor_belt_distance(speed, distance, direction=1, interface=0)
        engrave(image, pixel_size, low=0.0, high=40.0, velocity=5, acceleration=5, actual_acceleration=5)
        _send_command(msg) _set_ptp_cmd(x, y, z, r, mode) _set_jog_command(cmd)
        _set_cp_params(velocity, acceleration, period)
        _set_cple_cmd(x, y, z, power, absolute=False) _set_stepper_motor(speed, interface=0, motor_control=True)
        _set_stepper_motor_distance(speed, distance, interface=0, motor_control=True) _extract_cmd_index(response)
        _set_end_effector_laser(power=255, enable=False)""",
    pydobotplus.Dobot: """
        __init__(port=None) move_to(x=None, y=None, z=None, r=0, wait=True, mode=None, position=None)
        move_rel(x=0, y=0, z=0, r=0, wait=True) set_hht_trig_output(state) get_hht_trig_output()
        conveyor_belt_distance(speed_mm_per_sec, distance_mm, direction=1, interface=0)
        set_color(enable=True, port=1, version=1) get_color(port=1, version=1) set_ir(enable=True, port=2)
        get_ir(port=2) _send_command(msg, wait=False) _set_ptp_cmd(x, y, z, r, mode, wait)""",
}


def declared(text: str) -> list[tuple[str, list[tuple[str, Any]]]]:
    """Names of methods, and their parameters with their defaults."""
    found: list[tuple[str, list[tuple[str, Any]]]] = []
    for each in text.replace("\n", " ").split(")"):
        name, _, inside = each.strip().partition("(")
        if name:
            parts = [part.strip().partition("=") for part in inside.split(",") if part.strip()]
            named = [(part[0], eval(part[2]) if part[1] else inspect.Parameter.empty) for part in parts]
            found.append((name, named))
    return found


@pytest.mark.parametrize("library", SIGNATURES)
def test_methods_accept_the_original_parameters(library: type) -> None:
    for name, wanted in declared(SIGNATURES[library]):
        parameters = list(inspect.signature(getattr(library, name)).parameters.values())
        have = [(each.name, each.default) for each in parameters if each.name != "self"]
        # Further parameters must be optional.
        assert len(have) >= len(wanted), name
        for (name_had, default), (name_wanted, default_wanted) in zip(have, wanted, strict=False):
            assert name_had == name_wanted, name
            assert default == default_wanted or default_wanted is inspect.Parameter.empty, (name, name_had)
        assert all(default is not inspect.Parameter.empty for _, default in have[len(wanted) :]), name


# pydobot.


def test_connecting_sets_the_speeds_and_reads_the_pose(dobot: pydobot.Dobot) -> None:
    assert dobot.pose() == pytest.approx(START, abs=1e-3)
    assert (dobot.x, dobot.j2) == pytest.approx((START[0], 45.0), abs=1e-3)
    assert dobot._get_queued_cmd_current_index() == 5
    assert struct.unpack("<2f", ask(dobot, 83)) == (100.0, 100.0)


def ask(dobot: Any, id: int, ctrl: int = 0, params: bytes = b"") -> bytes:
    """The parameters of what answers a frame built by hand."""
    msg = Message()
    msg.id, msg.ctrl, msg.params = id, ctrl, bytearray(params)
    return bytes(dobot._send_command(msg).params)


def test_only_wait_waits_and_nothing_is_returned(dobot: pydobot.Dobot) -> None:
    assert dobot.move_to(220, 30, 20, 0) is None  # type: ignore[func-returns-value]
    assert dobot.suck(True) is None  # type: ignore[func-returns-value]
    dobot.move_to(200, -30, 40, 10, wait=True)
    assert dobot.pose()[:4] == pytest.approx((200, -30, 40, 10), abs=1e-3)
    assert ask(dobot, 62) == b"\x01\x01"


def test_truthy_values_switch_off_with_a_warning(dobot: pydobot.Dobot) -> None:
    dobot.suck(True)
    with pytest.warns(UserWarning, match=r"suck\(True\)"):
        dobot.suck(1)  # type: ignore[arg-type]
    assert ask(dobot, 62) == b"\x01\x00"


def test_verbose_prints_every_frame(capsys: pytest.CaptureFixture[str]) -> None:
    dobot = pydobot.Dobot("sim", verbose=True)
    capsys.readouterr()
    dobot._set_ptp_cmd(220, 0, 10, 0, mode=PTPMode.MOVJ_XYZ, wait=True)
    dobot.close()
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("pydobot: >> AA AA:19:84:3:01 00 00 5C 43")
    assert said[1].startswith("pydobot: << AA AA:10:84:3:06 00")
    assert said[2:] == ["pydobot: waiting for command 6", "pydobot: command 6 executed", "pydobot: sim closed"]


def test_refused_move_raises_an_error_with_a_remedy(dobot: pydobot.Dobot) -> None:
    with pytest.raises(errors.AlarmError, match="clear"):
        dobot.move_to(500, 0, 0, 0, wait=True)


def test_a_full_queue_makes_room_while_it_runs_and_is_an_error_while_it_does_not(dobot: pydobot.Dobot) -> None:
    for _ in range(100):
        dobot.wait(1)
    dobot._set_queued_cmd_stop_exec()
    with pytest.raises(errors.QueueFullError):
        for _ in range(100):
            dobot.wait(1)
    dobot._set_queued_cmd_start_exec()
    dobot.move_to(210, 0, 0, 0, wait=True)


def test_ctrl_c_stops_the_arm() -> None:
    dobot = pydobot.Dobot("sim:1")
    dobot.speed(20, 100)
    dobot.move_to(200, 100, 50, 0)

    def interrupt() -> None:
        # Wait until the arm moves and the main thread waits for it.
        while dobot.pose()[1] < 1:
            pass
        _thread.interrupt_main()

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        dobot.move_to(200, -100, 50, 0, wait=True)
    thread.join()
    before = dobot.pose()
    assert dobot.pose() == before
    assert abs(before[1]) < 90
    dobot.close()


def test_dangerous_commands_need_permission(dobot: pydobot.Dobot, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(errors.InvalidInputError, match="MAGICIAN_ALLOW=SetDeviceSN"):
        ask(dobot, 0, 1, b"other\0")
    monkeypatch.setenv("MAGICIAN_ALLOW", "SetDeviceSN")
    ask(dobot, 0, 1, b"other\0")
    assert ask(dobot, 0).startswith(b"other")


def test_a_closed_arm_says_so(dobot: pydobot.Dobot) -> None:
    assert dobot.ser.isOpen()
    dobot.close()
    assert not dobot.ser.isOpen()
    with pytest.raises(errors.ClosedError):
        dobot.pose()


def test_missing_port_raises_the_error_of_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    class Theirs(OSError):
        """As pyserial has one."""

    monkeypatch.setitem(sys.modules, "serial", type("serial", (), {"SerialException": Theirs}))
    with pytest.raises(Theirs, match="does not exist") as caught:
        pydobot.Dobot("/dev/not-there")
    assert isinstance(caught.value, errors.PortError)
    with pytest.raises(DobotException) as other:
        pydobotplus.Dobot("/dev/not-there")
    assert isinstance(other.value.__cause__, errors.PortError)


def test_the_port_in_the_library_takes_frames(dobot: pydobot.Dobot) -> None:
    msg = Message()
    msg.id = 246
    frame = bytes(msg.bytes())
    dobot.ser.write(frame[:3])
    assert dobot.ser.in_waiting == 0
    dobot.ser.write(frame[3:])
    answer = Message(dobot.ser.read_all())
    assert (answer.id, answer.params) == (246, struct.pack("<Q", 5))
    dobot.ser.write(frame)
    dobot.ser.reset_input_buffer()
    assert dobot.ser.read_all() == b""


def test_frames_sum_up_to_0() -> None:
    for ms in range(300):
        msg = Message()
        msg.id, msg.ctrl, msg.params = 110, 3, bytearray(struct.pack("<I", ms))
        assert sum(msg.bytes()[3:]) & 0xFF == 0
        again = Message(bytes(msg.bytes()))
        assert (again.id, again.ctrl, bytes(again.params)) == (110, 3, bytes(msg.params))
        assert str(again) == str(msg)


# pydobot2 and pydobotplus.


def test_newer_ones_return_indices(plus: pydobotplus.Dobot) -> None:
    assert plus.get_alarms() == set()
    assert plus.suck(True) == 6
    assert plus.move_to(220, 10, 30) == 7
    assert plus.get_pose().position == pytest.approx((220, 10, 30, 0), abs=1e-3)
    assert plus.move_to(z=40, mode=MODE_PTP.MOVL_XYZ, wait=False) == 8
    plus.wait_for_cmd(plus.home())
    plus.move_rel(x=10, y=-5)
    assert plus.get_pose().position[:2] == pytest.approx((START[0] + 10, -5), abs=1e-2)
    with pytest.raises(ValueError, match="x, y or z"):
        plus.move_to()
    with pytest.raises(DobotException, match="direction"):
        plus.conveyor_belt(0.5, 7)


def test_alarms_have_their_names(plus: pydobotplus.Dobot) -> None:
    with pytest.raises(DobotException) as caught:
        plus.move_to(500, 0, 0)
    assert isinstance(caught.value.__cause__, errors.AlarmError)
    alarms = plus.get_alarms()
    assert alarms and all(isinstance(alarm, Alarm) for alarm in alarms)
    plus.clear_alarms()
    assert plus.get_alarms() == set()
    assert Alarm(0xD7).name == "ALARM_0xD7"


def test_a_picture_smaller_than_the_queue_is_engraved(plus: pydobotplus.Dobot) -> None:
    plus.move_to(200, 0, 10)
    plus.engrave([[0, 128], [255, 0]], 0.5, velocity=50, acceleration=100, actual_acceleration=100)
    assert plus.get_pose().position[:2] == pytest.approx((200.5, 0.0), abs=1e-2)
    assert ask(plus, 61) == b"\x00\x00"


def test_pydobot2_passes_its_own_example() -> None:
    dobot = pydobot2.Dobot("sim")
    position = dobot.get_pose().position
    dobot.move_to(position.x + 20, position.y, position.z, position.r, wait=False)
    assert dobot.move_to(position.x, position.y, position.z, position.r, wait=True) == 7
    assert dobot.get_pose().position == pytest.approx(position, abs=1e-3)
    assert dobot.get_pose().joints.in_radians().j2 == pytest.approx(0.7854, abs=1e-4)
    dobot.close()


def test_an_arm_in_the_process_stays_on(dobot: pydobot.Dobot) -> None:
    dobot.move_to(220, 0, 10, 0, wait=True)
    other = pydobot.Dobot("sim")
    assert other.pose()[0] == pytest.approx(START[0], abs=1e-3)
    dobot.close()
    again = pydobot.Dobot("sim")
    assert again.pose()[0] == pytest.approx(220, abs=1e-3)
    other.close()
    again.close()


# Ports.


def test_ports_of_a_program_can_be_sent_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _line.find("COM3") == "COM3"
    monkeypatch.setenv("MAGICIAN_PORT", "sim")
    assert _line.find(None) == "sim"
    assert _line.find("COM3") == "COM3"
    monkeypatch.setenv("MAGICIAN_PORT_COM3", "sim:2")
    assert _line.find("COM3") == "sim:2"
    _line.redirect_to("udp:127.0.0.1")
    try:
        assert _line.find("COM3") == _line.find(None) == "udp:127.0.0.1"
        listed = _serial.comports()
        assert listed[0].device == listed[17].device == "udp:127.0.0.1"
        assert "USB" in listed[0].description and listed[0].vid == 4292
        assert [info.device for info in _serial.grep("10C4:EA60")] == ["udp:127.0.0.1"]
        assert all(part in listed[0].device for part in ("ttyUSB", "COM", "usbserial", "udp"))
        assert listed[0].device.startswith("COM") and "Bluetooth" not in listed[0].device
        device, description, hwid = listed[0]
        assert (device, str(listed[0])) == ("udp:127.0.0.1", f"{device} - {description}") and "VID:PID" in hwid
    finally:
        _line.redirect_to(None)
    assert _line.find("/dev/ttyUSB9") == "/dev/ttyUSB9"


# The runner.


def test_a_script_runs_as_it_would_alone(tmp_path: Path) -> None:
    script = """
import sys, __main__
from serial.tools import list_ports
import serial, pydobot, pydobotplus, DobotDllType
from pydobot.enums.ControlValues import ControlValues
from pydobot.dobot import Message
import neighbour
assert __name__ == "__main__" and __main__.__file__ == __file__ == sys.argv[0]
print(sys.argv[1:], list_ports.comports()[3].device, neighbour.here, pydobot.Dobot("COM7").pose()[5])
try:
    pydobot.Dobot("COM8", verbose=False).move_to(999, 0, 0, 0, wait=True)
except Exception as error:
    print(type(error).__name__)
sys.exit(7)
"""
    (tmp_path / "neighbour.py").write_text("here = 'yes'")
    done = run(script, tmp_path, "--port=sim", "--its")
    assert (done.returncode, done.stderr) == (7, "")
    assert done.stdout.splitlines() == ["['--its'] sim yes 45.0", "AlarmError"]


def test_the_environment_names_the_port(tmp_path: Path) -> None:
    script = "import pydobotplus; print(pydobotplus.Dobot('COM3').get_pose().joints.j3)"
    assert run(script, tmp_path, "x", MAGICIAN_PORT="sim").stdout == "45.0\n"
    assert run(script, tmp_path, "x", MAGICIAN_PORT_COM3="sim").stdout == "45.0\n"


def test_an_exception_stops_the_arm_and_shows_the_script_alone(tmp_path: Path) -> None:
    script = """
import pydobot
def fall():
    raise ValueError("so it goes")
dobot = pydobot.Dobot("COM3")
dobot.move_to(220, 0, 0, 0)
fall()
"""
    done = run(script, tmp_path, "--port", "sim", "x")
    assert done.returncode == 1
    said = done.stderr.splitlines()
    assert said[0] == "magician.compat: ended by an exception, so the arm at sim is stopped"
    assert said[-1] == "ValueError: so it goes" and "script.py" in said[2] and "magician" not in "".join(said[1:])


def test_a_syntax_error_is_the_script_s(tmp_path: Path) -> None:
    done = run("print('so far'\n", tmp_path, "x")
    assert done.returncode == 1 and "SyntaxError" in done.stderr
    assert "magician" not in done.stderr


def test_a_script_is_compiled_and_called_as_python_does_it(tmp_path: Path) -> None:
    done = run(
        "def f(x: int): ...\nprint(f.__annotations__, __file__ == __import__('os').path.abspath(__file__))",
        tmp_path,
        "",
    )
    assert done.stdout == "{'x': <class 'int'>} True\n"


def test_a_script_s_own_hook_hears_of_its_end(tmp_path: Path) -> None:
    done = run("import sys\nsys.excepthook = lambda k, e, t: print(k.__name__, t.tb_lineno)\n1 / 0", tmp_path, "")
    assert (done.returncode, done.stdout, done.stderr) == (1, "ZeroDivisionError 3\n", "")


def test_interrupt_shows_the_frames_of_the_script_alone(tmp_path: Path) -> None:
    done = run("raise KeyboardInterrupt", tmp_path, "")
    assert done.returncode != 0 and "KeyboardInterrupt" in done.stderr
    assert "magician" not in done.stderr


def test_modules_run_too(tmp_path: Path) -> None:
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "__init__.py").write_text("")
    (tmp_path / "tool" / "__main__.py").write_text(
        "import sys, pydobot; print(sys.argv[1:], pydobot.Dobot('COM1').pose()[6])"
    )
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", "-m", "tool", "a"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "['a'] 45.0\n", "")


def test_the_package_around_a_module_imports_the_stand_ins(tmp_path: Path) -> None:
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "__init__.py").write_text("from pydobot import Dobot")
    (tmp_path / "tool" / "go.py").write_text("from . import Dobot; print(round(Dobot('COM1').pose()[6]))")
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", "-m", "tool.go"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "45\n", "")
    done = subprocess.run([*command[:-1], "tool.gone"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 1 and "no module tool.gone" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--nonsense", "x.py"], "there is no option --nonsense"),
        (["--port"], "--port needs a value"),
        (["--dobotdll=v9", "x.py"], "one of v1, v2, v3"),
        ([], "there is no script"),
        (["/not/there.py"], "cannot be read"),
    ],
)
def test_wrong_calls_are_usage_errors(arguments: list[str], said: str) -> None:
    command = [sys.executable, "-m", "magician.compat", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 2 and said in done.stderr


def test_library_is_detected_by_the_used_names() -> None:
    which = _script.which_pydobot
    assert which("import pydobot; pydobot.Dobot(port='COM3', verbose=True)") == "pydobot"
    assert which("from pydobot import Dobot\nd = Dobot()\npose = d.get_pose()") == "pydobot2"
    assert which("from pydobot.dobot import MODE_PTP, Dobot") == "pydobot2"
    assert which("from pydobot import Dobot\nDobot('x').move_rel(x=1)") == "pydobotplus"
    assert which("from pydobot.dobotplus import Dobot") == "pydobotplus"
    assert which("x = pydobot.Dobot('COM3'); x.pose(); x.get_pose()") == "pydobot"
    assert which("not python at all (") == "pydobot"
    # Names of other libraries are no evidence: a verbose parser, a neural net for poses.
    others = "from pydobot import Dobot\nParser(verbose=True)\nmp.solutions.pose.Pose()\nself.pose = 1\n"
    assert which(others + "self.robot = Dobot('COM3')\nself.robot.get_pose()") == "pydobot2"
    assert which(others + "d = Dobot('COM3')\nd.home()\nd.move_to(1, 2, 3)") == "pydobot2"
    assert which(others + "d = Dobot('COM3')\nd.home()\nd.pose()") == "pydobot"
    assert which("from pydobot import dobot\ndobot.MODE_PTP", "x.pose()") == "pydobot2"
    assert which("import pydobot", copy="class Dobot:\n    def get_pose(self): ...") == "pydobot2"
    assert which("import pydobot\nx.get_pose()", copy="class Dobot:\n    def pose(self): ...") == "pydobot"
    assert which("import pydobot", copy="def get_pose(self): ...\ndef move_rel(self): ...") == "pydobotplus"


def test_family_is_detected_by_the_adjacent_file_or_the_calls(tmp_path: Path) -> None:
    which = _script.which_dobotdll
    assert which(["dType.SetPTPCmd(api, 1, 200, 0, 0, 0, isQueued=1)"], tmp_path) == "v3"
    assert which(["", "dType.SetPTPCmd(api, dobotId, 1, 200, 0, 0, 0, 1)"], tmp_path) == "v2"
    for text, family in (("def f(api, masterId)", "v3"), ("def f(api, dobotId)", "v2"), ("def f(api)", "v1")):
        (tmp_path / "DobotDllType.py").write_text(text)
        assert which([""], tmp_path) == family


def written(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def overlooked(folder: Path, name: str) -> _program.Program:
    path = folder / name
    return _program.find_modules(path, path.read_text(), folder)


def test_all_modules_of_a_program_are_looked_at(tmp_path: Path) -> None:
    moves = "from pydobot import Dobot\ndef go(d): d.move_rel(x=1)"
    programs = {
        "import beside": {"beside.py": moves},
        "from robot.arm import go": {"robot/arm.py": moves},
        "import robot": {"robot/__init__.py": "from .arm import go", "robot/arm.py": moves},
        "from robot import arm": {"robot/__init__.py": "", "robot/arm.py": "from .. import beside", "beside.py": moves},
        "import sys; sys.path.insert(0, 'src')\nimport beside": {"src/beside.py": moves},
        "import one": {"one.py": "import two", "two.py": "import one, three", "three.py": moves},
    }
    for nth, (main, files) in enumerate(programs.items()):
        folder = tmp_path / str(nth)
        written(folder, {"main.py": main, **files})
        assert _script.which_pydobot(*overlooked(folder, "main.py").sources) == "pydobotplus", main
    # Not installed packages, unrelated files or a copy of the library itself.
    written(tmp_path / "x", {"main.py": "import json, pydobot", "other.py": moves, "pydobot/__init__.py": moves})
    assert len(overlooked(tmp_path / "x", "main.py").sources) == 1


def test_the_family_is_that_of_the_wrapper_that_is_imported(tmp_path: Path) -> None:
    for nth, spelling in enumerate((
        "import lib.vendor.DobotDllType as dType",
        "from lib.vendor import DobotDllType as dType",
        "from lib.vendor.DobotDllType import *",
        "import lib.robot",
    )):  # fmt: skip
        folder = tmp_path / str(nth)
        written(folder, {
            "main.py": spelling,
            "lib/vendor/DobotDllType.py": "def f(api, dobotId)",
            "lib/robot.py": "from .vendor import DobotDllType",
        })  # fmt: skip
        program = overlooked(folder, "main.py")
        assert _script.which_dobotdll(program.sources, folder, program.wrappers) == "v2", spelling


@pytest.mark.parametrize("kept", [True, False])
@pytest.mark.parametrize(
    "spelling",
    [
        "import DobotDllType as dType",
        "import lib.DobotDllType as dType",
        "from lib import DobotDllType as dType",
        "from DobotDLL.python import DobotDllType as dType",
        "from lib.DobotDllType import *\nimport lib.DobotDllType as dType",
        "from robot import dType",
        "import DobotDLLType as dType",
        "import DobotDLL as dType",
        "from DobotDLL import dType",
        "from dobot2 import DobotDllType2 as dType",
        "from lib.DobotDllType import DobotDllType as dType",
        "import lib.DobotDllType as dType",
    ],
)
def test_the_vendor_s_wrapper_is_stood_in_for_wherever_it_lies(tmp_path: Path, spelling: str, kept: bool) -> None:
    written(tmp_path, {"robot/__init__.py": "from . import DobotDllType as dType"})
    if kept:
        copy = "masterId = 0\nraise SystemExit('the copy of the wrapper')"
        places = ("", "lib/", "robot/", "DobotDLL/python/") if "DLL" not in spelling[:15] else ("lib/", "robot/")
        written(tmp_path, {f"{place}DobotDllType.py": copy for place in places})
    script = f"{spelling}\napi = dType.load()\nprint(dType.ConnectDobot(api, '', 115200)[0])"
    done = run(script, tmp_path, MAGICIAN_PORT="sim")
    assert (done.returncode, done.stdout, done.stderr) == (0, "0\n", "")


def test_a_program_of_the_wrapper_finds_the_queue_started(tmp_path: Path) -> None:
    """Of programs that never start it; what another program has left in the queue is not set going."""
    program = """
import DobotDllType as dType
from magician.compat import _line
api = dType.load()
assert dType.ConnectDobot(api, "COM3", 115200)[0] == 0
index = dType.SetWAITCmd(api, 1, 1)[0]
while dType.GetQueuedCmdCurrentIndex(api)[0] < index:
    pass
print("waited")
dType.SetQueuedCmdStopExec(api)
dType.SetWAITCmd(api, 1, 1)
dType.DisconnectDobot(api)
dType.ConnectDobot(api, "COM3", 115200)
print(_line._slots[0].cell.state()["waiting"])
"""
    done = run(program, tmp_path, MAGICIAN_PORT="sim")
    assert (done.returncode, done.stdout) == (0, "waited\n1\n"), done.stderr


# Ctrl-C.

PRESSES = """
import atexit, os, signal, threading, time
import pydobot
from magician.compat import _line

def look():
    state = cell.state()
    print(state["moving"], state["waiting"], state["index"], *state["pose"][:2], flush=True)

def press():
    # On its way for long enough that the script waits, or does whatever it does, in the line that begins with this.
    there.wait()
    while cell.state()["pose"][1] < 0.005 or cell.state()["waiting"] < waiting:
        pass
    os.kill(os.getpid(), signal.SIGINT)

arm = pydobot.Dobot("COM3")
cell = _line._slots[0].cell
atexit.register(look)
arm.speed(5, 5)
waiting = {waiting}
there = threading.Event()
threading.Thread(target=press, daemon=True).start()
{rest}
"""
TEN_MOVES = "for y in range(10): arm.move_to(200, 100 - 20 * y, 0, 0)"


@pytest.mark.skipif(
    not hasattr(signal, "SIGINT") or os.name == "nt", reason="the keys of a console are pressed otherwise"
)
@pytest.mark.parametrize(
    ("waiting", "rest", "last"),
    [
        (31, "there.set()\nwhile True: arm.move_to(200, 100, 0, 0); arm.move_to(200, -100, 0, 0)", "arm.move_to"),
        (0, "there.set(); arm.move_to(200, 100, 0, 0, wait=True)", "arm.move_to"),
        (9, f"{TEN_MOVES}\nwhile True: there.set(); arm.pose()", "arm.pose()"),
        (9, f"{TEN_MOVES}\nwhile True: there.set()", "while True: there.set()"),
        (9, f"{TEN_MOVES}\nthere.set(); time.sleep(3600)", "time.sleep(3600)"),
        (9, f"{TEN_MOVES}\nthere.set(); threading.Event().wait()", "threading.Event().wait()"),
    ],
    ids=["full queue", "waiting", "polling", "busy", "sleeping", "locked"],
)
def test_ctrl_c_stops_the_arm_at_once(tmp_path: Path, waiting: int, rest: str, last: str) -> None:
    done = run(PRESSES.format(waiting=waiting, rest=rest), tmp_path, "--port", "sim:1", "")
    assert done.returncode == -signal.SIGINT
    moving, waits, index, x, y = done.stdout.split()
    # The first move, the seventh command, was running: 100 mm in twenty seconds.
    assert (moving, waits, index) == ("False", "0", "8") and 258 < float(x) < 260 and 0 <= float(y) < 50
    said = done.stderr.splitlines()
    assert said[0] == "magician.compat: interrupted, so the arm at sim:1 is stopped"
    assert said[1] == "Traceback (most recent call last):" and said[-1] == "KeyboardInterrupt"
    assert "script.py" in said[2] and last in said[3], done.stderr


@pytest.mark.skipif(os.name == "nt", reason="there, the keys of a console are pressed otherwise")
def test_a_script_that_catches_ctrl_c_goes_on(tmp_path: Path) -> None:
    rest = """
try:
    there.set()
    arm.move_to(200, 100, 0, 0, wait=True)
except KeyboardInterrupt:
    arm.speed(100, 100)
    arm.move_to(210, 0, 0, 0, wait=True)
"""
    done = run(PRESSES.format(waiting=0, rest=rest), tmp_path, "--port", "sim:1", "")
    assert done.returncode == 0, done.stderr
    moving, waits, index, x, y = done.stdout.split()
    assert (moving, waits, index) == ("False", "0", "11") and (round(float(x)), round(float(y))) == (210, 0)


@pytest.mark.skipif(os.name == "nt", reason="there, the keys of a console are pressed otherwise")
@pytest.mark.parametrize("doing", ["time.sleep(3600)", "threading.Event().wait()", "while True: arm.pose()"])
@pytest.mark.parametrize("last", ["arm.close()", "pass"])
def test_a_script_that_catches_ctrl_c_and_ends_well_leaves_an_arm_that_stands(
    tmp_path: Path, doing: str, last: str
) -> None:
    rest = f"""
{TEN_MOVES}
try:
    there.set()
    {doing}
except KeyboardInterrupt:
    {last}
while cell.state()["moving"] or cell.state()["waiting"]:
    pass
"""
    done = run(PRESSES.format(waiting=9, rest=rest), tmp_path, "--port", "sim:1", "")
    assert done.returncode == 0, done.stderr
    moving, waits, index, _, y = done.stdout.split()
    assert (moving, waits, index) == ("False", "0", "8") and float(y) < 50


# Uses of the classes in programs.

SENDS = """
    _send_command _send_message _read_message _set_cp_cmd _set_end_effector_gripper _set_end_effector_suction_cup
    _set_ptp_joint_params _set_ptp_coordinate_params _set_ptp_jump_params _set_ptp_common_params _set_ptp_cmd
    _set_queued_cmd_clear _set_queued_cmd_start_exec _set_queued_cmd_stop_exec _get_queued_cmd_current_index
"""
NEWER = f"""{SENDS}
    close get_pose get_alarms clear_alarms wait_for_cmd jog_x jog_y jog_z jog_r set_io move_to go_arc suck set_home home
    grip laze speed conveyor_belt conveyor_belt_distance engrave _extract_cmd_index _set_end_effector_laser
    _set_home_cmd _set_arc_cmd _set_home_coordinate _set_jog_coordinate_params _set_jog_command _set_stepper_motor
    _set_stepper_motor_distance _set_cp_params _set_cple_cmd _lock _ser logger
"""
# Methods of pydobot and its forks, on every arm, because programs mix them.
MIXED = """
    home goHome setHomeParams jump_to jump move_to_J goMovL go_lin move_inc_to rotate_joint go_angle move_to_with_l
    move_to_withL pose_l set_wait start_stepper stop_stepper stop_conveyor_belt _stop_gripper _get_device_version
    get_device_name set_device_name get_device_serial_number run pose wait get_eio set_eio
"""
PLUS = """
    PORT_GP1 PORT_GP2 PORT_GP4 PORT_GP5 set_hht_trig_output get_hht_trig_output set_color get_color set_ir get_ir
    move_rel
"""
# Names of the libraries' own arm classes: pydobot 1.3.2, pydobot2 0.1.0 and pydobotplus 0.1.2.
OLDER = "_get_pose _set_wait_cmd _get_eio_level _set_eio_level go _on lock ser verbose x y z r j1 j2 j3 j4"
OF_NEWER_ALONE = {"_lock", "_ser", "logger", "conveyor_belt_distance"}
NAMES = {
    pydobot.Dobot: {*f"{NEWER} {OLDER} {MIXED}".split()} - OF_NEWER_ALONE,
    pydobot2.Dobot: {*f"{NEWER} {MIXED}".split()},
    pydobotplus.Dobot: {*f"{NEWER} {PLUS} {MIXED}".split()},
}


@pytest.mark.parametrize("kind", NAMES, ids=lambda kind: kind.__module__)
def test_arms_have_the_names_of_the_libraries_and_no_others(kind: Any) -> None:
    arm = kind("sim")
    found = {name for name in dir(arm) if not name.startswith(("__", "_magician_"))}
    assert found == NAMES[kind]
    arm.close()


# Attributes that programs add to an arm.
USUAL = """
    arm line port serial core answer queue lock thread state command exchange open setup fault finish queued jog say ptp
    index timeout native bench name stop
"""


@pytest.mark.parametrize("kind", NAMES, ids=lambda kind: kind.__module__)
def test_arms_of_a_program_s_own_have_any_other_names(kind: Any) -> None:
    names = USUAL.split()

    class Dobot(kind):  # type: ignore[misc]
        def __init__(self, port: str) -> None:
            for name in names:
                for other in (f"_{name}", f"__{name}", f"_Dobot__{name}", f"_Robot__{name}"):
                    setattr(self, other, "mine")
            super().__init__(port)
            for name in names:
                if f"_{name}" not in NAMES[kind]:
                    assert getattr(self, f"_{name}") == "mine"
                setattr(self, f"_{name}", "mine")

    arm = Dobot("sim")
    arm.move_to(220, 0, 20, 0, wait=True)
    arm.suck(True)
    arm.speed(50, 50)
    if kind is pydobot.Dobot:
        arm.ser, port = None, arm.ser
        assert arm.pose()[:3] == pytest.approx((220, 0, 20), abs=1e-3) and port.is_open
    else:
        arm._ser, port = None, arm._ser
        assert arm.get_pose().position[:3] == pytest.approx((220, 0, 20), abs=1e-3) and port.is_open
        arm.jog_x(5)
        arm.jog_x(0)
    arm.close()


# DobotDllType.


@pytest.mark.parametrize("family", dobotdll.FAMILIES)
def test_a_program_for_the_vendor_s_wrapper(family: str) -> None:
    module: Any = dobotdll.family(family)
    api = module.load()
    connected = module.ConnectDobot(api, "sim", 115200)
    assert connected[0] == module.DobotConnect.DobotConnect_NoError
    ids = (connected[3],) if family == "v2" else ()
    module.SetQueuedCmdClear(api, *ids)
    module.SetPTPCommonParams(api, *ids, 100, 100, isQueued=1)
    index = module.SetPTPCmd(api, *ids, module.PTPMode.PTPMOVLXYZMode, 220, 30, 40, 5, isQueued=1)[0]
    module.SetQueuedCmdStartExec(api, *ids)
    deadline = time.monotonic() + 120
    while module.GetQueuedCmdCurrentIndex(api, *ids)[0] < index and time.monotonic() < deadline:
        pass
    assert module.GetPose(api, *ids)[:4] == pytest.approx([220, 30, 40, 5], abs=1e-3)
    with pytest.raises(module.DobotError, match="MAGICIAN_ALLOW"):
        module.SetDeviceSN(api, *ids, "other")
    module.MagicianAllow(api, "SetDeviceSN")
    module.SetDeviceSN(api, *ids, "other")
    module.DisconnectDobot(api, *ids)
    with pytest.raises(module.DobotError, match="ConnectDobot"):
        module.GetPose(api, *ids)
    with pytest.raises(ValueError, match="v1, v2, v3"):
        dobotdll.family("v4")


def test_failed_connection_returns_a_code() -> None:
    module: Any = dobotdll.family("v1")
    api = module.load()
    assert module.ConnectDobot(api, "/dev/not-there", 115200)[0] == module.DobotConnect.DobotConnect_Occupied
    with pytest.raises(AttributeError, match="no function GetPoze"):
        api.GetPoze()


@pytest.mark.parametrize("family", dobotdll.FAMILIES)
def test_a_loop_for_an_index_ends_under_an_alarm(family: str, monkeypatch: pytest.MonkeyPatch) -> None:
    module: Any = dobotdll.family(family)
    clock = iter(range(10**6))

    def sleep(_seconds: float) -> None:
        """It takes no time."""

    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: float(next(clock)), sleep=sleep))
    api = module.load()
    ids = (module.ConnectDobot(api, "sim", 115200)[3],) if family == "v2" else ()
    if not ids:
        module.ConnectDobot(api, "sim", 115200)
    index = module.SetPTPCmd(api, *ids, module.PTPMode.PTPMOVLXYZMode, 900, 0, 0, 0, isQueued=1)[0]
    index = module.SetPTPCmd(api, *ids, module.PTPMode.PTPMOVLXYZMode, 220, 0, 0, 0, isQueued=1)[0]
    with pytest.raises(module.DobotError, match="alarm 0x11"):
        for _ in range(1000):
            module.GetQueuedCmdCurrentIndex(api, *ids)
    module.ClearAllAlarmsState(api, *ids)
    while module.GetQueuedCmdCurrentIndex(api, *ids)[0] < index:
        module.GetPose(api, *ids)
    module.DisconnectDobot(api, *ids)
