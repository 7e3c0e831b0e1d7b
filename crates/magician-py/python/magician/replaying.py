"""Replay of recorded sessions on a virtual arm, and comparison of the answers."""

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
    """Difference between a recorded answer and that of the virtual arm."""

    text: str
    """The difference in words: ``"GetPose x: recorded 200, now 199.4"``."""
    time: float
    """Time of the request, s from the start of the trace."""
    link: str | None
    """Link of the trace on which the request was sent: a port, a client."""
    id: int
    """Id of the command."""
    command: str | None
    """The command, as the vendor calls it; ``None`` for an unknown id."""
    kind: Literal["value", "period", "form", "silent", "answered", "unasked"]
    """Kind of the difference: ``"value"`` of a field; ``"period"``, a pose of a neighbouring control period;
    ``"form"`` of the answer, such as its error bit; ``"silent"``, only the recording has an answer; ``"answered"``,
    only the virtual arm answers; ``"unasked"``, a recorded answer belongs to no request."""
    field: str | None
    """Field whose value differs."""
    recorded: Any
    """Recorded value of the field, or the frame of the answer; ``None`` without an answer."""
    replayed: Any
    """Value of the field, or the frame of the answer, from the virtual arm; ``None`` without an answer."""

    def __str__(self) -> str:
        return f"{self.time:.6f} s: {self.text}"


class Replay(Value):
    """Result of a replay."""

    differences: tuple[Difference, ...]
    """First 10000 differences, in order of time."""
    found: int
    """Total number of differences."""
    requests: int
    """Number of replayed requests."""
    answers: int
    """Number of compared answers."""
    fields: int
    """Number of compared fields."""
    ignored: int
    """Number of fields ignored on request."""
    unanswered: int
    """Number of requests that neither arm answered, or whose answer lies past the end of the trace."""
    undirected: int
    """Number of packets skipped because the trace does not give their sender."""

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

    The virtual arm starts as after power-up, and runs on the time of the trace, without real delays. Queue indices are
    compared relative to the first, the arm's clock by the time between two readings. Measured values may differ by
    ``tolerance``; everything else must be equal. Traces are never sent to a real arm.

    :param trace: A trace (pcapng), as ``Arm(port, trace=...)`` or ``magician sim --trace`` writes it: its file, or its
        bytes.
    :param link: Name or number of the link to replay; if left out, the arm's line of a proxy trace, or all links of any
        other trace.
    :param clock: Speed of the recorded virtual arm: seconds of its clock per second of the trace, or ``"max"``.
    :param ignore: Values to ignore: all fields of a command (``"GetPose"``), one field of a command
        (``"GetPose.x"``), or a field in all commands (``"queued_cmd_index"``).
    :param tolerance: Tolerance of measured values, in their unit: mm, degrees.
    :param time_tolerance: Tolerance of the arm's clock between two readings, ms.
    :param scenario: World of the virtual arm, as for :class:`VirtualArm`.
    :param profile: Firmware profile: path or text.
    :param save: File for the trace of the new session; must differ from the input files.
    :raises InvalidInputError: The trace is invalid or damaged, a link or field does not exist, the scenario or profile
        is invalid, or ``save`` is an input file.
    :raises OSError: A file cannot be read or written.
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
    options: dict[str, Any] = {
        "link": link,
        "clock": clock_speed(clock),
        "ignore": list(ignore),
        "tolerance": number("tolerance", tolerance, least=0),
        "time_tolerance": whole("time_tolerance", time_tolerance, 0, 2**32 - 1),
        "scenario": scenario_text(scenario),
        "profile": scenario_text(profile),
        "save": None if save is None else os.fspath(save),
    }
    counts, differences = _magician.replay(data, options)
    return Replay(tuple(differences), *counts)
