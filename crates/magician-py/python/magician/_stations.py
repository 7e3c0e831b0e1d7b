"""Values and requests shared by blocking and asyncio sessions at a station."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TypeVar

from . import _conversion
from ._arguments import text
from ._magician import Call, Core, Station
from ._values import Value
from .errors import PortError, StoppedError
from .programs import Plan

__all__ = ["ArmEntry", "ArmState", "Holder", "JobState", "Notice", "StationEvent", "ToolState"]

_V = TypeVar("_V", bound=Value)

_ENDED_STATES = ("done", "stopped", "failed", "interrupted")
_SUFFIXES = {".gcode": "gcode", ".nc": "gcode", ".ngc": "gcode", ".csv": "points", ".txt": "points"}


class Holder(Value):
    """Session that holds the lease of an arm."""

    session: str
    """Its id."""
    name: str
    """Name given by the session."""


class ArmEntry(Value):
    """An arm of a station."""

    name: str
    """Name of the arm at the station."""
    port: str
    """Port of the arm at the station."""
    virtual: bool
    """True for a virtual arm of the station."""
    link: str
    """``"up"`` or ``"lost"``."""
    holder: Holder | None
    """Holder of the lease, if any."""
    job: str | None
    """Id of the current job, if any."""


class ToolState(Value):
    """State of an arm's tools; values are ``None`` if unknown."""

    name: str | None
    """Name of the tool, if its tip has the offset of a named tool; otherwise ``None``."""
    bias: tuple[float, float, float] | None
    """Offset of the tip from the flange, mm."""
    suction: bool | None
    """True if the suction cup is on."""
    gripper: str | None
    """``"open"``, ``"closed"`` or ``"off"``."""
    laser: bool | None
    """True if the laser may burn."""


class ArmState(Value):
    """Latest state of an arm, read by a station."""

    arm: str
    """Name of the arm."""
    t: float
    """When the pose was read, Unix seconds of the station."""
    x: float
    """X of the tool tip, mm."""
    y: float
    """Y of the tool tip, mm."""
    z: float
    """Z of the tool tip, mm."""
    r: float
    """Rotation of the tool, degrees."""
    j1: float
    """Angle of joint 1, degrees."""
    j2: float
    """Angle of joint 2, degrees."""
    j3: float
    """Angle of joint 3, degrees."""
    j4: float
    """Angle of joint 4, degrees."""
    rail: float | None
    """Position on the rail, mm, if there is one."""
    current_index: int
    """Index of the last finished queued command."""
    left_space: int
    """Free places in the queue."""
    alarms: tuple[int, ...]
    """Codes of the active alarms."""
    link: str
    """``"up"`` or ``"lost"``; while it is lost the other values are the last ones read."""
    moving: bool
    """True if the arm is or may be moving."""
    homed: bool | None
    """True if the arm was homed since power-up; ``None`` if unknown."""
    tool: ToolState
    """State of the tools."""
    speed: float | None
    """Speed ratio of moves, percent, if known."""
    pins: tuple[Mapping[str, Any], ...]
    """Levels of the watched pins: ``kind``, ``address``, ``value``."""
    job: str | None
    """Id of the current job, if any."""
    jog: str | None
    """Current jog, if any."""
    holder: Holder | None
    """Holder of the lease, if any."""


class JobState(Value):
    """Progress of a job."""

    job: str
    """Its id."""
    arm: str
    """Name of the arm."""
    title: str | None
    """Title of the job."""
    state: str
    """``"checking"``, ``"running"``, ``"pausing"``, ``"paused"``, ``"stopping"``, ``"done"``, ``"stopped"``,
    ``"failed"`` or ``"interrupted"``.
    """
    step: int
    """Finished steps of the current loop."""
    steps: int | None
    """Number of steps of one loop."""
    loop: int
    """Current loop, from 1."""
    loops: int
    """Number of loops; 0 for endless."""
    seconds_left: float | None
    """Estimated remaining time, s, if known."""
    drawn_mm: float | None
    """Length of the drawn lines, mm."""
    travel_mm: float | None
    """Length of the travel moves, mm."""
    started: float | None
    """Unix seconds of the station."""
    ended: float | None
    """Unix seconds of the station."""
    holder: Holder | None
    """Session that started the job."""
    reason: str | None
    """Reason of a pause."""
    text: str | None
    """Message for the operator at a pause between parts, or at a pause step of the program."""
    error: Mapping[str, Any] | None
    """Reason of a failure."""

    @property
    def over(self) -> bool:
        """True if the job has ended for any reason."""
        return self.state in _ENDED_STATES

    @property
    def share(self) -> float:
        """Progress over all loops, 0 to 1; 0 if endless."""
        if self.state == "done":
            return 1.0
        if not self.steps or not self.loops:
            return 0.0
        return ((self.loop - 1) * self.steps + self.step) / (self.steps * self.loops)


class StationEvent(Value):
    """Event of an arm."""

    arm: str
    """Name of the arm."""
    seq: int
    """Its number, from 1."""
    t: float
    """Time of the event, Unix seconds of the station."""
    event: str
    """Kind of the event: ``"alarm-raised"``, ``"command-finished"``, ``"stop"``, ``"lease"``, ``"job"``, .."""
    data: Mapping[str, Any]
    """Further details."""


class Notice(Value):
    """Notification of a station."""

    method: str
    """``"lease.changed"``, ``"lease.asked"``, ``"job.changed"``, ..; ``"connection"`` if the
    connection to the station is lost or restored.
    """
    params: Any
    """Content of the notification."""


def _value(name: str, value: Any) -> Any:
    if value is None:
        return None
    if name == "holder":
        return Holder(value["session"], value["name"])
    if name == "tool":
        bias = value.get("bias")
        parts = {**value, "bias": None if bias is None else tuple(bias)}
        return value_of(ToolState, parts)
    return tuple(value) if name in ("alarms", "pins") else value


def value_of(cls: type[_V], data: Mapping[str, Any]) -> _V:
    """Converts a message of the station to a value; unknown fields are dropped."""
    names: tuple[str, ...] = cls._fields  # pyright: ignore[reportPrivateUsage]
    return cls(**{name: _value(name, data.get(name)) for name in names})


def event(data: Mapping[str, Any]) -> StationEvent:
    known = ("arm", "seq", "t", "event")
    more = {name: value for name, value in data.items() if name not in known}
    return StationEvent(data["arm"], data["seq"], data["t"], data["event"], more)


def to_json(params: Mapping[str, Any]) -> str:
    import json

    given = {name.rstrip("_"): value for name, value in params.items() if value is not None}
    try:
        return json.dumps(given)
    except TypeError as error:
        raise TypeError(f"a station takes text, numbers, lists and dictionaries: {error}") from None


def from_json(answer: str) -> Any:
    import json

    return json.loads(answer)


def source(
    program: Plan | str | os.PathLike[str] | bytes | None, name: str | None, options: dict[str, Any]
) -> dict[str, Any]:
    """Converts a program to the form that a station accepts."""
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


def require_done(state: JobState | None) -> JobState:
    """Returns a job that is done; raises an error for any other end."""
    assert state is not None, "it has a state"
    if state.state == "failed":
        error = dict(state.error or {})
        raise _conversion.failure(str(error.pop("message", "the job has failed")), error)
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
    """Arm at a session's station, as a connection target (``Connectable``)."""

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
