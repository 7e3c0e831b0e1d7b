from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import magician
import pytest

pytest_plugins = ["pytester"]

CRATES = Path(__file__).parents[2]


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> None:
    """A shell that starts something in the background has it ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def samples() -> Path:
    """The sample files of the program crate."""
    return CRATES / "magician-program" / "samples"


@pytest.fixture(scope="session")
def scenarios() -> Path:
    """The example scenarios of the simulator."""
    return CRATES / "magician-sim" / "scenarios"


def in_notebook(thing: object, kind: str = "svg") -> str:
    """What a notebook shows of it."""
    shown: str = getattr(thing, f"_repr_{kind}_")()
    return shown


@pytest.fixture
def arm(request: pytest.FixtureRequest) -> Iterator[magician.Arm]:
    """A virtual arm at full speed, homed; that of the test, as it is, if it has one of its own."""
    if "virtual_arm" in request.fixturenames:
        with request.getfixturevalue("virtual_arm").arm() as arm:
            yield arm
        return
    with magician.Arm("sim") as arm:
        arm.home()
        yield arm


@pytest.fixture
def slow() -> Iterator[magician.Arm]:
    """A virtual arm at the speed of a real one, its alarms cleared: what it waits for, it waits for."""
    with magician.Arm("sim:1") as arm:
        arm.clear_alarms()
        yield arm


@pytest.fixture
def meanwhile() -> Iterator[Callable[[Callable[[], object]], threading.Thread]]:
    """Starts threads, and has them end before the test does. What they raise fails the test (pytest's own check)."""
    threads: list[threading.Thread] = []

    def start(task: Callable[[], object]) -> threading.Thread:
        thread = threading.Thread(target=task)
        threads.append(thread)
        thread.start()
        return thread

    yield start
    for thread in threads:
        thread.join(120)
        assert not thread.is_alive()
