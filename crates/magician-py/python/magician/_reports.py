"""What is told of a program before it runs: notes on its file, and what a check has found."""

from __future__ import annotations

from typing import Any

from ._values import Value
from .errors import Error

__all__ = ["Complaint", "Note", "Placed", "Report", "clock", "report"]


class Placed(Value):
    """How a file was laid before the arm."""

    scale: float
    """Its size, 1 being the true one."""
    turn: float
    """By how many degrees it is turned counter-clockwise."""
    at: tuple[float, float]
    """The middle of what it draws or burns, in the arm's x and y, mm."""
    page: tuple[tuple[float, float], ...] | None = None
    """The corners of the page that it lies on, if one was asked for, in the arm's x and y, mm: the lower left one, and
    on round it counter-clockwise."""


class Note(Value):
    """A part of a file that was left out or interpreted; it is not an error."""

    message: str
    """What."""
    line: int | None = None
    """Line of the file, from 1."""
    column: int | None = None
    """Column in that line, from 1."""
    name: str | None = None
    """The element or point of the file."""
    help: str | None = None
    """What to do about it."""
    code: str = "problem"
    """Of what kind it is: ``"left-out"``, ``"assumed"``, ``"placed"``, ``"reordered"``, ``"power"``, ``"speed"``
    or ``"long"``."""

    def __str__(self) -> str:
        help = f" ({self.help})" if self.help else ""
        return _placed(self.message, _place(self.line, self.column, None), self.name) + help


class Complaint(Value):
    """A step that the arm could not do, or that a guard refuses."""

    step: int
    """Which step, from 1; one more than there are for what is wrong at the end."""
    error: Error
    """What a run of it would raise: with the value and its limit, where it is a matter of how much."""
    line: int | None = None
    """Line of the file that it comes from, from 1."""
    column: int | None = None
    """Column in that line, from 1."""
    row: int | None = None
    """Row of the array that it comes from, from 0."""
    name: str | None = None
    """The element or point of the file that it belongs to."""

    @property
    def message(self) -> str:
        """Why, in a sentence: ``joint 2 would be at 91.3 deg, limit 85.0 deg``."""
        return str(self.error)

    @property
    def value(self) -> float | None:
        """The value that is too large or too small, in :attr:`unit`."""
        return self.error.value

    @property
    def limit(self) -> float | None:
        """The limit that it breaks, in :attr:`unit`."""
        return self.error.limit

    @property
    def unit(self) -> str | None:
        """The unit of both."""
        return self.error.unit

    def __eq__(self, other: object) -> bool:
        # Compare texts: exceptions compare by identity.
        return _told(self) == _told(other) if isinstance(other, Complaint) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.step, self.line, self.column, self.row, self.name))

    def __repr__(self) -> str:
        return f"<Complaint: {self}>"

    def __str__(self) -> str:
        place = [*_place(self.line, self.column, self.row), f"step {self.step}"]
        return _placed(self.message, place, self.name)


class Report(Value):
    """The result of a check. A notebook shows it as a table."""

    refused: int
    """How many steps the arm could not do."""
    complaints: list[Complaint]
    """The first hundred of them, in their order."""
    steps: int
    """How many steps the plan has."""
    counts: dict[str, int]
    """How many of each kind: ``{"move": 4, "path": 120}``."""
    seconds: float | None
    """How long the arm takes, on its own clock; ``None`` if a step has no end that is known: homing, a trigger."""
    drawn: float
    """How far the tool draws or burns, mm."""
    travelled: float
    """How far it goes besides, mm."""
    power: tuple[float, float] | None
    """The weakest and the strongest power that is burnt, percent; ``None`` if nothing burns."""
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None
    """The least and the greatest x, y, z of the ways that draw or burn, mm; ``None`` if nothing is drawn."""
    travel_bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None
    """The least and the greatest x, y, z at which steps end, mm."""
    longest_way: tuple[int, float] | None
    """The step with the longest way, from 1, and how long that is, mm."""
    longest_time: tuple[int, float] | None
    """The step that takes longest, from 1, and how long, s."""

    @property
    def ok(self) -> bool:
        """Whether the arm can do all of it."""
        return self.refused == 0

    def raise_if_refused(self) -> None:
        """Raises the error of the first complaint, if there is one."""
        for complaint in self.complaints:
            raise complaint.error

    def __str__(self) -> str:
        lines = [self._line()]
        lines += map(str, self.complaints[:10])
        if self.refused > 10:
            lines.append(f"and {self.refused - 10} more")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Report: {self._line()}>"

    def _line(self) -> str:
        time = "its time is not known" if self.seconds is None else f"takes {self.seconds:.1f} s"
        state = (
            "the arm can do all of it"
            if self.ok
            else f"{self.refused} step{' is' if self.refused == 1 else 's are'} refused"
        )
        burns = ""
        if self.power is not None:
            least, most = self.power
            burns = f"burns with {least:.3g} to {most:.3g} %, " if least < most else f"burns with {most:.3g} %, "
        lengths = f"{self.drawn:.0f} mm drawn, {self.travelled:.0f} mm travelled"
        return f"{self.steps} steps, {lengths}, {burns}{time}: {state}"

    def _repr_html_(self) -> str:
        from html import escape

        found = "".join(
            f"<tr><td>{each.step}</td><td>{escape(', '.join(_place(each.line, each.column, each.row)))}</td>"
            f"<td>{escape(each.name or '')}</td><td>{escape(each.message)}</td></tr>"
            for each in self.complaints[:20]
        )
        table = f"<table><tr><th>step</th><th>where</th><th>name</th><th>why</th></tr>{found}</table>" if found else ""
        return f"<p>{escape(self._line())}</p>{table}"


def report(found: dict[str, Any]) -> Report:
    """The report of what the native part has found."""
    bounds, travel_bounds = found["bounds"], found["travel_bounds"]
    return Report(
        refused=found["refused"],
        complaints=[Complaint(**each) for each in found["complaints"]],
        steps=found["steps"],
        counts=found["counts"],
        seconds=found["seconds"],
        drawn=found["drawn"],
        travelled=found["travelled"],
        power=None if found["power"] is None else tuple(found["power"]),
        bounds=None if bounds is None else (tuple(bounds[0]), tuple(bounds[1])),
        travel_bounds=None if travel_bounds is None else (tuple(travel_bounds[0]), tuple(travel_bounds[1])),
        longest_way=found["longest_way"],
        longest_time=found["longest_time"],
    )


def _told(complaint: Complaint) -> tuple[object, ...]:
    place = complaint.step, complaint.line, complaint.column, complaint.row, complaint.name
    error = complaint.error
    return *place, error.kind, str(error), error.value, error.limit, error.unit


def clock(seconds: float) -> str:
    """A time as clocks have it."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def _place(line: int | None, column: int | None, row: int | None) -> list[str]:
    if row is not None:
        return [f"row {row}"]
    if line is None:
        return []
    return [f"line {line}"] if column is None else [f"line {line}", f"column {column}"]


def _placed(message: str, place: list[str], name: str | None) -> str:
    where = ", ".join(place)
    if name:
        where = f"{where} ({name})" if where else f"({name})"
    return f"{where}: {message}" if where else message
