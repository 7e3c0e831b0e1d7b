"""An arm held against the conformance suite: cases that say what a Magician does, each with its source."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import Literal

from . import _magician
from ._arguments import flag, hearing, seconds, text
from ._magician import Call
from ._native import until_left, wait_left
from ._telling import Line
from ._values import Value

__all__ = ["CaseProgress", "CaseResult", "Conformance", "Mismatch", "conform", "conform_async"]


class Mismatch(Value):
    """Where an arm did something else than a case says."""

    line: int
    """Line of the step in the case's file; 0 when the arm could not be brought to where the case begins."""
    step: str
    """The step, as it is written."""
    sent: bytes
    """What was sent last."""
    expected: str
    """What should have come, in words or bytes."""
    got: str
    """What came instead, in words."""
    received: bytes
    """What came instead, as it came."""

    def __str__(self) -> str:
        return f"{self.step}: expected {self.expected}, got {self.got}"


class CaseResult(Value):
    """A case, and what came of it."""

    case: str
    """Its name: ``"ptp.movl-100-mm"``."""
    chapter: str
    """What it is about: ``"ptp"``."""
    title: str
    """What the arm should do."""
    source: str
    """Where that is known from."""
    confidence: Literal["M", "V", "VL", "T", "G"]
    """How sure it is: measured on real arms, the vendor's word, the vendor's code for the sibling arm, third parties,
    our assumption."""
    tags: tuple[str, ...]
    """Of what kind it is: ``"moves"``, ``"exact"``, ``"hurts"``, ``"sim-only"``, ``"world"``, ``"power-up"``."""
    outcome: Literal["passed", "failed", "skipped"]
    """What came of it."""
    reason: str | None
    """Why it was skipped."""
    failure: Mismatch | None
    """Where it failed."""

    def __str__(self) -> str:
        why = self.reason if self.failure is None else self.failure
        return f"{self.outcome}: {self.case}" + ("" if why is None else f": {why}")


class Conformance(Value):
    """What came of all cases."""

    results: tuple[CaseResult, ...]
    """Each case, in the order of the suite."""

    @property
    def ok(self) -> bool:
        """True if none failed."""
        return not self.failed

    @property
    def passed(self) -> tuple[CaseResult, ...]:
        """Those that the arm passed."""
        return self._of("passed")

    @property
    def failed(self) -> tuple[CaseResult, ...]:
        """Those that it failed."""
        return self._of("failed")

    @property
    def skipped(self) -> tuple[CaseResult, ...]:
        """Those that are not for this arm."""
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

        found = ""
        for each in self.failed:
            why = (each.failure.expected, each.failure.got) if each.failure else ("", "")
            cells = "".join(f"<td>{escape(text)}</td>" for text in (each.case, each.title, *why))
            found += f"<tr>{cells}</tr>"
        head = "<tr><th>case</th><th>the arm should</th><th>expected</th><th>got</th></tr>"
        return f"<p>{self._counts()}</p>" + (f"<table>{head}{found}</table>" if found else "")


class CaseProgress(Value):
    """How far the suite is."""

    done: int
    """Cases that are done."""
    cases: int
    """Cases that were selected."""
    failed: int
    """How many of those done the arm failed."""
    result: CaseResult
    """The case that was done last."""

    @property
    def share(self) -> float:
        """Between 0 and 1."""
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

    Its parameters are saved first and restored at the end, also after Ctrl-C; its queue and its alarms are cleared.
    Cases that could harm or uncalibrate a real arm are left out. A program on asyncio has :func:`magician.aio.conform`.

    :param port: As for :class:`magician.Arm`; ``"sim"`` is a virtual arm whose clock takes no time.
    :param only: Only cases that match one of these: a chapter (``"ptp"``), a name in which ``*`` stands for anything, a
        tag (``"moves"``), or a confidence (``"M"``).
    :param skip: Cases to leave out, by the same.
    :param timeout: How long the arm may take to answer, s.
    :param allow_motion: Whether an arm that is not virtual may move, through most of its range: take its tool off and
        clear its reach.
    :param progress: ``True`` shows a line on stderr; a function is called with a :class:`CaseProgress` after each case.
        An exception in it ends the run.
    :raises InvalidInputError: A pattern matches nothing, or an arm that is not virtual would move and may not; nothing
        was sent.
    :raises PortError: The port is not there, not allowed or in use.
    """
    running = _Running(port, only, skip, timeout, allow_motion, progress)
    wait_left(running.call, running.left, running.hear)
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
    """As :func:`magician.conform`, for programs on asyncio. Cancelling it ends the run; the arm's parameters are
    restored before :exc:`asyncio.CancelledError` is raised.
    """
    running = _Running(port, only, skip, timeout, allow_motion, progress)
    await until_left(running.call, running.left, running.hear)
    return running.ended()


_Found = tuple[
    tuple[str, str, str, str, Literal["M", "V", "VL", "T", "G"], tuple[str, ...]],
    Literal["passed", "failed", "skipped"],
    str | None,
    tuple[int, str, bytes, str, str, bytes] | None,
]


class _Running:
    """A run of the suite, and what came of its cases so far."""

    call: Call[None]
    left: Call[None]

    def __init__(
        self,
        port: str | None,
        only: Iterable[str],
        skip: Iterable[str],
        timeout: float,
        allow_motion: bool,
        progress: CaseWatcher,
    ) -> None:
        hearing(progress)
        # A program without a console has no stderr.
        self._line = Line(sys.stderr) if progress is True and sys.stderr is not None else None
        self._tell: Callable[[CaseProgress], object] | None = progress if callable(progress) else self._line
        self._results: list[CaseResult] = []
        self._failed = 0
        patterns = [*_patterns("only", only)], [*_patterns("skip", skip)]
        self.call, self._cases, self.left = _magician.conform(
            text("port", port), *patterns, seconds("timeout", timeout, above=0), flag("allow_motion", allow_motion)
        )

    def hear(self, found: list[_Found]) -> None:
        """Hears of cases that were done."""
        for about, outcome, reason, failure in found:
            result = CaseResult(*about, outcome, reason, None if failure is None else Mismatch(*failure))
            self._results.append(result)
            self._failed += result.outcome == "failed"
            if self._tell is not None:
                self._tell(CaseProgress(len(self._results), self._cases, self._failed, result))

    def ended(self) -> Conformance:
        """The run has come to its end."""
        found = Conformance(tuple(self._results))
        if self._line is not None:
            self._line.end(repr(found)[1:-1])
        return found


def _patterns(name: str, patterns: Iterable[str]) -> Iterable[str]:
    if isinstance(patterns, str):
        raise TypeError(f"{name} is {patterns!r}; it takes patterns in a list: [{patterns!r}]")
    return patterns
