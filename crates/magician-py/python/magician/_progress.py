"""Progress reports of a run, and notes on its failure."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from typing import Any, Protocol, TextIO

from ._reports import clock, report
from .running import PlanProgress, RunResult, Watcher

__all__ = ["ProgressLine", "ProgressReporter"]

FIRST_LINE_DELAY = 0.3
"""Delay before the first progress line, s; shorter runs print none."""
DEFAULT_COLUMNS = 80
"""Default terminal width, columns."""
LINE_INTERVAL = 3.0
"""Interval of progress lines where a line cannot be overwritten, s."""


class ProgressReporter:
    """Reports the progress of a run."""

    def __init__(self, steps: int, watcher: Watcher) -> None:
        # None in a program without a console.
        out: TextIO | None = sys.stderr
        self._line = ProgressLine(out) if watcher is True and out is not None else None
        self._tell = watcher if callable(watcher) else self._line
        self._now = PlanProgress(0, steps, None)

    def __call__(self, reported: tuple[int, float | None, float]) -> None:
        """Receives a report of the native part."""
        now = PlanProgress(reported[0], self._now.steps, reported[1], reported[2])
        if now != self._now:
            self._now = now
            if self._tell is not None:
                self._tell(now)

    def ended(self, found: dict[str, Any]) -> RunResult:
        """Handles the successful end of the run."""
        if self._line is not None:
            done, steps = self._now.done, self._now.steps
            self._line.end(f"{done} of {steps} steps done")
        return RunResult(
            steps=found["steps"],
            commands=found["commands"],
            seconds=found["seconds"],
            first_index=found["first_index"],
            last_index=found["last_index"],
            pen=found["pen"],
            parked=found["parked"],
            report=report(found["report"]),
        )

    def broken(self, error: BaseException, said: str | None) -> None:
        """Handles a failure: adds notes on the arm's state and the progress to the exception."""
        if self._line is not None:
            self._line.clear()
        if said is not None:
            _note(error, said)
        if 0 < self._now.done < self._now.steps:
            done, steps = self._now.done, self._now.steps
            _note(error, f"at least {done} of {steps} steps are done; first_step={done + 1} goes on")


class HasShare(Protocol):
    """Progress of an operation."""

    @property
    def share(self) -> float:
        """Finished share, 0 to 1."""
        ...


class ProgressLine:
    """Progress line, overwritten on a terminal, or printed every few seconds elsewhere."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._over = out.isatty()
        self._begun = self._last = time.monotonic()
        # Width of the text on the line. Blanks erase it: a Windows console may ignore escape sequences.
        self._width = 0

    def __call__(self, progress: HasShare) -> None:
        now = time.monotonic()
        delay = (0 if self._width else FIRST_LINE_DELAY) if self._over else LINE_INTERVAL
        if now - self._last < delay:
            return
        self._last = now
        if self._over:
            filled = int(24 * progress.share)
            bar = f"[{'=' * filled}{' ' * (24 - filled)}] {progress}"
            # Text that wraps past the last column cannot be overwritten.
            room = self._columns() - 1
            bar = bar if len(bar) <= room else str(progress)[:room]
            self._write("\r" + bar.ljust(min(self._width, room)))
            self._width = len(bar)
        else:
            self._write(f"{progress}\n")

    def _columns(self) -> int:
        with contextlib.suppress(OSError, ValueError):
            return os.get_terminal_size(self._out.fileno()).columns or DEFAULT_COLUMNS
        return DEFAULT_COLUMNS

    def clear(self) -> None:
        if self._width:
            self._write("\r" + " " * self._width + "\r")
            self._width = 0

    def end(self, done: str) -> None:
        self.clear()
        self._write(f"{done} in {clock(time.monotonic() - self._begun)}\n")

    def _write(self, text: str) -> None:
        # A closed stderr must not stop the arm.
        with contextlib.suppress(OSError, ValueError):
            self._out.write(text)
            self._out.flush()


def _note(error: BaseException, text: str) -> None:
    """Adds a note to an exception."""
    if sys.version_info >= (3, 11):
        error.add_note(text)
    else:
        error.__notes__ = [*getattr(error, "__notes__", []), text]  # type: ignore[attr-defined]
