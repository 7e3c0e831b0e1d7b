"""Runs of plans: how far they are, what they come to, and how they end when somebody interrupts them."""

from __future__ import annotations

import asyncio
import contextlib
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TextIO, Union

from ._magician import Call, Core, Course
from .programs import Report, report_of

__all__ = ["Progress", "RunResult"]

LOOK = 0.05
"""Seconds between two looks at how far a run is."""
PATIENCE = 0.3
"""A run that is over sooner needs no line, s."""
LINES = 3.0
"""Between two lines where none can be written over, s."""


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    done: int
    """Steps that are finished."""
    steps: int
    """Steps of the plan."""
    seconds_left: float | None
    """How long the rest takes, where that is known; not on a virtual arm, whose clock may run at any speed."""

    @property
    def share(self) -> float:
        """Between 0 and 1."""
        return self.done / self.steps if self.steps else 1.0

    def __str__(self) -> str:
        left = "" if self.seconds_left is None else f", {_clock(self.seconds_left)} left"
        return f"step {self.done} of {self.steps}, {100 * self.share:.0f} %{left}"


@dataclass(frozen=True)
class RunResult:
    """What a run has come to."""

    steps: int
    """Steps that were done."""
    commands: int
    """Commands that the arm was sent for them."""
    seconds: float
    """How long it took, on the arm's clock."""
    first_index: int | None
    """Queue index of the first command."""
    last_index: int | None
    """Queue index of the last."""
    report: Report
    """What was found before anything moved."""


Watcher = Union[bool, Callable[[Progress], object]]
"""Who is told how far a run is: nobody, a line on stderr, or a function."""


class _Telling:
    """Tells somebody how far a run is."""

    def __init__(self, course: Course, steps: int, watcher: Watcher) -> None:
        self._course = course
        self._steps = steps
        self._line = Line(sys.stderr) if watcher is True else None
        self._told: Progress | None = None
        self._tell = watcher if callable(watcher) else self._line

    def now(self) -> Progress:
        return Progress(self._course.steps, self._steps, self._course.left)

    def look(self) -> None:
        """Tells it, if there is something new."""
        now = self.now()
        if self._tell is not None and now != self._told:
            self._told = now
            self._tell(now)

    def end(self) -> None:
        """The run has ended well."""
        self.look()
        if self._line is not None:
            self._line.end(self.now())

    def broken(self, error: BaseException) -> None:
        """It has not: the exception is told how far it came."""
        if self._line is not None:
            self._line.clear()
        now = self.now()
        if 0 < now.done < now.steps:
            note(error, f"{now.done} of {now.steps} steps are done; first_step={now.done + 1} goes on")


class Line:
    """A line on a terminal that is written over, or one every few seconds elsewhere."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._over = out.isatty()
        self._begun = self._last = time.monotonic()
        self._shown = False

    def __call__(self, progress: Progress) -> None:
        now = time.monotonic()
        if now - self._last < (PATIENCE if self._over and not self._shown else 0 if self._over else LINES):
            return
        self._last, self._shown = now, True
        if self._over:
            filled = int(24 * progress.share)
            self._write(f"\r[{'=' * filled}{' ' * (24 - filled)}] {progress}\x1b[K")
        else:
            self._write(f"{progress}\n")

    def clear(self) -> None:
        if self._over and self._shown:
            self._write("\r\x1b[K")

    def end(self, progress: Progress) -> None:
        self.clear()
        self._write(f"{progress.done} of {progress.steps} steps done in {_clock(time.monotonic() - self._begun)}\n")

    def _write(self, text: str) -> None:
        # Nobody who reads is no reason to stop an arm.
        with contextlib.suppress(OSError, ValueError):
            self._out.write(text)
            self._out.flush()


def follow(core: Core, begun: tuple[Call[dict[str, Any]], Course], steps: int, watcher: Watcher) -> RunResult:
    """Waits in this thread for the end of a run. Whatever else ends the wait, Ctrl-C above all, stops the arm first."""
    call, course = begun
    telling = _Telling(course, steps, watcher)
    ended = threading.Event()
    call.on_end(ended.set)
    try:
        while not ended.wait(LOOK):
            telling.look()
        telling.look()
    except BaseException as error:
        try:
            core.stop().wait()
            # It gives the settings back.
            ended.wait(3.0)
        except Exception as failure:
            note(error, f"the arm may go on: it did not confirm the stop: {failure}")
        telling.broken(error)
        raise
    try:
        result = _result(call.result())
    except BaseException as error:
        telling.broken(error)
        raise
    telling.end()
    return result


async def follow_in_loop(
    core: Core, begun: tuple[Call[dict[str, Any]], Course], steps: int, watcher: Watcher
) -> RunResult:
    """Waits in the running event loop for the end of a run. Whatever else ends the wait, a cancellation above all, stops the
    arm first."""
    from ._native import until

    call, course = begun
    telling = _Telling(course, steps, watcher)
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    call.on_end(lambda: loop.call_soon_threadsafe(ended.set))
    try:
        while not ended.is_set():
            try:
                await asyncio.wait_for(ended.wait(), LOOK)
            except (TimeoutError, asyncio.TimeoutError):
                telling.look()
        telling.look()
    except BaseException as error:
        try:
            await until(core.stop())
            await asyncio.wait_for(ended.wait(), 3.0)
        except Exception as failure:
            note(error, f"the arm may go on: it did not confirm the stop: {failure}")
        telling.broken(error)
        raise
    try:
        result = _result(call.result())
    except BaseException as error:
        telling.broken(error)
        raise
    telling.end()
    return result


def note(error: BaseException, text: str) -> None:
    """Adds a line to what an exception says of itself."""
    if sys.version_info >= (3, 11):
        error.add_note(text)
    else:
        error.__notes__ = [*getattr(error, "__notes__", []), text]  # type: ignore[attr-defined]


def _result(found: dict[str, Any]) -> RunResult:
    return RunResult(
        steps=found["steps"],
        commands=found["commands"],
        seconds=found["seconds"],
        first_index=found["first_index"],
        last_index=found["last_index"],
        report=report_of(found["report"]),
    )


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
