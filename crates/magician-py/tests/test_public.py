"""What is public: listed, documented, with hints and signatures that can be read."""

from __future__ import annotations

import importlib
import importlib.metadata
import inspect
import pkgutil
import subprocess
import sys
import types
import typing
from collections.abc import Iterator
from typing import Any

import magician
import pytest

# What tools/dobotdll.py brings is as the vendor's scripts know it.
BROUGHT = tuple(f"magician.compat.dobotdll.v{family}" for family in (1, 2, 3))


def public_modules() -> Iterator[types.ModuleType]:
    yield magician
    for found in pkgutil.walk_packages(magician.__path__, "magician."):
        if not any(part.startswith("_") for part in found.name.split(".")) and found.name not in BROUGHT:
            yield importlib.import_module(found.name)


MODULES = list(public_modules())


def listed(module: types.ModuleType) -> dict[str, Any]:
    return {name: getattr(module, name) for name in getattr(module, "__all__", ())}


def members(cls: type) -> Iterator[tuple[str, Any]]:
    """The public functions, properties and methods of a class that are this package's."""
    for name, found in inspect.getmembers_static(cls) if sys.version_info >= (3, 11) else vars(cls).items():
        if not name.startswith("_"):
            found = getattr(found, "__func__", found)
            found = found.fget if isinstance(found, property) else found
            if inspect.isfunction(found) and (found.__module__ or "").startswith("magician"):
                yield name, found


def objects() -> Iterator[tuple[str, Any]]:
    for module in MODULES:
        for name, found in listed(module).items():
            if inspect.isclass(found) or inspect.isroutine(found):
                yield f"{module.__name__}.{name}", found
            if inspect.isclass(found):
                yield from ((f"{module.__name__}.{name}.{member}", each) for member, each in members(found))


OBJECTS = dict(objects())


def test_there_are_many() -> None:
    for name in ("magician.Arm.move_to", "magician.aio.Arm.connect", "magician.Plan.path", "magician.Plan.estimate"):
        assert name in OBJECTS
    assert len(MODULES) > 15 and len(OBJECTS) > 700


@pytest.mark.parametrize("module", MODULES, ids=[module.__name__ for module in MODULES])
def test_what_has_no_underscore_is_public(module: types.ModuleType) -> None:
    assert module.__doc__
    if not hasattr(module, "__all__"):
        return  # a door to others, or pytest's
    for name, found in vars(module).items():
        if getattr(found, "__module__", None) == module.__name__ and not name.startswith("_"):
            assert name in listed(module), name


def test_hints_can_be_read() -> None:
    for name, found in OBJECTS.items():
        hints = typing.get_type_hints(found)
        if inspect.isfunction(found):
            assert "return" in hints, name


def test_signatures_can_be_read() -> None:
    for name, found in OBJECTS.items():
        if inspect.isclass(found) and issubclass(found, BaseException) and found.__init__ is Exception.__init__:
            continue  # as Python's own
        if typing.is_typeddict(found):
            continue  # no more than a dict
        assert inspect.signature(found) is not None, name


def test_all_is_documented() -> None:
    assert [name for name, found in OBJECTS.items() if not inspect.getdoc(found)] == []
    for module in MODULES:
        for name, found in listed(module).items():
            if inspect.isclass(found):
                bases: list[Any] = [base for base in found.__mro__[1:] if base is not object]
                assert found.__doc__ and found.__doc__ not in [base.__doc__ for base in bases], name


def test_help() -> None:
    program = "import magician; help(magician); help(magician.Arm); help(magician.commands); help(magician.words)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stderr == ""
    for part in ("Drive a Dobot Magician", "move_to(", "class PtpCmd(", "jump_to("):
        assert part in done.stdout


def test_the_version_is_that_of_the_distribution() -> None:
    assert magician.__version__ == importlib.metadata.version("dobot-magician")


def test_all_that_is_seen_is_seen_in_short(arm: magician.Arm, virtual_arm: magician.VirtualArm) -> None:
    plan = magician.Plan.path([(200, 0, 0), (900, 0, 0)], title="far")
    report = plan.check()
    jog = arm.jog("x+")
    shown = {
        jog: "<Jog>",
        arm.events(): "<Events of an arm>",
        arm.begin([]): "<Run, 0 commands done>",
        magician.aio.Arm.connect("sim"): "<Connecting to 'sim': await it>",
    }
    for thing, text in shown.items():
        assert repr(thing) == text
    with jog:
        assert repr(jog) == "<Jog, under way>"
    watch = arm.state()
    watch.changed()
    assert repr(watch) == "<StateWatch, the line is up>"
    assert repr(report) == f"<Report: {str(report).splitlines()[0]}>" and "are refused" in repr(report)
    assert repr(report.complaints[0]).startswith("<Complaint: row 1, step ")
    rehearsal = magician.Plan.path([(200, 0, 0)]).rehearse()
    assert repr(rehearsal) == "<Rehearsal: 4 steps, done after " + repr(rehearsal).split(" after ")[1]
    for value in (report, rehearsal, plan, plan.preview(), rehearsal.drawing, arm, virtual_arm, arm.pose(), arm.info()):
        assert len(repr(value)) < 300


def test_values_are_taken_apart(arm: magician.Arm) -> None:
    match arm.pose():
        case magician.Pose(x, _, _, r):
            assert (x, r) == (arm.pose().x, 0)
        case _:
            raise AssertionError
    match magician.events.Missed(3):
        case magician.events.Missed(count):
            assert count == 3


def test_plans_are_multiplied_from_either_side() -> None:
    plan = magician.Plan.path([(200, 0, 0)])
    anything: Any = plan
    assert 2 * plan == plan * 2 == plan + plan
    for wrong in (None, 3, "x"):
        with pytest.raises(TypeError):
            _ = anything + wrong
        assert anything != wrong


def test_what_is_no_program_is_told_what_one_is(arm: magician.Arm) -> None:
    plan = magician.Plan.path([(200, 0, 0)])
    anything: Any = arm
    for verb in (anything.perform, anything.estimate, anything.begin, anything.run):
        with pytest.raises(TypeError, match=r"commands in a list: \[HomeCmd\(...\)\]"):
            verb(magician.words.home())
        with pytest.raises(TypeError, match=r"commands in a list, not 5 \(int\): magician.words makes them"):
            verb(5)
        with pytest.raises(TypeError, match=r"magician.load\('x.svg'\)"):
            verb("x.svg")
    for verb in (anything.perform, anything.estimate, anything.begin):
        with pytest.raises(TypeError, match=r"arm.run\(plan\) runs a Plan"):
            verb(plan)


def test_an_arm_on_asyncio_is_connected_to() -> None:
    arm: Any = magician.aio.Arm
    with pytest.raises(TypeError, match=r"await Arm.connect\(...\)"):
        arm("sim")
    assert inspect.iscoroutinefunction(magician.aio.discover)
