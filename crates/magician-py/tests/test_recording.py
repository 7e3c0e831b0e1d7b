from __future__ import annotations

import asyncio
import csv
import itertools
import json
from pathlib import Path

import magician
import pytest
from magician import VirtualArm, aio, errors


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def seen(recording: magician.Recording, more: int = 2) -> None:
    """Waits until so many more readings were taken: what was done before is among them."""
    wanted = recording.readings + more
    while recording.readings < wanted:
        assert recording.is_open


def test_readings_are_in_the_file_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "day.csv"
    with VirtualArm().arm() as arm:
        with arm.record(path, rate=200) as recording:
            assert recording.is_open
            seen(recording)
            arm.move_to(220, 40, 20)
        assert not recording.is_open
        found = rows(path)
        assert recording.readings == len(found) >= 3
        assert recording.position is not None
        assert (recording.position.x, recording.position.y) == pytest.approx((220, 40), abs=0.01)
        assert float(found[-1]["x"]) == pytest.approx(220, abs=0.01)
        assert recording.length > 40
        assert recording.seconds == pytest.approx(float(found[-1]["t"]), abs=0.001)
        assert recording.steps is None
        assert repr(recording).startswith(f"<Recording {str(path)!r}, finished: ")


def test_the_clock_of_a_virtual_arm_counts(tmp_path: Path) -> None:
    cell = VirtualArm()
    with cell.arm() as arm, arm.record(tmp_path / "day.jsonl", rate=200) as recording:
        seen(recording)
        cell.advance(100)
        seen(recording)
    assert 100 <= recording.seconds < 101
    lines = [json.loads(line) for line in (tmp_path / "day.jsonl").read_text(encoding="utf-8").splitlines()]
    assert lines[0]["t"] < 1


@pytest.mark.parametrize("port", ["sim", None])
def test_a_leap_is_recorded_on_its_way(tmp_path: Path, port: str | None) -> None:
    """At full speed the arm is there at once; the file has the curve that it went."""
    path = tmp_path / "day.csv"
    with magician.Arm(port or VirtualArm()) as arm, arm.record(path, rate=50) as recording:
        before = arm.clock()
        arm.move_to(220, 60, 20)
        arm.line_to(220, -60, 20)
        took = arm.clock() - before
    found = rows(path)
    assert took > 1
    assert len(found) == recording.readings >= 50 * took - 4
    assert recording.seconds == pytest.approx(took, abs=0.5)
    for one, other in itertools.pairwise(found):
        assert 0 <= float(other["t"]) - float(one["t"]) < 0.3
        assert abs(float(other["y"]) - float(one["y"])) < 6
    assert float(found[-1]["y"]) == pytest.approx(-60, abs=0.01)


def test_a_hand_need_not_wait_for_the_recording(tmp_path: Path) -> None:
    cell = VirtualArm()
    with cell.arm() as arm:
        with arm.record(tmp_path / "lead.plan.json", rate=200) as recording:
            for j1 in (10, 20, 30):
                cell.guide((j1, 30, 30, 0))
                cell.advance(0.5)
        assert recording.steps is not None and recording.steps >= 3
        arm.move_to(220, 0, 60)
        arm.run(magician.load(tmp_path / "lead.plan.json"))
        assert arm.joints().j1 == pytest.approx(30, abs=0.5)


@pytest.mark.parametrize("name", ["lead.plan.json", "lead.playback"])
def test_manual_motion_is_recorded_as_a_program(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    cell = VirtualArm()
    with cell.arm() as arm:
        with arm.record(path, rate=200) as recording:
            for joints in [(0, 20, 30, 0), (30, 30, 40, 0), (30, 45, 45, 0)]:
                seen(recording)
                cell.advance(0.5)
                seen(recording)
                cell.guide(joints)
            seen(recording)
            cell.advance(0.5)
        taught = cell.position
        assert recording.steps is not None
        assert recording.steps >= 3
        arm.move_to(220, 0, 60)
        arm.run(magician.load(path))
        assert tuple(cell.position)[:3] == pytest.approx(tuple(taught)[:3], abs=0.5)


def test_a_file_that_is_there_is_replaced_only_if_that_is_wanted(tmp_path: Path) -> None:
    path = tmp_path / "day.csv"
    path.write_text("mine", encoding="utf-8")
    with VirtualArm().arm() as arm:
        with pytest.raises(FileExistsError, match=r"overwrite=True"), arm.record(path):
            pass
        assert path.read_text(encoding="utf-8") == "mine"
        with arm.record(path, overwrite=True) as recording:
            seen(recording)
            # The old file stays until the new one is complete.
            assert path.read_text(encoding="utf-8") == "mine"
            assert path.with_name("day.csv.partial").exists()
    assert rows(path)
    assert [file.name for file in tmp_path.iterdir()] == ["day.csv"]


def test_a_trace_replaces_a_file_when_the_arm_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "session.pcapng"
    path.write_text("mine", encoding="utf-8")
    with magician.Arm(VirtualArm(), trace=path) as arm:
        arm.pose()
        assert path.read_text(encoding="utf-8") == "mine"
    assert any(piece.ok for piece in magician.decode(path))
    assert [file.name for file in tmp_path.iterdir()] == ["session.pcapng"]


def test_units_are_a_second_line_and_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "day.csv"
    with VirtualArm().arm() as arm, arm.record(path, rate=200, units=True) as recording:
        seen(recording)
        arm.move_to(220, 40, 20)
    names, units, *_ = path.read_text(encoding="utf-8").splitlines()
    told = dict(zip(names.split(","), units.split(","), strict=True))
    assert (told["t"], told["x"], told["j1"]) == ("s", "mm", "deg")
    assert len(magician.load(path)) > 1


def test_invalid_recordings_are_refused(tmp_path: Path) -> None:
    with VirtualArm().arm() as arm:
        with pytest.raises(errors.InvalidInputError, match=r"a\.txt: its name does not end .*; use \.mcap, \.csv"):
            arm.record(tmp_path / "a.txt").begin()
        with pytest.raises(OSError, match=r"cannot be written"):
            arm.record(tmp_path / "none" / "a.csv").begin()
        for rate, tolerance in ((0, 1), (501, 1), (20, 0)):
            with pytest.raises(errors.InvalidInputError):
                arm.record(tmp_path / "a.csv", rate=rate, tolerance=tolerance)
        recording = arm.record(tmp_path / "a.csv")
        assert repr(recording).endswith(", not begun: 0.0 s, 0 readings, 0.0 mm>")
        with pytest.raises(errors.ClosedError):
            recording.finish()
        recording.begin()
        with pytest.raises(errors.ClosedError):
            recording.begin()
        assert recording.finish() is recording.finish()


def test_lost_line_ends_the_recording_and_keeps_its_readings(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    arm = VirtualArm().arm()
    recording = arm.record(path, rate=200).begin()
    seen(recording)
    arm.close()
    while recording.is_open:
        pass
    with pytest.raises(errors.PortError, match=r"lost the line to the arm after .*; the \d+ readings before"):
        recording.finish()
    assert not recording.is_open
    assert len(rows(path)) == recording.readings


def test_an_exception_of_the_block_goes_before_that_of_the_recording(tmp_path: Path) -> None:
    arm = VirtualArm().arm()
    with pytest.raises(KeyError), arm.record(tmp_path / "a.csv", rate=200):
        arm.close()
        raise KeyError


def test_a_port_is_connected_to_for_as_long(tmp_path: Path) -> None:
    cell = VirtualArm()
    with magician.record(cell, tmp_path / "a.mcap") as recording:
        assert recording.is_open
    assert (tmp_path / "a.mcap").read_bytes().startswith(b"\x89MCAP0")
    cell.restore(cell.snapshot())


def test_it_is_the_same_on_asyncio(tmp_path: Path) -> None:
    async def main() -> tuple[int, int]:
        async with aio.record(VirtualArm(), tmp_path / "a.csv") as one:
            pass
        async with aio.Arm.connect(VirtualArm()) as arm, arm.record(tmp_path / "b.csv") as two:
            await arm.move_to(220, 40, 20)
        return one.readings, two.readings

    one, two = asyncio.run(main())
    assert one >= 1
    assert two >= 1


def session(path: Path) -> Path:
    with magician.Arm(VirtualArm(), trace=path) as arm:
        arm.move_to(220, 30, 20)
        arm.pose()
    return path


def test_a_session_comes_out_the_same(tmp_path: Path) -> None:
    path = session(tmp_path / "session.pcapng")
    again = tmp_path / "again.pcapng"
    # A trace does not contain the virtual time of polls, so their answers may differ.
    found = magician.replay(path, clock="max", ignore=["QueuedCmdCurrentIndex"], save=again)
    assert found.ok, found.differences
    assert found.requests == found.answers > 5
    assert found.ignored > 0
    assert str(found).endswith("fields: all the same")
    assert magician.replay(path.read_bytes(), clock="max", ignore=["QueuedCmdCurrentIndex"]) == found
    assert magician.replay(again, clock="max").ok
    assert any(piece.ok for piece in magician.decode(path))


def test_differences_are_reported(tmp_path: Path) -> None:
    path = session(tmp_path / "session.pcapng")
    # The replaying arm does not know the poses between.
    found = magician.replay(path, clock="max", tolerance=1000)
    assert found.ok or {each.command for each in found.differences} <= {"GetQueuedCmdCurrentIndex"}
    data = path.read_bytes()
    name = bytes.fromhex("AA AA 02 0A 00 F6")
    at = data.index(name)
    # Replace the request by another one with a valid checksum.
    found = magician.replay(data[:at] + bytes.fromhex("AA AA 02 0D 00 F3") + data[at + 6 :], clock="max")
    assert not found.ok
    assert found.found == len(found.differences)
    kinds = {each.kind for each in found.differences}
    assert kinds & {"unasked", "silent", "form", "answered"}
    assert str(found.differences[0]).endswith(found.differences[0].text)


def test_invalid_replays_are_refused(tmp_path: Path) -> None:
    path = session(tmp_path / "session.pcapng")
    with pytest.raises(errors.InvalidInputError, match=r"no link 'other'"):
        magician.replay(path, link="other")
    with pytest.raises(errors.InvalidInputError, match=r"'GetNothing'"):
        magician.replay(path, ignore=["GetNothing"])
    with pytest.raises(errors.InvalidInputError):
        magician.replay(b"none")
    with pytest.raises(TypeError, match=r"names in a list"):
        magician.replay(path, ignore="GetPose")
    with pytest.raises(errors.InvalidInputError, match=r"both read and written"):
        magician.replay(path, save=path)
    scenario = tmp_path / "new.toml"
    scenario.write_text("[table]\n", encoding="utf-8")
    with pytest.raises(errors.InvalidInputError, match=r"both read and written"):
        magician.replay(path, scenario=scenario, save=scenario)
    assert scenario.read_text(encoding="utf-8") == "[table]\n"
    with pytest.raises(OSError):
        magician.Arm(VirtualArm(), trace=tmp_path / "none" / "a.pcapng")
