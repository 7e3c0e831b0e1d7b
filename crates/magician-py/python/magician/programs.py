"""Plans: drawn, taught or computed programs that are checked before anything moves.

A :class:`Plan` is a value. :func:`load` creates one from a file in any known format, :meth:`Plan.path` from an array of
points, :meth:`Plan.of` from commands. A plan can be checked (:meth:`Plan.check`), drawn (:meth:`Plan.preview`), moved,
rotated, repeated, and saved as readable text (:meth:`Plan.save`). ``arm.run(plan)`` runs it.

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
from ._targets import fill_r
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
"""Names of tools."""
Tool = ToolName | tuple[float, float, float]
"""Name of a tool, or its bias from the wrist, mm."""
Travel = Literal["path", "line", "joints", "jump"]
"""Motion to points: one continuous path, or to each point a straight line, joint interpolation, or a jump (up, across,
down)."""


class Surface(NamedTuple):
    """Work surface of the tool: paper, wood, a table; level, or tilted as measured."""

    height: float
    """Reported z of the arm when its tool touches the surface, at x = y = 0, mm."""
    slope: tuple[float, float] = (0.0, 0.0)
    """Slope in x and y, mm per mm."""


class Sheet(Value):
    """A sheet of paper before the arm, on which drawings are placed corner to corner."""

    corner: tuple[float, float]
    """Lower left corner, in the arm's x and y, mm."""
    rotation: float = 0.0
    """Direction of the lower edge, degrees from the arm's X towards its Y."""
    size: tuple[float, float] | None = None
    """Width and height, mm, if known."""


# `cargo xtask python` writes this class from the table of options.
class SetupOptions(TypedDict, total=False):
    """Options for drawing or engraving a file: the keywords of :func:`load`, :func:`write` and :func:`frame`. Options
    left out take the value of the file, or their default. Lengths are mm, angles degrees, speeds mm/s."""

    work: Literal["draw", "engrave"] | None
    """Kind of work for drawings and images: draw with a pen, or engrave with the laser. By default the tool decides:
    the laser engraves, every other tool draws."""
    font: str | os.PathLike[str] | None
    """Font of text: a built-in font or a font file: sans, script or gothic; default: sans. Built-in fonts draw
    letters in single strokes. A file is a TrueType, OpenType or SVG font, or stroke-order data for Chinese and
    Japanese characters (KanjiVG, hanzi-writer)."""
    size: float | None
    """Height of capital letters: a number above 0 and at most 10000 mm; default: 10."""
    wrap: float | None
    """Width at which text wraps: a number above 0 and at most 10000 mm."""
    place: bool | None
    """Place a program (G-code, a plan, playback, points) like a drawing. It is centred at the given point, else
    placed on the calibrated sheet, else where the arm has room for it. Setting a point, a page, a surface, fitting
    or a kind of work implies this option."""
    tool: Tool | None
    """Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm; default: pen. The setting stays
    on the arm."""
    fill: Literal["none", "hatch", "cross", "contour"] | None
    """Fill visible shapes, and letters of outline fonts, with lines; default: none. Parallel lines (hatch), two
    crossed sets of lines (cross), or rings from the edge inwards (contour). By default shapes are only outlined."""
    image: Literal["outline", "centerline", "halftone", "squiggle", "hatch"] | None
    """Style in which the pen draws an image; default: outline. Outlines of dark areas, one stroke along each dark
    line, dots, wavy lines, or crossed hatching; the last three reproduce grey levels."""
    surface: float | Surface | None
    """Height of the work surface: a number from -10000 to 10000 mm. This is the z of the arm's pose when the tool
    touches the surface."""
    at: tuple[float, float] | None
    """Position of the centre of the artwork: two numbers, X and Y, each from -10000 to 10000 mm."""
    scale: float | None
    """Scale factor; 1 is the original size: a number above 0 and at most 10000; default: 1. With a width or a
    height, the factor multiplies that size."""
    width: float | None
    """Width to scale to: a number above 0 and at most 10000 mm."""
    rotate: float | None
    """Counter-clockwise rotation: a number from -36000 to 36000 degrees; default: 0."""
    fit: bool | None
    """Shrink the artwork until all of it is within the arm's reach and on the page."""
    height: float | None
    """Height to scale to, instead of a width: a number above 0 and at most 10000 mm."""
    clip_page: bool | None
    """Clip a drawing to its page."""
    page: str | None
    """Paper size of the page to draw on; also a size in mm, such as 200x150: a3, a4, a5, a6 or letter, each also
    with -landscape, or WIDTHxHEIGHT in mm, such as 200x150. The artwork keeps its position if its file has a page of
    that size; otherwise it is centred. The page lies at the given point, else on the calibrated sheet, else where
    the arm has room for it."""
    margin: float | None
    """Margin kept to the edges of the page when fitting: a number from 0 to 10000 mm; default: 10."""
    turn: bool | None
    """Rotate the artwork by 90 degrees if it fits better; default: on."""
    mirror: bool | None
    """Mirror the artwork left to right."""
    move: tuple[float, float, float] | None
    """Offset added to the position: three numbers, X, Y and Z, each from -10000 to 10000 mm."""
    raw: bool | None
    """Use the coordinates of the file as arm coordinates, unchanged."""
    fill_spacing: float | None
    """Spacing of the fill lines: a number from 0.02 to 10000 mm; default: 0.8 with the pen, 0.2 with the laser.
    Measured on the surface, independent of the scale."""
    fill_angle: float | None
    """Angle of the fill lines, counter-clockwise from x: a number from -36000 to 36000 degrees; default: 45."""
    fill_inset: float | None
    """Inset of the fill lines from the edge of the shape: a number from 0 to 10000 mm; default: half of the spacing."""
    white: Literal["skip", "draw"] | None
    """Handling of white lines and shapes; default: skip. Either skip them, except on darker shapes or if nothing
    else would be drawn; or draw all of them."""
    align: Literal["left", "center", "right"] | None
    """Alignment of lines of text; default: left."""
    line_height: float | None
    """Line spacing of text, as a multiple of the height of capital letters: a number above 0 and at most 1000;
    default: 1.8."""
    text: Literal["outline", "stroke"] | None
    """Rendering of text in a drawing; default: outline. Either outlines, except for fonts whose name begins with
    Hershey or ends in 1-stroke or Single Line; or single strokes for all text."""
    system_fonts: Literal["on", "off"] | None
    """Use of installed fonts for text in a drawing; default: on. Without them all text uses the built-in font, with
    the same result on every machine."""
    strict_text: bool | None
    """Refuse text if the font lacks a character; by default the character is skipped, with a note."""
    parts: Literal["none", "layer", "color"] | None
    """Split a drawing into parts; the job pauses between them for a pen change. Split by layer (also pens of a plot,
    tools of G-code) or by colour. By default a drawing is split by layer if parts are selected or have pens, or if
    names of Inkscape layers contain % or !; otherwise it is not split."""
    only: str | Iterable[str] | None
    """Parts to draw, each by its name, colour (#rrggbb or a CSS name) or number. By default all parts are drawn."""
    passes: int | None
    """Number of times to draw each part before the next one: a whole number from 1 to 1000; default: 1."""
    pens: str | os.PathLike[str] | Iterable[Mapping[str, Any]] | None
    """Pens of the parts; the first pen that matches a part is used. Each pen has a match (a name, a colour or a
    number) and any of surface_offset, lift, speed, power, passes and fill."""
    no_pause: bool | None
    """Never pause for the operator, neither between parts nor where the program asks for it."""
    levels: int | None
    """Number of superimposed hatchings, or of dot sizes: a whole number from 1 to 64; default: 6 hatchings, 64 dot
    sizes."""
    despeckle: float | None
    """Largest size of spots in an image to remove; 0 keeps all: a number from 0 to 10000 mm; default: 0.3."""
    pen_width: float | None
    """Line width of the pen, for images: a number above 0 and at most 10000 mm; default: 0.5."""
    spacing: float | None
    """Spacing of the lines or dots of an image: a number above 0 and at most 10000 mm; default: 0.2 with the laser;
    with the pen, set by the style and the line width."""
    threshold: int | None
    """Grey level below which a pixel counts as dark, if the image is drawn or burnt in black and white: a whole
    number from 1 to 255; default: 128."""
    crop: tuple[int, int, int, int] | None
    """Area of an image to keep, in pixels from the upper left corner: four whole numbers of pixels, X, Y, W and H,
    the last two above 0."""
    brightness: float | None
    """Brightness adjustment of an image: a number from -100 to 100; default: 0."""
    contrast: float | None
    """Contrast adjustment of an image: a number from -100 to 100; default: 0."""
    gamma: float | None
    """Gamma, the exponent of the darkness; above 1 makes mid-tones lighter: a number above 0 and at most 100;
    default: 1."""
    invert: bool | None
    """Draw or burn the white areas instead of the black ones."""
    power: float | tuple[float, float] | None
    """Full laser power, or the range of all powers above 0, such as 5..80: percent above 0 and at most 100, such as
    80 or 5..80."""
    mode: Literal["grey", "threshold", "dither"] | None
    """Rendering of grey levels: as laser power, in black and white, or by dithering; default: grey."""
    one_way: bool | None
    """Burn all lines in the same direction: slower, but without errors from backlash."""
    overscan: float | None
    """Overscan: run-up and run-out of the tool at the ends of a line: a number above 0 and at most 10000 mm;
    default: derived from the speed."""
    frame: Literal["box", "hull", "outline"] | None
    """Trace the frame of the job instead of marking it. The frame is the bounding box along X and Y, the convex
    hull, or the outer contours."""
    frame_power: float | None
    """Laser power while tracing a frame: a number above 0 and at most 5 percent. By default the laser is off."""
    lift: float | None
    """Pen lift between lines: a number above 0 and at most 10000 mm; default: 10, or the value of the settings."""
    hop: float | None
    """Smallest pen lift, between lines that are close together: a number above 0 and at most 10000 mm; default: 3.
    The lift is half of the distance between the lines, at most the full lift."""
    travel_speed: float | None
    """Travel speed between lines: a number from 0.01 to 10000 mm/s; default: 200, or the value of the settings."""
    depths: Literal["flatten", "keep"] | None
    """Handling of depths below the surface; default: flatten. Either draw them on the surface, so that the pen never
    goes below it; or lower the pen to them."""
    order: bool | None
    """Reorder lines for the shortest travel; default: on."""
    merge: float | None
    """Largest gap between line ends to join; 0 disables joining: a number from 0 to 10000 mm; default: 0.1."""
    dedupe: bool | None
    """Draw duplicate lines only once; default: on. In a program, the lines are also joined and simplified as those
    of a drawing, but their order is kept."""
    simplify: float | None
    """Tolerance of line simplification: a point is dropped if the line stays within this distance without it; 0
    keeps all points: a number from 0 to 10000 mm; default: 0.02."""
    tolerance: float | None
    """Tolerance of curve flattening: largest distance of a line from its curve, at the drawn size: a number above 0
    and at most 10000 mm; default: 0.05."""
    speed: float | None
    """Speed while drawing or burning: a number from 0.01 to 10000 mm/s; default: the value of the file or the
    settings."""
    dialect: Literal["pen", "laser", "servo"] | None
    """Type of machine that a G-code file is for; the pen servo is moved by M3, M280 or M300; default: laser if the
    file switches a spindle or sets a power and has no features of a mill."""
    s_max: float | None
    """Value of S for full laser power in a G-code file: a number above 0 and at most 1000000000; default: the value
    of the file, else 1000."""
    pen_z: float | None
    """Z at which the pen touches the surface in placed G-code: a number from -10000 to 10000 mm; default: the first
    depth at which the program draws."""
    start: tuple[float, float, float] | None
    """Start position of the tool for a G-code program that does not set it: three numbers, X, Y and Z, each from
    -10000 to 10000 mm; default: the current position of the tool."""
    resample: float | None
    """Tolerance of simplifying a recording: points closer than this to the line are dropped: a number above 0 and at
    most 10000 mm. The remaining points keep their times, and the number of steps stays the same."""


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
    """One step of a plan: a command, the start of a part, or a pause for the operator."""

    number: int
    """Number of the step, from 1."""
    action: str
    """Kind of the step: ``move``, ``joints``, ``shift``, ``arc``, ``path``, ``burn``, ``suction``, ``gripper``,
    ``laser``, ``wait``, ``home``, ``part``, ``pause``, or ``command`` for anything else."""
    by: Literal["joints", "line", "jump"] | None
    """Motion type of a move."""
    command: Queueable | None
    """Command of the step; ``None`` for a part and a pause."""
    values: tuple[float, ...]
    """Numbers of the step: x, y, z, r (twice for an arc; the last of a burn is the power, percent), the seconds of a
    wait, 1 for on and 0 for off (gripper: 1 closes, 0 opens, -1 switches the pump off)."""
    target: tuple[float, float, float] | None
    """Target of the tool, x, y, z, mm, if the step defines it."""
    line: int | None = None
    """Line in the source file, from 1."""
    column: int | None = None
    """Column in that line, from 1."""
    row: int | None = None
    """Row in the source array, from 0."""
    name: str | None = None
    """Element or point of the source file."""


class Steps(Sequence[Step]):
    """Steps of a plan, created lazily on access."""

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
    """Result of a plan on a private virtual arm at full speed, with a time resolution of 1 µs."""

    ok: bool
    """True if all steps have ended without an alarm."""
    seconds: float
    """Duration on the arm's clock, s."""
    steps: int
    """Number of finished steps."""
    position: Position
    """Final pose of the tool."""
    joints: Joints
    """Final joint angles, degrees."""
    alarms: tuple[Alarm, ...]
    """Alarms active at the end."""
    log: list[tuple[float, str]]
    """Log of events: time, s, and description."""
    drawing: Drawing
    """Strokes of pen and laser."""
    _way: bytes = b""

    @property
    def way(self) -> list[tuple[float, ...]]:
        """Sampled path of the tool, x, y, z, mm, if ``watch`` was given."""
        return to_tuples(self._way, 3)

    def way_to_numpy(self) -> Floats:
        """Returns the sampled path as an array of shape (n, 3), mm. Needs NumPy."""
        return to_numpy(self._way, 3)

    def __repr__(self) -> str:
        x, y, z, r = self.position
        ended = "done" if self.ok else "stopped by an alarm"
        at = f"x {x:.1f}, y {y:.1f}, z {z:.1f}, r {r:.1f}"
        return f"<Rehearsal: {self.steps} steps, {ended} after {self.seconds:.1f} s at {at}>"

    def _repr_svg_(self) -> str:
        return self.drawing.svg


class Plan:
    """An immutable sequence of steps for an arm. Methods that change a plan return a new one. Notebooks display its
    picture.

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
        """Native object, for use by this package."""
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
        """Creates a plan from commands of :mod:`magician.words`.

        :raises InvalidInputError: A command cannot be queued, or a move keeps an r that no move before it has.
        """
        return cls(
            _magician.Plan.of_commands(string("title", title), fill_r(commands, None), _tool(tool), _surface(surface))
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
        """Creates a plan through points. An array is converted without a loop in Python.

        :param points: Shape (n, 3): x, y, z in mm; or (n, 4): with r in degrees. ``float64`` goes in as it is. A row of
            only NaN lifts the tool: it separates two paths.
        :param by: ``"path"`` for continuous paths, which do not stop at their corners and keep r; ``"line"``,
            ``"joints"`` or ``"jump"`` for a move to each point.
        :param title: Title of the plan.
        :param tool: Tool of the plan; the arm's current tool if left out.
        :param surface: Work surface, if known: the z at which the tool touches it, mm.
        :param r: Rotation for points without one, degrees.
        :param lift: Height above its ends at which a path is approached and left, mm; 0 moves there directly with joint
            interpolation.
        :param speed: Speed along a path, mm/s; the arm's setting if ``None``.
        :param acceleration: Acceleration along a path, mm/s².
        :param power: Laser power along a path, percent: one value, or one for each point, shape (n,).
        :raises InvalidInputError: A number is NaN, the shape is wrong, or r changes on a path.
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
        """Parses the text of a plan file.

        :raises InvalidInputError: It is not a plan file; the message gives line, column, and the expected content.
        """
        return cls(_magician.Plan.of_json(string("json", json)))

    # Inspection.

    @property
    def title(self) -> str:
        """Title of the plan."""
        return self.native.title

    @property
    def source(self) -> str | None:
        """Source file of the plan, if it was loaded."""
        return self.native.source

    @property
    def format(self) -> str | None:
        """Format of the source file: ``"svg"``, ``"gcode"``."""
        return self.native.format

    @property
    def notes(self) -> list[Note]:
        """Notes on parts of the file that were left out or interpreted."""
        return [
            Note(message, line or None, column or None, name, help, code)
            for line, column, name, message, help, code in self.native.notes
        ]

    @property
    def placed(self) -> Placed | None:
        """Placement of the file before the arm, if it was placed."""
        found = self.native.placed
        if found is None:
            return None
        scale, turn, (x, y), corners = found
        page = None if corners is None else tuple((x, y) for x, y in corners)
        return Placed(scale, turn, (x, y), page)

    @property
    def tool(self) -> str | None:
        """Tool of the plan: a name, or its bias ``"x,y,z"`` in mm. It is set on the arm first."""
        return self.native.tool

    @property
    def surface(self) -> Surface | None:
        """Work surface of the plan."""
        found = self.native.surface
        return None if found is None else Surface(found[0], (found[1][0], found[1][1]))

    @property
    def surface_is_assumed(self) -> bool:
        """True if the height of the work surface is unknown. The table of a virtual arm is then assumed, and a real arm
        refuses the plan."""
        return self.native.assumed

    @property
    def steps(self) -> Steps:
        """Steps of the plan."""
        return Steps(self.native)

    def commands(self) -> list[Queueable]:
        """Returns all commands sent to an arm, the tool's first."""
        return self.native.commands()

    def targets(self) -> list[tuple[float, ...]]:
        """Returns the target of each step: x, y, z in mm, NaN for steps without a target."""
        return to_tuples(self.native.targets(), 3)

    def to_numpy(self) -> Floats:
        """Returns :meth:`targets` as an array of shape (n, 3), mm. Needs NumPy."""
        return to_numpy(self.native.targets(), 3)

    def check(self) -> Report:
        """Checks the plan for a homed arm with its settings from power-up. Reports steps out of reach, the duration,
        and the length of the tool's path. ``arm.check(plan)`` starts at that arm's current pose."""
        if self._report is None:
            self._report = report(self.native.check(None))
        return self._report

    @property
    def estimate(self) -> float | None:
        """Duration from :meth:`check`, s; ``None`` if the end of a step is unknown."""
        return self.check().seconds

    def preview(
        self, path: str | os.PathLike[str] | None = None, *, side: bool | None = None, sheet: Sheet | None = None
    ) -> Picture:
        """Draws a picture of everything that will be drawn, burnt or carried, in true size.

        :param path: Path of a ``.svg`` or ``.png`` file to write.
        :param side: Whether to include a side view; if left out, only for plans that pick and place.
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
        """Runs the plan on a private virtual arm, as fast as possible, byte for byte as on a real arm.

        :param tool: Tool on the arm; defaults to the plan's tool, or else to the one that its steps need.
        :param table: z at which the tool touches the table, mm; defaults to the plan's surface, if any.
        :param watch: Sampling interval of the tool position, s; see :attr:`Rehearsal.way`.
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
        """Returns the plan shifted by these distances, mm.

        :raises InvalidInputError: A step cannot be shifted: its target is joint angles, or it begins at an unknown
            pose.
        """
        return Plan(self.native.moved((number("x", x), number("y", y), number("z", z))))

    def scaled(self, factor: float, about: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Plan:
        """Returns the plan scaled about the fixed point ``about`` (mm). Jump heights are scaled; speeds and rotations
        are not.

        :raises InvalidInputError: As :meth:`moved`; a factor that is not above 0.
        """
        return Plan(self.native.scaled(number("factor", factor, above=0), _three("about", about)))

    def rotated(self, degrees: float, about: tuple[float, float] = (0.0, 0.0)) -> Plan:
        """Returns the plan rotated counter-clockwise, seen from above, about the vertical through ``about`` (mm). The
        rotation r of poses changes accordingly.

        :raises InvalidInputError: As :meth:`moved`.
        """
        return Plan(self.native.rotated(number("degrees", degrees, unit="deg"), _two("about", about)))

    def repeated(self, times: int) -> Plan:
        """Returns the plan with its steps repeated ``times`` times. ``plan * 3`` is the same."""
        return Plan(self.native.repeated(whole("times", times, 0, _MOST)))

    def on_grid(self, rows: int, columns: int, pitch: tuple[float, float]) -> Plan:
        """Repeats the plan at each position of a grid. The plan itself is for the first position.

        :param rows: Number of rows, along Y.
        :param columns: Number of columns, along X.
        :param pitch: Distances between columns in x and between rows in y, mm.
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
        """Repeats the plan at each position of a pallet given by three positions (x, y, z; mm): the first, the last of
        its row, and the first of the last row. The pallet may be tilted."""
        return Plan(
            self.native.on_corners(
                _count("rows", rows),
                _count("columns", columns),
                [_three("first", first), _three("end_of_row", end_of_row), _three("last_row", last_row)],
            )
        )

    def from_step(self, step: int) -> Plan:
        """Returns the plan from a step on, counted from 1. It first applies the settings of earlier steps, and
        approaches the start of the step from above. It is for a homed arm; ``arm.run(plan, first_step=...)`` starts
        from that arm's current pose.

        :raises InvalidInputError: There is no such step, or its start pose is unknown.
        """
        return Plan(self.native.starting_at(whole("step", step, 1, max(1, len(self))), None))

    def __add__(self, other: Plan) -> Plan:
        """Appends the steps of another plan."""
        if not isinstance(other, Plan):  # pyright: ignore[reportUnnecessaryIsInstance]
            return NotImplemented
        return Plan(self.native.joined(other.native))

    def __mul__(self, times: int) -> Plan:
        return self.repeated(times)

    __rmul__ = __mul__

    # Files.

    def to_json(self) -> str:
        """Returns the text of a plan file: JSON with one step per line."""
        return self.native.to_json()

    def to_playback(self) -> tuple[str, list[str]]:
        """Returns the text of a file for DobotStudio's Teaching & Playback, and notes on content that such a file
        cannot express.

        :raises InvalidInputError: A step cannot be expressed in such a file.
        """
        return self.native.to_playback()

    def save(self, path: str | os.PathLike[str]) -> list[str]:
        """Writes the plan to a ``.plan.json`` (``.json``, ``.plan``) or, for DobotStudio, ``.playback`` file.
        :func:`load` reads both.

        :returns: Notes on content that the file cannot express; empty for a plan file.
        :raises InvalidInputError: The extension is unknown, or a step cannot be expressed in such a file.
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
        """Pauses for the operator: step numbers, with their messages."""
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
    """Loads a plan from a file: a taught program (``.playback``), G-code, a drawing (SVG, HPGL, DXF), a Blockly
    program, an image, points (CSV, JSON, text), or a plan file. Drawings use the pen, images are engraved.

    :param file: Path, or an open binary file.
    :param format: Format, if neither name nor content identifies it: ``playback``, ``svg``, ``gcode``, ``image``,
        ``dxf``, ``hpgl``, ``blockly``, ``points``, ``text``, ``testgrid``, ``plan``.
    :param title: Title of the plan; the file name if left out.
    :param sheet: Sheet on which drawings are placed, corner to corner. Without it they are placed where there is room.
    :param preset: Preset of ``magician preset``, which supplies options that are left out.
    :param options: Drawing or engraving method, position and size: see :class:`SetupOptions`. Drawings and images need
        a ``surface``; without it they are placed on the table of a virtual arm (-60 mm), and a real arm refuses them.
    :returns: The plan. :attr:`Plan.notes` lists the parts that were left out or interpreted.
    :raises InvalidInputError: The file cannot be read (with line and column) or placed, or an option is invalid.
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
    """Creates a plan that writes text with the pen, as ``magician write`` does.

    :param words: Text of one or more lines.
    :param title: Title of the plan; the beginning of the text if left out.
    :param sheet: As for :func:`load`.
    :param preset: As for :func:`load`.
    :param options: Font, layout and position: ``font``, ``size``, ``wrap``, ``align``, ``surface``, ``at``, ``speed``
        and the others of :class:`SetupOptions`.
    :returns: The plan.
    :raises InvalidInputError: The text is empty, the font cannot be read, or an option is invalid.
    :raises OSError: The font file cannot be opened.
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
    """Creates a plan that traces the outline of a job, as ``magician frame`` does: with the laser off at the height of
    the work, with any other tool ``lift`` above it. Each run traces the outline once.

    :param file: Path, or an open binary file.
    :param shape: ``"box"`` along the arm's X and Y; ``"hull"``, a rubber band round all lines; ``"outline"``, the outer
        contours, where lines less than 4 mm apart count as one shape. If the box or the outline leaves the reach, the
        hull is used, with a note in :attr:`Plan.notes`.
    :param format: As for :func:`load`.
    :param title: As for :func:`load`.
    :param sheet: As for :func:`load`.
    :param preset: As for :func:`load`.
    :param options: Options that :func:`load` would get for the plan; ``tool`` and ``work`` select drawing or burning.
        With ``frame_power`` the laser is lit along the outline, and the run requires ``allow_laser=True``.
    :returns: The plan.
    :raises InvalidInputError: The file draws or burns nothing, or as for :func:`load`.
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
    """Creates a plan that burns squares at many powers and speeds, to test a material, as ``magician testgrid`` does.

    :param power: Powers of the columns, percent: first, last, count.
    :param speed: Speeds of the rows, mm/s: first, last, count.
    :param cell: Side of a square, mm; the gap is a quarter of it.
    :param spacing: Distance between the lines of a square, mm.
    :param labels: Whether columns and rows are labelled, with the weakest power at the highest speed.
    :param options: Placement: ``surface``, ``at``, ``rotate``, ``fit`` and the others of :func:`load`.
    :returns: The plan.
    :raises InvalidInputError: A value is out of range.
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


# The name begins with `test`, so pytest would collect it in every module that imports it.
vars(testgrid)["__test__"] = False


_FONTS = ("sans", "script", "gothic")
_FONTS_OR_FILE = "sans, script, gothic or the path of a file"


def _font(given: dict[str, Any]) -> tuple[str, bytes] | None:
    """Takes a font file out of the options: returns its name and bytes."""
    font = given.get("font")
    if not isinstance(font, (str, os.PathLike)) or font in _FONTS:
        return None
    path = Path(given.pop("font"))
    try:
        return path.name, path.read_bytes()
    except OSError as error:
        raise OSError(error.errno, f"font takes {_FONTS_OR_FILE}: {error.strerror}", str(path)) from None


def _pens(given: dict[str, Any]) -> str | None:
    """Takes a pens file out of the options: returns its text."""
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
