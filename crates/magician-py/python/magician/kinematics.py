"""Forward kinematics, inverse kinematics and reach, for single poses or whole arrays.

No arm is needed. The driver, the check of programs and the virtual arm use the same constants: the
arm's geometry (model section 2) and the controller's joint limits.

>>> from magician import forward, inverse, is_reachable
>>> forward(0, 0, 0, 0)
Position(x=147.0, y=0.0, z=135.0, r=0.0)
>>> is_reachable(400, 0, 0)
False

:func:`forward`, :func:`inverse` and :func:`is_reachable` also take an array with one row per pose
(mm and degrees), and return NumPy arrays with as many rows.
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
    # Lets type hints be evaluated without NumPy.
    Mask = Any

__all__ = ["AnyTool", "JointArray", "PoseArray", "Ring", "forward", "inverse", "is_reachable", "reach"]

AnyTool = Tool | Sequence[float]
"""Name of a tool, or its bias: x, y, z in mm from the wrist."""

Ring = list[tuple[float, float]]
"""Vertices of a closed polygon, x and y in mm."""


class PoseArray(NamedTuple):
    """Poses computed from an array of joint angles."""

    poses: Floats
    """Rows of x, y, z (mm) and r (degrees); NaN where an angle is not finite."""
    reachable: Mask
    """Mask of rows whose joint angles are within the joint limits."""


class JointArray(NamedTuple):
    """Joint angles computed from an array of poses."""

    joints: Floats
    """Rows of j1 to j4, degrees; NaN for unreachable poses."""
    reachable: Mask
    """Mask of reachable poses."""


@overload
def forward(j1: float, j2: float, j3: float, j4: float = 0.0, /, *, tool: AnyTool = "none") -> Position: ...
@overload
def forward(joints: Joints, /, *, tool: AnyTool = "none") -> Position: ...
@overload
def forward(joints: Points, /, *, tool: AnyTool = "none") -> PoseArray: ...
def forward(*joints: Any, tool: AnyTool = "none") -> Position | PoseArray:
    """Computes the pose of the tool tip from joint angles, degrees (model section 2).

    ``forward(0, 45, 45, 0)`` and ``forward(arm.joints())`` return a :class:`Position`; ``forward(array)`` of shape
    (n, 4) returns :class:`PoseArray`. Angles beyond the joint limits are accepted.

    :param tool: the tool: ``"none"``, ``"suction"``, ``"gripper"``, ``"pen"``, ``"laser"``, or its bias x, y, z in mm.
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
    """Computes the joint angles for a pose of the tool tip, within the joint limits (model section 2).

    ``inverse(200, 0, 50, 0)`` returns :class:`Joints`; ``inverse(array)`` of shape (n, 3) or (n, 4) returns
    :class:`JointArray`, in which unreachable rows are NaN and masked.

    :param r: the rotation of the tool, degrees, for rows without one.
    :param tool: as for :func:`forward`.

    Raises :class:`~magician.errors.UnreachableError` for a single unreachable pose, with the value and the limit.
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
    """True if the tool tip can reach a pose; for an array, one value per row. Arguments as for :func:`inverse`."""
    bias = bias_of(tool)
    one = _one("pose", pose)
    data, columns = rows(pose[0] if one is None else [one])
    reachable = _magician.inverse(data, columns, number("r", r), bias)[1]
    return _mask(reachable) if one is None else reachable == b"\x01"


def reach(z: float, *, r: float = 0.0, tool: AnyTool = "none") -> list[Ring]:
    """Computes the boundary of the reach of the tool tip at a height: closed polygons, in the arm's x and y, mm.

    The list is empty if nothing is within reach.

    :param z: the height, mm.
    :param r: the rotation of the tool, degrees.
    :param tool: as for :func:`forward`.
    """
    rings = _magician.reach(number("z", z), number("r", r), bias_of(tool))
    return [list(zip(*[iter(to_list(ring))] * 2, strict=True)) for ring in rings]


def _one(name: str, values: tuple[Any, ...]) -> tuple[float, ...] | None:
    """Returns the numbers of one pose, or ``None`` for an array."""
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
