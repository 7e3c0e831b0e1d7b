"""What sessions at a station, blocking and on asyncio, have in common: values, and what goes into requests."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TypeVar

from . import _told
from ._arguments import text
from ._magician import Call, Core, Station
from ._values import Value
from .errors import PortError, StoppedError
from .programs import Plan

__all__ = ["ArmEntry", "ArmState", "Holder", "JobState", "Notice", "StationEvent", "ToolState"]

_V = TypeVar("_V", bound=Value)

_OVER = ("done", "stopped", "failed", "interrupted")
_SUFFIXES = {".gcode": "gcode", ".nc": "gcode", ".ngc": "gcode", ".csv": "points", ".txt": "points"}


class Holder(Value):
    """The session that has the lease of an arm."""

    session: str
    """Its id."""
    name: str
    """What it calls itself."""


class ArmEntry(Value):
    """An arm of a station."""

    name: str
    """Its name there."""
    port: str
    """Where the station has it."""
    virtual: bool
    """True if it is a virtual arm of the station's own."""
    link: str
    """``"up"`` or ``"lost"``."""
    holder: Holder | None
    """Who may move it now."""
    job: str | None
    """The job that it is at."""


class ToolState(Value):
    """What the tools of an arm do, each ``None`` where it is not known."""

    name: str | None
    """The tool that is mounted, if its tip is that of one with a name."""
    bias: tuple[float, float, float] | None
    """Its tip from the flange, mm."""
    suction: bool | None
    """True if the suction cup is on."""
    gripper: str | None
    """``"open"``, ``"closed"`` or ``"off"``."""
    laser: bool | None
    """True if the laser may burn."""


class ArmState(Value):
    """The state of an arm, as a station has read it last."""

    arm: str
    """Its name."""
    t: float
    """When the pose was read, Unix seconds of the station."""
    x: float
    """Of the tool's tip, mm."""
    y: float
    """Of the tool's tip, mm."""
    z: float
    """Of the tool's tip, mm."""
    r: float
    """Turn of the tool, degrees."""
    j1: float
    """Degrees."""
    j2: float
    """Degrees."""
    j3: float
    """Degrees."""
    j4: float
    """Degrees."""
    rail: float | None
    """Where on the rail, mm, if it has one."""
    current_index: int
    """The queued command that was finished last."""
    left_space: int
    """Free places in the queue."""
    alarms: tuple[int, ...]
    """Codes of the alarms that stand."""
    link: str
    """``"up"`` or ``"lost"``; while it is lost the rest is of before."""
    moving: bool
    """True if it moves, or may."""
    homed: bool | None
    """True if it was homed since it was switched on, if that is known."""
    tool: ToolState
    """What its tools do."""
    speed: float | None
    """Share of the set speed of moves, percent, if it is known."""
    pins: tuple[Mapping[str, Any], ...]
    """Levels of the pins that are watched: ``kind``, ``address``, ``value``."""
    job: str | None
    """The job that it is at."""
    jog: str | None
    """The jog that it is at."""
    holder: Holder | None
    """Who may move it now."""


class JobState(Value):
    """How far a job is."""

    job: str
    """Its id."""
    arm: str
    """The arm's name."""
    title: str | None
    """What it is called."""
    state: str
    """``"checking"``, ``"running"``, ``"pausing"``, ``"paused"``, ``"stopping"``, ``"done"``, ``"stopped"``,
    ``"failed"`` or ``"interrupted"``.
    """
    step: int
    """Finished steps of the present loop."""
    steps: int | None
    """Steps of one loop."""
    loop: int
    """The present loop, from 1."""
    loops: int
    """How many; 0 until it is stopped."""
    seconds_left: float | None
    """How long the rest takes, where that is known."""
    drawn_mm: float | None
    """Length of the lines that were drawn."""
    travel_mm: float | None
    """Length of the ways between them."""
    started: float | None
    """Unix seconds of the station."""
    ended: float | None
    """Unix seconds of the station."""
    holder: Holder | None
    """Who has started it."""
    reason: str | None
    """Why it is paused."""
    text: str | None
    """What the person is told for whom it pauses between parts, or because the program says so."""
    error: Mapping[str, Any] | None
    """Why it has failed."""

    @property
    def over(self) -> bool:
        """True if it has ended, in whatever way."""
        return self.state in _OVER

    @property
    def share(self) -> float:
        """Between 0 and 1, over all loops; 0 without an end."""
        if self.state == "done":
            return 1.0
        if not self.steps or not self.loops:
            return 0.0
        return ((self.loop - 1) * self.steps + self.step) / (self.steps * self.loops)


class StationEvent(Value):
    """Something that happened at an arm."""

    arm: str
    """Its name."""
    seq: int
    """Its number, from 1."""
    t: float
    """When, Unix seconds of the station."""
    event: str
    """What: ``"alarm-raised"``, ``"command-finished"``, ``"stop"``, ``"lease"``, ``"job"``, .."""
    data: Mapping[str, Any]
    """What else is known of it."""


class Notice(Value):
    """A notification of a station."""

    method: str
    """``"lease.changed"``, ``"lease.asked"``, ``"job.changed"``, ..; ``"connection"`` when it breaks or is back."""
    params: Any
    """What it says."""


def _value(name: str, value: Any) -> Any:
    if value is None:
        return None
    if name == "holder":
        return Holder(value["session"], value["name"])
    if name == "tool":
        bias = value.get("bias")
        parts = {**value, "bias": None if bias is None else tuple(bias)}
        return made(ToolState, parts)
    return tuple(value) if name in ("alarms", "pins") else value


def made(cls: type[_V], data: Mapping[str, Any]) -> _V:
    """A value of what the station says; what it does not know of is left out."""
    names: tuple[str, ...] = cls._fields  # pyright: ignore[reportPrivateUsage]
    return cls(**{name: _value(name, data.get(name)) for name in names})


def event(data: Mapping[str, Any]) -> StationEvent:
    known = ("arm", "seq", "t", "event")
    more = {name: value for name, value in data.items() if name not in known}
    return StationEvent(data["arm"], data["seq"], data["t"], data["event"], more)


def written(params: Mapping[str, Any]) -> str:
    import json

    given = {name.rstrip("_"): value for name, value in params.items() if value is not None}
    try:
        return json.dumps(given)
    except TypeError as error:
        raise TypeError(f"a station takes text, numbers, lists and dictionaries: {error}") from None


def read(answer: str) -> Any:
    import json

    return json.loads(answer)


def source(
    program: Plan | str | os.PathLike[str] | bytes | None, name: str | None, options: dict[str, Any]
) -> dict[str, Any]:
    """The program as a station takes it."""
    if program is None or name is not None:
        if name is None or program is not None:
            raise TypeError("a job is of one program: give it, or the name of one that the station keeps")
        return {"program": text("name", name), **options}
    if isinstance(program, Plan):
        return {"text": program.to_json(), "format": "plan", **options}
    from base64 import b64encode
    from pathlib import Path

    if isinstance(program, bytes):
        return {"data": b64encode(program).decode(), **options}
    path = Path(program)
    options.setdefault("format", _SUFFIXES.get(path.suffix.lower()))
    return {"data": b64encode(path.read_bytes()).decode(), **options}


def ended(state: JobState | None) -> JobState:
    """A job that is done; any other end is an error."""
    assert state is not None, "it has a state"
    if state.state == "failed":
        error = dict(state.error or {})
        raise _told.failure(str(error.pop("message", "the job has failed")), error)
    if state.state == "stopped":
        raise StoppedError("the job was stopped", data={"job": state.job})
    if state.state == "interrupted":
        raise PortError("the job was interrupted: job.resume() goes on with it")
    return state


def connecting(url: str, name: str, token: str | None) -> Call[Station]:
    if token is None:
        token = os.environ.get("MAGICIAN_TOKEN") or None
    return Station.connect(text("url", url), text("name", name), token)


class ArmAt:
    """An arm of a session, to be connected to."""

    def __init__(self, core: Station, name: str | None) -> None:
        self._core = core
        self._name = name

    def __repr__(self) -> str:
        return f"{self._name or 'the arm'} of a station"

    def connect_core(
        self,
        *,
        timeout: float,
        window: int,
        probe: bool,
        reconnect: bool,
        echo: float,
        fence: str | None,
        trace: str | None,
    ) -> Call[Core]:
        return self._core.open(
            self._name, timeout=timeout, window=window, probe=probe, reconnect=reconnect, echo=echo, fence=fence
        )
