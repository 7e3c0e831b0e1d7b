"""The sheet, the height of a surface and the tip of a tool, from points that were touched.

What ``magician calibrate`` does at a terminal, as functions of points: touch with the tool, by hand or with moves, take
``arm.pose()`` or the points of :meth:`magician.Arm.teach`, and give them to :func:`sheet`, :func:`surface` or
:func:`tip`. :func:`save` keeps the result where the command finds it, and :func:`saved` reads it back.

Lengths are mm, angles degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from . import _magician, words
from ._arguments import number
from ._scenarios import tool_bias
from ._targets import Target, spot
from ._values import Value
from .errors import InvalidInputError
from .places import Frame, Point
from .programs import Sheet, Surface

__all__ = ["Saved", "Tip", "TouchedSheet", "save", "saved", "sheet", "surface", "tip"]

_Triple = tuple[float, float, float]


class TouchedSheet(Value):
    """A sheet whose corners were touched: ``magician.load("house.svg", sheet=found.sheet, surface=found.surface)`` lays
    a drawing on it, corner on corner."""

    sheet: Sheet
    """Where it lies, how it is turned, and its size."""
    surface: Surface
    """Its height, and how it is tilted."""
    corners: tuple[_Triple, _Triple, _Triple]
    """The points: lower left, lower right, upper left."""

    @property
    def tilt(self) -> float:
        """How steep it is, degrees."""
        return math.degrees(math.atan(math.hypot(*self.surface.slope)))

    @property
    def frame(self) -> Frame:
        """Its plane: ``arm.move_to(found.frame(30, 20, 5))`` is 5 mm above the point that lies 30 mm to the right and
        20 mm up from its lower left corner."""
        return Frame.from_points(*self.corners)

    def __str__(self) -> str:
        width, height = self.sheet.size or (0.0, 0.0)
        x, y = self.sheet.corner
        return (
            f"{width:.1f} by {height:.1f} mm, lower left at x {x:.1f} y {y:.1f} z {self.corners[0][2]:.2f}, "
            f"turned by {self.sheet.rotation:.1f} deg, tilted by {self.tilt:.2f} deg"
        )


class Tip(Value):
    """Where the tip of a tool is: ``arm.tool(x=.., y=.., z=..)`` and ``magician.load(.., tool=found.bias)`` take its
    bias."""

    offset: tuple[float, float]
    """How far the tip is from where the tool's bias before had it, when the tool points ahead (J4 = 0): ahead and to
    the left, mm. It turns with the tool."""
    bias: _Triple
    """The bias to set: x, y, z from the wrist, mm."""
    touches: tuple[_Triple, _Triple]
    """Both touches: x, y and r."""
    tool: _Triple
    """The bias that was in force while it was touched, mm."""

    def __str__(self) -> str:
        ahead, left = self.offset
        x, y, z = self.bias
        return f"{ahead:.2f} mm ahead and {left:.2f} mm to the left: bias {x:.3f}, {y:.3f}, {z:.3f} mm"


class Saved(Value):
    """What the settings file says."""

    sheet: Sheet | None
    """The sheet that drawings lie on."""
    surface: Surface | None
    """The surface of that sheet, else the level one that was kept."""
    tool: str | None
    """The tool: a name, or its bias ``"x,y,z"`` in mm."""


def sheet(corners: Sequence[Target | Point]) -> TouchedSheet:
    """The sheet whose corners were touched with the tip of the tool.

    >>> found = magician.calibrate.sheet([(180, -60, -61), (300, -60, -61), (180, 30, -61)])
    >>> print(found)
    120.0 by 90.0 mm, lower left at x 180.0 y -60.0 z -61.00, turned by 0.0 deg, tilted by 0.00 deg

    :param corners: Lower left, lower right and upper left, as seen with the arm's X to the right: poses, points that
        were taught, or x, y, z.
    :raises InvalidInputError: There are not three; two are nearer than 30 mm, they make no right angle (more than 5
        degrees off), or the surface is steeper than 15 degrees. The message says what to touch again.
    """
    a, b, c = (_three(each) for each in _counted("corners", corners, 3))
    corner, rotation, height, slope, size = _magician.touched_sheet((a, b, c))
    return TouchedSheet(Sheet(corner, rotation, size), Surface(height, slope), (a, b, c))


def surface(touch: Target | Point) -> Surface:
    """The level surface that was touched with the tip of the tool: paper, wood, a table.

    >>> magician.calibrate.surface((220, 0, -61.5))
    Surface(height=-61.5, slope=(0.0, 0.0))

    :param touch: Where it was touched: a pose, a point that was taught, or x, y, z.
    """
    return Surface(_three(touch)[2])


def tip(touches: Sequence[Target | Point], *, tool: words.Tool | Sequence[float]) -> Tip:
    """The tip of a tool that touched one point twice, turned in between: half a turn tells most.

    >>> found = magician.calibrate.tip([(220, 3, 0, 0), (226, 3, 0, 180)], tool="pen")
    >>> found.offset
    (3.0, 0.0)

    :param touches: Both poses, points that were taught, or x, y, z, r; z does not count.
    :param tool: The tool whose tip the poses are of: its name, or its bias (x, y, z) in mm.
    :raises InvalidInputError: There are not two; the tool was turned by less than 30 degrees, or its tip would be more
        than 200 mm off.
    """
    one, other = (_turn(each) for each in _counted("touches", touches, 2))
    bias = tool_bias(tool)
    assert bias is not None
    offset, found = _magician.touched_tip((one, other), bias)
    return Tip(offset, found, (one, other), bias)


def save(found: TouchedSheet | Surface | Tip) -> str | None:
    """Keeps it in the settings file, as ``magician calibrate`` does: ``magician draw``, ``engrave`` and ``run`` use it
    from then on. The rest of the file stays as it is.

    :returns: The file.
    :raises InvalidInputError: It cannot be kept: a surface that is tilted belongs to a sheet; or the file cannot be
        edited.
    """
    if isinstance(found, TouchedSheet):
        return _magician.keep_sheet(found.corners)
    if isinstance(found, Tip):
        return _magician.keep_tip(found.touches, found.tool)
    if any(found.slope):
        raise InvalidInputError("the surface is tilted: it is kept with its sheet, from three points")
    height: float = number("height", found.height, unit="mm")
    return _magician.keep_surface(height)


def saved() -> Saved:
    """What was kept by :func:`save` or by ``magician calibrate``.

    :raises InvalidInputError: The settings file has a mistake.
    """
    sheet, surface, tool = _magician.kept_settings()
    if sheet is None:
        return Saved(None, None if surface is None else Surface(*surface), tool)
    corner, rotation, height, slope, size = sheet
    return Saved(Sheet(corner, rotation, size), Surface(height, slope), tool)


def _counted(name: str, points: Sequence[Target | Point], count: int) -> Sequence[Target | Point]:
    if len(points) != count:
        raise InvalidInputError(f"{name} are {len(points)} points; it takes {count}")
    return points


def _spot(point: Target | Point) -> tuple[float, float, float, float | None]:
    return spot(point.position if isinstance(point, Point) else point, None, None, None)


def _three(point: Target | Point) -> _Triple:
    x, y, z, _ = _spot(point)
    return x, y, z


def _turn(point: Target | Point) -> _Triple:
    x, y, _, r = _spot(point)
    if r is None:
        raise InvalidInputError(f"the touch {point!r} does not say how the tool was turned: it takes a pose")
    return x, y, r
