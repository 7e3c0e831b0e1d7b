from __future__ import annotations

import math
from pathlib import Path

import magician
import pytest
from magician import Pose, Surface, VirtualArm, calibrate, errors
from magician.places import Point
from magician.readings import Position


def corners(rotation: float) -> list[tuple[float, float, float]]:
    """Of a sheet of 120 by 90 mm at (180, -60), turned and tilted."""
    cos, sin = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))
    found: list[tuple[float, float, float]] = []
    for right, up in ((0, 0), (120, 0), (0, 90)):
        x, y = 180 + right * cos - up * sin, -60 + right * sin + up * cos
        found.append((x, y, -61 + 0.01 * x - 0.02 * y))
    return found


def touch(r: float) -> tuple[float, float, float, float]:
    """The pose that touches (230, 40), the tip being 3 mm ahead of the tool's and 1.5 mm to its right."""
    cos, sin = math.cos(math.radians(r)), math.sin(math.radians(r))
    return 230 - (3 * cos + 1.5 * sin), 40 - (3 * sin - 1.5 * cos), -60.0, r


def test_a_sheet_is_found_and_used() -> None:
    found = calibrate.sheet(corners(12))
    assert found.sheet.corner == pytest.approx((180, -60))
    assert found.sheet.rotation == pytest.approx(12)
    assert found.sheet.size == pytest.approx((120, 90), abs=1e-6)
    assert found.surface.height == pytest.approx(-61)
    assert found.surface.slope == pytest.approx((0.01, -0.02))
    assert found.tilt == pytest.approx(1.281, abs=0.001)
    assert tuple(found.frame(120, 0))[:3] == pytest.approx(found.corners[1], abs=0.1)
    as_taught = [Point(f"P{nth}", Position(*corner, 0.0)) for nth, corner in enumerate(found.corners)]
    assert calibrate.sheet(as_taught) == found
    assert calibrate.sheet([Pose(*corner, 0.0, (0.0, 0.0, 0.0, 0.0)) for corner in found.corners]) == found


def test_a_drawing_lies_on_the_sheet(samples: Path) -> None:
    found = calibrate.sheet([(200, -60, -60), (300, -60, -60), (200, 60, -57)])
    plan = magician.load(samples / "house.svg", sheet=found.sheet, surface=found.surface, fit=True)
    assert not plan.surface_is_assumed
    # The surface rises along y, so the pen must too.
    assert plan.surface == found.surface
    assert found.surface.slope[1] == pytest.approx(0.025)
    with VirtualArm().arm() as arm:
        arm.run(plan)


def test_a_surface_is_as_high_as_it_was_touched() -> None:
    assert calibrate.surface((220, 0, -61.5)) == Surface(-61.5)


def test_a_tip_is_found() -> None:
    found = calibrate.tip([touch(-80), touch(100)], tool="pen")
    assert found.offset == pytest.approx((3, -1.5))
    assert found.bias == pytest.approx((64, -1.5, 0))
    assert calibrate.tip([touch(0), touch(90)], tool=(1, 2, 3)).bias == pytest.approx((4, 0.5, 3))
    assert str(found) == "3.00 mm ahead and -1.50 mm to the left: bias 64.000, -1.500, 0.000 mm"


def test_impossible_touches_are_refused_with_a_remedy() -> None:
    a, b, c = corners(0)
    for points, message in [
        ([a, b], r"corners are 2 points; it takes 3"),
        ([a, c, b], r"-90\.0 deg.*; touch lower left, lower right and upper left"),
        ([a, (185, -60, -60), c], r"5\.\d mm long.*; touch corners that are farther apart"),
    ]:
        with pytest.raises(errors.InvalidInputError, match=message):
            calibrate.sheet(points)
    with pytest.raises(errors.InvalidInputError, match=r"turned by 20\.0 deg"):
        calibrate.tip([touch(0), touch(20)], tool="pen")
    with pytest.raises(errors.InvalidInputError, match=r"how the tool was turned"):
        calibrate.tip([(1, 2, 3), (4, 5, 6)], tool="pen")


def test_saved_calibration_is_read_by_command_and_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "config.toml"
    path.write_text("# mine\nwindow = 4\n", encoding="utf-8")
    monkeypatch.setenv("MAGICIAN_CONFIG", str(path))
    monkeypatch.delenv("MAGICIAN_TOOL", raising=False)
    assert calibrate.saved() == calibrate.Saved(None, None, None)
    assert calibrate.save(Surface(-61.5)) == str(path)
    assert calibrate.saved().surface == Surface(-61.5)
    found = calibrate.sheet(corners(12))
    calibrate.save(found)
    calibrate.save(calibrate.tip([touch(-80), touch(100)], tool="pen"))
    kept = calibrate.saved()
    assert kept.sheet is not None
    assert kept.surface is not None
    assert kept.sheet.rotation == pytest.approx(12, abs=1e-3)
    assert kept.surface.slope == pytest.approx((0.01, -0.02), abs=1e-6)
    assert kept.tool == "64,-1.5,0"
    assert path.read_text(encoding="utf-8").startswith("# mine\nwindow = 4\n")
    with pytest.raises(errors.InvalidInputError, match=r"kept with its sheet"):
        calibrate.save(found.surface)
    path.write_text("window = ", encoding="utf-8")
    with pytest.raises(errors.InvalidInputError, match=r"config\.toml"):
        calibrate.saved()


def test_the_height_is_taken_from_where_the_tool_touches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MAGICIAN_CONFIG", str(tmp_path / "config.toml"))
    with VirtualArm().arm() as arm:
        arm.move_to(220, 30, -52.5)
        surface = arm.touch_off()
        assert surface.height == pytest.approx(-52.5, abs=0.01) and surface.slope == (0.0, 0.0)
        # The table of a virtual arm has nothing to do with a real one.
        assert calibrate.saved().surface is None
        arm.laser(True)
        with pytest.raises(errors.InvalidInputError, match="laser is on") as told:
            arm.touch_off()
        assert told.value.code == "laser-on"
