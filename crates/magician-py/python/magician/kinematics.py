"""Poses of joint angles, joint angles of poses, and what the arm can reach: one at a time, or whole arrays.

No arm is needed. The figures are those of the driver, the check and the virtual arm: the arm's geometry (model
section 2) and the controller's limits of its joints.

>>> from magician import forward, inverse, is_reachable
>>> forward(0, 0, 0, 0)
Position(x=147.0, y=0.0, z=135.0, r=0.0)
>>> is_reachable(400, 0, 0)
False

An array in place of the numbers has one row for each pose, mm and degrees; the result is a NumPy array of as many rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from . import _magician
from ._arguments import number, numbers
from ._meaning import Joints, Position
from ._points import Floats, Points, rows, to_list, to_numpy
from .commands import Pose
from .errors import InvalidInputError
from .words import Tool, bias_of

if TYPE_CHECKING:
    from numpy import bool_
    from numpy.typing import NDArray

    Mask = NDArray[bool_]
else:
    # So that type hints can be evaluated without NumPy.
    Mask = Any

__all__ = ["AnyTool", "JointArray", "PoseArray", "Ring", "forward", "inverse", "is_reachable", "reach"]

AnyTool = Tool | Sequence[float]
"""A tool: its name, or its bias, x, y, z in mm from the wrist."""

Ring = list[tuple[float, float]]
"""Corners of a closed polygon, x and y in mm."""


class PoseArray(NamedTuple):
    """Poses of many joint angles."""

    poses: Floats
    """Rows of x, y, z (mm) and r (degrees); NaN where an angle is not finite."""
    reachable: Mask
    """Which rows of the joint angles are within the limits of the joints."""


class JointArray(NamedTuple):
    """Joint angles of many poses."""

    joints: Floats
    """Rows of j1 to j4, degrees; NaN where the arm cannot be."""
    reachable: Mask
    """Which of the poses the arm can reach."""


@overload
def forward(j1: float, j2: float, j3: float, j4: float = 0.0, /, *, tool: AnyTool = "none") -> Position: ...
@overload
def forward(joints: Joints, /, *, tool: AnyTool = "none") -> Position: ...
@overload
def forward(joints: Points, /, *, tool: AnyTool = "none") -> PoseArray: ...
def forward(*joints: Any, tool: AnyTool = "none") -> Position | PoseArray:
    """The pose of the tool's tip at joint angles, degrees (model section 2).

    ``forward(0, 45, 45, 0)`` and ``forward(arm.joints())`` return a :class:`Position`; ``forward(array)`` of shape
    (n, 4) returns :class:`PoseArray`. Angles beyond the limits of the joints have a pose too.

    :param tool: whose tip: ``"none"``, ``"suction"``, ``"gripper"``, ``"pen"``, ``"laser"``, or its bias x, y, z in mm.
    """
    bias = bias_of(tool)
    one = _one("joints", joints)
    if one is not None:
        return Position(*to_list(_magician.forward(rows([(*one, 0.0)[:4]])[0], bias)[0]))
    data, columns = rows(joints[0])
    if columns != 4:
        raise InvalidInputError(
            f"joint angles have the shape (n, 4), j1 to j4 in degrees; these have {columns} columns"
        )
    poses, reachable = _magician.forward(data, bias)
    return PoseArray(to_numpy(poses, 4), _mask(reachable))


@overload
def inverse(x: float, y: float, z: float, r: float = 0.0, /, *, tool: AnyTool = "none") -> Joints: ...
@overload
def inverse(  # type: ignore[overload-overlap]  # pyright: ignore[reportOverlappingOverload]  # A pose is an array too.
    pose: Position | Pose, /, *, tool: AnyTool = "none"
) -> Joints: ...
@overload
def inverse(poses: Points, /, *, r: float = 0.0, tool: AnyTool = "none") -> JointArray: ...
def inverse(*pose: Any, r: float = 0.0, tool: AnyTool = "none") -> Joints | JointArray:
    """The joint angles that bring the tool's tip to a pose, within the limits of the joints (model section 2).

    ``inverse(200, 0, 50, 0)`` returns :class:`Joints`; ``inverse(array)`` of shape (n, 3) or (n, 4) returns
    :class:`JointArray`, in which rows that cannot be reached are NaN and marked.

    :param r: the rotation of the tool, degrees, of rows without one.
    :param tool: as for :func:`forward`.

    Raises :class:`~magician.errors.UnreachableError` for a single pose that the arm cannot reach, with the limit in the
    way and both values.
    """
    bias = bias_of(tool)
    one = _one("pose", pose)
    if one is not None:
        x, y, z, turn = (*one, number("r", r))[:4]
        return Joints(*_magician.inverse_of((x, y, z, turn), bias))
    data, columns = rows(pose[0])
    joints, reachable = _magician.inverse(data, columns, number("r", r), bias)
    return JointArray(to_numpy(joints, 4), _mask(reachable))


@overload
def is_reachable(x: float, y: float, z: float, r: float = 0.0, /, *, tool: AnyTool = "none") -> bool: ...
@overload
def is_reachable(  # type: ignore[overload-overlap]  # pyright: ignore[reportOverlappingOverload]
    pose: Position | Pose, /, *, tool: AnyTool = "none"
) -> bool: ...
@overload
def is_reachable(poses: Points, /, *, r: float = 0.0, tool: AnyTool = "none") -> Mask: ...
def is_reachable(*pose: Any, r: float = 0.0, tool: AnyTool = "none") -> bool | Mask:
    """True if the tool's tip can be at a pose; of an array, for each of its rows. Arguments as for :func:`inverse`."""
    bias = bias_of(tool)
    one = _one("pose", pose)
    data, columns = rows(pose[0] if one is None else [one])
    reachable = _magician.inverse(data, columns, number("r", r), bias)[1]
    return _mask(reachable) if one is None else reachable == b"\x01"


def reach(z: float, *, r: float = 0.0, tool: AnyTool = "none") -> list[Ring]:
    """The edges of what the tool's tip can reach at a height: closed polygons, in the arm's x and y, mm.

    The list is empty where nothing is within reach.

    :param z: the height, mm.
    :param r: the rotation of the tool, degrees.
    :param tool: as for :func:`forward`.
    """
    rings = _magician.reach(number("z", z), number("r", r), bias_of(tool))
    return [list(zip(*[iter(to_list(ring))] * 2, strict=True)) for ring in rings]


def _one(name: str, values: tuple[Any, ...]) -> tuple[float, ...] | None:
    """The numbers of one pose; none for an array of them."""
    if len(values) == 1:
        only = values[0]
        if name == "pose" and isinstance(only, Pose):
            only = only.position
        if not isinstance(only, (Position, Joints)):
            return None
        values = only
    if len(values) not in (3, 4):
        raise TypeError(f"{name}: 3 or 4 numbers, or one array of rows, not {len(values)} values")
    return numbers(name, values, len(values))


def _mask(data: bytes) -> Mask:
    import numpy

    return numpy.frombuffer(bytearray(data), dtype=numpy.bool_)
