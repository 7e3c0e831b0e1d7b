"""Runs of plans: their progress and their results."""

from __future__ import annotations

from collections.abc import Callable

from ._reports import Report, clock
from ._values import Value

__all__ = ["PlanProgress", "RunResult", "Watcher"]


class PlanProgress(Value):
    """Progress of a run."""

    done: int
    """Number of finished steps."""
    steps: int
    """Number of steps of the plan."""
    seconds_left: float | None
    """Estimated remaining time, s; ``None`` if unknown, as on a virtual arm, whose clock may run at any speed."""
    seconds_silent: float = 0.0
    """Time since the arm last answered while the run waits for it, s; 0 while it answers."""

    @property
    def share(self) -> float:
        """Share of the steps that are finished, 0 to 1."""
        return self.done / self.steps if self.steps else 1.0

    def __str__(self) -> str:
        left = "" if self.seconds_left is None else f", {clock(self.seconds_left)} left"
        if self.seconds_silent >= 1:
            left = f", waiting for the arm's reply, {self.seconds_silent:.0f} s"
        return f"step {self.done} of {self.steps}, {100 * self.share:.0f} %{left}"


class RunResult(Value):
    """The result of a run."""

    steps: int
    """Number of finished steps."""
    commands: int
    """Number of commands sent for them."""
    seconds: float
    """Duration on the arm's clock, s."""
    first_index: int | None
    """Queue index of the first command."""
    last_index: int | None
    """Queue index of the last command."""
    report: Report
    """Report of the check before the run."""
    pen: str | None = None
    """Final position of the pen: ``"up"`` or ``"down"``; ``None`` if the plan is no drawing."""
    parked: bool = False
    """True if the tool was parked."""


Watcher = bool | Callable[[PlanProgress], object]
"""Receiver of progress: ``None``, ``True`` for a line on stderr, or a function."""
