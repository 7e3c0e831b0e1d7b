"""An arm held against the conformance suite: cases that say what a Magician does, each with its source."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from . import _magician
from ._arguments import flag, seconds, text
from ._values import Value

__all__ = ["CaseResult", "Conformance", "Mismatch", "conform"]


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
        """Whether none failed."""
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


def conform(
    port: str | None = None,
    *,
    only: Iterable[str] = (),
    skip: Iterable[str] = (),
    timeout: float = 3.0,
    allow_motion: bool = False,
) -> Conformance:
    """Runs the conformance suite on an arm, as ``magician conform`` does.

    >>> magician.conform("sim", only=["queue"]).ok
    True

    Its parameters are saved first and restored at the end, also after Ctrl-C; its queue and its alarms are cleared.
    Cases that could harm or uncalibrate a real arm are left out. It takes a while: a program on asyncio gives it to
    :func:`asyncio.to_thread`.

    :param port: As for :class:`magician.Arm`; ``"sim"`` is a virtual arm whose clock takes no time.
    :param only: Only cases that match one of these: a chapter (``"ptp"``), a name in which ``*`` stands for anything, a
        tag (``"moves"``), or a confidence (``"M"``).
    :param skip: Cases to leave out, by the same.
    :param timeout: How long the arm may take to answer, s.
    :param allow_motion: Whether an arm that is not virtual may move, through most of its range: take its tool off and
        clear its reach.
    :raises InvalidInputError: A pattern matches nothing, or an arm that is not virtual would move and may not; nothing
        was sent.
    :raises PortError: The port is not there, not allowed or in use.
    """
    patterns = [*_patterns("only", only)], [*_patterns("skip", skip)]
    found = _magician.conform(
        text("port", port), *patterns, seconds("timeout", timeout, above=0), flag("allow_motion", allow_motion)
    )
    return Conformance(
        tuple(
            CaseResult(*about, outcome, reason, None if failure is None else Mismatch(*failure))
            for about, outcome, reason, failure in found
        )
    )


def _patterns(name: str, patterns: Iterable[str]) -> Iterable[str]:
    if isinstance(patterns, str):
        raise TypeError(f"{name} is {patterns!r}; it takes patterns in a list: [{patterns!r}]")
    return patterns
