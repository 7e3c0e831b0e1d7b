"""Recorded sessions, replayed on a virtual arm: what comes out otherwise than it did."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from . import _magician
from ._arguments import number, whole
from ._scenarios import clock_speed, scenario_file, scenario_text
from ._values import Value

__all__ = ["Difference", "Replay", "replay"]


class Difference(Value):
    """An answer of the virtual arm that is not the recorded one."""

    text: str
    """The difference in words: ``"GetPose x: recorded 200, now 199.4"``."""
    time: float
    """When the request was sent, seconds since the trace began."""
    link: str | None
    """The link of the trace on which it was sent: a port, a client."""
    id: int
    """Id of the command."""
    command: str | None
    """The command, as the vendor calls it; ``None`` for an unknown id."""
    kind: Literal["value", "form", "silent", "answered", "unasked"]
    """What differs: the value of a field; the form of the answer; an answer that only the recording has, or only the
    virtual arm gives; a recorded answer that belongs to no request."""
    field: str | None
    """The field that has another value."""
    recorded: Any
    """The field in the recording, or the frame of the answer; ``None`` without an answer."""
    replayed: Any
    """The same of the virtual arm."""

    def __str__(self) -> str:
        return f"{self.time:.6f} s: {self.text}"


class Replay(Value):
    """What a replay came to."""

    differences: tuple[Difference, ...]
    """The differences in the order of time, the first 10000."""
    found: int
    """How many there are in all."""
    requests: int
    """Requests that were sent again."""
    answers: int
    """Answers that were compared."""
    fields: int
    """Their fields that were compared."""
    ignored: int
    """Fields that were left out, as asked for."""
    unanswered: int
    """Requests that neither arm answered, or that the trace ends too early for."""
    undirected: int
    """Packets that were left out, because the trace does not say who sent them."""

    @property
    def ok(self) -> bool:
        """True if nothing differs."""
        return self.found == 0

    def __str__(self) -> str:
        found = "all the same" if self.ok else "1 difference" if self.found == 1 else f"{self.found} differences"
        return f"{self.requests} requests, {self.answers} answers compared in {self.fields} fields: {found}"


def replay(
    trace: bytes | bytearray | memoryview | str | os.PathLike[str],
    *,
    link: str | None = None,
    clock: float | Literal["max"] = 1.0,
    ignore: Sequence[str] = (),
    tolerance: float = 0.01,
    time_tolerance: int = 100,
    scenario: str | os.PathLike[str] | None = None,
    profile: str | os.PathLike[str] | None = None,
    save: str | os.PathLike[str] | None = None,
) -> Replay:
    """Replays a recorded session on a virtual arm and compares the answers, as ``magician replay`` does.

    >>> with magician.Arm("sim", trace="session.pcapng") as arm:
    ...     arm.move_to(220, 60, 20)
    >>> print(magician.replay("session.pcapng", clock="max"))

    The virtual arm starts as after power-up, and runs in the trace's time, which takes none of this program's. Queue
    indices are compared relative to the first, the arm's clock by the time between two readings; everything else must
    be equal, but for numbers that are measured. No real arm is sent a trace.

    :param trace: A trace (pcapng), as ``Arm(port, trace=...)`` or ``magician sim --trace`` writes it: its file, or its
        bytes.
    :param link: Only this link, by name or number; the arm's own line in the trace of a proxy, all links of any other
        trace if left out.
    :param clock: Arm seconds per trace second, or ``"max"``: the speed of the virtual arm that was recorded.
    :param ignore: What is left out: a command (``"GetPose"``), a field of one (``"GetPose.x"``) or every field of a
        name (``"queued_cmd_index"``).
    :param tolerance: How far measured values may be off, in their unit: mm, degrees.
    :param time_tolerance: The same of the arm's clock between two readings, ms.
    :param scenario: The world around the virtual arm, as for :class:`VirtualArm`.
    :param profile: A firmware profile: its file, or its text.
    :param save: A file for the new session, a trace as well; not one of those that are read.
    :raises InvalidInputError: It is no trace or damaged; there is no such link or field; a mistake in the scenario or
        the profile; ``save`` is one of the files that are read.
    :raises OSError: A file cannot be read, or not be written.
    """
    if isinstance(ignore, str):
        raise TypeError(f"ignore is {ignore!r}; it takes names in a list: [{ignore!r}]")
    inputs = [scenario_file(scenario), scenario_file(profile)]
    if isinstance(trace, (bytes, bytearray, memoryview)):
        data = bytes(trace)
    else:
        data = Path(trace).read_bytes()
        inputs.append(os.fspath(trace))
    if save is not None:
        _magician.check_distinct([file for file in inputs if file is not None], [os.fspath(save)])
    how: dict[str, Any] = {
        "link": link,
        "clock": clock_speed(clock),
        "ignore": list(ignore),
        "tolerance": number("tolerance", tolerance, least=0),
        "time_tolerance": whole("time_tolerance", time_tolerance, 0, 2**32 - 1),
        "scenario": scenario_text(scenario),
        "profile": scenario_text(profile),
        "save": None if save is None else os.fspath(save),
    }
    counts, differences = _magician.replay(data, how)
    return Replay(tuple(differences), *counts)
