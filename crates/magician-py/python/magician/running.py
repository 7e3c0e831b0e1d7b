"""Runs of plans: their progress and their results."""

from __future__ import annotations

from collections.abc import Callable

from ._reports import Report, clock
from ._values import Value

__all__ = ["PlanProgress", "RunResult", "Watcher"]


class PlanProgress(Value):
    """How far a run is."""

    done: int
    """Steps that are finished."""
    steps: int
    """Steps of the plan."""
    seconds_left: float | None
    """How long the rest takes, where that is known; not on a virtual arm, whose clock may run at any speed."""
    seconds_silent: float = 0.0
    """How long the arm has not answered while the run waits for it; 0 as long as it answers."""

    @property
    def share(self) -> float:
        """Between 0 and 1."""
        return self.done / self.steps if self.steps else 1.0

    def __str__(self) -> str:
        left = "" if self.seconds_left is None else f", {clock(self.seconds_left)} left"
        if self.seconds_silent >= 1:
            left = f", waiting for the arm's reply, {self.seconds_silent:.0f} s"
        return f"step {self.done} of {self.steps}, {100 * self.share:.0f} %{left}"


class RunResult(Value):
    """The result of a run."""

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
    pen: str | None = None
    """How the pen of a drawing stands: ``"up"`` or ``"down"``; ``None`` for what is no drawing."""
    parked: bool = False
    """Whether the tool was parked."""


Watcher = bool | Callable[[PlanProgress], object]
"""Who is told how far a run is: nobody, a line on stderr, or a function."""
