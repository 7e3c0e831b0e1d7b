"""Diagnosis of an arm and its line, with remedies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import _magician
from ._arguments import flag, seconds, text, whole
from ._magician import Call
from ._native import until_with_cleanup, wait_with_cleanup
from ._values import Value
from .errors import Error

__all__ = ["Diagnosis", "Finding", "doctor", "doctor_async"]


class Finding(Value):
    """Result of one check."""

    check: str
    """Name of the check: ``"port"``, ``"line"``, ``"answer"``, ``"back_to_back"``, ``"index_law"``, ``"left_space"``,
    ``"current_index"``, ``"window"``, ``"identity"``, ``"line_speed"``, ``"turnaround"``, ``"jitter"``, ``"losses"``,
    ``"alarms"`` (one for each), ``"homed"``, ``"fence"``, ``"queue"``."""
    ok: bool | None
    """True if the check passed; ``None`` if it was skipped or has no verdict."""
    value: Any
    """Measured value: a number, a text, a dictionary (``"identity"``), or ``None``."""
    unit: str | None
    """Unit of the value: ``"ms"``, ``"baud"``, ``"requests"``, ``"commands"``, ``"indices"``."""
    text: str
    """Description of the result."""
    advice: str | None
    """Remedy, if there is one."""

    def __str__(self) -> str:
        mark = "-" if self.ok is None else "✓" if self.ok else "✗"
        advice = "" if self.advice is None else f"\n  → {self.advice}"
        return f"{mark} {self.check.replace('_', ' ')}: {self.text}{advice}"


class Diagnosis(Value):
    """Result of a diagnosis. Printing it gives one line per finding, with the remedy."""

    findings: tuple[Finding, ...]
    """Findings, in order of the checks."""
    port: str | None
    """Port of the arm, once known."""
    window: int | None
    """Number of requests that may be in flight: for ``magician.Arm(port, window=..)``."""
    turnaround: float | None
    """Latency from request to reply, without the transmission time on a serial line, s."""
    error: Error | None
    """Reason of an early end (no arm, or its line was lost): the exception that :class:`magician.Arm` would raise."""

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
    """Finds the arm, checks it and its line, and suggests remedies, as ``magician doctor`` does.

    >>> magician.doctor("sim").ok
    True

    The diagnosis checks the port, its permissions and its holder, distinguishes an arm from other devices, sends reads
    back to back, measures latency, and reads alarms and queue. Nothing moves, and without ``try_queue`` it only reads.
    A missing arm is a finding, not an exception. It takes some seconds; with asyncio use :func:`magician.aio.doctor`.
    No program may have the port open, including this one.

    :param port: As for :class:`magician.Arm`, but a name.
    :param count: Number of timed replies of each of two kinds, 1 to 100,000.
    :param timeout: Timeout of a reply, s.
    :param try_queue: Whether to test the queue: it is stopped, filled with 15 waits of 0 ms, and cleared.
        A queue with commands is left alone; an empty one stays stopped until a program starts it.
    :param on_finding: Called with each finding as it arrives. An exception in it ends the diagnosis.
    :raises InvalidInputError: The port is invalid, or an argument is out of range.
    """
    examination = _Examination(port, count, timeout, try_queue, on_finding)
    return examination.ended(*wait_with_cleanup(examination.call, examination.cleanup, examination.on_results))


async def doctor_async(
    port: str | None = None,
    *,
    count: int = 200,
    timeout: float = 3.0,
    try_queue: bool = False,
    on_finding: Callable[[Finding], object] | None = None,
) -> Diagnosis:
    """Runs :func:`magician.doctor` on asyncio. Cancelling it ends the diagnosis; the port is closed
    before :exc:`asyncio.CancelledError` is raised.
    """
    examination = _Examination(port, count, timeout, try_queue, on_finding)
    return examination.ended(*await until_with_cleanup(examination.call, examination.cleanup, examination.on_results))


class _Examination:
    """A running diagnosis with its findings so far."""

    call: Call[tuple[str | None, int | None, float | None, Error | None]]
    cleanup: Call[None]

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
        self.call, self.cleanup = _magician.doctor(
            text("port", port),
            whole("count", count, 1, 100_000),
            seconds("timeout", timeout, above=0),
            flag("try_queue", try_queue),
        )

    def on_results(self, found: list[Any]) -> None:
        """Receives a finding."""
        for parts in found:
            self._findings.append(Finding(*parts))
            if self._tell is not None:
                self._tell(self._findings[-1])

    def ended(self, port: str | None, window: int | None, turnaround: float | None, error: Error | None) -> Diagnosis:
        """Handles the end of the diagnosis."""
        turnaround = None if turnaround is None else turnaround / 1000
        return Diagnosis(tuple(self._findings), port, window, turnaround, error)
