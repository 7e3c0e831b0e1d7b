"""Calibration of the sheet, the surface height and the tool tip from touched points.

These functions do the work of ``magician calibrate``. Touch points with the tool, by hand or with moves, and pass
``arm.pose()`` or the points of :meth:`magician.Arm.teach` to :func:`sheet`, :func:`surface` or :func:`tip`.
:func:`save` stores the result in the settings file of the command line, and :func:`saved` reads it back.

Lengths are mm, angles degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from . import _magician, words
from ._arguments import number
from ._scenarios import tool_bias
from ._targets import Target, position_of
from ._values import Value
from .errors import InvalidInputError
from .places import Frame, Point
from .programs import Sheet, Surface

__all__ = ["Saved", "Tip", "TouchedSheet", "save", "saved", "sheet", "surface", "tip"]

_Triple = tuple[float, float, float]


class TouchedSheet(Value):
    """A sheet calibrated by its corners: ``magician.load("house.svg", sheet=found.sheet, surface=found.surface)``
    places a drawing on it, corner on corner."""

    sheet: Sheet
    """Position, rotation and size of the sheet."""
    surface: Surface
    """Height and tilt of the surface."""
    corners: tuple[_Triple, _Triple, _Triple]
    """Touched points: lower left, lower right, upper left."""

    @property
    def tilt(self) -> float:
        """Tilt of the surface, degrees."""
        return math.degrees(math.atan(math.hypot(*self.surface.slope)))

    @property
    def frame(self) -> Frame:
        """Frame of the sheet: ``arm.move_to(found.frame(30, 20, 5))`` moves to 5 mm above the point 30 mm to the right
        and 20 mm up from its lower left corner."""
        return Frame.from_points(*self.corners)

    def __str__(self) -> str:
        width, height = self.sheet.size or (0.0, 0.0)
        x, y = self.sheet.corner
        return (
            f"{width:.1f} by {height:.1f} mm, lower left at x {x:.1f} y {y:.1f} z {self.corners[0][2]:.2f}, "
            f"turned by {self.sheet.rotation:.1f} deg, tilted by {self.tilt:.2f} deg"
        )


class Tip(Value):
    """A calibrated tool tip. Pass its bias to ``arm.tool(x=.., y=.., z=..)`` or ``magician.load(..,
    tool=found.bias)``."""

    offset: tuple[float, float]
    """Offset of the tip from the previous bias with the tool pointing ahead (J4 = 0): forward and left, mm. It turns
    with the tool."""
    bias: _Triple
    """New bias: x, y, z from the wrist, mm."""
    touches: tuple[_Triple, _Triple]
    """Both touches: x, y, mm, and r, degrees."""
    tool: _Triple
    """Bias in effect during the touches, mm."""

    def __str__(self) -> str:
        ahead, left = self.offset
        x, y, z = self.bias
        return f"{ahead:.2f} mm ahead and {left:.2f} mm to the left: bias {x:.3f}, {y:.3f}, {z:.3f} mm"


class Saved(Value):
    """Calibration stored in the settings file."""

    sheet: Sheet | None
    """Sheet on which drawings are placed."""
    surface: Surface | None
    """Surface of the sheet, or else the stored level surface."""
    tool: str | None
    """Tool: a name, or its bias ``"x,y,z"`` in mm."""


def sheet(corners: Sequence[Target | Point]) -> TouchedSheet:
    """Computes the sheet from corners touched with the tool tip.

    >>> found = magician.calibrate.sheet([(180, -60, -61), (300, -60, -61), (180, 30, -61)])
    >>> print(found)
    120.0 by 90.0 mm, lower left at x 180.0 y -60.0 z -61.00, turned by 0.0 deg, tilted by 0.00 deg

    :param corners: Lower left, lower right and upper left, as seen with the arm's X to the right: poses, taught points,
        or x, y, z.
    :raises InvalidInputError: There are not three corners, two are closer than 30 mm, the angle deviates from 90
        degrees by more than 5, or the surface is tilted by more than 15 degrees. The message names the corner to touch
        again.
    """
    a, b, c = (_three(each) for each in _checked_touches("corners", corners, 3))
    corner, rotation, height, slope, size = _magician.sheet_from_touches((a, b, c))
    return TouchedSheet(Sheet(corner, rotation, size), Surface(height, slope), (a, b, c))


def surface(touch: Target | Point) -> Surface:
    """Computes the level surface (paper, wood, a table) from a point touched with the tool tip.

    >>> magician.calibrate.surface((220, 0, -61.5))
    Surface(height=-61.5, slope=(0.0, 0.0))

    :param touch: Touched point: a pose, a taught point, or x, y, z.
    """
    return Surface(_three(touch)[2])


def tip(touches: Sequence[Target | Point], *, tool: words.Tool | Sequence[float]) -> Tip:
    """Computes the tool tip from two touches of one point with a rotation in between; half a turn is most accurate.

    >>> found = magician.calibrate.tip([(220, 3, 0, 0), (226, 3, 0, 180)], tool="pen")
    >>> found.offset
    (3.0, 0.0)

    :param touches: Two poses, taught points, or x, y, z, r; z is ignored.
    :param tool: Tool in effect for the poses: its name, or its bias (x, y, z) in mm.
    :raises InvalidInputError: There are not two touches, the rotation is below 30 degrees, or the tip would be offset
        by more than 200 mm.
    """
    one, other = (_turn(each) for each in _checked_touches("touches", touches, 2))
    bias = tool_bias(tool)
    assert bias is not None
    offset, found = _magician.tip_from_touches((one, other), bias)
    return Tip(offset, found, (one, other), bias)


def save(found: TouchedSheet | Surface | Tip) -> str | None:
    """Saves a calibration in the settings file, as ``magician calibrate`` does. ``magician draw``, ``engrave`` and
    ``run`` use it from then on. The rest of the file is unchanged.

    :returns: Path of the settings file.
    :raises InvalidInputError: A tilted surface cannot be stored without a sheet, or the file cannot be edited.
    """
    if isinstance(found, TouchedSheet):
        return _magician.save_sheet(found.corners)
    if isinstance(found, Tip):
        return _magician.save_tip(found.touches, found.tool)
    if any(found.slope):
        raise InvalidInputError("the surface is tilted: it is kept with its sheet, from three points")
    height: float = number("height", found.height, unit="mm")
    return _magician.save_surface(height)


def saved() -> Saved:
    """Reads the calibration stored by :func:`save` or ``magician calibrate``.

    :raises InvalidInputError: The settings file is invalid.
    """
    sheet, surface, tool = _magician.stored_settings()
    if sheet is None:
        return Saved(None, None if surface is None else Surface(*surface), tool)
    corner, rotation, height, slope, size = sheet
    return Saved(Sheet(corner, rotation, size), Surface(height, slope), tool)


def _checked_touches(name: str, points: Sequence[Target | Point], count: int) -> Sequence[Target | Point]:
    if len(points) != count:
        raise InvalidInputError(f"{name} are {len(points)} points; it takes {count}")
    return points


def _spot(point: Target | Point) -> tuple[float, float, float, float | None]:
    return position_of(point.position if isinstance(point, Point) else point, None, None, None)


def _three(point: Target | Point) -> _Triple:
    x, y, z, _ = _spot(point)
    return x, y, z


def _turn(point: Target | Point) -> _Triple:
    x, y, _, r = _spot(point)
    if r is None:
        raise InvalidInputError(f"the touch {point!r} does not say how the tool was turned: it takes a pose")
    return x, y, r
