"""Points in and out, with and without NumPy."""

from __future__ import annotations

import math
import subprocess
import sys
from array import array
from typing import Any

import pytest
from magician import Plan, words
from magician.errors import InvalidInputError

ROWS = [(200.0, 0.0, 0.0), (220.0, 10.0, 0.0), (240.0, 0.0, 0.0)]
NAN = math.nan


def test_rows_of_numbers_are_a_path() -> None:
    plan = Plan.path(ROWS, lift=5, speed=30)
    assert [step.action for step in plan.steps] == ["command", "move", "move", "path", "path", "move"]
    assert [step.by for step in plan.steps if step.action == "move"] == ["joints", "line", "line"]
    assert plan.targets()[1] == (200, 0, 5) and plan.targets()[-1] == (240, 0, 5)
    assert plan.steps[3].row == 1 and plan.steps[3].line is None
    assert plan.steps[0].command == words.path_speed(30, 100)
    assert [step.by for step in Plan.path(ROWS, lift=0, speed=None).steps] == ["joints", None, None]


def test_gaps_lift_the_tool() -> None:
    plan = Plan.path([*ROWS, (NAN, NAN, NAN), *ROWS], speed=None)
    assert [step.action for step in plan.steps] == ["move", "move", "path", "path", "move"] * 2
    assert Plan.path([(NAN, NAN, NAN)], speed=None).commands() == []


def test_moves_go_to_each_point() -> None:
    four = [(*row, 5.0 * at) for at, row in enumerate(ROWS)]
    for by in ("line", "joints", "jump"):
        plan = Plan.path(four, by=by)
        assert [(step.by, step.values) for step in plan.steps] == [(by, row) for row in four]
    assert Plan.path(ROWS, by="line", r=7).steps[2].values == (240, 0, 0, 7)


def test_a_laser_has_a_power_for_all_or_for_each() -> None:
    one = Plan.path(ROWS, power=40, tool="laser")
    assert [step.values[3] for step in one.steps if step.action == "burn"] == [40, 40]
    each = Plan.path(ROWS, power=[10, 20, 30])
    assert [step.values[3] for step in each.steps if step.action == "burn"] == [20, 30]
    with pytest.raises(InvalidInputError, match=r"power has the shape \(3,\)"):
        Plan.path(ROWS, power=[10, 20])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([(1.0, 2.0)], r"shape \(n, 3\) or \(n, 4\)"),
        ([(1.0, 2.0, 3.0), (1.0, 2.0, 3.0, 4.0)], "3 or 4"),
        ([1.0, 2.0, 3.0], r"these have \(3,\)"),
        ([(200.0, 0.0, math.inf)], "row 0: z is inf"),
        ([*ROWS, (200.0, NAN, 0.0)], "row 3: y is NaN"),
        ([(200.0, 0.0, 0.0, 0.0), (210.0, 0.0, 0.0, 1.0)], "row 1: r is 1, and 0"),
    ],
)
def test_invalid_points_are_refused(points: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Plan.path(points)


def test_a_complaint_names_the_row() -> None:
    report = Plan.path([*ROWS, (500.0, 0.0, 0.0)], by="line").check()
    (complaint,) = report.complaints
    assert (complaint.row, complaint.line, complaint.step) == (3, None, 4)
    assert str(complaint).startswith("row 3, step 4: ")


def test_buffers_go_in_without_numpy() -> None:
    flat = array("d", [number for row in ROWS for number in row])
    table = memoryview(flat).cast("B").cast("d", (3, 3))
    assert Plan.path(table) == Plan.path(ROWS)  # type: ignore[arg-type]


def test_numpy_is_not_imported_unless_it_is_there_already() -> None:
    program = "import sys, magician; magician.Plan.path([(200, 0, 0)]).check(); assert 'numpy' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_arrays_go_in_and_come_out() -> None:
    numpy = pytest.importorskip("numpy")
    table = numpy.array(ROWS)
    plan = Plan.path(table, speed=None)
    assert plan == Plan.path(ROWS, speed=None)
    for other in (table.astype("float32"), table.astype("int64"), numpy.asfortranarray(table), table.astype(">f8")):
        assert Plan.path(other, speed=None) == plan
    wide = numpy.zeros((3, 8))
    wide[:, ::2][:, :3] = table
    assert Plan.path(wide[:, ::2][:, :3], speed=None) == plan
    out = plan.to_numpy()
    assert out.shape == (5, 3) and out.dtype == numpy.float64 and out.flags.writeable
    numpy.testing.assert_array_equal(out[1:-1], table)
    powers = numpy.linspace(0, 100, 3)
    assert [step.values[3] for step in Plan.path(table, power=powers).steps if step.action == "burn"] == [50, 100]
    done = Plan.path(table, tool="pen").rehearse(watch=0.1)
    assert done.way_to_numpy().shape[1] == 3
    assert done.drawing[0].to_numpy().shape == (len(done.drawing[0].points), 2)


def test_a_hundred_thousand_points_go_in_at_once() -> None:
    numpy = pytest.importorskip("numpy")
    angle = numpy.linspace(0, 400 * numpy.pi, 100_000)
    radius = numpy.linspace(5, 40, angle.size)
    points = numpy.column_stack(
        [240 + radius * numpy.cos(angle), radius * numpy.sin(angle), numpy.full_like(angle, -50)]
    )
    plan = Plan.path(points, tool="pen")
    report = plan.check()
    assert report.ok and report.counts["path"] == 99_999
    assert report.drawn == pytest.approx(float(numpy.hypot(*numpy.diff(points[:, :2], axis=0).T).sum()), rel=1e-5)
    numpy.testing.assert_allclose(plan.to_numpy()[3:-1], points[1:], atol=2e-5)


def test_arrays_of_other_things_are_refused() -> None:
    numpy = pytest.importorskip("numpy")
    table = numpy.array(ROWS)
    for wrong in (complex, object, str, bool, "S8", "M8[s]"):
        values = numpy.zeros((3, 3), dtype=wrong)
        with pytest.raises(
            TypeError, match=r"points must be real numbers, not an array of .*: convert it by astype\(float\)"
        ):
            Plan.path(values)
        with pytest.raises(TypeError, match=r"power must be real numbers"):
            Plan.path(table, power=values[0])


def test_masks_are_not_overlooked() -> None:
    numpy = pytest.importorskip("numpy")
    table = numpy.ma.array(ROWS, mask=[[0, 0, 0], [0, 1, 0], [0, 0, 0]])
    with pytest.raises(InvalidInputError, match="points are masked, row 1"):
        Plan.path(table)
    with pytest.raises(InvalidInputError, match="power are masked, row 2"):
        Plan.path(ROWS, power=numpy.ma.array([1.0, 2.0, 3.0], mask=[0, 0, 1]))
    assert Plan.path(numpy.ma.array(ROWS)) == Plan.path(ROWS)
    assert Plan.path(numpy.ma.array(ROWS, mask=numpy.zeros((3, 3)))) == Plan.path(ROWS)
    assert Plan.path(table.filled(0.0)).steps[3].values == (220, 0, 0)


def test_arrays_of_every_layout() -> None:
    numpy = pytest.importorskip("numpy")
    table = numpy.array(ROWS)
    plan = Plan.path(ROWS)
    for kind in ("f2", "f4", "f8", "g", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", ">f4", ">i4"):
        few = numpy.array([(100, 0, 0), (120, 10, 0)])
        assert Plan.path(few.astype(kind)) == Plan.path(few.tolist()), kind
    layouts: list[Any] = [numpy.asfortranarray(table), table.T.copy().T, table[::-1][::-1], table.view(), list(table)]
    layouts += [tuple(tuple(row) for row in ROWS), numpy.broadcast_to(table, (3, 3)), iter(ROWS), memoryview(table)]
    for same in layouts:
        assert Plan.path(same) == plan
    table.flags.writeable = False
    assert Plan.path(table) == plan
    assert Plan.path(table[::2]) == Plan.path(ROWS[::2])
    assert Plan.path(numpy.broadcast_to(table[:1], (2, 3))) == Plan.path([ROWS[0]] * 2)


def test_arrays_of_other_shapes() -> None:
    numpy = pytest.importorskip("numpy")
    nothing: list[Any] = [numpy.empty((0, 3)), numpy.empty((0, 4), dtype="f4"), [], ()]
    for none in nothing:
        assert Plan.path(none, speed=None).commands() == []
    for shape in ((), (3,), (0,), (3, 0), (3, 2), (3, 5), (2, 3, 3), (0, 2)):
        for kind in ("f8", "f4"):
            with pytest.raises(InvalidInputError, match=r"the shape \(n, 3\) or \(n, 4\).*these have \(") as caught:
                Plan.path(numpy.full(shape, 200.0, dtype=kind))
            assert str(caught.value).endswith(f"these have {shape}")
    with pytest.raises(InvalidInputError, match=r"power has the shape \(3,\).*this has \(3, 1\)"):
        Plan.path(ROWS, power=numpy.ones((3, 1)))


def test_rows_of_other_things_are_refused() -> None:
    none: list[Any] = ["200", None, 1j, [1], {}]
    for wrong in none:
        with pytest.raises(TypeError, match="points: row 1 has"):
            Plan.path([ROWS[0], (200, 0, wrong)])
    with pytest.raises(InvalidInputError, match="points: row 1 has"):
        Plan.path([ROWS[0], (200, 0, 10**400)])
    none = ["abc", b"abc", {1: 2}, 5, None]
    for wrong in none:
        with pytest.raises(TypeError):
            Plan.path(wrong)


def test_powers_are_percent_and_for_paths() -> None:
    for bad in (NAN, math.inf, -1, 101):
        with pytest.raises(InvalidInputError, match=r"row 1: power is .* %; it is a number from 0 to 100"):
            Plan.path(ROWS, power=[10, bad, 10])
        with pytest.raises(InvalidInputError, match=r"power is .*; it takes a number from 0 to 100"):
            Plan.path(ROWS, power=bad)
    gap = Plan.path([*ROWS, (NAN, NAN, NAN), *ROWS], power=[1, 2, 3, NAN, 4, 5, 6])
    assert [step.values[3] for step in gap.steps if step.action == "burn"] == [2, 3, 5, 6]
    with pytest.raises(InvalidInputError, match=r'power is for by="path"'):
        Plan.path(ROWS, by="line", power=10)
