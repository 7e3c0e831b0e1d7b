"""The plugin for pytest, in a run of its own."""

from __future__ import annotations

import pytest

TEST = """
import pytest
from magician import Plan, words

@pytest.mark.scenario("cell.toml")
def test_the_cube_is_held(arm, virtual_arm):
    arm.run(Plan.path([(220, 80, -40)], by="jump", tool="suction"))
    arm.perform([words.suction(True), words.wait(0.5)])
    assert virtual_arm.object("red cube").held

@pytest.mark.scenario("cell.toml")
def test_every_test_has_its_own(virtual_arm):
    assert virtual_arm.object("red cube").on_table

@pytest.mark.scenario("title = 'here'")
def test_fails(virtual_arm):
    assert virtual_arm.title == "there"

def test_without_a_world(virtual_arm):
    assert virtual_arm.objects == []
"""
CELL = """
tool = { kind = "suction" }
table = { height = -60 }
object = [{ name = "red cube", size = [20, 20, 20], at = [220, 80], color = "red" }]
"""


def test_fixtures_and_marks(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(TEST)
    pytester.makefile(".toml", cell=CELL)
    result = pytester.runpytest_subprocess("--strict-markers")
    result.assert_outcomes(passed=3, failed=1)
    result.stdout.fnmatch_lines(["*virtual arm*", "<VirtualArm here at x 259.1*", "alarms: 0x00 RESET_OCCURRED"])
    assert "scenario(file_or_text)" in pytester.runpytest_subprocess("--markers").stdout.str()
