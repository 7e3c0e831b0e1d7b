"""What is wrong with an arm or with the line to it, and what to do about it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import _magician
from ._arguments import flag, seconds, text, whole
from ._magician import Call
from ._native import until_left, wait_left
from ._values import Value
from .errors import Error

__all__ = ["Diagnosis", "Finding", "doctor", "doctor_async"]


class Finding(Value):
    """One thing that was looked at."""

    check: str
    """What: ``"port"``, ``"line"``, ``"answer"``, ``"back_to_back"``, ``"index_law"``, ``"left_space"``,
    ``"current_index"``, ``"window"``, ``"identity"``, ``"line_speed"``, ``"turnaround"``, ``"jitter"``, ``"losses"``,
    ``"alarms"`` (one for each), ``"homed"``, ``"fence"``, ``"queue"``."""
    ok: bool | None
    """True if it is as it should be; ``None`` where it was not looked at, or there is nothing to judge."""
    value: Any
    """The figure: a number, a text, a dictionary (``"identity"``), or ``None``."""
    unit: str | None
    """Unit of the figure: ``"ms"``, ``"baud"``, ``"requests"``, ``"commands"``, ``"indices"``."""
    text: str
    """What was found."""
    advice: str | None
    """What to do, if there is something to do."""

    def __str__(self) -> str:
        mark = "-" if self.ok is None else "✓" if self.ok else "✗"
        advice = "" if self.advice is None else f"\n  → {self.advice}"
        return f"{mark} {self.check.replace('_', ' ')}: {self.text}{advice}"


class Diagnosis(Value):
    """What was found about an arm and its line. Printed, it is a line for each finding, with what to do about it."""

    findings: tuple[Finding, ...]
    """Each finding, in the order in which they came."""
    port: str | None
    """Where the arm is, once that is known."""
    window: int | None
    """How many requests at once the line takes: for ``magician.Arm(port, window=..)``."""
    turnaround: float | None
    """From request to reply, without the time of the bytes on a serial line, s."""
    error: Error | None
    """Why it ended early: there is no arm, or its line was lost. What :class:`magician.Arm` would raise."""

    @property
    def ok(self) -> bool:
        """True if it came to its end and no check failed."""
        return self.error is None and not self.failed

    @property
    def failed(self) -> tuple[Finding, ...]:
        """The checks that failed."""
        return tuple(finding for finding in self.findings if finding.ok is False)

    def __str__(self) -> str:
        lines = [str(finding) for finding in self.findings]
        # Skip the error if the last finding has the same text.
        if self.error is not None and not (self.findings and self.findings[-1].text == str(self.error)):
            lines.append(f"✗ {self.error}")
        return "\n".join(lines)


def doctor(
    port: str | None = None,
    *,
    count: int = 200,
    timeout: float = 3.0,
    try_queue: bool = False,
    on_finding: Callable[[Finding], object] | None = None,
) -> Diagnosis:
    """Finds the arm, checks it and the line to it, and says how to fix what is wrong, as ``magician doctor`` does.

    >>> magician.doctor("sim").ok
    True

    It checks the port, its permissions and who holds it, tells an arm from other devices, sends reads back to back,
    times replies, and looks at alarms and queue. Nothing moves, and without ``try_queue`` it only reads. An arm that is
    not there is a finding, and no exception. It takes some seconds; a program on asyncio has
    :func:`magician.aio.doctor`. No other program may have the port open, nor this one.

    :param port: As for :class:`magician.Arm`, but a name.
    :param count: How many replies of each of two kinds are timed, 1 to 100,000.
    :param timeout: How long the arm may take to reply, s.
    :param try_queue: Whether to try the queue, too: it is stopped, 15 waits of 0 ms are put into it, and dropped again.
        A queue with commands is left alone; an empty one stays stopped until a program starts it.
    :param on_finding: Called with each finding as it comes. What it raises ends the examination.
    :raises InvalidInputError: The port makes no sense, or an argument is out of range.
    """
    examination = _Examination(port, count, timeout, try_queue, on_finding)
    return examination.ended(*wait_left(examination.call, examination.left, examination.hear))


async def doctor_async(
    port: str | None = None,
    *,
    count: int = 200,
    timeout: float = 3.0,
    try_queue: bool = False,
    on_finding: Callable[[Finding], object] | None = None,
) -> Diagnosis:
    """As :func:`magician.doctor`, for programs on asyncio. Cancelling it ends the examination; the port is closed
    before :exc:`asyncio.CancelledError` is raised.
    """
    examination = _Examination(port, count, timeout, try_queue, on_finding)
    return examination.ended(*await until_left(examination.call, examination.left, examination.hear))


class _Examination:
    """An examination, and what it has found so far."""

    call: Call[tuple[str | None, int | None, float | None, Error | None]]
    left: Call[None]

    def __init__(
        self,
        port: str | None,
        count: int,
        timeout: float,
        try_queue: bool,
        on_finding: Callable[[Finding], object] | None,
    ) -> None:
        if on_finding is not None and not callable(on_finding):
            raise TypeError(f"on_finding is {on_finding!r}; it takes a function")
        self._tell = on_finding
        self._findings: list[Finding] = []
        self.call, self.left = _magician.doctor(
            text("port", port),
            whole("count", count, 1, 100_000),
            seconds("timeout", timeout, above=0),
            flag("try_queue", try_queue),
        )

    def hear(self, found: list[Any]) -> None:
        """Hears what was found."""
        for parts in found:
            self._findings.append(Finding(*parts))
            if self._tell is not None:
                self._tell(self._findings[-1])

    def ended(self, port: str | None, window: int | None, turnaround: float | None, error: Error | None) -> Diagnosis:
        """It has come to its end."""
        turnaround = None if turnaround is None else turnaround / 1000
        return Diagnosis(tuple(self._findings), port, window, turnaround, error)
