"""The fence of an arm, through Python's door."""

from __future__ import annotations

import random
from pathlib import Path

import magician
import pytest
from magician import Arm, VirtualArm, commands, errors

FENCE = {"floor": -50.0, "keep_out": [[[200.0, 60.0, -100.0], [260.0, 120.0, 60.0]]]}


def test_a_motion_across_it_is_refused_with_both_values() -> None:
    with Arm("sim", fence={"floor": -60.0}) as arm:
        arm.move_to(220, 0, -60)
        with pytest.raises(errors.UnreachableError, match=r"z -71.2 mm, the fence's floor is -60.0 mm") as caught:
            arm.move_to(220, 0, -71.2)
        assert caught.value.limit == -60.0
        assert arm.pose().z == pytest.approx(-60.0, abs=0.01)


@pytest.mark.parametrize("fence", [{"roof": 3.0}, {"floor": "low"}, {"floor": float("nan")}, {"box": [[0, 0, 0]]}])
def test_invalid_fences_are_refused(fence: dict[str, object]) -> None:
    with pytest.raises(errors.Error):
        Arm("sim", fence=fence)


def test_the_file_of_settings_holds_in_python_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = tmp_path / "config.toml"
    settings.write_text("[arms.mine]\nport = 'sim'\n[arms.mine.fence]\nfloor = -20\n")
    monkeypatch.setenv("MAGICIAN_CONFIG", str(settings))
    with Arm("sim") as arm, pytest.raises(errors.UnreachableError, match=r"the fence's floor is -20.0 mm"):
        arm.move_to(220, 0, -30)
    settings.write_text("[arms.mine]\nport = 'sim'\n[arms.mine.fence]\nroof = -20\n")
    with pytest.raises(errors.Error, match=r"config.toml:4:1"):
        Arm("sim")


def test_random_programs_do_not_cross_it() -> None:
    dice = random.Random(16)
    passed = refused = 0
    for _ in range(40):
        cell = VirtualArm()
        with Arm(cell, fence=FENCE) as arm:
            for _ in range(6):
                x, y, z = dice.uniform(180, 280), dice.uniform(-150, 150), dice.uniform(-70, 80)
                move = dice.choice(["move", "enqueue", "set"])
                command = commands.PtpCmd(ptp_mode=commands.PtpMode(dice.choice([0, 1, 2])), x=x, y=y, z=z, r=0.0)
                try:
                    if move == "move":
                        arm.move_to(x, y, z)
                    elif move == "enqueue":
                        arm.enqueue(command)
                        arm.start_queue()
                    else:
                        arm.set(command)
                    passed += 1
                except (errors.UnreachableError, errors.InvalidInputError):
                    refused += 1
                pose = arm.pose()
                assert pose.z >= -50.01
                within = 200 < pose.x < 260 and 60 < pose.y < 120 and pose.z < 60
                assert not within
    assert passed > 20 and refused > 20


def test_fit_respects_the_fence_of_the_settings(samples: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = tmp_path / "config.toml"
    settings.write_text("[arms.mine]\nport = 'sim'\n[arms.mine.fence]\nbox = [[180, -20, -100], [300, 20, 100]]\n")
    monkeypatch.setenv("MAGICIAN_PORT", "sim")
    monkeypatch.setenv("MAGICIAN_CONFIG", str(tmp_path / "none.toml"))
    whole = magician.load(samples / "house.svg", fit=True)
    monkeypatch.setenv("MAGICIAN_CONFIG", str(settings))
    fenced = magician.load(samples / "house.svg", fit=True)
    assert whole.placed is not None and fenced.placed is not None
    assert fenced.placed.scale < whole.placed.scale
    with Arm("sim") as arm:
        assert arm.run(fenced).steps == len(fenced)
