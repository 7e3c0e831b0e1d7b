"""Plugin for pytest; see :mod:`magician.testing`."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .. import Arm, VirtualArm

MARK = "scenario(file_or_text): the world of the virtual arm of a test, a path beside the test file or a text in TOML"


def pytest_configure(config: pytest.Config) -> None:
    """Registers the mark."""
    config.addinivalue_line("markers", MARK)


@pytest.fixture
def virtual_arm(request: pytest.FixtureRequest) -> VirtualArm:
    """Provides a virtual arm for this test, in virtual time: see ``@pytest.mark.scenario``."""
    from .. import VirtualArm

    return VirtualArm(_scenario(request))


@pytest.fixture
def arm(virtual_arm: VirtualArm) -> Iterator[Arm]:
    """Provides an arm connected to the virtual arm of this test."""
    connected = virtual_arm.arm()
    try:
        yield connected
    finally:
        connected.close()


def _scenario(request: pytest.FixtureRequest) -> str | Path | None:
    mark = request.node.get_closest_marker("scenario")
    if mark is None:
        return None
    given = mark.args[0] if len(mark.args) == 1 and not mark.kwargs else mark.args
    if not isinstance(given, (str, Path)):
        raise TypeError(f"a scenario is a path or a text, not {given!r}")
    if isinstance(given, str) and ("\n" in given or "=" in given):
        return given
    return Path(request.path).parent / given


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Adds the state of the arm to the report of a failed test."""
    report = yield
    virtual = getattr(item, "funcargs", {}).get("virtual_arm")
    if report.when == "call" and report.failed and virtual is not None:
        report.sections.append(("virtual arm", _describe(virtual)))
    return report


def _describe(virtual: Any) -> str:
    lines = [repr(virtual), *map(repr, virtual.objects)]
    alarms = virtual.alarms
    if alarms:
        lines.append("alarms: " + ", ".join(f"0x{alarm:02x} {alarm.name}" for alarm in alarms))
    lines += virtual.events()
    return "\n".join(lines)
