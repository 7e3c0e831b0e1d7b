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
from typing import IO, TYPE_CHECKING, Any, Literal, NamedTuple, TypedDict, overload

from . import _magician
from ._arguments import as_json, flag, flags, number, numbers, seconds, whole
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

if TYPE_CHECKING:
    from typing_extensions import Unpack
else:
    import typing

    class _Unpack:
        """Of Python 3.10, which has none."""

        def __class_getitem__(cls, item: object) -> object:
            return Any

    Unpack = getattr(typing, "Unpack", _Unpack)

__all__ = [
    "Complaint",
    "Note",
    "Placed",
    "Plan",
    "Points",
    "Rehearsal",
    "Report",
    "SetupOptions",
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


# `cargo xtask python` writes this class from the table of options.
class SetupOptions(TypedDict, total=False):
    """How a file is drawn or engraved: the keywords of :func:`load`, :func:`write` and :func:`frame`. What is not
    given is as the file says, or usual. Lengths are mm, angles degrees, speeds mm/s."""

    work: Literal["draw", "engrave"] | None
    """Work that is made of drawings and images: the pen draws, or the laser engraves. Without it the tool decides:
    the laser engraves, every other tool draws."""
    font: str | os.PathLike[str] | None
    """Font of text: a built-in one, or a file: sans, script or gothic; sans if left out. The letters of a built-in
    font are single lines. A file is TrueType, OpenType, an SVG font, or the order of strokes of Chinese and Japanese
    characters (KanjiVG, hanzi-writer)."""
    size: float | None
    """Height of a capital in text: a number above 0 and at most 10000 mm; 10 if left out."""
    wrap: float | None
    """Width at which lines of text are broken: a number above 0 and at most 10000 mm."""
    place: bool | None
    """Place a program (G-code, a plan, playback, points) like a drawing. Its centre goes to the given point, else
    onto the sheet, else where there is room. A point, a page, a surface, fitting and both works imply it."""
    tool: Tool | None
    """Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm; pen if left out. It stays set on
    the arm."""
    fill: Literal["none", "hatch", "cross", "contour"] | None
    """Fill visible shapes, and letters of outline fonts, with lines; none if left out. Parallel lines, others across
    them as well, or rings from the edge inwards; without them shapes are outlined."""
    image: Literal["outline", "centerline", "halftone", "squiggle", "hatch"] | None
    """Treatment of an image that the pen draws; outline if left out. Edges of what is dark, one stroke along each
    dark line, dots, swinging lines, or crossed hatchings; the last three keep its greys."""
    surface: float | Surface | None
    """Height of the work surface: a number from -10000 to 10000 mm. It is the z of the arm's pose when the tool
    touches it."""
    at: tuple[float, float] | None
    """Position of its centre: two numbers, X and Y, each from -10000 to 10000 mm."""
    scale: float | None
    """Scale factor; 1 is the true size: a number above 0 and at most 10000; 1 if left out. With a width or a height
    it multiplies that size."""
    width: float | None
    """Width that it is scaled to: a number above 0 and at most 10000 mm."""
    rotate: float | None
    """Counter-clockwise rotation: a number from -36000 to 36000 degrees; 0 if left out."""
    fit: bool | None
    """Shrink it until the arm reaches all of it, and the page has room for it."""
    height: float | None
    """Height that it is scaled to, instead of a width: a number above 0 and at most 10000 mm."""
    clip_page: bool | None
    """Clip a drawing at its page."""
    page: str | None
    """Page of paper that it lies on; a size in mm, such as 200x150, is taken too: a3, a4, a5, a6 or letter, each
    also with -landscape, or WIDTHxHEIGHT in mm, such as 200x150. It lies there as its file has it on a page of that
    size, else centre on centre. The page lies at the given point, else on the calibrated sheet, else where there is
    room."""
    margin: float | None
    """Distance from the edges of the page that fitting keeps: a number from 0 to 10000 mm; 10 if left out."""
    turn: bool | None
    """Rotate it by 90 degrees where that fits better; on if left out."""
    mirror: bool | None
    """Mirror it left to right."""
    move: tuple[float, float, float] | None
    """Shift from where it lies: three numbers, X, Y and Z, each from -10000 to 10000 mm."""
    raw: bool | None
    """Take the coordinates of the file as the arm's, unchanged."""
    fill_spacing: float | None
    """Distance of the lines that fill a shape: a number from 0.02 to 10000 mm; 0.8 with the pen, 0.2 with the laser
    if left out. It is measured on the surface, whatever the scale."""
    fill_angle: float | None
    """Direction of the lines that fill a shape, counter-clockwise from x: a number from -36000 to 36000 degrees; 45
    if left out."""
    fill_inset: float | None
    """Distance of the lines that fill a shape from its edge: a number from 0 to 10000 mm; half the distance of the
    lines if left out."""
    white: Literal["skip", "draw"] | None
    """Treatment of white lines and shapes; skip if left out. They are left out, except on darker shapes and where
    nothing else would be drawn; or all are drawn."""
    align: Literal["left", "center", "right"] | None
    """Alignment of lines of text; left if left out."""
    line_height: float | None
    """Distance from one line of text to the next, in heights of a capital: a number above 0 and at most 1000; 1.8 if
    left out."""
    text: Literal["outline", "stroke"] | None
    """Treatment of the letters of texts in a drawing; outline if left out. Their edges, except in fonts whose name
    begins with Hershey or ends in 1-stroke or Single Line; or all in single lines."""
    system_fonts: Literal["on", "off"] | None
    """Use of the installed fonts that texts in a drawing name; on if left out. Without them all is written in the
    built-in font, on every machine alike."""
    strict_text: bool | None
    """Refuse text if its font lacks a character; otherwise that is left out, with a note."""
    parts: Literal["none", "layer", "color"] | None
    """Division of a drawing into parts, between which the job pauses for a change of the pen. Layers (also pens of a
    plot and tools of G-code), or colours. Layers are taken where parts are chosen or have pens, and if names of
    Inkscape layers have % or !; else there are no parts."""
    only: str | Iterable[str] | None
    """Parts that are drawn, each by its name, its colour (#rrggbb or of CSS) or its number. Without them all parts
    are drawn."""
    passes: int | None
    """Number of times that each part is drawn before the next: a whole number from 1 to 1000; 1 if left out."""
    pens: str | os.PathLike[str] | Iterable[Mapping[str, Any]] | None
    """Pens of the parts; the first that is for a part counts. Each has a match (a name, a colour or a number) and
    any of surface_offset, lift, speed, power, passes and fill."""
    no_pause: bool | None
    """Never pause for a person, neither between parts nor where the program says so."""
    levels: int | None
    """Number of hatchings that are laid over each other, or of sizes of dots: a whole number from 1 to 64; 6
    hatchings, 64 sizes of dots if left out."""
    despeckle: float | None
    """Size of the largest spots of an image that are left out; 0 keeps all: a number from 0 to 10000 mm; 0.3 if left
    out."""
    pen_width: float | None
    """Width of the line that the pen draws, for an image: a number above 0 and at most 10000 mm; 0.5 if left out."""
    spacing: float | None
    """Distance between the lines or dots of an image: a number above 0 and at most 10000 mm; 0.2 with the laser;
    with the pen by its treatment and its width if left out."""
    threshold: int | None
    """Grey below which an image counts as dark, where it is drawn or burnt in black and white: a whole number from 1
    to 255; 128 if left out."""
    crop: tuple[int, int, int, int] | None
    """Part of an image that is kept, in its pixels from the upper left corner: four whole numbers of pixels, X, Y, W
    and H, the last two above 0."""
    brightness: float | None
    """Lightening of an image: a number from -100 to 100; 0 if left out."""
    contrast: float | None
    """Additional contrast of an image: a number from -100 to 100; 0 if left out."""
    gamma: float | None
    """Exponent of the darkness; above 1 makes mid-tones lighter: a number above 0 and at most 100; 1 if left out."""
    invert: bool | None
    """Draw or burn what is white instead of what is black."""
    power: float | tuple[float, float] | None
    """Full power of the laser, or the range of all power above 0, such as 5..80: percent above 0 and at most 100,
    such as 80 or 5..80."""
    mode: Literal["grey", "threshold", "dither"] | None
    """Use of grey levels: as power, in black and white, or as denser dots; grey if left out."""
    one_way: bool | None
    """Burn all lines in the same direction: slower, but free of backlash."""
    overscan: float | None
    """Run-up and run-out of the tool at the ends of a line: a number above 0 and at most 10000 mm; as the speed
    needs if left out."""
    frame: Literal["box", "hull", "outline"] | None
    """Go round what would be marked, instead of marking it. Its box along X and Y, its convex hull, or its outer
    contours."""
    frame_power: float | None
    """Power of the laser on a frame: a number above 0 and at most 5 percent. Without it the laser is off."""
    lift: float | None
    """Pen lift between lines: a number above 0 and at most 10000 mm; 10, or as the settings say if left out."""
    hop: float | None
    """Least pen lift, between lines that are near each other: a number above 0 and at most 10000 mm; 3 if left out.
    It is half of the way between them, up to the whole lift."""
    travel_speed: float | None
    """Speed between lines: a number from 0.01 to 10000 mm/s; 200, or as the settings say if left out."""
    depths: Literal["flatten", "keep"] | None
    """Treatment of depths below the surface; flatten if left out. They are drawn on the surface, and a pen never
    goes below it; or the pen goes down to them."""
    order: bool | None
    """Draw lines in the order that travels least; on if left out."""
    merge: float | None
    """Largest gap between ends of lines that are joined; 0 joins none: a number from 0 to 10000 mm; 0.1 if left out."""
    dedupe: bool | None
    """Draw a line that is there twice once; on if left out. In a program it tidies the lines as those of a drawing,
    but leaves their order."""
    simplify: float | None
    """Distance below which a point is left out whose line goes on almost the same without it; 0 keeps all: a number
    from 0 to 10000 mm; 0.02 if left out."""
    tolerance: float | None
    """Largest distance of a line from its curve, in the size in which it is drawn: a number above 0 and at most
    10000 mm; 0.05 if left out."""
    speed: float | None
    """Speed along the lines that are drawn or burnt: a number from 0.01 to 10000 mm/s; as the file or the settings
    say if left out."""
    dialect: Literal["pen", "laser", "servo"] | None
    """Machine of a G-code file; the servo of a pen is moved by M3, M280 or M300; the laser if the file switches a
    spindle or sets a power and has nothing of a mill's if left out."""
    s_max: float | None
    """S of full laser power in a G-code file: a number above 0 and at most 1000000000; as the file says, else 1000
    if left out."""
    pen_z: float | None
    """Z at which the pen of placed G-code touches the surface: a number from -10000 to 10000 mm; the first depth at
    which it draws if left out."""
    start: tuple[float, float, float] | None
    """Position of the tool where a G-code program begins that does not say so: three numbers, X, Y and Z, each from
    -10000 to 10000 mm; where the tool is if left out."""
    resample: float | None
    """Distance below which points of a recording are left out that are close to the line: a number above 0 and at
    most 10000 mm. The others keep their times, and the number of steps stays."""


_SWITCHES = (
    "place",
    "fit",
    "clip_page",
    "turn",
    "mirror",
    "raw",
    "strict_text",
    "no_pause",
    "invert",
    "one_way",
    "order",
    "dedupe",
)
# So far it is written.


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
    """True if all steps have ended without an alarm."""
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

    # Creation.

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

    # Inspection.

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
        """True if the work surface height is unknown: it is then assumed to be the table of a virtual arm, and no real
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

    # Changes.

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

    # Files.

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

    # Value protocol.

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
    sheet: Sheet | None = None,
    preset: str | None = None,
    **options: Unpack[SetupOptions],
) -> Plan:
    """A plan of a file: a taught program (``.playback``), G-code, a drawing (SVG, HPGL, DXF), a Blockly program, an
    image, points (CSV, JSON, text), or a plan file. Drawings are drawn with the pen, images engraved.

    :param file: Path, or an open binary file.
    :param format: What it is, where neither name nor content tells: ``playback``, ``svg``, ``gcode``, ``image``,
        ``dxf``, ``hpgl``, ``blockly``, ``points``, ``text``, ``testgrid``, ``plan``.
    :param title: What it is called; the file's name if left out.
    :param sheet: The sheet that drawings lie on, corner on corner. Without it they lie wherever there is room.
    :param preset: A preset of ``magician preset``: what it says counts for options that are left out.
    :param options: How it is drawn or engraved, where and how large: see :class:`SetupOptions`. Drawings and images
        need a ``surface``; without it they are laid on the table of a virtual arm (-60 mm), and no other arm runs them.
    :returns: The plan. :attr:`Plan.notes` lists the parts that were left out or interpreted.
    :raises InvalidInputError: It cannot be read (with line and column), cannot be placed like this, or an option is
        invalid.
    :raises OSError: The file cannot be opened.
    """
    name, data = _open(file)
    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    unknown = given.keys() - SetupOptions.__annotations__.keys()
    if unknown:
        raise TypeError(f"load() got an unexpected keyword argument {min(unknown)!r}")
    wanted: dict[str, Any] = {
        "format": string("format", format),
        "title": string("title", title),
        "surface": None,
        "sheet": None if sheet is None else _sheet(sheet),
        "font_file": _font(given),
        "pens_file": _pens(given),
        "preset": string("preset", preset),
    }
    surface = given.get("surface")
    if isinstance(surface, Surface):
        wanted["surface"] = _surface(surface)
        given["surface"] = surface.height
    for switch in given.keys() & set(_SWITCHES):
        # Accept 1 and 0: Python compares them equal to True and False.
        if isinstance(given[switch], int) and given[switch] in (0, 1):
            given[switch] = bool(given[switch])
    if isinstance(given.get("only"), str):
        given["only"] = [given["only"]]
    power: Any = given.get("power")
    if hasattr(power, "__len__") and not isinstance(power, (str, Mapping)):
        least, most = _two("power", power)
        given["power"] = f"{least!r}..{most!r}"
    import json

    wanted["options"] = json.dumps({name: as_json(name, value) for name, value in given.items()})
    return Plan(_magician.Plan.load(name, data, wanted))


def write(
    words: str,
    *,
    title: str | None = None,
    sheet: Sheet | None = None,
    preset: str | None = None,
    **options: Unpack[SetupOptions],
) -> Plan:
    """A plan that writes text with the pen, as ``magician write`` does.

    :param words: The text; it may have several lines.
    :param title: What it is called; the beginning of the text if left out.
    :param sheet: As of :func:`load`.
    :param preset: As of :func:`load`.
    :param options: How and where it is written: ``font``, ``size``, ``wrap``, ``align``, ``surface``, ``at``, ``speed``
        and the others of :class:`SetupOptions`.
    :returns: The plan.
    :raises InvalidInputError: There is no text, the font cannot be read, or an option is invalid.
    :raises OSError: The file of the font cannot be opened.
    """
    if not isinstance(words, str):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"words is {words!r}; it takes text")
    title = words.split("\n", 1)[0][:40] if title is None else title
    return load(io.BytesIO(words.encode()), format="text", title=title, sheet=sheet, preset=preset, **options)


def frame(
    file: str | os.PathLike[str] | IO[bytes],
    shape: Literal["box", "hull", "outline"] = "box",
    *,
    format: str | None = None,
    title: str | None = None,
    sheet: Sheet | None = None,
    preset: str | None = None,
    **options: Unpack[SetupOptions],
) -> Plan:
    """A plan that goes round what a file would draw or burn, as ``magician frame`` does: with the laser off at the
    height of the work, with any other tool ``lift`` above it. Each run of it goes round once.

    :param file: Path, or an open binary file.
    :param shape: ``"box"`` along the arm's X and Y; ``"hull"``, a rubber band round all lines; ``"outline"``, the outer
        contours, where lines less than 4 mm apart count as one shape. Where the box or the outline leaves the reach it
        is the hull, and :attr:`Plan.notes` says so.
    :param format: As of :func:`load`.
    :param title: As of :func:`load`.
    :param sheet: As of :func:`load`.
    :param preset: As of :func:`load`.
    :param options: Those with which :func:`load` would make the plan; ``tool`` and ``work`` say whether it is drawn or
        burnt. With ``frame_power`` the laser is lit on the way, and an arm runs it with ``allow_laser=True`` alone.
    :returns: The plan.
    :raises InvalidInputError: The file marks nothing, or as of :func:`load`.
    :raises OSError: The file cannot be opened.
    """
    options["frame"] = shape
    return load(file, format=format, title=title, sheet=sheet, preset=preset, **options)


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


# Its name begins with `test`, so pytest would collect it in every module that imports it.
vars(testgrid)["__test__"] = False


_FONTS = ("sans", "script", "gothic")
_FONTS_OR_FILE = "sans, script, gothic or the path of a file"


def _font(given: dict[str, Any]) -> tuple[str, bytes] | None:
    """The name and the bytes of a font that is a file, which is no option any more."""
    font = given.get("font")
    if not isinstance(font, (str, os.PathLike)) or font in _FONTS:
        return None
    path = Path(given.pop("font"))
    try:
        return path.name, path.read_bytes()
    except OSError as error:
        raise OSError(error.errno, f"font takes {_FONTS_OR_FILE}: {error.strerror}", str(path)) from None


def _pens(given: dict[str, Any]) -> str | None:
    """The text of a file of pens, which is no option any more."""
    if isinstance(given.get("pens"), (str, os.PathLike)):
        return Path(given.pop("pens")).read_text("utf-8")
    return None


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
