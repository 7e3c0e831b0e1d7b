from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import magician
import pytest


@pytest.fixture
def arm() -> Iterator[magician.Arm]:
    """A virtual arm at full speed, homed."""
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
        thread.join(30)
        assert not thread.is_alive()
