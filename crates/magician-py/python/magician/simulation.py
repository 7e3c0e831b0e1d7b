"""Virtual arms that are stepped: for learning, for planning and for tests.

A :class:`VirtualArm` is driven as a real arm is, through a driver. A :class:`Simulation` is the same arm, the same
world and the same motions without driver, thread and wall clock: each step tells it a target and lets its time pass.
:class:`Simulations` steps many of them at once, on all cores.

A step sends the frames that a host would send, and each target passes the check that ``arm.run`` makes. The same steps
give the same numbers, bit for bit, on however many threads. Lengths are mm, angles degrees, times seconds.

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
    # So that type hints can be evaluated without NumPy.
    Image = Any
    Mask = Any

__all__ = ["ActionName", "Image", "Mask", "Observation", "Observations", "Simulation", "Simulations", "View"]

ActionName = Literal["move_to", "line_to", "jump_to", "move_joints", "move_by", "line_by", "move_joints_by"]
"""The word whose four numbers an action is: :mod:`magician.words` has each."""

View = Literal["top", "side"]
"""From above, x to the right and y up; or from the side, the distance from the base axis to the right and z up."""

_SEEDS = 2**64 - 1


class Observation(NamedTuple):
    """An arm after a step, as a host sees it."""

    pose: Position
    """The pose that it reports."""
    joints: Joints
    """The joint angles that it reports."""
    time: float
    """Its clock, s."""
    moving: bool
    """True if it is still on its way."""
    refused: bool
    """True if the check refused the last target, so that it was not sent."""
    alarm: bool
    """True if an alarm stands that stops the arm; the next target clears it."""
    holding: bool
    """True if suction cup or gripper hold something."""


class Observations(NamedTuple):
    """Many arms after a step: a row for each."""

    poses: Floats
    """The poses that they report, shape (n, 4)."""
    joints: Floats
    """The joint angles that they report, shape (n, 4)."""
    time: Floats
    """Their clocks, s, shape (n,)."""
    moving: Mask
    """Which are still on their way."""
    refused: Mask
    """Whose last target the check refused."""
    alarm: Mask
    """At which an alarm stands that stops the arm."""
    holding: Mask
    """Whose suction cup or gripper hold something."""


class _Arms:
    """What one and many have in common."""

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
            whole("seed", seed, 0, _SEEDS),
            number("object_noise", object_noise, least=0, unit="mm"),
            number("joint_noise", joint_noise, least=0, unit="deg"),
        )

    @property
    def object_names(self) -> tuple[str, ...]:
        """The names of the objects, in the order of the scenario."""
        return tuple(self._native.names())

    def _reset(self, seed: int | None, which: bytes | None) -> None:
        begin = None if seed is None else whole("seed", seed, 0, _SEEDS)
        self._native.reset(begin, which, self._threads)

    def _images(self, which: Sequence[int], view: View, size: tuple[int, int]) -> bytearray:
        if view not in ("top", "side"):
            raise InvalidInputError(f'view is {view!r}; it is "top" or "side"')
        height, width = (whole("size", side, 1, 10_000) for side in size)
        return self._native.images(list(which), view == "top", (height, width), self._threads)

    def __reduce__(self) -> Any:
        raise TypeError(f"{type(self).__name__} is not copied or pickled: make another, and restore a snapshot in it")


class Simulation(_Arms):
    """A virtual arm that is stepped.

    An action is the four numbers of the word that ``action`` names, and in a fifth place the suction cup or gripper: on
    (closed) above 0, else off. The tool is switched at once, before the motion begins. A target with NaN is none: the
    arm goes on as before. An infinite one is refused, as any that is out of reach (:attr:`Observation.refused`).

    A real arm cannot be given another target on its way, only be stopped. So a step ends, without ``dt``, when the arm
    is at rest; with ``dt`` when that time is over. An arm that is then still on its way goes on if the next target is
    the same, and is stopped by force, its queue cleared, before it is told another.
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
        """Begins with an arm that has just been switched on, its alarms cleared.

        :param scenario: As for :class:`~magician.VirtualArm`.
        :param action: What the four numbers of an action are.
        :param tool: As for :class:`~magician.VirtualArm`.
        :param speed: Share of the point-to-point speeds, percent; that of power-up if it is left out.
        :param seed: Seed of the random numbers.
        :param object_noise: By how much an object on the table may stand elsewhere in x and in y, mm.
        :param joint_noise: By how much each joint may stand elsewhere at the beginning, degrees, within its limits.
        :raises InvalidInputError: Something makes no sense.
        """
        super().__init__(1, scenario, action, tool, speed, seed, object_noise, joint_noise, 1)

    def reset(self, seed: int | None = None) -> Observation:
        """Begins a new episode: with the random numbers of a seed, or with the next ones."""
        self._reset(seed, None)
        return self.observe()

    def step(self, action: Sequence[float] | SupportsArray, dt: float | None = None) -> Observation:
        """Tells the arm an action, lets so much time pass, or lets it come to rest (at most a minute), and observes.

        :raises InvalidInputError: There are not four or five numbers, or ``dt`` is no time.
        """
        data, columns = _table([action], 1, "an action")
        time = None if dt is None else number("dt", dt, least=0, most=1e6, unit="s")
        return _one(*self._native.step(data, columns, time, 1))

    def observe(self) -> Observation:
        """The arm as it is."""
        return _one(*self._native.look())

    @property
    def objects(self) -> dict[str, Place]:
        """Where the objects are, by their names."""
        places = zip(*[iter(to_list(self._native.objects()))] * 4, strict=True)
        return {name: Place(*place) for name, place in zip(self.object_names, places, strict=True)}

    def snapshot(self) -> Snapshot:
        """The state of the arm, its world and its random numbers at this instant, also during a motion."""
        return Snapshot(self._native.snapshot(0))

    def restore(self, snapshot: Snapshot) -> Observation:
        """Goes back to a snapshot, of this simulation or another, or of a :class:`~magician.VirtualArm` at rest."""
        self._native.restore(0, _saved(snapshot))
        return self.observe()

    def image(self, view: View = "top", size: tuple[int, int] = (256, 256)) -> Image:
        """A camera's image: an array of shape (height, width, 3), red, green and blue, 0 to 255.

        Without NumPy it is a ``memoryview`` of that shape.

        :param view: ``"top"`` or ``"side"``.
        :param size: height and width in pixels.
        """
        return _shaped(self._images([0], view, size), (*size, 3))


class Simulations(_Arms):
    """Virtual arms that are stepped together, each in a world of its own, on all cores: NumPy in, NumPy out.

    Arm i is what ``Simulation(seed=seed + i)`` is, and does what it does, bit for bit.
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
        """Begins with arms that have just been switched on, their alarms cleared.

        :param count: How many.
        :param threads: On how many threads they are stepped; as many as there are cores if it is left out.

        The rest is as for :class:`Simulation`.
        """
        cores = whole("threads", threads, 1, 1024) if threads is not None else os.cpu_count() or 1
        count = whole("count", count, 1, 1_000_000)
        super().__init__(count, scenario, action, tool, speed, seed, object_noise, joint_noise, cores)

    def __len__(self) -> int:
        return self._count

    def reset(self, seed: int | None = None, *, which: SupportsArray | Sequence[bool] | None = None) -> Observations:
        """Begins a new episode with the random numbers of ``seed + i``, or with the next ones.

        :param which: A mask of the arms that are reset; all of them if it is left out.
        """
        mask = None if which is None else bytes(1 if one else 0 for one in _flat(which))
        if mask is not None and len(mask) != self._count:
            raise InvalidInputError(f"which has {len(mask)} entries, one for each of {self._count} arms is needed")
        self._reset(seed, mask)
        return self.observe()

    def step(self, actions: Sequence[Sequence[float]] | SupportsArray, dt: float | None = None) -> Observations:
        """A step of each: actions of shape (n, 4) or (n, 5), as for :meth:`Simulation.step`.

        :raises InvalidInputError: There are not as many actions as arms, or ``dt`` is no time.
        """
        data, columns = _table(actions, self._count, "actions")
        time = None if dt is None else number("dt", dt, least=0, most=1e6, unit="s")
        return _many(*self._native.step(data, columns, time, self._threads))

    def observe(self) -> Observations:
        """The arms as they are."""
        return _many(*self._native.look())

    @property
    def objects(self) -> Floats:
        """Where the objects are: x, y, z and yaw, in an array of shape (n, objects, 4)."""
        rows: Any = to_numpy(self._native.objects(), 4)
        places: Floats = rows.reshape(self._count, -1, 4)
        return places

    def snapshot(self) -> list[Snapshot]:
        """Each of them at this instant."""
        return [Snapshot(self._native.snapshot(nth)) for nth in range(self._count)]

    def restore(self, snapshots: Snapshot | Iterable[Snapshot]) -> Observations:
        """Goes back to snapshots: one for each, or one that all of them go on from."""
        if isinstance(snapshots, Snapshot):
            snapshots = [snapshots] * self._count
        # A single value, even of a wrong type, counts as a list of one: `_saved` reports it.
        several: Any = snapshots if hasattr(snapshots, "__iter__") else [snapshots]
        found = list(map(_saved, several))
        if len(found) != self._count:
            raise InvalidInputError(
                f"there are {len(found)} snapshots for {self._count} arms: give one for each, or one"
            )
        for nth, native in enumerate(found):
            self._native.restore(nth, native)
        return self.observe()

    def images(self, view: View = "top", size: tuple[int, int] = (256, 256)) -> Image:
        """A camera's image of each: shape (n, height, width, 3), as :meth:`Simulation.image`."""
        return _shaped(self._images(range(self._count), view, size), (self._count, *size, 3))


def _saved(snapshot: Any) -> _magician.Saved:
    return instance("snapshot", snapshot, Snapshot, "snapshot() makes one").native


def _one(values: bytes, flags: bytes) -> Observation:
    row = to_list(values)
    return Observation(Position(*row[:4]), Joints(*row[4:8]), row[8], *map(bool, flags))


def _many(values: bytes, flags: bytes) -> Observations:
    import numpy

    rows = to_numpy(values, 9)
    marks: Any = numpy.frombuffer(bytearray(flags), dtype=numpy.bool_)
    so = marks.reshape(-1, 4)
    return Observations(rows[:, :4], rows[:, 4:8], rows[:, 8], so[:, 0], so[:, 1], so[:, 2], so[:, 3])


def _flat(values: Any) -> list[Any]:
    found: list[Any] = values.tolist() if hasattr(values, "tolist") else list(values)
    return found


def _shaped(data: bytearray, shape: tuple[int, ...]) -> Image:
    try:
        import numpy
    except ModuleNotFoundError:
        view: Any = memoryview(data).cast("B", shape)
        seen: Image = view
        return seen
    flat: Any = numpy.frombuffer(data, dtype=numpy.uint8)
    pixels: Image = flat.reshape(shape)
    return pixels
