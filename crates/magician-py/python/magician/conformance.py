"""Conformance suite: cases of documented Magician behaviour, each with its source, run on an arm."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import Literal

from . import _magician
from ._arguments import check_progress, flag, seconds, text
from ._magician import Call
from ._native import until_with_cleanup, wait_with_cleanup
from ._progress import ProgressLine
from ._values import Value

__all__ = ["CaseProgress", "CaseResult", "Conformance", "Mismatch", "conform", "conform_async"]


class Mismatch(Value):
    """Deviation of an arm from a case."""

    line: int
    """Line of the step in the case file; 0 if the arm could not reach the start state of the case."""
    step: str
    """Text of the step."""
    sent: bytes
    """Last frame or command sent."""
    expected: str
    """Expected answer, in words or bytes."""
    got: str
    """Actual answer, in words."""
    received: bytes
    """Actual answer, raw."""

    def __str__(self) -> str:
        return f"{self.step}: expected {self.expected}, got {self.got}"


class CaseResult(Value):
    """A case and its result."""

    case: str
    """Its name: ``"ptp.movl-100-mm"``."""
    chapter: str
    """Chapter of the case: ``"ptp"``."""
    title: str
    """Expected behaviour."""
    source: str
    """Source of the expectation."""
    confidence: Literal["M", "V", "VL", "T", "G"]
    """Confidence in the source: ``"M"`` measured on real arms, ``"V"`` vendor document, ``"VL"``
    vendor code for the sibling arm, ``"T"`` third parties, ``"G"`` own assumption.
    """
    tags: tuple[str, ...]
    """Tags of the case: ``"moves"``, ``"exact"``, ``"hurts"``, ``"sim-only"``, ``"world"``, ``"power-up"``."""
    outcome: Literal["passed", "failed", "skipped"]
    """Result of the case."""
    reason: str | None
    """Reason for skipping."""
    failure: Mismatch | None
    """Deviation of a failed case."""

    def __str__(self) -> str:
        why = self.reason if self.failure is None else self.failure
        return f"{self.outcome}: {self.case}" + ("" if why is None else f": {why}")


class Conformance(Value):
    """Results of all cases."""

    results: tuple[CaseResult, ...]
    """Results in the order of the suite."""

    @property
    def ok(self) -> bool:
        """True if no case failed."""
        return not self.failed

    @property
    def passed(self) -> tuple[CaseResult, ...]:
        """Passed cases."""
        return self._of("passed")

    @property
    def failed(self) -> tuple[CaseResult, ...]:
        """Failed cases."""
        return self._of("failed")

    @property
    def skipped(self) -> tuple[CaseResult, ...]:
        """Skipped cases, which do not apply to this arm."""
        return self._of("skipped")

    def _of(self, outcome: str) -> tuple[CaseResult, ...]:
        return tuple(each for each in self.results if each.outcome == outcome)

    def _counts(self) -> str:
        return f"{len(self.failed)} failed, {len(self.passed)} passed, {len(self.skipped)} skipped"

    def __str__(self) -> str:
        return "\n".join([self._counts(), *map(str, self.failed)])

    def __repr__(self) -> str:
        return f"<Conformance: {self._counts()}>"

    def _repr_html_(self) -> str:
        from html import escape

        rows = ""
        for each in self.failed:
            why = (each.failure.expected, each.failure.got) if each.failure else ("", "")
            cells = "".join(f"<td>{escape(text)}</td>" for text in (each.case, each.title, *why))
            rows += f"<tr>{cells}</tr>"
        head = "<tr><th>case</th><th>the arm should</th><th>expected</th><th>got</th></tr>"
        return f"<p>{self._counts()}</p>" + (f"<table>{head}{rows}</table>" if rows else "")


class CaseProgress(Value):
    """Progress of the suite."""

    done: int
    """Number of finished cases."""
    cases: int
    """Number of selected cases."""
    failed: int
    """Number of failed cases."""
    result: CaseResult
    """Last finished case."""

    @property
    def share(self) -> float:
        """Share of the cases that are finished, 0 to 1."""
        return self.done / self.cases

    def __str__(self) -> str:
        failed = f", {self.failed} failed" if self.failed else ""
        return f"case {self.done} of {self.cases}, {100 * self.share:.0f} %{failed}"


CaseWatcher = bool | Callable[[CaseProgress], object]
"""``True`` for a line on stderr, or a function that is called with the progress."""


def conform(
    port: str | None = None,
    *,
    only: Iterable[str] = (),
    skip: Iterable[str] = (),
    timeout: float = 3.0,
    allow_motion: bool = False,
    progress: CaseWatcher = False,
) -> Conformance:
    """Runs the conformance suite on an arm, as ``magician conform`` does.

    >>> magician.conform("sim", only=["queue"]).ok
    True

    The arm's parameters are saved first and restored at the end, also after Ctrl-C; queue and alarms are cleared. Cases
    that could damage or decalibrate a real arm are skipped. With asyncio use :func:`magician.aio.conform`.

    :param port: As for :class:`magician.Arm`; ``"sim"`` is a virtual arm that runs without real delays.
    :param only: Patterns of the cases to run: a chapter (``"ptp"``), a name with ``*`` as wildcard, a tag
        (``"moves"``), or a confidence (``"M"``).
    :param skip: Patterns of the cases to skip.
    :param timeout: Timeout of an answer, s.
    :param allow_motion: Allows motion of a real arm, through most of its range: take its tool off
        and clear its reach.
    :param progress: ``True`` shows a line on stderr; a function is called with a :class:`CaseProgress` after each case.
        An exception in it ends the run.
    :raises InvalidInputError: A pattern matches nothing, or a real arm would move without ``allow_motion``; nothing was
        sent.
    :raises PortError: The port does not exist, access is denied, or it is in use.
    """
    running = _Running(port, only, skip, timeout, allow_motion, progress)
    wait_with_cleanup(running.call, running.cleanup, running.on_results)
    return running.ended()


async def conform_async(
    port: str | None = None,
    *,
    only: Iterable[str] = (),
    skip: Iterable[str] = (),
    timeout: float = 3.0,
    allow_motion: bool = False,
    progress: CaseWatcher = False,
) -> Conformance:
    """Runs :func:`magician.conform` on asyncio. Cancelling it ends the run; the arm's parameters are
    restored before :exc:`asyncio.CancelledError` is raised.
    """
    running = _Running(port, only, skip, timeout, allow_motion, progress)
    await until_with_cleanup(running.call, running.cleanup, running.on_results)
    return running.ended()


_Found = tuple[
    tuple[str, str, str, str, Literal["M", "V", "VL", "T", "G"], tuple[str, ...]],
    Literal["passed", "failed", "skipped"],
    str | None,
    tuple[int, str, bytes, str, str, bytes] | None,
]


class _Running:
    """A running suite with its results so far."""

    call: Call[None]
    cleanup: Call[None]

    def __init__(
        self,
        port: str | None,
        only: Iterable[str],
        skip: Iterable[str],
        timeout: float,
        allow_motion: bool,
        progress: CaseWatcher,
    ) -> None:
        check_progress(progress)
        # A program without a console has no stderr.
        self._line = ProgressLine(sys.stderr) if progress is True and sys.stderr is not None else None
        self._on_progress: Callable[[CaseProgress], object] | None = progress if callable(progress) else self._line
        self._results: list[CaseResult] = []
        self._failed = 0
        patterns = [*_patterns("only", only)], [*_patterns("skip", skip)]
        self.call, self._cases, self.cleanup = _magician.conform(
            text("port", port), *patterns, seconds("timeout", timeout, above=0), flag("allow_motion", allow_motion)
        )

    def on_results(self, results: list[_Found]) -> None:
        """Receives finished cases."""
        for case_fields, outcome, reason, failure in results:
            result = CaseResult(*case_fields, outcome, reason, None if failure is None else Mismatch(*failure))
            self._results.append(result)
            self._failed += result.outcome == "failed"
            if self._on_progress is not None:
                self._on_progress(CaseProgress(len(self._results), self._cases, self._failed, result))

    def ended(self) -> Conformance:
        """Ends the progress line and returns the results."""
        results = Conformance(tuple(self._results))
        if self._line is not None:
            self._line.end(repr(results)[1:-1])
        return results


def _patterns(name: str, patterns: Iterable[str]) -> Iterable[str]:
    if isinstance(patterns, str):
        raise TypeError(f"{name} is {patterns!r}; it takes patterns in a list: [{patterns!r}]")
    return patterns
