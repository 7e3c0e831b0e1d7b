"""Stepped virtual arms for reinforcement learning, planning and tests.

A :class:`VirtualArm` is controlled through a driver, like a real arm. A :class:`Simulation` has the same arm, world and
motions without driver, thread and wall clock: each step sets a target and advances the clock. :class:`Simulations`
steps many of them in parallel, on all cores.

A step sends the frames of a real host, and each target passes the check of ``arm.run``. Results are deterministic, bit
for bit, for any number of threads. Lengths are mm, angles degrees, times seconds.

>>> arm = Simulation()
>>> arm.step((220, 60, 20, 0)).pose
Position(x=220.0, y=60.0, z=20.0, r=0.0)
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from . import _magician, words
from ._arguments import instance, number, whole
from ._meaning import Joints, Position
from ._points import Floats, SupportsArray, to_list, to_numpy
from ._points import table as _table
from ._scenarios import scenario_text, tool_bias
from .errors import InvalidInputError
from .virtual import Place, Snapshot

if TYPE_CHECKING:
    from numpy import bool_, uint8
    from numpy.typing import NDArray

    Image = NDArray[uint8]
    Mask = NDArray[bool_]
else:
    # Lets type hints be evaluated without NumPy.
    Image = Any
    Mask = Any

__all__ = ["ActionName", "Image", "Mask", "Observation", "Observations", "Simulation", "Simulations", "View"]

ActionName = Literal["move_to", "line_to", "jump_to", "move_joints", "move_by", "line_by", "move_joints_by"]
"""Command of :mod:`magician.words` whose four numbers form an action."""

View = Literal["top", "side"]
"""Camera view: from above, x to the right and y up; or from the side, distance from the base axis to the right and z
up."""

_MAX_SEED = 2**64 - 1


class Observation(NamedTuple):
    """Observation of an arm after a step, as seen by a host."""

    pose: Position
    """Reported pose."""
    joints: Joints
    """Reported joint angles, degrees."""
    time: float
    """Arm clock, s."""
    moving: bool
    """True if a motion is still under way."""
    refused: bool
    """True if the check refused the last target, which was then not sent."""
    alarm: bool
    """True if an active alarm stops the arm; the next target clears it."""
    holding: bool
    """True if suction cup or gripper hold an object."""


class Observations(NamedTuple):
    """Observations of many arms after a step, one row each."""

    poses: Floats
    """Reported poses, shape (n, 4)."""
    joints: Floats
    """Reported joint angles, degrees, shape (n, 4)."""
    time: Floats
    """Arm clocks, s, shape (n,)."""
    moving: Mask
    """Mask of arms whose motion is still under way."""
    refused: Mask
    """Mask of arms whose last target the check refused."""
    alarm: Mask
    """Mask of arms stopped by an active alarm."""
    holding: Mask
    """Mask of arms whose suction cup or gripper hold an object."""


class _Arms:
    """Base class of :class:`Simulation` and :class:`Simulations`."""

    __slots__ = ("_count", "_native", "_threads")

    def __init__(
        self,
        count: int,
        scenario: str | os.PathLike[str] | None,
        action: ActionName,
        tool: words.Tool | Sequence[float] | None,
        speed: float | None,
        seed: int,
        object_noise: float,
        joint_noise: float,
        threads: int,
    ) -> None:
        self._count, self._threads = count, threads
        self._native = _magician.Sims(
            count,
            scenario_text(scenario),
            tool_bias(tool),
            action,
            None if speed is None else number("speed", speed, above=0, most=100, unit="%"),
            whole("seed", seed, 0, _MAX_SEED),
            number("object_noise", object_noise, least=0, unit="mm"),
            number("joint_noise", joint_noise, least=0, unit="deg"),
        )

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the objects, in the order of the scenario."""
        return tuple(self._native.names())

    def _reset(self, seed: int | None, which: bytes | None) -> None:
        first_seed = None if seed is None else whole("seed", seed, 0, _MAX_SEED)
        self._native.reset(first_seed, which, self._threads)

    def _images(self, which: Sequence[int], view: View, size: tuple[int, int]) -> bytearray:
        if view not in ("top", "side"):
            raise InvalidInputError(f'view is {view!r}; it is "top" or "side"')
        height, width = (whole("size", side, 1, 10_000) for side in size)
        return self._native.images(list(which), view == "top", (height, width), self._threads)

    def __reduce__(self) -> Any:
        raise TypeError(f"{type(self).__name__} is not copied or pickled: make another, and restore a snapshot in it")


class Simulation(_Arms):
    """A stepped virtual arm.

    An action consists of the four numbers of the command named by ``action``, and optionally a fifth for suction cup or
    gripper: on (closed) above 0, else off. The tool is switched at once, before the motion. A target with NaN is
    ignored: the arm continues. An infinite target is refused, as one out of reach (:attr:`Observation.refused`).

    The target of a real arm cannot be changed during a motion; the arm can only be stopped. Therefore a step without
    ``dt`` ends when the arm is at rest. A step with ``dt`` ends after ``dt`` seconds. If a motion is then still under
    way, a step with the same target continues it; another target first forces a stop and clears the queue.
    """

    __slots__ = ()

    def __init__(
        self,
        scenario: str | os.PathLike[str] | None = None,
        *,
        action: ActionName = "line_to",
        tool: words.Tool | Sequence[float] | None = None,
        speed: float | None = None,
        seed: int = 0,
        object_noise: float = 0.0,
        joint_noise: float = 0.0,
    ) -> None:
        """Creates an arm that was just switched on, its alarms cleared.

        :param scenario: As for :class:`~magician.VirtualArm`.
        :param action: Meaning of the four numbers of an action.
        :param tool: As for :class:`~magician.VirtualArm`.
        :param speed: Point-to-point speed ratio, percent; the power-up value if left out.
        :param seed: Seed of the random number generator.
        :param object_noise: Maximum random displacement of objects on the table in x and y, mm.
        :param joint_noise: Maximum random offset of each joint at the start, degrees, within its limits.
        :raises InvalidInputError: An argument or the scenario is invalid.
        """
        super().__init__(1, scenario, action, tool, speed, seed, object_noise, joint_noise, 1)

    def reset(self, seed: int | None = None) -> Observation:
        """Starts a new episode. Without a seed the random number generator continues its sequence."""
        self._reset(seed, None)
        return self.observe()

    def step(self, action: Sequence[float] | SupportsArray, dt: float | None = None) -> Observation:
        """Applies an action, advances the clock by ``dt`` seconds, and returns the observation. Without ``dt`` the
        clock advances until the arm is at rest, but at most a minute.

        :raises InvalidInputError: The action does not have four or five numbers, or ``dt`` is not a valid time.
        """
        data, columns = _table([action], 1, "an action")
        time = None if dt is None else number("dt", dt, least=0, most=1e6, unit="s")
        return _observation(*self._native.step(data, columns, time, 1))

    def observe(self) -> Observation:
        """Returns the current observation."""
        return _observation(*self._native.look())

    @property
    def objects(self) -> dict[str, Place]:
        """Positions of the objects, by name."""
        places = zip(*[iter(to_list(self._native.objects()))] * 4, strict=True)
        return {name: Place(*place) for name, place in zip(self.object_names, places, strict=True)}

    def snapshot(self) -> Snapshot:
        """Takes a snapshot of arm, world and random numbers, also during a motion."""
        return Snapshot(self._native.snapshot(0))

    def restore(self, snapshot: Snapshot) -> Observation:
        """Restores a snapshot of this or another simulation, or of a :class:`~magician.VirtualArm` at rest."""
        self._native.restore(0, _native_snapshot(snapshot))
        return self.observe()

    def image(self, view: View = "top", size: tuple[int, int] = (256, 256)) -> Image:
        """Renders a camera image: an array of shape (height, width, 3), red, green and blue, 0 to 255.

        Without NumPy it is a ``memoryview`` of that shape.

        :param view: ``"top"`` or ``"side"``.
        :param size: height and width in pixels.
        """
        return _shaped(self._images([0], view, size), (*size, 3))


class Simulations(_Arms):
    """Virtual arms stepped in parallel on all cores, each in its own world: NumPy in, NumPy out.

    Arm i behaves exactly, bit for bit, like ``Simulation(seed=seed + i)``.
    """

    __slots__ = ()

    def __init__(
        self,
        count: int,
        scenario: str | os.PathLike[str] | None = None,
        *,
        action: ActionName = "line_to",
        tool: words.Tool | Sequence[float] | None = None,
        speed: float | None = None,
        seed: int = 0,
        object_noise: float = 0.0,
        joint_noise: float = 0.0,
        threads: int | None = None,
    ) -> None:
        """Creates arms that were just switched on, their alarms cleared.

        :param count: Number of arms.
        :param threads: Number of threads; the number of cores if left out.

        Other parameters as for :class:`Simulation`.
        """
        thread_count = whole("threads", threads, 1, 1024) if threads is not None else os.cpu_count() or 1
        count = whole("count", count, 1, 1_000_000)
        super().__init__(count, scenario, action, tool, speed, seed, object_noise, joint_noise, thread_count)

    def __len__(self) -> int:
        return self._count

    def reset(self, seed: int | None = None, *, which: SupportsArray | Sequence[bool] | None = None) -> Observations:
        """Starts a new episode. Arm i uses the seed ``seed + i``; without a seed each random number generator continues
        its sequence.

        :param which: Mask of the arms to reset; all if left out.
        """
        mask = None if which is None else bytes(1 if one else 0 for one in _flat(which))
        if mask is not None and len(mask) != self._count:
            raise InvalidInputError(f"which has {len(mask)} entries, one for each of {self._count} arms is needed")
        self._reset(seed, mask)
        return self.observe()

    def step(self, actions: Sequence[Sequence[float]] | SupportsArray, dt: float | None = None) -> Observations:
        """Steps all arms: actions of shape (n, 4) or (n, 5), as for :meth:`Simulation.step`.

        :raises InvalidInputError: The number of actions differs from the number of arms, or ``dt`` is not a valid time.
        """
        data, columns = _table(actions, self._count, "actions")
        time = None if dt is None else number("dt", dt, least=0, most=1e6, unit="s")
        return _observations(*self._native.step(data, columns, time, self._threads))

    def observe(self) -> Observations:
        """Returns the current observations."""
        return _observations(*self._native.look())

    @property
    def objects(self) -> Floats:
        """Positions of the objects: x, y, z and yaw, an array of shape (n, objects, 4)."""
        rows: Any = to_numpy(self._native.objects(), 4)
        places: Floats = rows.reshape(self._count, -1, 4)
        return places

    def snapshot(self) -> list[Snapshot]:
        """Takes a snapshot of each arm."""
        return [Snapshot(self._native.snapshot(nth)) for nth in range(self._count)]

    def restore(self, snapshots: Snapshot | Iterable[Snapshot]) -> Observations:
        """Restores snapshots: one for each arm, or one for all."""
        if isinstance(snapshots, Snapshot):
            snapshots = [snapshots] * self._count
        # A single value becomes a list of one, so that `_native_snapshot` reports it if its type is wrong.
        snapshot_list: Any = snapshots if hasattr(snapshots, "__iter__") else [snapshots]
        natives = list(map(_native_snapshot, snapshot_list))
        if len(natives) != self._count:
            raise InvalidInputError(
                f"there are {len(natives)} snapshots for {self._count} arms: give one for each, or one"
            )
        for nth, native in enumerate(natives):
            self._native.restore(nth, native)
        return self.observe()

    def images(self, view: View = "top", size: tuple[int, int] = (256, 256)) -> Image:
        """Renders a camera image of each arm: shape (n, height, width, 3), as :meth:`Simulation.image`."""
        return _shaped(self._images(range(self._count), view, size), (self._count, *size, 3))


def _native_snapshot(snapshot: Any) -> _magician.Saved:
    return instance("snapshot", snapshot, Snapshot, "snapshot() makes one").native


def _observation(values: bytes, flags: bytes) -> Observation:
    row = to_list(values)
    return Observation(Position(*row[:4]), Joints(*row[4:8]), row[8], *map(bool, flags))


def _observations(values: bytes, flags: bytes) -> Observations:
    import numpy

    rows = to_numpy(values, 9)
    flag_array: Any = numpy.frombuffer(bytearray(flags), dtype=numpy.bool_)
    columns = flag_array.reshape(-1, 4)
    return Observations(
        rows[:, :4], rows[:, 4:8], rows[:, 8], columns[:, 0], columns[:, 1], columns[:, 2], columns[:, 3]
    )


def _flat(values: Any) -> list[Any]:
    found: list[Any] = values.tolist() if hasattr(values, "tolist") else list(values)
    return found


def _shaped(data: bytearray, shape: tuple[int, ...]) -> Image:
    try:
        import numpy
    except ModuleNotFoundError:
        view: Any = memoryview(data).cast("B", shape)
        image: Image = view
        return image
    flat: Any = numpy.frombuffer(data, dtype=numpy.uint8)
    pixels: Image = flat.reshape(shape)
    return pixels
