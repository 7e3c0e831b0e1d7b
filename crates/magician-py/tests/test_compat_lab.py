"""Programs for DobotLab, DobotEDU and pydobotlab: the 28 calls of one table, and the shapes of what they return."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from magician.compat import _lab, _line, dobotedu, pydobotlab


@pytest.fixture(autouse=True)
def one_arm() -> Iterator[None]:
    """A virtual arm for whatever port is named."""
    _line._slots.clear()
    _line.redirect_to("sim")
    yield
    _line.redirect_to(None)
    for line in _line.opened():
        line.close()


@pytest.fixture
def bot() -> Iterator[pydobotlab.Magician]:
    with pydobotlab.Magician("COM3", verbose=False) as bot:
        yield bot


def run(folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    path = folder / "script.py"
    path.write_text(script)
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", str(path)]
    return subprocess.run(command, capture_output=True, text=True, env={"PATH": ""}, timeout=300)


# Table of calls.

FRAMES = {
    "ptp": ((1, 220, 20, 30, 5), 84, 3, "01 00005c43 0000a041 0000f041 0000a040"),
    "set_device_withl": ((True, 1), 3, 1, "01 01"),
    "set_ptpl_params": ((50, 50), 85, 3, "00004842 00004842"),
    "set_ptpwithl_cmd": ((1, 220, 20, 30, 5, 100), 86, 3, "01 00005c43 0000a041 0000f041 0000a040 0000c842"),
    "motion_params": ((50, 40), 83, 3, "00004842 00002042"),
    "jump_params": ((100, 20), 82, 3, "0000a041 0000c842"),
    "set_multiplexing": ((1, 1), 130, 3, "01 01"),
    "set_pwm": ((4, 1000, 50), 132, 3, "04 00007a44 00004842"),
    "set_do": ((1, 1), 131, 3, "01 01"),
    "get_di": ((7,), 133, 0, "07"),
    "get_adc": ((9,), 134, 0, "09"),
    "set_endeffector_suctioncup": ((True, True), 62, 3, "01 01"),
    "set_endeffector_gripper": ((True, False), 63, 3, "01 00"),
    "set_infrared_sensor": ((2, True, 1), 138, 3, "01 02 01"),
    "get_infrared_sensor": ((2,), 138, 0, "02"),
    "set_color_sensor": ((1, True, 1), 137, 3, "01 01 01"),
    "get_color_sensor": ((), 137, 0, ""),
    "wait": ((0.5,), 110, 3, "f4010000"),
    "set_home": ((), 31, 3, "00000000"),
    "get_pose": ((), 10, 0, ""),
    "get_posel": ((), 13, 0, ""),
    "clear_alarm": ((), 20, 1, ""),
    "get_arm_speed_ratio": ((0,), 72, 0, ""),
    "set_lost_step_params": ((5.0,), 170, 1, "0000a040"),
    "set_lost_step_cmd": ((), 171, 3, ""),
    "get_lost_step_result": ((), 20, 0, ""),
    "set_converyor": ((0, True, 500.0), 135, 3, "00 01 f4010000"),
}


class Recorder:
    """A line that notes frames; poses are those of the original's recording."""

    def __init__(self) -> None:
        self.frames: list[tuple[int, int, str]] = []

    def exchange(self, id: int, ctrl: int, params: bytes) -> tuple[int, bytes]:
        self.frames.append((id, ctrl, params.hex()))
        return ctrl, bytes.fromhex("00004843 00000000 00004842 00000000") + bytes(16)

    def finish(self, index: int, motion: bool = False) -> None:
        """At once."""


@pytest.mark.parametrize("name", FRAMES)
def test_calls_send_the_frames_of_pydobotlab(name: str) -> None:
    values, id, ctrl, params = FRAMES[name]
    call = next(call for call in _lab.CALLS if call.lab.partition(" ")[0] == name)
    line: Any = Recorder()
    _lab.exchange(line, call, list(values))
    assert line.frames == [(id, ctrl, params.replace(" ", ""))]


def test_a_new_angle_is_a_move_from_where_the_arm_is() -> None:
    line: Any = Recorder()
    _lab.exchange(line, next(call for call in _lab.CALLS if call.lab == "set_r r"), [30])
    assert line.frames == [(10, 0, ""), (84, 3, "01000048430000000000004842" + "0000f041")]


def test_the_manual_s_28_calls_are_there_and_others_have_names_of_their_own() -> None:
    assert len([call for call in _lab.CALLS if call.lab]) == len(FRAMES) + 1
    names = [call.edu.partition(" ")[0] for call in _lab.CALLS]
    assert len(set(names)) == len(names)
    for call in _lab.CALLS:
        for name in filter(None, (call.lab, call.edu)):
            assert callable(
                getattr(pydobotlab.Magician if name is call.lab else dobotedu.magician, name.split()[0])
            ) or (name.split()[0] in ("motion_params", "jump_params"))


@pytest.mark.parametrize(("pin", "number"), [("DO_01", 1), ("DI_07", 7), ("AD_09", 9), (20, 20)])
def test_pins_have_labels(pin: int | str, number: int) -> None:
    assert _lab.io(pin) == number
    with pytest.raises(ValueError, match="no pin"):
        _lab.io("DO_21")


# pydobotlab.


def test_calls_return_true_when_the_arm_has_done_them(bot: pydobotlab.Magician) -> None:
    assert bot.ptp(mode=1, x=220, y=30, z=20, r=5) is True
    x, y, z, r, joints = bot.get_pose()
    assert (x, y, z, r) == pytest.approx((220, 30, 20, 5), abs=1e-2) and len(joints) == 4
    assert bot.set_r(10) is True and bot.get_pose().r == pytest.approx(10, abs=1e-2)
    assert bot.set_endeffector_suctioncup(True, True) is True
    bot.motion_params = 50, 40
    bot.jump_params = 100, 20
    assert (bot.motion_params, bot.jump_params) == ((50, 40), (100, 20))
    assert bot.get_arm_speed_ratio(1) == 50
    assert bot.wait(0.01) is True and bot.set_home() is True and not bot.get_alarms()


def test_a_batch_runs_at_its_end(bot: pydobotlab.Magician) -> None:
    with bot.batch():
        bot.ptp(1, 220, 30, 20, 5)
        bot.ptp(1, 200, -30, 20, 5)
        assert bot.queued_cmd_left_space() < 32
    assert bot.get_pose().as_xyzr()[:2] == pytest.approx((200, -30), abs=1e-2)


def test_a_batch_in_a_batch_runs_at_the_end_of_the_outer_one(bot: pydobotlab.Magician) -> None:
    before = bot.get_pose().as_xyzr()
    with bot.batch():
        with bot.batch():
            bot.ptp(1, 220, 30, 20, 5)
        bot.ptp(1, 200, -30, 20, 5)
        assert bot.get_pose().as_xyzr() == before
    assert bot.get_pose().as_xyzr()[:2] == pytest.approx((200, -30), abs=1e-2)


def test_a_batch_that_raises_moves_nothing(bot: pydobotlab.Magician) -> None:
    before = bot.get_pose().as_xyzr()
    with pytest.raises(ZeroDivisionError), bot.batch():
        bot.ptp(1, 220, 30, 20, 5)
        bot.move_to(1 / 0, 0, 0)
    bot.wait_idle()
    assert bot.wait(0.01) is True and bot.get_pose().as_xyzr() == before


def test_idle_is_when_the_last_queued_command_is_done(bot: pydobotlab.Magician) -> None:
    bot.wait_idle()
    index = bot.move_to(220, 30, 20, 5, mode=pydobotlab.PTPMode.MOVL_XYZ, wait=False)
    bot.wait_idle()
    assert bot.queued_cmd_current_index() == index
    assert bot.execute_command(pydobotlab.CommandID.SET_WAIT_CMD, bytes(4)) is True


def test_exceptions_have_a_cause_and_alarms(bot: pydobotlab.Magician) -> None:
    with pytest.raises(pydobotlab.DobotKinematicError) as caught:
        bot.ptp(1, 900, 0, 0, 0)
    assert caught.value.__cause__ is not None
    assert caught.value.alarms == ["PUBLIC_RESET", "PLAN_INVERSE_CALCULATION"] == bot.get_lost_step_result()
    assert pydobotlab.Alarm.PLAN_INVERSE_CALCULATION in bot.get_alarms()
    bot.clear_alarm()
    bot.ensure_no_alarms()


def test_alarms_have_groups() -> None:
    raw = sum(1 << code for code in (0x51, 0x4A, 0x70)).to_bytes(16, "little")
    alarms = pydobotlab.AlarmSet(raw)
    assert alarms.names() == ["LIMIT_0x4A", "LOST_STEP_J2", "UNKNOWN_0x70"] and len(alarms) == 3
    with pytest.raises(pydobotlab.DobotLostStepError, match="clear_alarm"):
        raise pydobotlab.alarms.alarm_error(pydobotlab.AlarmSet(raw[:9] + b"\0\0\2"))


def test_a_call_before_connect_says_so() -> None:
    with pytest.raises(pydobotlab.DobotConnectionError, match="connect"):
        pydobotlab.Dobot("COM4").get_pose()


def test_connecting_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    bot = pydobotlab.Dobot(pydobotlab.discover()[0].port)
    bot.connect()
    bot.disconnect()
    assert capsys.readouterr().out == "[pydobotlab] Connected to sim.\n" and not bot.is_open


# DobotEDU and DobotLab.


def test_results_are_taken_in_every_shape() -> None:
    edu = dobotedu.MagicianApi()
    edu.ptp(mode=1, x=220, y=30, z=20, r=5)
    pose = edu.get_pose()
    x, y, z, r, joints = pose
    assert (pose["x"], pose[1], z, r) == (220, 30, 20, 5) and joints == pose["jointAngle"]
    assert x == 220 and y == 30 and dict(pose.items())["r"] == 5
    edu.set_infrared_sensor(port=2, enable=True, version=1)
    seen: Any = edu.get_infrared_sensor(port=2)
    assert (seen["status"], seen, bool(seen), seen.get("status")) == (0, 0, False, 0)
    with pytest.raises(KeyError):
        seen["state"]
    assert set(edu.get_color_sensor()) <= {0, 1}


def test_rates_are_called_and_assigned() -> None:
    edu: Any = dobotedu.MagicianApi()
    edu.motion_params(50, 40)
    assert edu.get_ptpcommon_params()["velocityRatio"] == 50
    edu.motion_params = 60, 40
    assert edu.get_ptpcommon_params()["velocityRatio"] == 60
    edu.jump_params(100, 20)
    assert edu.get_ptpjump_params() == {"jumpHeight": 20, "zLimit": 100}


def test_a_search_says_which_arm_the_program_is_connected_to() -> None:
    edu = dobotedu.dobot_edu.magician
    (arm,) = edu.search_dobot()
    assert arm["status"] == "unconnected"
    edu.connect_dobot(arm["portName"])
    assert [found["status"] for found in edu.search_dobot()] == ["connected"]
    edu.disconnect_dobot(arm["portName"])
    assert edu.search_dobot() == [arm]


def test_the_port_may_be_named_in_front_by_keyword_or_not() -> None:
    edu = dobotedu.dobot_edu
    port = edu.magician.search_dobot()[0]["portName"]
    assert edu.magician.connect_dobot(port_name=port) is True
    edu.magician.set_ptpcmd(port, ptp_mode=1, x=220, y=30, z=20, r=5)
    edu.magician.set_endeffector_suctioncup(port_name=port, enable=True, on=True, is_queued=False)
    assert edu.m_lite.get_pose(port)["x"] == 220
    edu.set_portname("COM4")
    edu.m_lite.set_ptpcmd(1, 230, 30, 20, 5, True, True)
    assert edu.magician.get_pose()["x"] == 230
    with pytest.raises(TypeError, match="set_ptpcmd"):
        edu.magician.set_ptpcmd(port, ptp_mode=1, x=220)
    with pytest.raises(TypeError, match="speed"):
        edu.magician.set_homecmd(speed=1)
    edu.magician.disconnect_dobot(port)


SENSORS = """
from magician.compat import _line
sent = []
ever = _line.Line.exchange
def exchange(line, id, ctrl, params, **rest):
    sent.append((id, params.hex()))
    return ever(line, id, ctrl, params, **rest)
_line.Line.exchange = exchange
{magician}.set_infrared_sensor(port=2, enable=True, version=1)
{magician}.set_color_sensor(port=3, enable=True, version=1)
print([frame for frame in sent if frame[0] in (137, 138)])
"""


@pytest.mark.parametrize(
    ("start", "magician", "first", "second"),
    [
        ("from DobotEDU import *", "magician", "010101", "010201"),
        ("import pydobotlab\nbot = pydobotlab.Dobot()\nbot.connect()", "bot", "010201", "010301"),
    ],
)
def test_sockets_are_counted_as_each_library_does(
    tmp_path: Path, start: str, magician: str, first: str, second: str
) -> None:
    done = run(tmp_path, start + SENSORS.replace("{magician}", magician))
    assert done.stdout.splitlines()[-1] == f"[(138, '{first}'), (137, '{second}')]", done.stderr


@pytest.mark.parametrize(
    "start",
    [
        "from DobotEDU import *",
        "from DobotEDU import dobot_edu\nmagician = dobot_edu.magician",
        "import DobotEDU\nmagician = DobotEDU.magician",
        "from DobotEDU import DobotEDU\nmagician = DobotEDU().magician",
        "from dobot_edu import magician",
        "import DobotRPC.RPCClient\nDobotRPC.RPCClient.RPCClient.is_connected = lambda s: True\nfrom DobotEDU import *",
        "",
    ],
)
def test_scripts_find_the_arm_as_they_name_it(tmp_path: Path, start: str) -> None:
    script = (
        f"{start}\nmagician.set_home()\nmagician.ptp(mode=0, x=220, y=0, z=30, r=0)\nprint(magician.get_pose()['x'])"
    )
    done = run(tmp_path, script)
    assert (done.returncode, done.stdout, done.stderr) == (0, "220.0\n", "")


def test_other_devices_of_dobotedu_are_not_there(tmp_path: Path) -> None:
    done = run(tmp_path, "from DobotEDU import dobot_edu\ngo = dobot_edu.beta_go\ngo.set_rotate(r=1)")
    assert done.stderr.splitlines()[-1].startswith("magician.errors.UnsupportedError: magiciango.set_rotate")
