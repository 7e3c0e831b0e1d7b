"""Reports on a program before it runs: notes on its file, and results of the check."""

from __future__ import annotations

from typing import Any

from ._values import Value
from .errors import Error

__all__ = ["Complaint", "Note", "Placed", "Report", "clock", "report"]


class Placed(Value):
    """Placement of a file before the arm."""

    scale: float
    """Scale factor; 1 is true size."""
    turn: float
    """Counter-clockwise rotation, degrees."""
    at: tuple[float, float]
    """Centre of the drawn or burnt area, in the arm's x and y, mm."""
    page: tuple[tuple[float, float], ...] | None = None
    """Corners of the page, in the arm's x and y, mm: counter-clockwise from the lower left; ``None`` without a page."""


class Note(Value):
    """Note on a part of a file that was left out or interpreted; not an error."""

    message: str
    """The note, in a sentence."""
    line: int | None = None
    """Line of the file, from 1."""
    column: int | None = None
    """Column in that line, from 1."""
    name: str | None = None
    """Element or point of the file."""
    help: str | None = None
    """Suggested remedy."""
    code: str = "problem"
    """Kind of the note: ``"left-out"``, ``"assumed"``, ``"placed"``, ``"reordered"``, ``"power"``, ``"speed"``
    or ``"long"``."""

    def __str__(self) -> str:
        help = f" ({self.help})" if self.help else ""
        return _placed(self.message, _place(self.line, self.column, None), self.name) + help


class Complaint(Value):
    """Step that the arm cannot do, or that a guard refuses."""

    step: int
    """Number of the step, from 1; one more than the number of steps for a fault at the end."""
    error: Error
    """The exception that a run would raise, with value and limit if a limit is broken."""
    line: int | None = None
    """Line in the source file, from 1."""
    column: int | None = None
    """Column in that line, from 1."""
    row: int | None = None
    """Row in the source array, from 0."""
    name: str | None = None
    """Element or point of the source file."""

    @property
    def message(self) -> str:
        """The reason, in a sentence: ``joint 2 would be at 91.3 deg, limit 85.0 deg``."""
        return str(self.error)

    @property
    def value(self) -> float | None:
        """Value out of range, in :attr:`unit`."""
        return self.error.value

    @property
    def limit(self) -> float | None:
        """Limit that the value exceeds, in :attr:`unit`."""
        return self.error.limit

    @property
    def unit(self) -> str | None:
        """Unit of value and limit."""
        return self.error.unit

    def __eq__(self, other: object) -> bool:
        # Compare texts: exceptions compare by identity.
        return _comparison_key(self) == _comparison_key(other) if isinstance(other, Complaint) else NotImplemented

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
    """Number of steps that the arm cannot do."""
    complaints: list[Complaint]
    """The first hundred complaints, in order."""
    steps: int
    """Number of steps of the plan."""
    counts: dict[str, int]
    """Number of steps of each kind: ``{"move": 4, "path": 120}``."""
    seconds: float | None
    """Duration on the arm's clock, s; ``None`` if the end of a step is unknown: homing, a trigger."""
    drawn: float
    """Length of the drawn or burnt lines, mm."""
    travelled: float
    """Length of the travel moves, mm."""
    power: tuple[float, float] | None
    """Minimum and maximum laser power, percent; ``None`` if nothing burns."""
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None
    """Minimum and maximum x, y, z of the drawn or burnt lines, mm; ``None`` if nothing is drawn."""
    travel_bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None
    """Minimum and maximum x, y, z of the step targets, mm."""
    longest_way: tuple[int, float] | None
    """Step with the longest path, from 1, and the length, mm."""
    longest_time: tuple[int, float] | None
    """Step with the longest duration, from 1, and the duration, s."""

    @property
    def ok(self) -> bool:
        """True if the arm can do every step."""
        return self.refused == 0

    def raise_if_refused(self) -> None:
        """Raises the error of the first complaint, if any."""
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
    """Builds the report from the results of the native part."""
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


def _comparison_key(complaint: Complaint) -> tuple[object, ...]:
    place = complaint.step, complaint.line, complaint.column, complaint.row, complaint.name
    error = complaint.error
    return *place, error.kind, str(error), error.value, error.limit, error.unit


def clock(seconds: float) -> str:
    """Formats a duration as a clock does."""
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
