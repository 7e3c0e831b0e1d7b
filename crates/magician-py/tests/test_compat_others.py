"""Programs for dobotapi, pydobotpp and dobotWrapperPy, and programs with an arm's class that opens the port itself."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from magician.compat import _line, dobotapi, dobotwrapperpy, pydobotpp
from magician.compat.dobotapi.dobot_interfaces import MODE_PTP, Position


@pytest.fixture(autouse=True)
def one_arm() -> Iterator[None]:
    _line._slots.clear()
    _line.redirect_to("sim")
    yield
    _line.redirect_to(None)
    for line in _line.opened():
        line.close()


@pytest.fixture
def frames(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is sent: id, Ctrl and parameters."""
    sent: list[str] = []
    ever = _line.Line.exchange

    def exchange(line: _line.Line, id: int, ctrl: int, params: bytes, **rest: Any) -> tuple[int, bytes]:
        sent.append(f"{id}/{ctrl} {params.hex()}".strip())
        return ever(line, id, ctrl, params, **rest)

    monkeypatch.setattr(_line.Line, "exchange", exchange)
    return sent


def run(folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    (folder / "script.py").write_text(script)
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", str(folder / "script.py")]
    return subprocess.run(command, capture_output=True, text=True, env={"PATH": ""}, timeout=300)


def test_dobotapi_sends_its_frames(frames: list[str]) -> None:
    bot = dobotapi.Dobot(execution_delay=0.15)
    assert bot.connect() is True
    assert [frame.split("/")[0] for frame in frames] == ["240", "245", "80", "81", "82", "83"]
    del frames[:]
    bot.move_to(210, 20, 30, 5)
    assert bot.get_pose().position == pytest.approx((210, 20, 30, 5), abs=1e-2)
    bot.move_to_position(Position(215, 20, 30, 5), MODE_PTP.MOVJ_XYZ)
    bot.ir_toggle(enable=True)
    assert bot.get_ir() is False
    bot.gripper.open()
    bot.gripper.close()
    bot.suction_cup.suck()
    bot.suction_cup.idle()
    bot.conveyor_belt.move(0.5)
    bot.conveyor_belt.move(speed=-0.5)
    bot.conveyor_belt.idle()
    assert [frame for frame in frames if frame[:3] != "246"] == [
        "84/3 02000052430000a0410000f0410000a040",
        "10/0",
        "84/3 01000057430000a0410000f0410000a040",
        "138/3 010201",
        "138/0 020101",
        "63/3 0100",
        "63/3 0101",
        "62/3 0101",
        "62/3 0100",
        "135/3 000152d9ffff",
        "135/3 000152d9ffff",
        "135/3 000100000000",
    ]
    with pytest.raises(dobotapi.exceptions.DobotException, match=r"-1\.0 to 1\.0"):
        bot.conveyor_belt.move(1.5)
    del frames[:]
    bot.close()
    assert frames == ["63/3 0101", "62/3 0100", "135/3 000100000000"] and not bot.connected()


def test_dobotapi_reports_missing_connection_and_alarms() -> None:
    with pytest.raises(dobotapi.exceptions.DobotException, match="connect"):
        dobotapi.Dobot("COM3").get_pose()
    assert dobotapi.utils.get_coms_port()[0] == "sim"
    bot = dobotapi.Dobot()
    bot.connect()
    with pytest.raises(dobotapi.exceptions.DobotException, match="alarm"):
        bot.move_to(900, 0, 0)


def test_pydobotpp_stops_when_it_is_closed(frames: list[str]) -> None:
    bot = pydobotpp.Dobot(port="COM3", should_clear_alarms=False)
    assert "20/1" not in frames
    bot.move_to(210, 20, 30, 5, mode=pydobotpp.PTPMode.MOVL_XYZ)
    assert bot.get_pose().position.x == pytest.approx(210, abs=1e-2)
    assert bot.wait(10) == 7
    del frames[:]
    bot.close()
    assert frames == ["242/1", "245/1", "240/1", "61/3 0000", "63/3 0100", "62/3 0100", "241/1", "245/1"]
    bot.close()
    assert int(pydobotpp.GPIOPort.GP5) == 3


def test_dobotwrapperpy_sends_structures(frames: list[str]) -> None:
    from magician.compat.dobotwrapperpy import paramsStructures as made
    from magician.compat.dobotwrapperpy.enums.level import Level
    from magician.compat.dobotwrapperpy.enums.ptpMode import PTPMode

    tag: Any = made
    bot: Any = dobotwrapperpy.DobotApi(dobotwrapperpy.DobotConnection(port="COM3"))
    bot.initialize_robot()
    del frames[:]
    assert bot.set_ptp_cmd(tag.tagPTPCmd(PTPMode.MOVJ_XYZ, 210, 20, 30, 5), wait=True, is_queued=True) == 6
    assert bot.set_io_do(tag.tagIODO(address=1, level=Level.HIGH), True, True) == 7
    assert bot.set_wait_cmd(params=tag.tagWAITCmd(timeout=1), is_queued=True) == 8
    assert bot.set_end_effector_suction_cup(True, False, True) == 9
    assert bot.set_ptp_common_params(tag.tagPTPCommonParams(50, 40)) is None
    assert frames == [
        "84/3 01000052430000a0410000f0410000a040",
        "131/3 0101",
        "110/3 01000000",
        "62/3 0101",
        "83/1 0000484200002042",
    ]
    assert bot.get_ptp_common_params() == tag.tagPTPCommonParams(50.0, 40.0)
    assert bot.get_pose().x == pytest.approx(210, abs=1e-2) and len(bot.get_pose().jointAngle) == 4
    assert bot.get_end_effector_suction_cup() == (True, True)
    with pytest.raises(AttributeError, match="no call set_nothing"):
        bot.set_nothing()


def test_dobotwrapperpy_moves_by_so_much_to_a_place(frames: list[str]) -> None:
    async def program() -> tuple[float, ...]:
        bot = dobotwrapperpy.DobotAsync("COM3")
        await bot.connect()
        await bot.move_xyz_joint(210, 20, 30, 5)
        await bot.move_relative_xyz_joint(5, 0, 0, 0)
        await bot.jump_relative_xyz(0, -5, 0, 0)
        await bot.move_in_circle(220, 20, 30, 5, 225, 15, 30, 5)
        return await bot.pose()

    assert asyncio.run(program())[:4] == pytest.approx((225, 15, 30, 5), abs=1e-2)
    # Relative moves are sent as absolute ones: joint move, jump and arc.
    assert [frame[:7] for frame in frames if frame[:2] in ("84", "10") and frame[:3] != "10/"] == [
        "84/3 01",
        "84/3 01",
        "84/3 00",
        "101/3 0",
    ]


def test_a_star_imports_dobotwrapperpy_s_structures() -> None:
    names: dict[str, Any] = {}
    exec("from magician.compat.dobotwrapperpy.paramsStructures import *", names)
    assert names["tagPTPCmd"](1, 210, 20, 30, 5).x == 210


def test_dobotwrapperpy_is_awaited() -> None:
    async def program() -> tuple[float, ...]:
        bot = dobotwrapperpy.DobotAsync("COM3")
        await bot.connect()
        await bot.clear_alarms()
        await bot.move_xyz_linear(210, 20, 30, 5)
        await bot.move_relative_xyz_linear(5, 0, 0, 0)
        await bot.suck(True)
        return await bot.pose()

    assert asyncio.run(program())[:4] == pytest.approx((215, 20, 30, 5), abs=1e-2)


@pytest.mark.parametrize(
    "script",
    [
        "from dobotapi import Dobot\nd = Dobot('COM3')\nd.connect()\n"
        "d.move_to(210, 0, 30)\nx = d.get_pose().position.x",
        "from dobotapi.dobot import Dobot, Position\nfrom dobotapi.utils import get_coms_port\n"
        "d = Dobot(get_coms_port()[0])\nd.connect()\n"
        "d.move_to_position(Position(210, 0, 30, 0))\nx = d.get_pose()[0][0]",
        "from pydobotpp import Dobot, PTPMode, Pose\nd = Dobot('COM3')\n"
        "d.move_to(210, 0, 30)\nx = d.get_pose().position.x",
        "import dobotWrapperPy\nd = dobotWrapperPy.Dobot(port='COM3', verbose=False)\n"
        "d.move_to(210, 0, 30, 0, wait=True)\nx = d.pose()[0]",
        "from dobotWrapperPy.dobotapi import DobotApi\nfrom dobotWrapperPy.dobotConnection import DobotConnection\n"
        "from dobotWrapperPy.paramsStructures import tagPTPCmd\nfrom dobotWrapperPy.enums.ptpMode import PTPMode\n"
        "d = DobotApi(DobotConnection(port='COM3'))\nd.initialize_robot()\n"
        "d.set_ptp_cmd(tagPTPCmd(PTPMode.MOVJ_XYZ, 210, 0, 30, 0), True, True)\nx = d.get_pose().x",
        # A subclass that opens the port in its own constructor.
        "import serial\nfrom pydobot.dobot import MODE_PTP\nimport pydobot\nclass Arm(pydobot.Dobot):\n"
        "  def __init__(self, port):\n    self._ser = serial.Serial(port, 115200)\n"
        "    self._set_queued_cmd_start_exec()\n"
        "d = Arm('COM3')\nd.move_to(210, 0, 30, wait=True)\nx = d.get_pose().position.x",
    ],
    ids=["dobotapi", "dobotapi.dobot", "pydobotpp", "dobotWrapperPy", "DobotApi", "own port"],
)
def test_programs_import_them_as_they_are(tmp_path: Path, script: str) -> None:
    done = run(tmp_path, script + "\nprint(round(x))")
    assert (done.returncode, done.stdout, done.stderr) == (0, "210\n", "")
