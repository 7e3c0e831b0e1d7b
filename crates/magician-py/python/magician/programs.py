"""Programs: what a person draws, teaches or computes, as plans that are checked before anything moves.

A :class:`Plan` is a value. :func:`load` makes one of a file of any kind that is known, :meth:`Plan.path` of an array of
points, :meth:`Plan.of` of commands. It tells what would come of it (:meth:`Plan.check`), shows it
(:meth:`Plan.preview`), is moved, turned and repeated, and kept in a file that people can read (:meth:`Plan.save`).
``arm.run(plan)`` has an arm do it.

Lengths are mm, angles degrees, times seconds; coordinates are the arm's: X forward, Y to its left, Z up.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Literal, NamedTuple, overload

from . import _magician
from ._arguments import flag, flags, number, numbers, seconds, whole
from ._arguments import text as string
from ._meaning import Joints, Position
from ._pictures import Drawing, Picture
from ._points import Floats, Points, SupportsArray, column, rows, to_numpy, to_tuples
from ._protocol import Queueable
from ._reports import Complaint, Note, Placed, Report, report
from ._targets import kept
from ._values import Value
from .alarms import Alarm
from .errors import InvalidInputError

__all__ = [
    "Complaint",
    "Note",
    "Placed",
    "Plan",
    "Points",
    "Rehearsal",
    "Report",
    "Sheet",
    "Step",
    "Steps",
    "Surface",
    "Tool",
    "ToolName",
    "Travel",
    "frame",
    "load",
    "testgrid",
    "write",
]

ToolName = Literal["none", "suction", "gripper", "pen", "laser"]
"""The tools that have a name."""
Tool = ToolName | tuple[float, float, float]
"""A tool by its name, or by its bias from the wrist, mm."""
Travel = Literal["path", "line", "joints", "jump"]
"""How points are reached: along one continuous path, or each on a straight line, with all joints together, or up,
across and down."""


class Surface(NamedTuple):
    """What the tool works on: paper, wood, a table. Level, or tilted as it was measured."""

    height: float
    """The z that the arm reports where its tool touches it, at x = y = 0, mm."""
    slope: tuple[float, float] = (0.0, 0.0)
    """How much higher it is for each mm in x and in y."""


class Sheet(Value):
    """A sheet of paper before the arm: drawings lie on it corner on corner."""

    corner: tuple[float, float]
    """Where its lower left corner lies, in the arm's x and y, mm."""
    rotation: float = 0.0
    """How its lower edge runs, degrees from the arm's X towards its Y."""
    size: tuple[float, float] | None = None
    """Its width and height, where they are known, mm."""


class Step(Value):
    """One step of a plan: one command, or where a part begins or the plan waits for a person."""

    number: int
    """Which, from 1."""
    action: str
    """What is done: ``move``, ``joints``, ``shift``, ``arc``, ``path``, ``burn``, ``suction``, ``gripper``, ``laser``,
    ``wait``, ``home``, ``part``, ``pause``, or ``command`` for anything else."""
    by: Literal["joints", "line", "jump"] | None
    """Which way a move goes."""
    command: Queueable | None
    """The command that does it; none of a part and of a pause."""
    values: tuple[float, ...]
    """Its numbers: x, y, z, r (an arc's twice, a burn's last the power in percent), seconds of a wait, 1 for on and 0
    for off (a gripper closes at 1, opens at 0, and its pump is off at -1)."""
    target: tuple[float, float, float] | None
    """Where it leads the tool, if it says so itself: x, y, z, mm."""
    line: int | None = None
    """Line of the file that it comes from, from 1."""
    column: int | None = None
    """Column in that line, from 1."""
    row: int | None = None
    """Row of the array that it comes from, from 0."""
    name: str | None = None
    """The element or point of the file that it belongs to."""


class Steps(Sequence[Step]):
    """The steps of a plan; each is made when it is looked at."""

    __slots__ = ("_native",)

    def __init__(self, native: _magician.Plan) -> None:
        self._native = native

    def __len__(self) -> int:
        return len(self._native)

    @overload
    def __getitem__(self, at: int) -> Step: ...
    @overload
    def __getitem__(self, at: slice) -> list[Step]: ...
    def __getitem__(self, at: int | slice) -> Step | list[Step]:
        if isinstance(at, slice):
            return [self[each] for each in range(*at.indices(len(self)))]
        if not -len(self) <= at < len(self):
            raise IndexError("there is no such step")
        return _step(self._native.step(at % len(self)))

    def __iter__(self) -> Iterator[Step]:
        for at in range(len(self)):
            yield _step(self._native.step(at))

    def __eq__(self, other: object) -> bool:
        return list(self) == list(other) if isinstance(other, Steps) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<{len(self)} steps>"


class Rehearsal(Value):
    """What came of a plan on a virtual arm of its own, at full speed, to the microsecond."""

    ok: bool
    """Whether all steps have ended without an alarm."""
    seconds: float
    """How long it took, on the arm's clock."""
    steps: int
    """How many steps have ended."""
    position: Position
    """Where the tool is at the end."""
    joints: Joints
    """The joint angles at the end."""
    alarms: tuple[Alarm, ...]
    """The alarms that stand at the end."""
    log: list[tuple[float, str]]
    """What happened in it: seconds, and in words."""
    drawing: Drawing
    """What pen or laser have left."""
    _way: bytes = b""

    @property
    def way(self) -> list[tuple[float, ...]]:
        """Where the tool was from look to look, if it was watched: x, y, z, mm."""
        return to_tuples(self._way, 3)

    def way_to_numpy(self) -> Floats:
        """The same as an array of shape (n, 3), mm. Needs NumPy."""
        return to_numpy(self._way, 3)

    def __repr__(self) -> str:
        x, y, z, r = self.position
        ended = "done" if self.ok else "stopped by an alarm"
        at = f"x {x:.1f}, y {y:.1f}, z {z:.1f}, r {r:.1f}"
        return f"<Rehearsal: {self.steps} steps, {ended} after {self.seconds:.1f} s at {at}>"

    def _repr_svg_(self) -> str:
        return self.drawing.svg


class Plan:
    """What an arm is to do, step by step. A value: what changes it makes another one. A notebook shows its picture.

    Example:
        >>> import magician
        >>> square = [(200, 0, 20), (240, 0, 20), (240, 40, 20), (200, 40, 20), (200, 0, 20)]
        >>> plan = magician.Plan.path(square, tool="pen", speed=50)
        >>> plan.check().ok
        True
    """

    __slots__ = ("_report", "native")

    def __init__(self, native: _magician.Plan) -> None:
        self.native = native
        """The native part, for the rest of this package."""
        self._report: Report | None = None

    # Making one.

    @classmethod
    def of(
        cls,
        commands: Iterable[Queueable],
        *,
        title: str = "",
        tool: Tool | None = None,
        surface: float | Surface | None = None,
    ) -> Plan:
        """A plan of commands, as :mod:`magician.words` makes them.

        :raises InvalidInputError: A command cannot be queued, or a move keeps an r that no move before it has.
        """
        return cls(
            _magician.Plan.of_commands(string("title", title), kept(commands, None), _tool(tool), _surface(surface))
        )

    @classmethod
    def path(
        cls,
        points: Points,
        *,
        by: Travel = "path",
        title: str = "",
        tool: Tool | None = None,
        surface: float | Surface | None = None,
        r: float = 0.0,
        lift: float = 10.0,
        speed: float | None = 50.0,
        acceleration: float = 100.0,
        power: float | Sequence[float] | SupportsArray | None = None,
    ) -> Plan:
        """A plan through points: an array goes in at once, without a loop in Python.

        :param points: Shape (n, 3): x, y, z in mm; or (n, 4): with r in degrees. ``float64`` goes in as it is. A row of
            nothing but NaN lifts the tool: the path ends before it and another begins behind it.
        :param by: ``"path"`` for continuous paths, which do not stop at their corners and keep r; ``"line"``,
            ``"joints"`` or ``"jump"`` for a move to each point.
        :param title: What it is called.
        :param tool: The tool that it is made for; the one in force on the arm if left out.
        :param surface: The surface that it works on, where it is known: the z at which the tool touches it, mm.
        :param r: The rotation where the points have none, degrees.
        :param lift: How far above its ends a path is come to and left, mm; 0 goes straight there with all joints.
        :param speed: Along a path, mm/s; as the arm is set if ``None``.
        :param acceleration: Along a path, mm/s².
        :param power: Of the laser along a path, percent: one for all, or one for each point, shape (n,).
        :raises InvalidInputError: NaN where a number is needed, another shape, an r that changes on a path.
        """
        data, columns = rows(points)
        count = len(data) // (8 * columns)
        each = b""
        one: Any = power
        if hasattr(power, "__len__"):
            each, one = column(one, count, "power"), None
        way = {
            "title": string("title", title),
            "tool": _tool(tool),
            "surface": _surface(surface),
            "by": string("by", by),
            "r": number("r", r, unit="deg"),
            "lift": number("lift", lift, least=0, unit="mm"),
            "speed": number("speed", speed, above=0, unit="mm/s"),
            "acceleration": number("acceleration", acceleration, above=0, unit="mm/s2"),
            "power": number("power", one, least=0, most=100, unit="%"),
        }
        return cls(_magician.Plan.of_points(data, columns, each, way))

    @classmethod
    def from_json(cls, json: str) -> Plan:
        """The plan in the text of a plan file.

        :raises InvalidInputError: It is not a plan file; the message has line, column, and what is expected.
        """
        return cls(_magician.Plan.of_json(string("json", json)))

    # Looking at it.

    @property
    def title(self) -> str:
        """Its title."""
        return self.native.title

    @property
    def source(self) -> str | None:
        """The file that it was loaded from."""
        return self.native.source

    @property
    def format(self) -> str | None:
        """The format of that file: ``"svg"``, ``"gcode"``."""
        return self.native.format

    @property
    def notes(self) -> list[Note]:
        """The parts of the file that were left out or interpreted."""
        return [
            Note(message, line or None, column or None, name, help, code)
            for line, column, name, message, help, code in self.native.notes
        ]

    @property
    def placed(self) -> Placed | None:
        """How the file was laid before the arm, if it was placed."""
        found = self.native.placed
        if found is None:
            return None
        scale, turn, (x, y), corners = found
        page = None if corners is None else tuple((x, y) for x, y in corners)
        return Placed(scale, turn, (x, y), page)

    @property
    def tool(self) -> str | None:
        """The tool that it is made for: a name, or its bias ``"x,y,z"`` in mm. The arm is told of it first."""
        return self.native.tool

    @property
    def surface(self) -> Surface | None:
        """The surface that it works on."""
        found = self.native.surface
        return None if found is None else Surface(found[0], (found[1][0], found[1][1]))

    @property
    def surface_is_assumed(self) -> bool:
        """Whether the work surface height is unknown: it is then assumed to be the table of a virtual arm, and no real
        arm runs the plan."""
        return self.native.assumed

    @property
    def steps(self) -> Steps:
        """Its steps."""
        return Steps(self.native)

    def commands(self) -> list[Queueable]:
        """All commands that an arm is sent, the tool's first."""
        return self.native.commands()

    def targets(self) -> list[tuple[float, ...]]:
        """Where its steps lead: x, y, z in mm for each, NaN for those that lead nowhere by themselves."""
        return to_tuples(self.native.targets(), 3)

    def to_numpy(self) -> Floats:
        """:meth:`targets` as an array of shape (n, 3), mm. Needs NumPy."""
        return to_numpy(self.native.targets(), 3)

    def check(self) -> Report:
        """Checks it for an arm that was just homed and has its settings from power-up: steps out of reach, the time it
        takes, the length of the tool's path. ``arm.check(plan)`` begins at that arm's present pose."""
        if self._report is None:
            self._report = report(self.native.check(None))
        return self._report

    @property
    def estimate(self) -> float | None:
        """The time an arm takes for it, s; ``None`` if the end of a step is not known. It is that of :meth:`check`."""
        return self.check().seconds

    def preview(
        self, path: str | os.PathLike[str] | None = None, *, side: bool | None = None, sheet: Sheet | None = None
    ) -> Picture:
        """A picture of everything that will be drawn, burnt or carried, in true size.

        :param path: A ``.svg`` or ``.png`` file to write.
        :param side: Whether there is a view from the side; if left out, for plans that pick and place.
        :param sheet: A sheet of known size to show.
        """
        corners = None if sheet is None else _corners(sheet)
        picture = Picture(self.native.preview(None, None if side is None else flag("side", side), corners))
        if path is not None:
            picture.save(path)
        return picture

    def rehearse(
        self, *, tool: Tool | None = None, table: float | None = None, watch: float | None = None
    ) -> Rehearsal:
        """Runs it on a virtual arm of its own, as fast as possible, byte for byte as on a real arm.

        :param tool: The tool on the arm; the plan's own if it names one, else the one that its steps need.
        :param table: The z at which the tool touches the table, mm; the plan's surface if it has one.
        :param watch: How often to look where the tool is, s; see :attr:`Rehearsal.way`.
        """
        found = self.native.rehearse(
            _tool(tool),
            number("table", table, unit="mm"),
            None if watch is None else seconds("watch", watch, least=1e-6),
        )
        return Rehearsal(
            ok=found["good"],
            seconds=found["seconds"],
            steps=found["steps"],
            position=Position(*found["pose"]),
            joints=Joints(*found["joints"]),
            alarms=found["alarms"],
            log=found["log"],
            drawing=Drawing(found["drawing"]),
            _way=found["way"],
        )

    # Changing it.

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Plan:
        """The same plan in another place, moved by these distances in mm.

        :raises InvalidInputError: A step cannot be moved: it goes to joint angles, or begins at an unknown pose.
        """
        return Plan(self.native.moved((number("x", x), number("y", y), number("z", z))))

    def scaled(self, factor: float, about: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Plan:
        """The same in another size, ``about`` a point that stays where it is (mm). Heights of jumps count as lengths;
        speeds and rotations stay.

        :raises InvalidInputError: As :meth:`moved`; a factor that is not above 0.
        """
        return Plan(self.native.scaled(number("factor", factor, above=0), _three("about", about)))

    def rotated(self, degrees: float, about: tuple[float, float] = (0.0, 0.0)) -> Plan:
        """The same turned to the left, seen from above, about the vertical through ``about`` (mm). The rotation r of
        poses turns along.

        :raises InvalidInputError: As :meth:`moved`.
        """
        return Plan(self.native.rotated(number("degrees", degrees, unit="deg"), _two("about", about)))

    def repeated(self, times: int) -> Plan:
        """Its steps repeated ``times`` times. ``plan * 3`` is the same."""
        return Plan(self.native.repeated(whole("times", times, 0, _MOST)))

    def on_grid(self, rows: int, columns: int, pitch: tuple[float, float]) -> Plan:
        """The plan at each place of a grid, one after the other. As it stands it is for the first.

        :param rows: Rows, along Y.
        :param columns: Columns, along X.
        :param pitch: From a column to the next in x and from a row to the next in y, mm.
        """
        return Plan(self.native.on_grid(_count("rows", rows), _count("columns", columns), _two("pitch", pitch)))

    def on_pallet(
        self,
        rows: int,
        columns: int,
        first: tuple[float, float, float],
        end_of_row: tuple[float, float, float],
        last_row: tuple[float, float, float],
    ) -> Plan:
        """The plan at each place of a pallet as it stands, by three of its places (x, y, z; mm): the first, the last of
        its row, and the first of the last row. The others are in between, on any slope."""
        return Plan(
            self.native.on_corners(
                _count("rows", rows),
                _count("columns", columns),
                [_three("first", first), _three("end_of_row", end_of_row), _three("last_row", last_row)],
            )
        )

    def from_step(self, step: int) -> Plan:
        """The plan from a step on, counted from 1: it first sets what the steps before would have set, and goes from
        above to where the step begins. For an arm that was just homed; ``arm.run(plan, first_step=...)`` begins where
        that arm stands.

        :raises InvalidInputError: There is no such step, or the pose at which it begins is unknown.
        """
        return Plan(self.native.starting_at(whole("step", step, 1, max(1, len(self))), None))

    def __add__(self, other: Plan) -> Plan:
        """The steps of another one after these."""
        if not isinstance(other, Plan):  # pyright: ignore[reportUnnecessaryIsInstance]
            return NotImplemented
        return Plan(self.native.joined(other.native))

    def __mul__(self, times: int) -> Plan:
        return self.repeated(times)

    __rmul__ = __mul__

    # Keeping it.

    def to_json(self) -> str:
        """The text of a plan file: JSON with one step on a line."""
        return self.native.to_json()

    def to_playback(self) -> tuple[str, list[str]]:
        """The text of a file for DobotStudio's Teaching & Playback, and notes on what such a file cannot express.

        :raises InvalidInputError: A step cannot be written to such a file.
        """
        return self.native.to_playback()

    def save(self, path: str | os.PathLike[str]) -> list[str]:
        """Writes it to a ``.plan.json`` (``.json``, ``.plan``) or, for DobotStudio, ``.playback`` file. :func:`load`
        reads both.

        :returns: Notes on what the file cannot express; none for a plan file.
        :raises InvalidInputError: The name has another ending, or a step cannot be written to such a file.
        :raises OSError: The file cannot be written.
        """
        to = Path(path)
        end = to.suffix.lower()
        if end in (".json", ".plan"):
            _magician.write_whole(to, self.to_json().encode())
            return []
        if end in (".playback", ".xml"):
            playback, lost = self.to_playback()
            _magician.write_whole(to, playback.encode())
            return lost
        raise InvalidInputError(f"{to}: a plan is kept as .plan.json or .playback; preview() makes pictures")

    @property
    def pauses(self) -> list[tuple[int, str]]:
        """Where it waits for a person: the numbers of these steps, and what the person is told."""
        return self.native.pauses()

    # What every value has.

    def __len__(self) -> int:
        return len(self.native)

    def __bool__(self) -> bool:
        return True

    def __eq__(self, other: object) -> bool:
        return self.native == other.native if isinstance(other, Plan) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        tool = f", {self.tool}" if self.tool else ""
        return f"<Plan {self.title!r}: {len(self)} steps{tool}>"

    def _repr_svg_(self) -> str:
        return self.preview().svg


def load(
    file: str | os.PathLike[str] | IO[bytes],
    *,
    format: str | None = None,
    title: str | None = None,
    tool: Tool | None = None,
    surface: float | Surface | None = None,
    sheet: Sheet | None = None,
    place: bool = False,
    raw: bool = False,
    pen_z: float | None = None,
    depths: Literal["flatten", "keep"] = "flatten",
    at: tuple[float, float] | None = None,
    page: str | None = None,
    margin: float | None = None,
    scale: float = 1.0,
    rotate: float = 0.0,
    fit: bool = False,
    turn: bool = True,
    mirror: bool = False,
    clip_page: bool = False,
    resample: float | None = None,
    white: Literal["skip", "draw"] = "skip",
    move: tuple[float, float, float] = (0.0, 0.0, 0.0),
    start: tuple[float, float, float] | None = None,
    speed: float | None = None,
    travel_speed: float | None = None,
    lift: float | None = None,
    hop: float | None = None,
    order: bool = True,
    tolerance: float | None = None,
    dialect: Literal["pen", "laser", "servo"] | None = None,
    s_max: float | None = None,
    work: Literal["draw", "engrave"] | None = None,
    width: float | None = None,
    height: float | None = None,
    threshold: int | None = None,
    power: float | tuple[float, float] | None = None,
    mode: Literal["grey", "threshold", "dither"] = "grey",
    image: Literal["outline", "centerline", "halftone", "squiggle", "hatch"] | None = None,
    levels: int | None = None,
    despeckle: float | None = None,
    pen_width: float | None = None,
    crop: tuple[int, int, int, int] | None = None,
    brightness: float | None = None,
    contrast: float | None = None,
    invert: bool = False,
    one_way: bool = False,
    spacing: float | None = None,
    overscan: float | None = None,
    gamma: float | None = None,
    merge: float | None = None,
    dedupe: bool | None = None,
    simplify: float | None = None,
    font: str | os.PathLike[str] | None = None,
    size: float | None = None,
    wrap: float | None = None,
    align: Literal["left", "center", "right"] | None = None,
    line_height: float | None = None,
    text: Literal["outline", "stroke"] | None = None,
    system_fonts: Literal["on", "off"] | None = None,
    strict_text: bool = False,
    fill: Literal["none", "hatch", "cross", "contour"] = "none",
    fill_spacing: float | None = None,
    fill_angle: float | None = None,
    fill_inset: float | None = None,
    parts: Literal["none", "layer", "color"] | None = None,
    only: str | Iterable[str] = (),
    passes: int | None = None,
    pens: str | os.PathLike[str] | Iterable[Mapping[str, Any]] | None = None,
    no_pause: bool = False,
    frame: Literal["box", "hull", "outline"] | None = None,
    frame_power: float | None = None,
    preset: str | None = None,
) -> Plan:
    """A plan of a file: a taught program (``.playback``), G-code, a drawing (SVG, HPGL, DXF), a Blockly program, an
    image, points (CSV, JSON, text), or a plan file. Drawings are drawn with the pen, images engraved.

    :param file: Path, or an open binary file.
    :param format: What it is, where neither name nor content tells: ``playback``, ``svg``, ``gcode``, ``image``,
        ``dxf``, ``hpgl``, ``blockly``, ``points``, ``text``, ``testgrid``, ``plan``.
    :param title: What it is called; the file's name if left out.
    :param tool: The tool on the arm, by name or by its bias in mm.
    :param surface: How high the paper or the wood lies: the z of the arm's pose when its tool touches it, mm. Drawings
        and images need it; without it they are laid on the table of a virtual arm (-60 mm), and no other arm runs them.
    :param sheet: The sheet that drawings lie on, corner on corner. Without it they lie wherever there is room.
    :param place: Whether the coordinates of G-code, a plan, a playback file or points are its own: the middle of what
        it draws goes to ``at``, else onto the sheet, else to where there is room, and what G-code draws lies on the
        surface. ``at``, ``page``, ``fit``, ``surface`` and ``work`` imply it.
    :param raw: Whether its coordinates are the arm's, as they stand.
    :param pen_z: The Z of placed G-code at which its pen touches, mm; the first depth at which it draws if left out.
    :param depths: Depths below the surface: ``"flatten"`` draws them on the surface, a pen never goes below it;
        ``"keep"`` takes the pen down to them.
    :param at: Where its middle goes, x and y, mm.
    :param page: The page of paper that it lies on, its middle on the middle of the page: ``"a3"``, ``"a4"``, ``"a5"``,
        ``"a6"`` or ``"letter"``, each also with ``-landscape``, or its width and height in mm, such as ``"200x150"``.
        The page's middle is at ``at``, else on the middle of the sheet, else where there is room; ``Plan.placed.page``
        has its corners.
    :param margin: What ``fit`` makes smaller keeps this far from the edges of the page, mm, 0 or more; 10 if left out.
    :param scale: Its size, 1 being the true one.
    :param rotate: By how much it is turned to the left, degrees.
    :param fit: Whether it is made smaller until the arm reaches all of it, and the page has room for it.
    :param turn: Whether it may be turned by 90 degrees, to lie in front of the arm or to be larger with ``fit``.
    :param mirror: Whether it is mirrored, left to right.
    :param clip_page: Whether what lies beyond the page of a drawing is cut off.
    :param resample: Points of a recording that are nearer than this to the line are left out, mm; the others keep their
        times.
    :param white: White lines and shapes of an SVG: ``"skip"`` leaves them out, but on darker shapes and where nothing
        else would be drawn; ``"draw"`` draws them all.
    :param move: By how much it is moved then, mm.
    :param start: Where the tool stands when G-code that is not placed begins, for what depends on it, mm.
    :param speed: Along lines that are drawn or burnt, mm/s.
    :param travel_speed: Between them, mm/s.
    :param lift: Pen lift between lines, mm.
    :param hop: Least pen lift between lines that are near each other, mm: half of the way between them, up to ``lift``;
        3 if left out.
    :param order: Whether lines may be drawn in another order, to travel less.
    :param tolerance: Largest distance of a line from its curve, mm; 0.05 if left out.
    :param dialect: What G-code is for; if left out, a laser where it switches one and nothing in it is a mill's.
        ``"servo"`` is a pen that M3, M280 or M300 lifts by angles.
    :param s_max: The S of G-code that is the laser's full power (``$30`` of its controller); if left out, what the file
        says of it, else 1000.
    :param work: ``"draw"`` draws all with the pen, images as ``image`` says; ``"engrave"`` burns all, drawings along
        their lines.
    :param width: How wide it becomes, mm.
    :param height: How high it becomes, mm, instead.
    :param threshold: With ``image="outline"``, ``"centerline"`` or ``mode="threshold"``: darker is dark, 1 to 255.
    :param power: What full power is, percent, of whatever burns; or the least and the most of all that is above 0.
    :param mode: How grey levels become power.
    :param image: What the pen makes of an image: ``"outline"`` draws the edges of what is dark, ``"centerline"`` one
        stroke along each dark line; ``"halftone"`` dots, ``"squiggle"`` lines that swing and ``"hatch"`` crossed
        hatchings, which keep its greys. It implies ``work="draw"``, where ``"outline"`` is meant if it is left out.
    :param levels: With ``image="hatch"`` the number of hatchings, 1 to 64, 6 if left out; with ``"halftone"`` that of
        the sizes of dots, 64 if left out.
    :param despeckle: Spots of an image that are smaller are not drawn, mm; 0.3 if left out, 0 keeps all.
    :param pen_width: Width of the line that the pen draws, mm; 0.5 if left out. ``"halftone"``, ``"squiggle"`` and
        ``"hatch"`` are made for it.
    :param crop: What is kept of an image: x and y of its upper left corner, width and height, in pixels.
    :param brightness: How much lighter an image is made, -100 to 100.
    :param contrast: How much more contrast it is given, -100 to 100.
    :param invert: Whether white is drawn or burnt instead of black.
    :param one_way: Whether all lines of an image are burnt in the same direction.
    :param spacing: Distance between the lines or dots of an image, mm; if left out, 0.2 with the laser, with the pen by
        ``image`` and ``pen_width``.
    :param overscan: Run-up and run-out of the tool at the ends of a line, mm; as needed if left out.
    :param gamma: Exponent of the darkness; above 1 makes mid-tones lighter.
    :param merge: Ends of lines of a drawing that are no farther apart than this are joined, mm; 0.1 if left out.
    :param dedupe: Whether a line that is there twice is drawn once: in a drawing it is if this is left out. ``True``
        does the same, with ``merge`` and ``simplify``, for G-code, plans, playback and points, whose lines stay in
        their order.
    :param simplify: Points of a drawing that are no farther from the line without them are left out, mm; 0.02 if left
        out.
    :param font: Font of text: ``"sans"``, ``"script"`` or ``"gothic"``, whose letters are single lines, or the path of
        a file: TrueType, OpenType, an SVG font, or the order of strokes of Chinese and Japanese characters (KanjiVG,
        hanzi-writer). ``"sans"`` if left out.
    :param size: Height of a capital in text, mm; 10 if left out.
    :param wrap: The width that lines of text are broken at, mm.
    :param align: Where shorter lines of text lie.
    :param line_height: From one line of text to the next, in heights of a capital; 1.8 if left out.
    :param text: How the letters of texts in an SVG are drawn: by their outlines, except in fonts whose name begins with
        Hershey or ends in 1-stroke or Single Line; or ``"stroke"``, all in single lines.
    :param system_fonts: Whether texts in an SVG are written in the fonts that they name, where those are installed;
        ``"on"`` if left out, ``"off"`` writes all in the built-in font, on every machine alike.
    :param strict_text: Whether text is refused of which the font lacks a character; otherwise that is left out.
    :param fill: How the visible shapes of an SVG are filled: ``"hatch"`` with parallel lines, ``"cross"`` with others
        across them as well, ``"contour"`` with rings from the edge inwards. ``"none"`` draws their outlines alone.
    :param fill_spacing: Distance of those lines, mm on the surface whatever ``scale`` is, 0.02 or more; 0.8 with the
        pen and 0.2 with the laser if left out. It, ``fill_angle`` and ``fill_inset`` need a ``fill``.
    :param fill_angle: Their direction, degrees counter-clockwise from x; 45 if left out.
    :param fill_inset: Their distance from the edge, mm, 0 or more; half of ``fill_spacing`` if left out.
    :param parts: What a drawing is divided into: ``"layer"`` (layers, pens of a plot, tools of G-code) or ``"color"``.
        Between its parts the job pauses, so that a pen can be changed; a laser job only before layers whose name
        begins with ``!``. If left out: layers, with ``only`` or ``pens`` and where names of Inkscape layers begin
        with ``%`` (left out) or ``!``; else a drawing has no parts.
    :param only: Parts that are drawn, each by its name, its colour (``#rrggbb`` or a name of CSS) or its number.
    :param passes: How often each part is drawn before the next, 1 to 1000.
    :param pens: Pens of the parts: mappings with ``match`` (a name, a colour or a number) and any of
        ``surface_offset``, ``lift``, ``speed``, ``power``, ``passes`` and ``fill``; or the path of a TOML file with a
        ``[[pen]]`` for each. The first that matches a part counts.
    :param no_pause: Whether the plan never waits for a person.
    :param frame: Go round what would be drawn or burnt, without a mark, instead: see :func:`frame`.
    :param frame_power: Power of the laser on a frame, percent, 5 at most; dark if left out.
    :param preset: A preset of ``magician preset``: what it says counts for arguments that are left out or as usual.
    :returns: The plan. :attr:`Plan.notes` lists the parts that were left out or interpreted.
    :raises InvalidInputError: It cannot be read (with line and column), cannot be placed like this, or an argument is
        invalid.
    :raises OSError: The file cannot be opened.
    """
    name, data = _open(file)
    font_name, font_file = _font(font)
    given: Any = power
    if power is not None:
        given = _two("power", given if hasattr(power, "__len__") else (0.0, given))
    wanted: Mapping[str, Any] = {
        "format": string("format", format),
        "title": string("title", title),
        "tool": _tool(tool),
        "surface": _surface(surface),
        "sheet": None if sheet is None else _sheet(sheet),
        "start": None if start is None else _three("start", start),
        "pen_z": number("pen_z", pen_z, unit="mm"),
        "depths": string("depths", depths),
        "at": None if at is None else _two("at", at),
        "page": string("page", page),
        "margin": number("margin", margin, least=0, unit="mm"),
        "scale": number("scale", scale, above=0),
        "rotate": number("rotate", rotate, unit="deg"),
        **flags(
            place=place,
            raw=raw,
            fit=fit,
            turn=turn,
            mirror=mirror,
            clip_page=clip_page,
            order=order,
            invert=invert,
            one_way=one_way,
            strict_text=strict_text,
            no_pause=no_pause,
        ),
        "dedupe": None if dedupe is None else flag("dedupe", dedupe),
        "by": _three("move", move),
        "speed": number("speed", speed, above=0, unit="mm/s"),
        "travel_speed": number("travel_speed", travel_speed, above=0, unit="mm/s"),
        "lift": number("lift", lift, above=0, unit="mm"),
        "hop": number("hop", hop, above=0, unit="mm"),
        "tolerance": number("tolerance", tolerance, above=0, unit="mm"),
        "resample": number("resample", resample, above=0, unit="mm"),
        "white": string("white", white),
        "dialect": string("dialect", dialect),
        "s_max": number("s_max", s_max, above=0),
        "work": string("work", work),
        "width": number("width", width, above=0, unit="mm"),
        "height": number("height", height, above=0, unit="mm"),
        "threshold": None if threshold is None else whole("threshold", threshold, 1, 255),
        "power": given,
        "mode": string("mode", mode),
        "image": string("image", image),
        "levels": None if levels is None else whole("levels", levels, 1, 64),
        "despeckle": number("despeckle", despeckle, least=0, unit="mm"),
        "pen_width": number("pen_width", pen_width, above=0, unit="mm"),
        "crop": None if crop is None else _crop(crop),
        "brightness": number("brightness", brightness, least=-100, most=100),
        "contrast": number("contrast", contrast, least=-100, most=100),
        "spacing": number("spacing", spacing, above=0, unit="mm"),
        "overscan": number("overscan", overscan, above=0, unit="mm"),
        "gamma": number("gamma", gamma, above=0),
        "merge": number("merge", merge, least=0, unit="mm"),
        "simplify": number("simplify", simplify, least=0, unit="mm"),
        "font": font_name,
        "font_file": font_file,
        "size": number("size", size, above=0, unit="mm"),
        "wrap": number("wrap", wrap, above=0, unit="mm"),
        "align": string("align", align),
        "line_height": number("line_height", line_height, above=0),
        "text": string("text", text),
        "system_fonts": string("system_fonts", system_fonts),
        "fill": string("fill", fill),
        "fill_spacing": number("fill_spacing", fill_spacing, least=0.02, unit="mm"),
        "fill_angle": number("fill_angle", fill_angle, unit="deg"),
        "fill_inset": number("fill_inset", fill_inset, least=0, unit="mm"),
        "parts": string("parts", parts),
        "only": [only] if isinstance(only, str) else [str(string("only", one)) for one in only],
        "passes": None if passes is None else whole("passes", passes, 1, 1000),
        **_pens(pens),
        "frame": string("frame", frame),
        "frame_power": number("frame_power", frame_power, above=0, unit="percent"),
        "preset": string("preset", preset),
    }
    return Plan(_magician.Plan.load(name, data, wanted))


def write(
    words: str,
    *,
    font: str | os.PathLike[str] | None = None,
    size: float | None = None,
    wrap: float | None = None,
    align: Literal["left", "center", "right"] | None = None,
    line_height: float | None = None,
    strict_text: bool = False,
    **options: Any,
) -> Plan:
    """A plan that writes text with the pen, as ``magician write`` does.

    :param words: The text; it may have several lines.
    :param font: ``"sans"``, ``"script"`` or ``"gothic"``, or the path of a file, as of :func:`load`.
    :param size: Height of a capital, mm; 10 if left out.
    :param wrap: The width that lines are broken at, mm.
    :param align: Where shorter lines lie.
    :param line_height: From one line to the next, in heights of a capital; 1.8 if left out.
    :param strict_text: Whether text is refused of which the font lacks a character; otherwise that is left out, and
        :attr:`Plan.notes` names it.
    :param options: Where and how it is written: ``surface``, ``at``, ``rotate``, ``speed`` and the others of
        :func:`load`.
    :returns: The plan.
    :raises InvalidInputError: There is no text, the font cannot be read, or an argument is invalid.
    :raises OSError: The file of the font cannot be opened.
    """
    if not isinstance(words, str):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"words is {words!r}; it takes text")
    options.setdefault("title", words.split("\n", 1)[0][:40])
    return load(
        io.BytesIO(words.encode()),
        format="text",
        font=font,
        size=size,
        wrap=wrap,
        align=align,
        line_height=line_height,
        strict_text=strict_text,
        **options,
    )


def frame(
    file: str | os.PathLike[str] | IO[bytes],
    shape: Literal["box", "hull", "outline"] = "box",
    *,
    frame_power: float | None = None,
    **options: Any,
) -> Plan:
    """A plan that goes round what a file would draw or burn, as ``magician frame`` does: with the laser off at the
    height of the work, with any other tool ``lift`` above it. Each run of it goes round once.

    :param file: Path, or an open binary file.
    :param shape: ``"box"`` along the arm's X and Y; ``"hull"``, a rubber band round all lines; ``"outline"``, the outer
        contours, where lines less than 4 mm apart count as one shape. Where the box or the outline leaves the reach it
        is the hull, and :attr:`Plan.notes` says so.
    :param frame_power: Power of the laser on the way, percent, 5 at most; dark if left out. An arm runs it with
        ``allow_laser=True`` alone.
    :param options: Those with which :func:`load` would make the plan; ``tool`` and ``work`` say whether it is drawn or
        burnt.
    :returns: The plan.
    :raises InvalidInputError: The file marks nothing, or as of :func:`load`.
    :raises OSError: The file cannot be opened.
    """
    return load(file, frame=shape, frame_power=frame_power, **options)


def testgrid(
    *,
    power: tuple[float, float, int] = (10, 100, 5),
    speed: tuple[float, float, int] = (5, 40, 5),
    cell: float = 8,
    spacing: float = 0.2,
    labels: bool = True,
    **options: Any,
) -> Plan:
    """A plan that burns squares with many powers and speeds, to try a material, as ``magician testgrid`` does.

    :param power: Powers of the columns, percent: from, to, how many.
    :param speed: Speeds of the rows, mm/s: from, to, how many.
    :param cell: Side of a square, mm; a quarter of it is between them.
    :param spacing: Distance between the lines of a square, mm.
    :param labels: Whether columns and rows are labelled, with the weakest power at the highest speed.
    :param options: Where it goes: ``surface``, ``at``, ``rotate``, ``fit`` and the others of :func:`load`.
    :returns: The plan.
    :raises InvalidInputError: A value is out of its range.
    """
    series: dict[str, str] = {}
    for name, (first, last, count) in (("power", power), ("speed", speed)):
        ends = (number(name, first, above=0), number(name, last, above=0))
        series[name] = "{}:{}:{}".format(*map(repr, ends), _count(name, count))
    grid: dict[str, Any] = {
        "format": "magician-testgrid",
        **series,
        "cell": number("cell", cell, above=0, unit="mm"),
        "spacing": number("spacing", spacing, above=0, unit="mm"),
        **flags(labels=labels),
    }
    options.setdefault("title", "test grid")
    import json

    return load(io.BytesIO(json.dumps(grid).encode()), format="testgrid", **options)


# Its name begins as those of tests do, and pytest would take it for one where it is imported.
vars(testgrid)["__test__"] = False


_FONTS = ("sans", "script", "gothic")
_FONTS_OR_FILE = "sans, script, gothic or the path of a file"


def _font(font: str | os.PathLike[str] | None) -> tuple[str | None, bytes | None]:
    if font is None or (isinstance(font, str) and font in _FONTS):
        return font, None
    if not isinstance(font, (str, os.PathLike)):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"font is {font!r}; it takes {_FONTS_OR_FILE}")
    path = Path(font)
    try:
        return path.name, path.read_bytes()
    except OSError as error:
        raise OSError(error.errno, f"font takes {_FONTS_OR_FILE}: {error.strerror}", str(path)) from None


def _pens(pens: str | os.PathLike[str] | Iterable[Mapping[str, Any]] | None) -> dict[str, str | None]:
    if pens is None:
        return {"pens": None, "pens_file": None}
    if isinstance(pens, (str, os.PathLike)):
        return {"pens": None, "pens_file": Path(pens).read_text("utf-8")}
    try:
        import json

        return {"pens": json.dumps([dict(pen) for pen in pens]), "pens_file": None}
    except (TypeError, ValueError):
        raise TypeError(f"pens is {pens!r}; it takes mappings, or the path of a TOML file") from None


def _open(file: str | os.PathLike[str] | IO[bytes]) -> tuple[str, bytes]:
    if isinstance(file, (str, os.PathLike)):
        path = Path(file)
        return path.name, path.read_bytes()
    if not hasattr(file, "read"):
        raise TypeError(f"a file is a path, or open for reading bytes, not {type(file).__name__}")
    name = getattr(file, "name", "file")
    return (Path(name).name if isinstance(name, str) else "file"), file.read()


def _tool(tool: Tool | None) -> str | None:
    if tool is None or isinstance(tool, str):
        return tool
    return ",".join(map(repr, _three("tool", tool)))


def _surface(surface: float | Surface | None) -> tuple[float, tuple[float, float]] | None:
    if surface is None:
        return None
    if isinstance(surface, Surface):
        return number("surface.height", surface.height, unit="mm"), _two("surface.slope", surface.slope)
    if isinstance(surface, (str, bytes)) or not hasattr(surface, "__float__"):
        raise TypeError(f"a surface is its height in mm, or a Surface, not {surface!r}")
    return number("surface", surface, unit="mm"), (0.0, 0.0)


def _sheet(sheet: Sheet) -> tuple[float, float, float, tuple[float, float] | None]:
    if not isinstance(sheet, Sheet):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"sheet is {sheet!r}; it takes a Sheet")
    size = None if sheet.size is None else _two("sheet.size", sheet.size)
    return *_two("sheet.corner", sheet.corner), number("sheet.rotation", sheet.rotation, unit="deg"), size


def _two(name: str, values: Iterable[float]) -> tuple[float, float]:
    a, b = numbers(name, values, 2)
    return a, b


def _crop(values: Iterable[int]) -> tuple[int, ...]:
    window = tuple(values)
    if len(window) != 4:
        raise InvalidInputError(f"crop is {window}; it takes x, y, width and height in pixels")
    return tuple(whole("crop", value, least, _MOST) for value, least in zip(window, (0, 0, 1, 1), strict=True))


def _three(name: str, values: Iterable[float]) -> tuple[float, float, float]:
    a, b, c = numbers(name, values, 3)
    return a, b, c


_MOST = 2**32 - 1


def _count(name: str, value: int) -> int:
    return whole(name, value, 1, _MOST)


def _corners(sheet: Sheet) -> list[tuple[float, float]] | None:
    from math import cos, radians, sin

    x, y, rotation, size = _sheet(sheet)
    turn = radians(rotation)
    if size is None:
        return None
    width, height = size
    ends = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
    return [(x + right * cos(turn) - up * sin(turn), y + right * sin(turn) + up * cos(turn)) for right, up in ends]


def _step(found: dict[str, Any]) -> Step:
    return Step(
        number=found["number"],
        action=found["action"],
        by=found["by"],
        command=found["command"],
        values=tuple(found["values"]),
        target=None if found["target"] is None else tuple(found["target"]),
        line=found["line"],
        column=found["column"],
        row=found["row"],
        name=found["name"],
    )
