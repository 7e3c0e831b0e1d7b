"""The arm for programs on asyncio.

``tools/blocking.py`` generates the blocking interface, :class:`magician.Arm`, from this file: it is the same, without
``await``. The file is long because it holds the whole interface in one piece: one class with every command for an arm.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from time import monotonic
from types import TracebackType
from typing import Any, Generic, Literal, TypeVar, overload

from . import _conversion, commands, events, words
from ._arguments import check_progress, ending_options, flag, flags, instance, not_a_file, number, seconds, text, whole
from ._bound import Bound
from ._magician import Call, Core, Feed
from ._magician import Events as NativeEvents
from ._magician import Job as NativeJob
from ._magician import Jog as NativeJog
from ._magician import Lesson as NativeLesson
from ._magician import Program as NativeProgram
from ._magician import Recording as NativeRecording
from ._magician import StateWatch as NativeStateWatch
from ._motions import FinishedMotion, RunningMotion, Steps, homing, intercepting, performing
from ._naming import find
from ._native import (
    GeneratorEnd,
    Where,
    connecting,
    iterator_of,
    opened,
    start_call,
    until,
    until_done,
    until_ended,
    until_moment,
    until_next,
    until_over,
    until_settled,
    until_steps,
    until_stopped,
)
from ._pictures import Picture
from ._points import Points
from ._progress import ProgressReporter
from ._protocol import Command, Query, Queueable, Readable, Writable
from ._reports import report
from ._targets import JointTarget, RFiller, Target, command_list, fill_r, joints, keeps_r, position_of
from .alarms import Alarm
from .commands import Pose, RailVersion
from .errors import ClosedError, Error, InvalidInputError, ResponseTimeoutError, UnexpectedError, UnsupportedError
from .kinematics import JointArray, Mask, PoseArray
from .pins import FunctionLike, PinLike, PortLike, StepperLike, VersionLike, pins
from .places import Belt, Point, Poses, meeting, picking, placing
from .programs import Plan, Report, Surface
from .readings import Color, Info, Joints, Link, Position, Progress, Ran, Stats, Status
from .running import PlanProgress, RunResult, Watcher
from .words import Direction, Four, Tool

__all__ = [
    "Arm",
    "Check",
    "Connecting",
    "Events",
    "Job",
    "Jog",
    "Lesson",
    "Motion",
    "Recording",
    "Run",
    "StateWatch",
    "Station",
    "conform",
    "discover",
    "doctor",
    "record",
]

# [aio]
from collections.abc import AsyncIterable, AsyncIterator
from typing import TYPE_CHECKING

from ._ports import discover_async as discover
from .conformance import conform_async as conform
from .diagnosis import doctor_async as doctor

if TYPE_CHECKING:
    from ._aio_station import Station

# [both]
_R = TypeVar("_R", bound=Readable)
_A = TypeVar("_A", bound=Command)
_T = TypeVar("_T")

Check = Literal["reach", "unknown_start", "jog", "laser", "alarms"]
"""A check that a program passes before a byte of it is sent:

* ``reach``: targets and paths out of reach or beyond a limit;
* ``unknown_start``: paths that cannot be checked because their start is unknown: after homing to a point that is not
  known, or when the arm was moving as the check began;
* ``jog``: jogs, which go on until a limit ends them with an alarm;
* ``laser``: a laser that burns while the arm waits, homes, or travels with its joints, and one that is left burning;
* ``alarms``: an alarm that holds the queue when the program begins. Homing runs all the same.

NaN, speeds of 0 or less and values that the protocol does not have are always refused, whichever checks are left out.
"""


def _hearing(progress: Callable[[Progress], object] | None) -> Callable[[Any], object] | None:
    check_progress(progress)
    return None if progress is None else lambda parts: progress(Progress(*parts))


_PROGRESS_WAITS = "progress is reported during a wait: leave out progress or wait=False"


_Recorded = tuple[str, float, float, bool, bool]


def _plan(plan: Any) -> Plan:
    if not isinstance(plan, Plan):
        raise TypeError(f"expected a Plan, not {plan!r}: magician.load and Plan.of make one")
    return plan


def _names(skip: Collection[Check]) -> list[str]:
    if isinstance(skip, str):
        raise TypeError(f"skip is {skip!r}; it takes names in a list: [{skip!r}]")
    return list(skip)


# [aio]
class Connecting(Bound):
    """A connection about to be made: ``await`` it, or enter it with ``async with``."""

    def __init__(self, port: Where, **options: Any) -> None:
        self._port = port
        self._options = options
        self._arm: Arm | None = None

    def __await__(self) -> Generator[Any, Any, Arm]:
        return self._connected().__await__()

    def __repr__(self) -> str:
        return f"<Connecting to {self._port!r}: await it>"

    async def _connected(self) -> Arm:
        return Arm(await until(connecting(self._port, **self._options)))

    async def __aenter__(self) -> Arm:
        self._arm = await self._connected()
        return self._arm

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._arm is not None:
            await self._arm.__aexit__(kind, error, trace)


# [both]
class Arm(Bound):
    """A connected arm.

    Lengths are mm, angles degrees, times seconds. Every call ends: with its answer, or with an exception of
    :mod:`magician.errors` by its deadline. An arm may be used from any thread and any task; a :meth:`stop` overtakes
    all other calls.

    A ``with`` block that ends with an exception stops the arm and its laser. One that ends normally leaves the arm as
    it is, except that a laser that is still lit without a running program, and a belt or stepper that still runs, are
    switched off. Interrupting a call that waits for a motion, with Ctrl-C or by cancelling it, stops the arm before the
    exception propagates. A connection that is closed, garbage-collected, or still open when the interpreter exits stops
    the motions that it started, unless :meth:`detach` was called.

    This is a convenience, not a safety function: the arm has a power switch.
    """

    # [aio]
    def __init__(self, core: Core) -> None:
        if not isinstance(core, Core):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError("an arm on asyncio is connected to: await Arm.connect(...), or async with Arm.connect(...)")
        self._core = opened(core)

    @classmethod
    def connect(
        cls,
        port: Where = None,
        *,
        timeout: float = 3.0,
        window: int = 1,
        probe: bool = True,
        reconnect: bool = True,
        echo: float = 0.1,
        fence: Mapping[str, object] | None = None,
        trace: str | os.PathLike[str] | None = None,
    ) -> Connecting:
        """Connects to an arm and makes sure that it answers.

        ``arm = await Arm.connect("sim")``, or ``async with Arm.connect("sim") as arm``.

        :param port: ``"sim"`` for a virtual arm in this process (``"sim:1"`` at the speed of a real one), a serial port
            (``"/dev/ttyUSB0"``, ``"COM3"``), ``"usb:10c4:ea60"``, ``"arm:SERIAL"``, ``"udp:HOST[:PORT]"``,
            ``"tcp:HOST:PORT"``, ``"http://HOST:PORT/ARM"`` for an arm of a station, or a virtual arm of your making.
            Without it ``MAGICIAN_PORT`` of the environment, or the one arm that is plugged in.
        :param timeout: seconds after which every single call to the arm ends. Waiting for a motion has deadlines of its
            own.
        :param window: maximum number of requests in flight, 1 to 8. Use more than 1 only for an arm that is known to
            take requests back to back; ``magician doctor`` can measure it.
        :param probe: whether to check at the start that an arm answers.
        :param reconnect: whether to reconnect after the line was lost: to the same port, and the same arm at it.
        :param echo: over UDP, how many seconds after a datagram the network may still deliver a second copy of it.
        :param fence: limits for everything sent over this connection, instead of those of ``[arms.NAME.fence]`` in the
            settings file: ``floor`` (the lowest z of the tool's tip, mm), ``box`` (two corners that it stays between),
            ``keep_out`` (a list of boxes), ``top_speed`` (mm/s), ``strongest_laser`` (percent). A command that would
            cross it is refused before it is sent.
        :param trace: a file for everything that passes on the line (pcapng): Wireshark opens it,
            :func:`magician.decode` reads it, :func:`magician.replay` replays it on a virtual arm.

        Raises :class:`~magician.errors.PortError` when the port does not exist, is in use or access is denied,
        :class:`~magician.errors.ResponseTimeoutError` when no arm answers, :class:`~magician.errors.UnexpectedError`
        when another device answers, ``OSError`` when the trace cannot be written.
        """
        how = {"probe": probe, "reconnect": reconnect}
        return Connecting(port, timeout=timeout, window=window, echo=echo, fence=fence, trace=trace, **how)

    # [blocking]
    # def __init__(
    #     self,
    #     port: Where = None,
    #     *,
    #     timeout: float = 3.0,
    #     window: int = 1,
    #     probe: bool = True,
    #     reconnect: bool = True,
    #     echo: float = 0.1,
    #     fence: Mapping[str, object] | None = None,
    #     trace: str | os.PathLike[str] | None = None,
    # ) -> None:
    #     """Connects to an arm and makes sure that it answers.
    #
    #     :param port: ``"sim"`` for a virtual arm in this process (``"sim:1"`` at the speed of a real one), a serial
    #         port (``"/dev/ttyUSB0"``, ``"COM3"``), ``"usb:10c4:ea60"``, ``"arm:SERIAL"``, ``"udp:HOST[:PORT]"``,
    #         ``"tcp:HOST:PORT"``, ``"http://HOST:PORT/ARM"`` for an arm of a station, or a virtual arm of your making.
    #         Without it ``MAGICIAN_PORT`` of the environment, or the one arm that is plugged in.
    #     :param timeout: seconds after which every single call to the arm ends. Waiting for a motion has deadlines of
    #         its own.
    #     :param window: maximum number of requests in flight, 1 to 8. Use more than 1 only for an arm that is known to
    #         take requests back to back; ``magician doctor`` can measure it.
    #     :param probe: whether to check at the start that an arm answers.
    #     :param reconnect: whether to reconnect after the line was lost: to the same port, and the same arm at it.
    #     :param echo: over UDP, how many seconds after a datagram the network may still deliver a second copy of it.
    #     :param fence: limits for everything sent over this connection, instead of those of ``[arms.NAME.fence]`` in
    #         the settings file: ``floor`` (the lowest z of the tool's tip, mm), ``box`` (two corners that it stays
    #         between), ``keep_out`` (a list of boxes), ``top_speed`` (mm/s), ``strongest_laser`` (percent). A command
    #         that would cross it is refused before it is sent.
    #     :param trace: a file for everything that passes on the line (pcapng): Wireshark opens it,
    #         :func:`magician.decode` reads it, :func:`magician.replay` replays it on a virtual arm.
    #
    #     Raises :class:`~magician.errors.PortError` when the port does not exist, is in use or access is denied,
    #     :class:`~magician.errors.ResponseTimeoutError` when no arm answers, :class:`~magician.errors.UnexpectedError`
    #     when another device answers, ``OSError`` when the trace cannot be written.
    #     """
    #     how = {"probe": probe, "reconnect": reconnect}
    #     call = connecting(port, timeout=timeout, window=window, echo=echo, fence=fence, trace=trace, **how)
    #     self._core = opened(wait(call))
    # [both]

    async def __aenter__(self) -> Arm:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._core.is_here():
            return
        try:
            if error is None:
                await self._settle()
                if self.link.state == "up":
                    await until(self._core.let_go())
                self.detach()
            elif self.link.state != "closed":
                await until_stopped(self._core, error)
        finally:
            # Close the connection even if the wait for the stop is interrupted.
            await self.close()

    def __repr__(self) -> str:
        if not hasattr(self, "_core"):
            # Shown in a traceback of the constructor, before the attributes exist.
            return "<Arm, not connected>"
        if not self._core.is_here():
            return "<Arm of another process>"
        return f"<Arm at {self.name}, {self.link.state}>"

    # Motions that were begun without waiting.

    _last: RunningMotion | None = None

    async def _settle(self) -> None:
        """Waits until motions that were begun without waiting have ended."""
        last, self._last = self._last, None
        if last is not None:
            await until_settled(last, self._core)

    def _drop(self) -> None:
        """Drops motions that were begun without waiting and have not been sent."""
        last, self._last = self._last, None
        if last is not None:
            last.drop()

    async def _go(self, steps: Steps, wait: bool) -> Motion[Any]:
        if flag("wait", wait):
            await self._settle()
            return Motion(self._core, FinishedMotion(await until_steps(steps, self._core)))
        if self._last is not None and self._last.over:
            # Raises the failure of an earlier motion if its own caller has not seen it.
            await self._settle()
        self._last = going = RunningMotion(self._core, steps, self._last)
        return Motion(self._core, going)

    async def _move(self, *program: Queueable, speed: float | None = None, wait: bool = True) -> Motion[Ran]:
        percent = number("speed", speed, above=0, most=100, unit="%")
        return await self._go(performing(self._core, program, speed=percent), wait)

    def _place(
        self, x: Any, y: float | None = None, z: float | None = None, r: float | None = None
    ) -> tuple[float, float, float, float | None]:
        if isinstance(x, str) and y is None and z is None:
            try:
                x = self.poses[x]
            except KeyError as error:
                raise InvalidInputError(error.args[0]) from None
        return position_of(x, y, z, r)

    _poses: Poses | None = None

    @property
    def poses(self) -> Poses:
        """Named poses, stored in ``poses.json`` beside the program: ``arm.poses["tray"] = arm.pose()``, then
        ``arm.move_to("tray")`` in any later program. Assign to use another file: ``arm.poses = Poses("cell.json")``.
        """
        if self._poses is None:
            self._poses = Poses()
        return self._poses

    @poses.setter
    def poses(self, poses: Poses) -> None:
        if not isinstance(poses, Poses):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"poses is {poses!r}; it takes a magician.Poses")
        self._poses = poses

    # The connection.

    @property
    def name(self) -> str:
        """Name of the connection in messages: the port as passed by the caller."""
        return self._core.name()

    @property
    def timeout(self) -> float:
        """Timeout of a single call to the arm, s. A new value applies to later calls."""
        return self._core.timeout()

    @timeout.setter
    def timeout(self, timeout: float) -> None:
        self._core.set_timeout(seconds("timeout", timeout, above=0))

    @property
    def link(self) -> Link:
        """Current state of the line to the arm. A silent line counts as up; calls over it end by their deadlines."""
        return _conversion.link(self._core.link())

    @property
    def moving(self) -> bool:
        """True if a motion or a queue that this connection started may still be running.

        If in doubt the value is True: a motion counts until its end was read. Motions that other programs started do
        not count.
        """
        return self._core.moving()

    def detach(self) -> None:
        """Leaves the motions and the queue of this connection running when the connection ends, for any reason."""
        self._core.detach()

    async def close(self) -> None:
        """Closes the connection and waits until it is closed. Its motions are stopped, unless it was detached.

        All other calls on it fail with :class:`~magician.errors.ClosedError`, those under way too. Closing it again
        does nothing.
        """
        if self._core.is_here():
            self._drop()
            await until(self._core.close())

    async def reconnected(self) -> None:
        """Waits until the line is up again. Returns at once if the line is up.

        Nothing is retransmitted: calls in flight when the line was lost have ended with an error. Look at the arm
        before you continue.

        Raises :class:`~magician.errors.PortError` when the connection does not reconnect,
        :class:`~magician.errors.ClosedError` when it is closed meanwhile.
        """
        await until(self._core.reconnected())

    async def stats(self) -> Stats:
        """Returns the traffic counters of the line, and the capacity of the arm's queue."""
        return Stats(*await until(self._core.stats()))

    # Pose and state.

    async def pose(self) -> Pose:
        """Returns the commanded pose: ``x``, ``y``, ``z`` (mm) and ``r`` (degrees) of the tool, ``j1`` to ``j4``
        (degrees).

        Document 1.4.1.
        """
        return await until(self._core.get(Pose))

    async def _known_pose(self) -> Pose:
        """Returns the pose at the end of the last motion if it is recent; otherwise reads it."""
        return await until(self._core.known_pose(Pose))

    async def joints(self) -> Joints:
        """Returns the joint angles, degrees."""
        return (await self.pose()).joints

    async def bias(self) -> tuple[float, float, float]:
        """Returns the offset of the tool tip from the wrist: x, y, z in mm (document 1.8.1)."""
        bias = await until(self._core.get(commands.EndEffectorParams))
        return bias.x_bias, bias.y_bias, bias.z_bias

    @overload
    async def forward(self, j1: float, j2: float, j3: float, j4: float = 0.0, /) -> Position: ...
    @overload
    async def forward(self, joints: Joints, /) -> Position: ...
    @overload
    async def forward(self, joints: Points, /) -> PoseArray: ...
    async def forward(self, *joints: Any) -> Position | PoseArray:
        """Computes the pose of the tool tip from joint angles, degrees: :func:`magician.forward` for the tool that is
        set, whole arrays too. Nothing moves."""
        from .kinematics import forward

        # The arguments select the overload, so the type checker cannot.
        whichever: Any = forward
        found: Position | PoseArray = whichever(*joints, tool=await self.bias())
        return found

    @overload
    async def inverse(self, x: float, y: float, z: float, r: float = 0.0, /) -> Joints: ...
    @overload
    async def inverse(  # type: ignore[overload-overlap]  # pyright: ignore[reportOverlappingOverload]
        self, pose: Position | Pose, /
    ) -> Joints: ...
    @overload
    async def inverse(self, poses: Points, /, *, r: float = 0.0) -> JointArray: ...
    async def inverse(self, *pose: Any, r: float = 0.0) -> Joints | JointArray:
        """Computes the joint angles for a pose of the tool tip: :func:`magician.inverse` for the current
        tool; accepts arrays. Nothing moves. Raises :class:`~magician.errors.UnreachableError` for a single pose that
        the arm cannot reach.
        """
        from .kinematics import inverse

        found: Joints | JointArray = inverse(*pose, r=r, tool=await self.bias())
        return found

    @overload
    async def is_reachable(self, x: float, y: float, z: float, r: float = 0.0) -> bool: ...
    @overload
    async def is_reachable(  # type: ignore[overload-overlap]  # pyright: ignore[reportOverlappingOverload]
        self, pose: Position | Pose, /
    ) -> bool: ...
    @overload
    async def is_reachable(self, poses: Points, /, *, r: float = 0.0) -> Mask: ...
    async def is_reachable(self, x: Any, y: float | None = None, z: float | None = None, r: float = 0.0) -> bool | Mask:
        """True if the tool tip can reach a pose, mm and degrees: :func:`magician.is_reachable` for the
        tool that is set, whole arrays too. The path there is not checked; a motion is, before it is sent.
        """
        from .kinematics import is_reachable

        pose: tuple[Any, ...] = (x,) if y is None and z is None else (x, y, z, r)
        found: bool | Mask = is_reachable(*pose, r=r, tool=await self.bias())
        return found

    async def rail_position(self) -> float:
        """Returns the position on the rail, mm (document 1.4.3)."""
        return (await until(self._core.get(commands.PoseL))).pose_l

    async def clock(self) -> float:
        """Returns the arm's clock: seconds since power-up, with a resolution of 1 ms (document 1.3.5)."""
        return (await self.get(commands.DeviceTime)).g_systick / 1000

    async def info(self) -> Info:
        """Returns the name, serial number and firmware of the arm, and the time since power-up."""
        name = await self.get(commands.DeviceName)
        serial = await self.get(commands.DeviceSn)
        version = await self.get(commands.DeviceVersion)
        clock = await self.get(commands.DeviceTime)
        rail = await self.get(commands.DeviceWithL)
        try:
            processor = (await self.get(commands.DeviceId)).device_id
        except (UnexpectedError, TimeoutError):
            processor = None
        return Info(
            port=self.name,
            name=name.device_name,
            serial_number=serial.device_sn,
            firmware=f"{version.major_version}.{version.minor_version}.{version.revision}",
            processor_id=processor,
            uptime=clock.g_systick / 1000,
            rail=rail.with_l,
            laser=await until(self._core.laser()),
        )

    async def alarms(self) -> tuple[Alarm, ...]:
        """Returns the active alarms, each with cause and remedy (document 1.5.1)."""
        return (await until(self._core.get(commands.AlarmsState))).alarms_state

    async def clear_alarms(self, *, allow_laser: bool = False) -> None:
        """Clears the alarms; the queue continues if their causes are gone (document 1.5.2).

        :param allow_laser: as for :meth:`start_queue`.
        """
        await self.set(commands.ClearAlarmsState(), allow_laser=allow_laser)

    def state(
        self,
        rate: float = 10.0,
        *,
        inputs: Iterable[PinLike] = (),
        outputs: Iterable[PinLike] = (),
        analogs: Iterable[PinLike] = (),
    ) -> StateWatch:
        """Watches the state of the arm: pose, queue, alarms and link, at ``rate`` Hz (0.01 to 1000).

        ``async for status in arm.state(20): ...`` gives every reading. All watches share one set of reads, at the
        highest requested rate, and less often while the line is busy.

        :param inputs: Pins of digital inputs to read as well (:class:`~magician.Pin`); they must have been multiplexed.
        :param outputs: the same, of digital outputs.
        :param analogs: the same, of analog inputs.

        Raises :class:`~magician.errors.InvalidInputError` for a rate or an address out of range.
        """
        rate = number("rate", rate, least=0.01, most=1000, unit="Hz")
        watched = pins("inputs", inputs), pins("outputs", outputs), pins("analogs", analogs)
        return StateWatch(self._core.state(rate, *watched))

    def events(self) -> Events:
        """Subscribes to events from now on: alarms, finished commands, a lost line. Any number of listeners is allowed.

        Events are derived from other traffic: they cause no reads of their own, and without reads there are no events.
        To see an alarm within 100 ms, keep a :meth:`state` watch at 10 Hz. Each listener buffers 256 events, then drops
        the oldest.
        """
        return Events(self._core.events())

    # Raw commands: get, set and enqueue send their argument unchecked.

    @overload
    async def get(self, what: type[_R]) -> _R: ...
    @overload
    async def get(self, what: Query[_A]) -> _A: ...
    @overload
    async def get(self, what: str, **fields: Any) -> Any: ...
    async def get(self, what: type[Readable] | Query[Any] | str, **fields: Any) -> Any:
        """Reads a value of the arm.

        By its class, ``arm.get(commands.Pose)``; with a question, ``arm.get(commands.GetIoDi(address=19))``; or by any
        name of the command, ``arm.get("IODI", address=19)``.

        Raises :class:`~magician.errors.ResponseTimeoutError`, :class:`~magician.errors.UnexpectedError` when the answer
        cannot be read, :class:`~magician.errors.PortError` when the line broke.
        """
        return await until(self._core.get(find(what, "get", fields) if isinstance(what, str) else what))

    @overload
    async def set(self, command: Writable, *, allow_dangerous: bool = False, allow_laser: bool = False) -> None: ...
    @overload
    async def set(
        self, command: str, *, allow_dangerous: bool = False, allow_laser: bool = False, **fields: Any
    ) -> None: ...
    async def set(
        self, command: Writable | str, *, allow_dangerous: bool = False, allow_laser: bool = False, **fields: Any
    ) -> None:
        """Sets a value or orders an action, at once: ``arm.set(commands.PtpCommonParams(50, 50))``.

        Or by any name of the command: ``arm.set("PTPCommonParams", velocity_ratio=50, acceleration_ratio=50)``.

        :param allow_dangerous: allows commands that can brick, decalibrate or unlock the arm: firmware, serial number,
            sensor calibration, Wi-Fi, :class:`~magician.commands.ResetPose`; or that store a program in it:
            :class:`~magician.commands.QueuedCmdStartDownload`.
        :param allow_laser: Whether the laser of a real arm may burn: without it a command that lights the laser (or
            raises its pins EIO 2 and 4) is refused.

        Raises as :meth:`get`, and :class:`~magician.errors.UncertainError` when an action that must not be repeated was
        not answered.
        """
        told: Writable = find(command, "set", fields) if isinstance(command, str) else command
        if keeps_r(told):
            raise InvalidInputError("r is left out, and the arm's present r is not read here: give r")
        allowed = flag("allow_dangerous", allow_dangerous), flag("allow_laser", allow_laser)
        await until(self._core.set(told, *allowed))

    @overload
    async def enqueue(self, command: Queueable, *, allow_laser: bool = False) -> int: ...
    @overload
    async def enqueue(self, command: str, *, allow_laser: bool = False, **fields: Any) -> int: ...
    async def enqueue(self, command: Queueable | str, *, allow_laser: bool = False, **fields: Any) -> int:
        """Appends a command to the arm's queue and returns its index. The queue is not started: see
        :meth:`start_queue`.

        :param allow_laser: as for :meth:`set`.

        Raises :class:`~magician.errors.QueueFullError` when the queue is full, :class:`~magician.errors.UncertainError`
        when it is not known whether the arm took it, else as :meth:`get`.
        """
        told: Queueable = find(command, "set", fields) if isinstance(command, str) else command
        if keeps_r(told):
            raise InvalidInputError("r is left out, and the arm's r at that point is not known: give r")
        return await until(self._core.enqueue(told, flag("allow_laser", allow_laser)))

    async def raw(
        self,
        id: int,
        ctrl: int = 0,
        params: bytes | bytearray | memoryview = b"",
        *,
        allow_dangerous: bool = False,
        allow_laser: bool = False,
    ) -> bytes:
        """Sends an arbitrary frame and returns the parameters of the answer.

        :param id: id of the command, 0 to 255.
        :param ctrl: control byte: 0 a get, 1 a set, 3 a queued set.
        :param params: the parameters, at most 248 bytes: ``bytes(commands.PtpCommonParams(50, 50))``.
        :param allow_dangerous: as for :meth:`set`.
        :param allow_laser: as for :meth:`set`.
        """
        id, ctrl = whole("id", id, 0, 255), whole("ctrl", ctrl, 0, 255)
        if isinstance(params, (str, int)):  # bytes() would accept these with another meaning
            raise TypeError(f"params are bytes, not {params!r}")
        allowed = flag("allow_dangerous", allow_dangerous), flag("allow_laser", allow_laser)
        return await until(self._core.raw(id, ctrl, bytes(params), *allowed))

    # Programs.

    @overload
    async def perform(
        self,
        program: Iterable[Queueable],
        *,
        progress: Callable[[Progress], object] | None = None,
        skip: Collection[Check] = (),
        require_homed: bool = False,
        keep: bool = False,
        allow_laser: bool = False,
        wait: Literal[True] = True,
    ) -> Ran: ...
    @overload
    async def perform(
        self,
        program: Iterable[Queueable],
        *,
        skip: Collection[Check] = (),
        require_homed: bool = False,
        keep: bool = False,
        allow_laser: bool = False,
        wait: Literal[False],
    ) -> Motion[Ran]: ...
    async def perform(
        self,
        program: Iterable[Queueable],
        *,
        progress: Callable[[Progress], object] | None = None,
        skip: Collection[Check] = (),
        require_homed: bool = False,
        keep: bool = False,
        allow_laser: bool = False,
        wait: bool = True,
    ) -> Ran | Motion[Ran]:
        """Checks commands from the arm's current pose and settings, runs them, and waits until they have finished.
        Nothing is sent before the check passes.

        Any number of commands is fed through the arm's queue. :mod:`magician.words` builds them.

        :param progress: called now and then with the progress, while this call waits.
        :param skip: checks to leave out.
        :param require_homed: refuses an arm whose alarms say that it was not homed since it was switched on.
        :param keep: runs commands of an earlier program that still wait in the queue, before these.
        :param allow_laser: Whether the laser of an arm that is not virtual may burn.
        :param wait: Whether to wait for the end. ``False`` returns a :class:`Motion` at once.

        Raises :class:`~magician.errors.UnreachableError` with value and limit and
        :class:`~magician.errors.InvalidInputError` from the check, :class:`~magician.errors.AlarmError` as soon as an
        alarm holds the queue, :class:`~magician.errors.ClosedError` after a stop, else as :meth:`enqueue`.
        """
        asked = flags(require_homed=require_homed, keep=keep, allow_laser=allow_laser)
        names, hear = _names(skip), _hearing(progress)
        given = command_list(program)
        if hear is None or not flag("wait", wait):
            if hear is not None:
                raise InvalidInputError(_PROGRESS_WAITS)
            motion = await self._go(performing(self._core, given, skip=names, **asked), wait)
            return await motion.wait() if wait else motion
        await self._settle()
        call = self._core.perform(await self._kept(given), names, **asked)
        return Ran(*await until_done(call, self._core, hear))

    async def _kept(self, program: Iterable[Queueable]) -> Sequence[Queueable]:
        """Fills in r of each command from the arm's current pose."""
        given = command_list(program)
        return fill_r(given, (await self._known_pose()).r) if any(map(keeps_r, given)) else given

    async def estimate(self, program: Iterable[Queueable], *, skip: Collection[Check] = ()) -> float:
        """Checks commands from the arm's current pose and settings, and returns their duration, s.

        The duration is simulated, with a resolution of 1 µs; ``math.inf`` if the end of a command is unknown: homing, a
        wait for an input. Raises as the check of :meth:`perform`.
        """
        names = _names(skip)
        return await until(self._core.estimate(await self._kept(program), names))

    def begin(
        self,
        program: Iterable[Queueable],
        *,
        keep: bool = False,
        horizon: float = 2.0,
        laser_horizon: float = 1.0,
        trust_pose: bool = False,
        patience: float = 30.0,
        allow_laser: bool = False,
    ) -> Run:
        """Prepares a run that can resume after the line was lost. Nothing is sent before :meth:`Run.finish`, and
        nothing is checked.

        :param keep: runs commands of an earlier program that still wait in the queue, before these.
        :param horizon: maximum duration of queued motion, s. It bounds how long the arm moves on if this program dies,
            as the arm has no watchdog. At least two commands are always queued.
        :param laser_horizon: the same while the laser may be lit.
        :param trust_pose: resumes an interrupted run even if the end pose of its last finished command is unknown.
        :param patience: maximum time to wait for a silent arm while the line is up, s; at least the timeout of single
            calls. Meanwhile ``silent`` of the progress is the time since the last answer.
        :param allow_laser: Whether the laser of an arm that is not virtual may burn.
        """
        how = {
            **flags(keep=keep, trust_pose=trust_pose, allow_laser=allow_laser),
            "horizon": seconds("horizon", horizon),
            "laser_horizon": seconds("laser_horizon", laser_horizon),
            "patience": seconds("patience", patience),
        }
        return Run(self._core, self._core.begin(fill_r(program, None), how))

    # Motion: each of these waits for its end, unless wait=False.

    async def home(self, *, wait: bool = True) -> Motion[None]:
        """Homes the arm, waits for the end (up to half a minute), and clears the alarms (document 1.6.2). Programs on
        this computer treat the arm as homed until it is switched off."""
        return await self._go(homing(self._core), wait)

    async def touch_off(self, *, unhomed: bool = False) -> Surface:
        """Sets the height of the level work surface to the current height of the tool tip, without motion::

            arm.line_to(220, 0, -55)      # down to the paper, by small steps
            plan = magician.load("house.svg", surface=arm.touch_off())

        The height of a real arm is stored in the settings file, as by ``magician calibrate surface``. The command line
        and a station use it from then on; :func:`magician.calibrate.saved` reads it back.

        :param unhomed: Whether to accept a real arm that is not known to be homed since power-up. The height may then
            be wrong.
        :raises InvalidInputError: The arm moves, its laser is on, it is not known to be homed, or its poses are for a
            tool that ends at another height than the one that draws; or the settings keep a sheet, whose height takes
            precedence.
        """
        return Surface(await until(self._core.touch_off(flag("unhomed", unhomed))))

    @overload
    async def move_to(
        self,
        x: float,
        y: float,
        z: float,
        r: float | None = None,
        *,
        linear: bool = False,
        rail: float | None = None,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    @overload
    async def move_to(
        self,
        to: Target | str,
        /,
        *,
        r: float | None = None,
        linear: bool = False,
        rail: float | None = None,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    async def move_to(
        self,
        x: Any,
        y: float | None = None,
        z: float | None = None,
        r: float | None = None,
        *,
        linear: bool = False,
        rail: float | None = None,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Moves to a pose, with joint interpolation or on a straight line, and waits for the end.

        :param x: mm forward from the base axis; or a pose, or a sequence x, y, z and optionally r:
            ``arm.move_to(arm.pose())``; or the name of one of :attr:`poses`.
        :param y: mm to the arm's left.
        :param z: mm up from the shoulder axis; the table is below 0.
        :param r: rotation of the tool, degrees; left out keeps it.
        :param linear: whether the tool moves on a straight line.
        :param rail: target on the rail, mm (0 to 1000), reached at the same time.
        :param speed: Speed and acceleration ratio for this move alone, percent, as :meth:`speed` sets it for all moves.
        :param wait: Whether to wait for the end. ``False`` returns a :class:`Motion` at once.

        Raises :class:`~magician.errors.UnreachableError` with both values, before anything is sent, else as
        :meth:`perform`.
        """
        to = self._place(x, y, z, r)
        move: words.Move = words.line_to(*to) if linear else words.move_to(*to)
        return await self._move(move if rail is None else words.with_rail(move, rail), speed=speed, wait=wait)

    @overload
    async def line_to(
        self, x: float, y: float, z: float, r: float | None = None, *, speed: float | None = None, wait: bool = True
    ) -> Motion[Ran]: ...
    @overload
    async def line_to(
        self, to: Target | str, /, *, r: float | None = None, speed: float | None = None, wait: bool = True
    ) -> Motion[Ran]: ...
    async def line_to(
        self,
        x: Any,
        y: float | None = None,
        z: float | None = None,
        r: float | None = None,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Moves to a pose on a straight line (mm, degrees; r is kept if left out) and waits for the end. Parameters as
        for :meth:`move_to`.
        """
        return await self._move(words.line_to(*self._place(x, y, z, r)), speed=speed, wait=wait)

    @overload
    async def jump_to(
        self,
        x: float,
        y: float,
        z: float,
        r: float | None = None,
        *,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    @overload
    async def jump_to(
        self,
        to: Target | str,
        /,
        *,
        r: float | None = None,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    async def jump_to(
        self,
        x: Any,
        y: float | None = None,
        z: float | None = None,
        r: float | None = None,
        *,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Jumps to a pose over obstacles: up, across, down (mm, degrees; r is kept if left out). Waits for the end.
        Parameters as for :meth:`move_to`.

        :meth:`jump_height` says how high. ``linear``: across on a straight line (E28: seen to do nothing on some
        firmware).
        """
        to = self._place(x, y, z, r)
        move = words.jump_line_to(*to) if linear else words.jump_to(*to)
        return await self._move(move, speed=speed, wait=wait)

    async def pick(
        self,
        at: Target | str,
        *,
        tool: Literal["suction", "gripper"] = "suction",
        approach: float = 40.0,
        retreat: float | None = None,
        hold: float | None = None,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Picks up an object: moves above it, straight down, suction on or gripper closed, straight up. All of it is
        checked before it starts.

        :param at: Grip position: a pose, a sequence x, y, z and optionally r, or the name of one of :attr:`poses`.
        :param tool: Gripping tool. A gripper opens on the way down.
        :param approach: Height above the object where the descent begins, mm.
        :param retreat: Height of the lift, mm; ``approach`` if left out.
        :param hold: Time that the tool needs to grip, s: 0.3 for suction and 0.5 for a gripper if left out.
        :param speed: As for :meth:`move_to`.
        :param wait: As for :meth:`move_to`.
        """
        x, y, z, r = self._place(at)
        return await self._move(*picking((x, y, z), r, tool, approach, retreat, hold), speed=speed, wait=wait)

    async def pick_from_belt(
        self,
        at: Target | str,
        belt: Belt,
        *,
        since: float | None = None,
        tool: Literal["suction", "gripper"] = "suction",
        approach: float = 40.0,
        retreat: float | None = None,
        hold: float | None = None,
        speed: float | None = None,
        lead: float = 0.0,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Picks up an object from a running belt. The arm moves above the earliest meeting point, waits there, and
        descends so that it arrives together with the object. Suction is on from the start.

        The meeting point is computed from simulated durations; all of it is checked before anything moves.

        ::

            arm.conveyor(0, 40)
            seen = arm.infrared_edge("GP2")
            arm.pick_from_belt((180, -150, -30), Belt(40), since=seen)

        :param at: Grip position at time ``since``: a pose, a sequence x, y, z and optionally r, or the name of one of
            :attr:`poses`.
        :param belt: Speed and direction of the belt.
        :param since: Time at which the object was at ``at``: the arm's :meth:`clock`, s; now if left out.
        :param tool: Gripping tool. A gripper closes on arrival; the belt moves on while it closes.
        :param approach: As for :meth:`pick`.
        :param retreat: As for :meth:`pick`.
        :param hold: As for :meth:`pick`.
        :param speed: As for :meth:`move_to`.
        :param lead: Time by which the arm arrives earlier, s. Use it if the arm is seen to arrive late because of a
            slow line or arm.
        :param wait: As for :meth:`move_to`. Without ``since``, "now" is when it was called.
        :raises UnreachableError: The object never comes within reach, or leaves it before the arm can arrive. Nothing
            has moved.
        :raises ResponseTimeoutError: The arm was above the meeting point too late, and stays there.
        """
        x, y, z, r = self._place(at)
        lead = number("lead", lead, least=-10, most=10, unit="s")
        percent = number("speed", speed, above=0, most=100, unit="%")
        instant = number("since", since, least=0, unit="s")
        velocity = instance("belt", belt, Belt, "Belt(40, direction=90) is one").velocity
        if instant is None and not flag("wait", wait):
            # The position holds for the time of the call, however long earlier motions take.
            instant = await self.clock()

        def made(place: tuple[float, float, float], r: float) -> tuple[list[Queueable], list[Queueable]]:
            return meeting(place, r, tool, approach, retreat, hold, percent)

        made((x, y, z), 0 if r is None else r)
        return await self._go(
            intercepting(self._core, (x, y, z), r, velocity, instant, made, approach, lead, percent), wait
        )

    async def place(
        self,
        at: Target | str,
        *,
        tool: Literal["suction", "gripper"] = "suction",
        approach: float = 40.0,
        retreat: float | None = None,
        hold: float | None = None,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Places the held object: moves above the target, straight down, suction off or gripper open, straight up.
        Parameters as for :meth:`pick`.
        """
        x, y, z, r = self._place(at)
        return await self._move(*placing((x, y, z), r, tool, approach, retreat, hold), speed=speed, wait=wait)

    async def move_by(
        self,
        dx: float = 0,
        dy: float = 0,
        dz: float = 0,
        dr: float = 0,
        *,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Moves by a distance (mm, degrees) from the current pose: ``arm.move_by(dz=20)``."""
        word = words.line_by if linear else words.move_by
        return await self._move(word(dx, dy, dz, dr), speed=speed, wait=wait)

    async def line_by(
        self,
        dx: float = 0,
        dy: float = 0,
        dz: float = 0,
        dr: float = 0,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Moves by a distance (mm, degrees) from the current pose, on a straight line."""
        return await self.move_by(dx, dy, dz, dr, linear=True, speed=speed, wait=wait)

    @overload
    async def move_joints(
        self,
        j1: float,
        j2: float,
        j3: float,
        j4: float | None = None,
        *,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    @overload
    async def move_joints(
        self,
        to: JointTarget,
        /,
        *,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    async def move_joints(
        self,
        j1: Any,
        j2: float | None = None,
        j3: float | None = None,
        j4: float | None = None,
        *,
        linear: bool = False,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Moves to joint angles, degrees, or to those of a pose; j4 is kept if left out. ``linear`` moves the tool on a
        straight line.
        """
        word = words.line_joints if linear else words.move_joints
        return await self._turn(word, joints(j1, j2, j3, j4), speed, wait)

    @overload
    async def line_joints(
        self,
        j1: float,
        j2: float,
        j3: float,
        j4: float | None = None,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    @overload
    async def line_joints(
        self,
        to: JointTarget,
        /,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    async def line_joints(
        self,
        j1: Any,
        j2: float | None = None,
        j3: float | None = None,
        j4: float | None = None,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Moves to joint angles, degrees, with the tool on a straight line; j4 is kept if left out."""
        return await self._turn(words.line_joints, joints(j1, j2, j3, j4), speed, wait)

    @overload
    async def jump_joints(
        self,
        j1: float,
        j2: float,
        j3: float,
        j4: float | None = None,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    @overload
    async def jump_joints(
        self,
        to: JointTarget,
        /,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]: ...
    async def jump_joints(
        self,
        j1: Any,
        j2: float | None = None,
        j3: float | None = None,
        j4: float | None = None,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Jumps to joint angles, degrees, over obstacles; j4 is kept if left out."""
        return await self._turn(words.jump_joints, joints(j1, j2, j3, j4), speed, wait)

    async def _turn(
        self,
        word: Callable[[float, float, float, float], Queueable],
        to: tuple[float, float, float, float | None],
        speed: float | None,
        wait: bool,
    ) -> Motion[Ran]:
        j1, j2, j3, j4 = to

        def make(pose: Pose | None) -> Sequence[Queueable]:
            return [word(j1, j2, j3, pose.j4 if pose is not None and j4 is None else j4 or 0.0)]

        percent = number("speed", speed, above=0, most=100, unit="%")
        return await self._go(performing(self._core, make, asks=j4 is None, speed=percent), wait)

    async def move_joints_by(
        self,
        d1: float = 0,
        d2: float = 0,
        d3: float = 0,
        d4: float = 0,
        *,
        speed: float | None = None,
        wait: bool = True,
    ) -> Motion[Ran]:
        """Turns the joints by these angles, degrees, relative to their current ones."""
        return await self._move(words.move_joints_by(d1, d2, d3, d4), speed=speed, wait=wait)

    async def arc_to(self, via: Four, to: Four, *, speed: float | None = None, wait: bool = True) -> Motion[Ran]:
        """Moves to ``to`` along the arc through ``via``; both are x, y, z, r (document 1.12.2, E33).

        :param speed: Speed ratio for this arc alone, percent.
        :param wait: As for :meth:`move_to`.
        """
        return await self._arc(words.arc_to(via, to), speed, wait)

    async def circle(
        self, via: Four, over: Four, turns: int = 1, *, speed: float | None = None, wait: bool = True
    ) -> Motion[Ran]:
        """Moves along the circle through the current pose, ``via`` and ``over`` (x, y, z, r), back to the current pose.

        :param speed: As for :meth:`arc_to`.
        :param wait: As for :meth:`move_to`.
        """
        return await self._arc(words.circle(via, over, turns), speed, wait)

    async def _arc(self, arc: Queueable, speed: float | None, wait: bool) -> Motion[Ran]:
        percent = number("speed", speed, above=0, most=100, unit="%")
        return await self._go(performing(self._core, [arc], speed=percent, arc=True), wait)

    async def path_to(self, x: float, y: float, z: float, *, wait: bool = True) -> Motion[Ran]:
        """Moves to a point, mm, as a continuous path of one segment. Build longer paths with :func:`words.path_to`.
        There is no ``speed`` because the controller does not scale paths: :meth:`path_speed` sets their speed.
        """
        return await self._move(words.path_to(x, y, z), wait=wait)

    async def path_by(self, dx: float = 0, dy: float = 0, dz: float = 0, *, wait: bool = True) -> Motion[Ran]:
        """Moves by a distance, mm, from the current pose, as :meth:`path_to`."""
        return await self._move(words.path_by(dx, dy, dz), wait=wait)

    async def wait(self, seconds: float) -> None:
        """Holds the arm's queue for a time, s, and waits. A virtual arm's clock advances, unlike with
        :func:`time.sleep`."""
        await self._move(words.wait(seconds))

    async def wait_for_level(self, address: PinLike, high: bool) -> None:
        """Waits until a digital input (EIO address 1 to 20) has this level, without timeout (document 1.14.1)."""
        await self._move(words.wait_for_level(address, high))

    async def wait_below(self, address: PinLike, threshold: int) -> None:
        """Waits until an analog input (EIO address 1 to 20) is below a threshold (0 to 4095 counts, 4095 at 3.3 V)."""
        await self._move(words.wait_below(address, threshold))

    async def wait_at_most(self, address: PinLike, threshold: int) -> None:
        """Waits until the input is at most the threshold, as :meth:`wait_below`."""
        await self._move(words.wait_at_most(address, threshold))

    async def wait_at_least(self, address: PinLike, threshold: int) -> None:
        """Waits until the input is at least the threshold, as :meth:`wait_below`."""
        await self._move(words.wait_at_least(address, threshold))

    async def wait_above(self, address: PinLike, threshold: int) -> None:
        """Waits until the input is above the threshold, as :meth:`wait_below`."""
        await self._move(words.wait_above(address, threshold))

    async def check_lost_steps(self) -> None:
        """Checks for lost steps: compares the joints with their sensors. A lost step raises an alarm (E36)."""
        await self._move(words.check_lost_steps())

    # The rail.

    async def rail(self, on: bool, version: RailVersion | int | str) -> None:
        """Sets whether the arm is mounted on a rail, and the rail's version (document 1.3.4, E15)."""
        await self.set(words.rail(on, version))

    async def move_with_rail(
        self, x: float, y: float, z: float, r: float, rail: float, *, speed: float | None = None, wait: bool = True
    ) -> Motion[Ran]:
        """Moves to a pose and to ``rail`` mm on the rail (0 to 1000) at the same time."""
        return await self._move(words.move_with_rail(x, y, z, r, rail), speed=speed, wait=wait)

    async def rail_to(self, position: float, *, speed: float | None = None, wait: bool = True) -> Motion[Ran]:
        """Moves only the carriage, to this position on the rail, mm (0 to 1000)."""
        there = words.rail_to(position, Pose(0, 0, 0, 0, (0, 0, 0, 0))).l

        def make(pose: Pose | None) -> Sequence[Queueable]:
            assert pose is not None
            return [words.rail_to(there, pose)]

        percent = number("speed", speed, above=0, most=100, unit="%")
        return await self._go(performing(self._core, make, asks=True, speed=percent), wait)

    async def rail_by(self, distance: float, *, speed: float | None = None, wait: bool = True) -> Motion[Ran]:
        """Moves only the carriage, by this distance, mm."""
        return await self._move(words.rail_by(distance), speed=speed, wait=wait)

    # Speeds and jump height, from the next motion on.

    async def speed(self, velocity: float, acceleration: float | None = None) -> None:
        """Sets the speed and acceleration ratios of point-to-point moves, percent (document 1.10.4).

        Above 0; more than 100 counts as 100. The acceleration ratio equals the velocity ratio if left out.
        """
        await self.set(words.speed(velocity, acceleration))

    async def joint_speed(self, velocity: Four, acceleration: Four) -> None:
        """Sets speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in point-to-point moves (document 1.10.1)."""
        await self.set(words.joint_speed(velocity, acceleration))

    async def line_speed(self, velocity: float, acceleration: float) -> None:
        """Sets speed (mm/s) and acceleration (mm/s2) of the tool on straight lines (document 1.10.2)."""
        await self.set(words.line_speed(velocity, acceleration))

    async def path_speed(self, velocity: float, acceleration: float) -> None:
        """Sets maximum speed (mm/s) and acceleration (mm/s2) of continuous paths (document 1.11.1, E31)."""
        await self.set(words.path_speed(velocity, acceleration))

    async def arc_speed(self, velocity: float, acceleration: float) -> None:
        """Sets speed (mm/s) and acceleration (mm/s2) of arcs and circles (document 1.12.1).

        In the vendor's code arcs use the speeds of :meth:`line_speed` instead (model section 9): set both.
        """
        await self.set(words.arc_speed(velocity, acceleration))

    async def rail_speed(self, velocity: float, acceleration: float) -> None:
        """Sets speed (mm/s) and acceleration (mm/s2) of the rail (document 1.10.6, E26)."""
        await self.set(words.rail_speed(velocity, acceleration))

    async def jump_height(self, height: float, z_limit: float) -> None:
        """Sets the lift of jumps above the higher end, and the upper z limit, mm (document 1.10.3, E30)."""
        await self.set(words.jump_height(height, z_limit))

    async def jump_heights(self, start: float, end: float, z_limit: float) -> None:
        """Sets the lift of jumps above start and end, and the upper z limit, mm (document 1.10.8, E27)."""
        await self.set(words.jump_heights(start, end, z_limit))

    async def jog_speed(self, velocity: float, acceleration: float | None = None) -> None:
        """Sets the jog speed ratio, percent (document 1.9.3)."""
        await self.set(words.jog_speed(velocity, acceleration))

    async def jog_joint_speed(self, velocity: Four, acceleration: Four) -> None:
        """Sets speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in joint jogs (document 1.9.1)."""
        await self.set(words.jog_joint_speed(velocity, acceleration))

    async def jog_axis_speed(self, velocity: Four, acceleration: Four) -> None:
        """Sets speeds (mm/s; deg/s for r) and accelerations of x, y, z and r in Cartesian jogs (document 1.9.2)."""
        await self.set(words.jog_axis_speed(velocity, acceleration))

    async def jog_rail_speed(self, velocity: float, acceleration: float) -> None:
        """Sets speed (mm/s) and acceleration (mm/s2) of rail jogs (document 1.9.5, E25)."""
        await self.set(words.jog_rail_speed(velocity, acceleration))

    async def home_at(self, x: float, y: float, z: float, r: float) -> None:
        """Sets the home point, where :meth:`home` ends from now on (document 1.6.1)."""
        await self.set(words.home_at(x, y, z, r))

    async def lost_step_threshold(self, degrees: float) -> None:
        """Sets the lost-step threshold: the deviation from which a joint has lost steps, degrees; 5 at power-up
        (document 1.18.1)."""
        await self.set(words.lost_step_threshold(degrees))

    # Tool, pins, motors and sensors, at once.

    async def tool(self, name: Tool | None = None, *, x: float = 0, y: float = 0, z: float = 0) -> None:
        """Sets the tool: its name, or the offset of its tip, x, y, z in mm from the wrist. Later poses refer to this
        tip."""
        await self.set(words.tool(name, x=x, y=y, z=z))

    async def suction(self, on: bool) -> None:
        """Switches the suction cup on or off; it takes about 0.3 s to hold (document 1.8.3)."""
        await self.set(words.suction(on))

    async def grip(self) -> None:
        """Closes the gripper, in about 0.5 s (document 1.8.4)."""
        await self.set(words.grip())

    async def release(self) -> None:
        """Opens the gripper."""
        await self.set(words.release())

    async def pump_off(self) -> None:
        """Switches the air pump off; suction cup and gripper go limp."""
        await self.set(words.pump_off())

    async def laser(self, on: bool, *, allow_laser: bool = False) -> None:
        """Switches the laser to full power or off (document 1.8.2). It is switched off when the connection ends without
        :meth:`detach`, and at the end of a ``with`` block.

        :param allow_laser: Whether the laser of an arm that is not virtual may burn; off takes no permission.
        """
        await self.set(words.laser(on), allow_laser=allow_laser)

    async def multiplex(self, address: PinLike, function: FunctionLike) -> None:
        """Sets the function of an EIO pin (1 to 20), before the pin can be used (document 1.15.1, E40)."""
        await self.set(words.multiplex(address, function))

    async def output(self, address: PinLike, high: bool, *, allow_laser: bool = False) -> None:
        """Sets the level of a digital output (EIO address 1 to 20; document 1.15.2).

        :param allow_laser: Whether the laser's pins, EIO 2 and 4, of an arm that is not virtual may be raised.
        :raises InvalidInputError: The pin is not a digital output: call :meth:`multiplex` first.
        """
        await self._drive(words.output(address, high), allow_laser)

    async def pwm(self, address: PinLike, frequency: float, duty_cycle: float, *, allow_laser: bool = False) -> None:
        """Sets a pulse-width output (EIO address 1 to 20): frequency, Hz (10 to 1000000), and duty cycle, percent.

        :param allow_laser: Whether the laser's pin, EIO 4, of an arm that is not virtual may be driven.
        :raises InvalidInputError: The pin is not a pulse-width output: call :meth:`multiplex` first.
        """
        await self._drive(words.pwm(address, frequency, duty_cycle), allow_laser)

    async def servo(self, address: PinLike, pulse_ms: float) -> None:
        """Sets the position of a hobby servo on a pulse-width pin by its pulse width: 1 to 2 ms, 1.5 ms being the
        centre of most servos."""
        await self._drive(words.servo(address, pulse_ms), False)

    async def _drive(self, command: commands.IoDo | commands.IoPwm, allow_laser: bool) -> None:
        await until(self._core.drive(command, flag("allow_laser", allow_laser)))

    async def level_at(self, address: PinLike) -> bool:
        """Reads the level of a digital input (EIO address 1 to 20; document 1.15.4)."""
        return (await self.get(words.level_at(address))).level

    async def analog_at(self, address: PinLike) -> float:
        """Reads the voltage at an analog input (EIO address 1 to 20), V, 0 to 3.3 (document 1.15.5)."""
        return (await self.get(words.analog_at(address))).volts

    async def motor(self, index: StepperLike, speed: int) -> None:
        """Runs an external motor at a speed in pulses/s, whose sign is the direction; 0 stops it (document 1.15.6).

        It runs until stopped, by `stop` or the end of the connection.
        """
        await self.set(words.motor(index, speed))

    async def motor_by(self, index: StepperLike, speed: int, distance: int, *, wait: bool = True) -> Motion[Ran]:
        """Runs an external motor for a number of pulses and waits; the sign of the speed is the direction."""
        return await self._move(words.motor_by(index, speed, distance), wait=wait)

    async def conveyor(self, index: StepperLike, mm_per_s: float) -> None:
        """Runs the conveyor belt on this motor output at a speed in mm/s, whose sign is the direction; 0 stops it.

        It runs until stopped, by `stop` or the end of the connection.
        """
        await self.set(words.conveyor(index, mm_per_s))

    async def conveyor_by(self, index: StepperLike, mm: float, mm_per_s: float, *, wait: bool = True) -> Motion[Ran]:
        """Moves the conveyor belt on this motor output by a distance in mm and waits until it is at rest."""
        return await self._move(words.conveyor_by(index, mm, mm_per_s), wait=wait)

    async def infrared_edge(self, port: PortLike, timeout: float | None = None) -> float:
        """Waits for a rising edge of the infrared sensor on a port, and returns its time: the arm's :meth:`clock`, s.
        An object that is already detected must leave first.

        :param timeout: Maximum time to wait, seconds; none if left out.
        :raises ResponseTimeoutError: No object came before the timeout.
        """
        limit = None if timeout is None else monotonic() + seconds("timeout", timeout)
        seen = True
        while True:
            before, seen = seen, await self.infrared_at(port)
            if seen and not before:
                return await self.clock()
            if limit is not None and monotonic() >= limit:
                raise ResponseTimeoutError(f"nothing came before the sensor in {timeout:g} s")

    async def color_sensor(self, port: PortLike, on: bool, version: VersionLike) -> None:
        """Switches the colour sensor on a port (document 1.15.7, E42)."""
        await self.set(words.color_sensor(port, on, version))

    async def color_at(self, port: PortLike) -> Color | None:
        """Reads the colour from the sensor on a port; ``None`` if two channels are equally strong."""
        return (await self.get(words.color_at(port))).color

    async def infrared(self, port: PortLike, on: bool, version: VersionLike) -> None:
        """Switches the infrared sensor on a port (document 1.15.8, E43)."""
        await self.set(words.infrared(port, on, version))

    async def infrared_at(self, port: PortLike) -> bool:
        """True if the infrared sensor on a port detects an object."""
        return (await self.get(words.infrared_at(port))).state

    # Queue and stop.

    async def start_queue(self, *, allow_laser: bool = False) -> None:
        """Starts the queue once the arm is at rest (document 1.19.1), because a start may abort the motion under way.

        :param allow_laser: on a real arm, starts the queue even if it holds commands of another program, which may burn
            and cannot be read back.
        """
        await until(self._core.start_queue(flag("allow_laser", allow_laser)))

    async def clear_queue(self) -> None:
        """Clears the queue; the motion under way may be aborted (document 1.19.6). Ends a run under way."""
        self._drop()
        await self.set(commands.QueuedCmdClear())

    async def current_index(self) -> int:
        """Returns the index of the last finished queued command; 0 before the first (document 1.19.7)."""
        return (await self.get(commands.QueuedCmdCurrentIndex)).queued_cmd_current_index

    async def left_space(self) -> int:
        """Returns the number of free places in the arm's queue (document 1.19.8)."""
        return (await self.get(commands.QueuedCmdLeftSpace)).left_space

    async def wait_for(self, index: int, *, progress: Callable[[Progress], object] | None = None) -> None:
        """Waits until the queued command with this index has finished. Detects alarms and standstill.

        Raises :class:`~magician.errors.AlarmError` when an alarm holds the queue, :class:`~magician.errors.ClosedError`
        after a stop, :class:`~magician.errors.ResponseTimeoutError` when the queue makes no progress: soon if this
        connection has stopped it, after five seconds if this connection has not started it, since another program may
        start it.
        """
        index = whole("index", index, 0, 0xFFFF_FFFF_FFFF_FFFF)
        await until_done(self._core.wait_for(index), self._core, _hearing(progress))

    async def wait_still(self) -> None:
        """Waits until the arm is at rest: three equal poses over two periods of 20 ms.

        Raises :class:`~magician.errors.ResponseTimeoutError` when it is still moving after five seconds.
        """
        await until_done(self._core.wait_still(), self._core)

    async def stop(self) -> None:
        """Stops the motion, switches the laser off, clears the queue, and waits until the arm is at rest.

        A stop overtakes all other calls; unsent commands end with :class:`~magician.errors.ClosedError`.
        Suction and gripper stay as they are. Any thread or task may call it while others wait.

        Raises :class:`~magician.errors.ResponseTimeoutError` when the arm does not answer or does not stop.
        """
        self._drop()
        await until(self._core.stop())

    def request_stop(self) -> None:
        """Stops the arm as :meth:`stop` does, but returns at once: for signal handlers, callbacks and other threads.

        The stop is sent ahead of all other requests, and retransmitted for up to three seconds until it is answered.
        While the line is lost, it becomes the first request after reconnecting.
        """
        self._drop()
        self._core.request_stop()

    async def stop_gentle(self) -> None:
        """Stops the queue after the command under way (document 1.19.2).

        Waiting commands stay; :meth:`start_queue` resumes them. Ends a run under way.
        """
        self._drop()
        await until(self._core.stop_gentle())

    # Jogging.

    def jog(self, direction: Direction | commands.JogCmd, *, keep: float = 0.3, ratio: float | None = None) -> Jog:
        """Jogs a coordinate, a joint or the rail while a ``with`` block calls ``keep``: a dead man's switch.

        ::

            async with arm.jog("x+", ratio=20) as jog:
                while button_is_pressed():
                    jog.keep()

        A jog bypasses the queue and acts at once. A new jog replaces the one under way.

        :param direction: ``"x+"`` to ``"r-"`` a coordinate, ``"j1+"`` to ``"j4-"`` a joint, ``"rail+"`` and
            ``"rail-"``.
        :param keep: keep-alive timeout, s, 0.02 to 2: the jog ends unless :meth:`Jog.keep` was called.
        :param ratio: jog speed ratio, 1 to 100 %. It is set before the jog and stays set; left unchanged if left out.

        The arm itself has no watchdog: if the computer fails or the cable breaks, a jog continues to the end of its
        range.
        """
        command = words.jog(direction) if isinstance(direction, str) else direction
        keep = seconds("keep", keep, least=0.02, most=2)
        return Jog(self._core, command, keep, number("ratio", ratio, least=1, most=100, unit="%"))

    async def stop_jog(self) -> None:
        """Ends any jog at once, and repeats this until the arm is at rest."""
        await until(self._core.stop_jog())

    # Programs.

    async def check(self, plan: Plan) -> Report:
        """Checks a plan from the arm's current pose and settings. Nothing moves."""
        start = await until(self._core.start_of(_plan(plan).native))
        return report(plan.native.check(start))

    async def preview(self, plan: Plan) -> Picture:
        """Draws a picture of a plan from the arm's current pose. Nothing moves."""
        start = await until(self._core.start_of(_plan(plan).native))
        return Picture(plan.native.preview(start, None, None))

    @overload
    async def run(
        self,
        program: Plan | Iterable[Queueable],
        *,
        progress: Watcher = False,
        first_step: int = 1,
        resume: bool = False,
        overlap: float = 0,
        check: bool = True,
        keep: bool = False,
        require_homed: bool = False,
        unhomed: bool = False,
        stay: bool = False,
        park: tuple[float, float, float] | None = None,
        lift: float | None = None,
        allow_laser: bool = False,
        restore: bool = True,
        wait: Literal[True] = True,
    ) -> RunResult: ...
    @overload
    async def run(
        self,
        program: Plan | Iterable[Queueable],
        *,
        first_step: int = 1,
        resume: bool = False,
        overlap: float = 0,
        check: bool = True,
        keep: bool = False,
        require_homed: bool = False,
        unhomed: bool = False,
        stay: bool = False,
        park: tuple[float, float, float] | None = None,
        lift: float | None = None,
        allow_laser: bool = False,
        restore: bool = True,
        wait: Literal[False],
    ) -> Job: ...
    async def run(
        self,
        program: Plan | Iterable[Queueable],
        *,
        progress: Watcher = False,
        first_step: int = 1,
        resume: bool = False,
        overlap: float = 0,
        check: bool = True,
        keep: bool = False,
        require_homed: bool = False,
        unhomed: bool = False,
        stay: bool = False,
        park: tuple[float, float, float] | None = None,
        lift: float | None = None,
        allow_laser: bool = False,
        restore: bool = True,
        wait: bool = True,
    ) -> RunResult | Job:
        """Runs a plan, or commands, and waits for the end. Everything is checked before anything is sent.

        The queue holds just enough commands that the arm never waits: if this program dies, at most two seconds of
        motion remain. If the wait ends early (Ctrl-C, a cancelled task, an exception in ``progress``), the arm stops
        first and lifts the pen of a drawing; notes on the exception report this and the number of finished steps. A
        second Ctrl-C, at least 0.5 s later, stops the arm at once without lifting the pen. Settings are restored in any
        case.

        :param program: A :class:`~magician.Plan`, or commands as :mod:`magician.words` makes them.
        :param progress: ``True`` shows a line on stderr; a function is called with a :class:`~magician.PlanProgress` up
            to 10 times a second.
        :param first_step: First step to run, counted from 1: settings of earlier steps are applied, and the arm
            approaches from above.
        :param resume: Resumes an interrupted run of the same plan, started from Python or the command line.
        :param overlap: With ``resume``: distance along the line by which a burn overlaps the burnt part, mm.
        :param check: Whether to refuse a plan that fails the check.
        :param keep: Whether to run commands first that an earlier program left in the queue.
        :param require_homed: Whether to refuse an arm that was not homed since power-up.
        :param unhomed: Whether to run on a real arm that is not known to be homed since power-up. Its positions may be
            wrong.
        :param stay: Whether the pen stays down at the end, and when the drawing is stopped, instead of going up.
        :param park: Final position (x, y, z) of the tool tip, mm: up first, then across.
        :param lift: Lift of the pen, mm; that of :func:`~magician.load`, or 10.
        :param allow_laser: Whether the laser of an arm that is not virtual may burn.
        :param restore: Whether speeds and jump heights that the plan changes are restored at its end.
        :param wait: Whether to wait for the end. ``False`` returns as soon as earlier motions have ended, with a
            :class:`Job`, as :meth:`start` does.
        :raises UnreachableError, InvalidInputError: The check refuses a step; the message names the step, the value
            and the limit.
        :raises AlarmError: An alarm holds the queue.
        :raises ClosedError: It was stopped.
        """
        check_progress(progress)
        if progress is not False and not flag("wait", wait):
            raise InvalidInputError(_PROGRESS_WAITS)
        if not isinstance(program, Plan):
            program = await self._kept(program)
        if flag("wait", wait) and isinstance(program, Plan):
            _check_pauses(program)
        await self._settle()
        job = self.start(
            program,
            first_step=first_step,
            resume=resume,
            overlap=overlap,
            check=check,
            keep=keep,
            require_homed=require_homed,
            unhomed=unhomed,
            stay=stay,
            park=park,
            lift=lift,
            allow_laser=allow_laser,
            restore=restore,
        )
        return await job.wait(progress=progress) if flag("wait", wait) else job

    def start(
        self,
        program: Plan | Iterable[Queueable],
        *,
        first_step: int = 1,
        resume: bool = False,
        overlap: float = 0,
        check: bool = True,
        keep: bool = False,
        require_homed: bool = False,
        unhomed: bool = False,
        stay: bool = False,
        park: tuple[float, float, float] | None = None,
        lift: float | None = None,
        allow_laser: bool = False,
        restore: bool = True,
    ) -> Job:
        """Starts a plan, or commands, and returns a :class:`Job` at once, which can wait, pause and resume.

        Parameters as for :meth:`run`. A job that is garbage-collected is stopped.

        >>> job = arm.start(plan)
        >>> job.pause()
        >>> arm.perform([words.line_by(dz=20)])
        >>> job.resume()
        >>> result = job.wait()
        """
        plan = program if isinstance(program, Plan) else Plan.of(not_a_file(program))
        how = {
            "first_step": whole("first_step", first_step, 1, max(1, len(plan))),
            "overlap": number("overlap", overlap, least=0, unit="mm"),
            **flags(resume=resume, check=check, keep=keep, require_homed=require_homed),
            **flags(unhomed=unhomed, allow_laser=allow_laser, restore=restore),
            **ending_options(stay, park, lift),
        }
        return Job(self._core, self._core.start(plan.native, how), len(plan))

    async def stream(
        self,
        # [aio]
        program: Iterable[Queueable | None] | AsyncIterable[Queueable | None],
        # [blocking]
        # program: Iterable[Queueable | None],
        # [both]
        *,
        ahead: int = 32,
        skip: Collection[Check] = (),
        allow_laser: bool = False,
    ) -> Ran:
        """Runs commands from a generator, possibly endless, and waits for the end.

        The next commands are fetched while the arm executes earlier ones, so the arm does not wait between them and a
        path passes its corners without a stop. The generator is at most ``ahead`` commands ahead of the arm. Each
        command is checked from the state that the earlier ones lead to, and then sent.

        The generator runs in the caller's thread and may block. Meanwhile the arm finishes its queue and rests. An
        error that ends the run (a stop, an alarm) is raised when the generator yields the next command; an asynchronous
        generator is cancelled at once. The generator may read the arm and its sensors, and stop it, but not move it. To
        wait for the arm or a sensor, it yields ``None`` repeatedly: it is resumed when the arm has finished a command,
        or after 10 ms, while a virtual arm's clock advances.

        An exception in the generator, Ctrl-C and a cancelled task stop the arm. A command that the check refuses does
        not: the earlier commands finish, and then the error is raised.

        ::

            def spiral():
                for nth in itertools.count():
                    angle, radius = nth / 10, 10 + nth / 50
                    yield words.path_to(220 + radius * cos(angle), radius * sin(angle), 20)

            arm.stream(spiral())

        :param program: A generator of commands, or any iterable.
        :param ahead: Maximum number of fetched but unfinished commands, 1 to 10000.
        :param skip: As for :meth:`perform`.
        :param allow_laser: As for :meth:`perform`. A lit laser is switched off while the generator yields no command.
        :raises UnreachableError, InvalidInputError: The check refuses a command; ``step`` is its index, from 0.
        :raises AlarmError: An alarm holds the queue.
        :raises ClosedError: It was stopped.
        """
        ahead, names = whole("ahead", ahead, 1, 10_000), _names(skip)
        coming = iterator_of(program)
        await self._settle()
        keeping = RFiller((await self._known_pose()).r)
        feed, running = self._core.stream(ahead, names, flag("allow_laser", allow_laser))
        return await self._feed_from(coming, feed, running, keeping)

    async def _feed_from(
        self,
        # [aio]
        coming: Iterator[Queueable | None] | AsyncIterator[Queueable | None],
        # [blocking]
        # coming: Iterator[Queueable | None],
        # [both]
        feed: Feed,
        running: Call[tuple[int, int | None, int | None]],
        keeping: RFiller,
    ) -> Ran:
        """Feeds the commands to a run, and waits for its end."""
        start_call(running)
        try:
            while feed.free() or await until(feed.room()):
                command = await until_next(coming, running)
                if command is None:
                    await until(feed.rest())
                else:
                    feed.push(keeping(command))
        except GeneratorEnd:
            feed.end()
        # [aio]
        except GeneratorExit:
            # The coroutine is being closed and cannot await: request the stop without waiting for it.
            running.cancel()
            raise
        # [both]
        except BaseException as error:
            running.cancel()
            self._drop()
            await until_stopped(self._core, error)
            raise
        return Ran(*await until_done(running, self._core))

    # Pictures.

    def record(
        self,
        path: str | os.PathLike[str],
        *,
        rate: float = 20.0,
        tolerance: float = 0.5,
        units: bool = False,
        overwrite: bool = False,
    ) -> Recording:
        """Records the motion of the arm to a file while a ``with`` block runs. The motion may come from this program,
        from a hand that holds the unlock key, or from another program.

        ``async with arm.record("day.csv") as recording``

        The file extension selects the format, as in ``magician record``: ``.mcap``, ``.csv`` and ``.jsonl`` are
        readings (time in s, pose and joints in mm and degrees, queue index and space, alarms); ``.plan.json`` is a
        program that repeats the motion at its own speed and with its pauses, ``.playback`` the same for DobotStudio,
        with a stop at each point; :func:`magician.load` reads both. It only reads. A virtual arm at full speed or in
        virtual time is sampled by its own clock while it moves, any other arm by the host's clock.

        :param path: The file.
        :param rate: Readings per second, 0.1 to 500; a line at 115200 baud carries about 50.
        :param tolerance: Largest deviation of the program from the recorded motion, mm, 0.01 to 100.
        :param units: Whether a ``.csv`` file has the units of its columns in a second line; it can be read back.
        :param overwrite: Whether an existing file may be replaced.
        :returns: The recording; for errors see :meth:`Recording.begin`.
        """
        return Recording(self._core, None, _recorded(path, rate, tolerance, units, overwrite))

    def teach(
        self, *, by: Literal["joints", "line", "jump"] = "joints", title: str = "", unhomed: bool = False
    ) -> Lesson:
        """Teaches a program by hand while a ``with`` block runs. Hold the unlock key on the forearm, move the arm, and
        release the key: each release adds a point.

        ``async with arm.teach() as lesson``

        Points are collected even if the program does not wait for them. Changed settings of the arm are restored at the
        end of the block, or by the next program if this one is killed.

        :param by: Motion to the points: joint interpolation, a straight line, or a jump (up, across, down).
        :param title: Title of the program.
        :param unhomed: Whether to teach on a real arm that is not known to be homed since power-up. The points may then
            be wrong.
        """
        return Lesson(self._core, text("title", title), text("by", by), **flags(unhomed=unhomed))

    async def picture(self) -> Picture:
        """Draws the arm's current pose, from above and from the side."""
        return Picture(await until(self._core.snapshot()))

    def _repr_svg_(self) -> str | None:
        # Notebooks call this synchronously, so block here even in asyncio. Without a picture they show the text.
        try:
            return self._core.snapshot().wait().svg
        except Error:
            return None


class Motion(Bound, Generic[_T]):
    """A motion started with ``wait=False``, which runs in the background.

    The motions of an arm run one after another. If one fails or is cancelled, later ones are dropped. If :meth:`wait`
    is not called, the next call that moves the arm, or the end of the ``with`` block, raises the error. A ``with``
    block that ends normally waits for the last motion.

    >>> motion = arm.move_to(220, 60, 20, wait=False)
    >>> motion.done()
    False
    >>> motion.wait()
    Ran(commands=1, first=1, last=1)
    """

    def __init__(self, core: Core, going: RunningMotion | FinishedMotion) -> None:
        self._core = core
        self._going = going

    def __repr__(self) -> str:
        return f"<Motion, {'under way' if not self.done() else 'done' if self._going.failure is None else 'failed'}>"

    def done(self) -> bool:
        """True if it has ended, successfully or not."""
        return self._going.over

    async def wait(self, timeout: float | None = None) -> _T:
        """Waits for the end and returns the result. Interrupting the wait stops the arm.

        :param timeout: Maximum time to wait, s; the motion continues after it.
        :raises ResponseTimeoutError: It was still under way after ``timeout``.
        :raises ClosedError: It was cancelled or stopped. Otherwise it raises the errors of the motion.
        """
        limit = None if timeout is None else seconds("timeout", timeout)
        found: _T = await until_ended(self._going, self._core, limit)
        return found

    # [aio]
    def __await__(self) -> Generator[Any, Any, _T]:
        return self.wait().__await__()

    # [both]
    def cancel(self) -> None:
        """Stops the arm if the motion has begun, and drops later motions. Returns at once.

        :meth:`wait` returns once the arm is at rest. Motions started after this call wait for that too.
        """
        self._going.cancel()


class Jog(Bound):
    """A jog: see :meth:`Arm.jog`. It starts with its ``with`` block and stops at the end of the block."""

    def __init__(self, core: Core, command: commands.JogCmd, keep: float, ratio: float | None) -> None:
        self._core = core
        self._how = (command, keep, ratio)
        self._jog: NativeJog | None = None

    def __repr__(self) -> str:
        return "<Jog>" if self._jog is None else "<Jog, under way>"

    async def __aenter__(self) -> Jog:
        self._jog = await until(self._core.jog(*self._how))
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        jog, self._jog = self._jog, None
        if jog is None:
            return
        try:
            await until(jog.stop())
        except Error:
            if error is None:
                raise

    def keep(self) -> None:
        """Renews the keep-alive timeout of the jog. Nothing is sent.

        Raises if the jog has ended: :class:`~magician.errors.ResponseTimeoutError` after the keep-alive timeout,
        :class:`~magician.errors.PortError` when the line was lost, :class:`~magician.errors.ClosedError` after a stop
        or another jog.
        """
        if self._jog is None:
            raise ClosedError("the jog has not begun, or was ended: it runs inside `with arm.jog(...) as jog`")
        self._jog.keep()


def _check_pauses(plan: Plan) -> None:
    for step, told in plan.pauses:
        raise InvalidInputError(
            f"the plan pauses at step {step} ({told}), and nobody could resume it: start() gives a job that can be "
            "resumed, and load(no_pause=True) never pauses"
        )


class Job(Bound):
    """A running plan: see :meth:`Arm.start`."""

    def __init__(self, core: Core, job: NativeJob, steps: int) -> None:
        self._core = core
        self._job = job
        self._steps = steps

    def __repr__(self) -> str:
        return f"<Job, {self.state}>"

    @property
    def state(self) -> str:
        """``checking``, ``running``, ``pausing``, ``paused``, ``stopping``, ``ending_options`` or ``ended``."""
        return self._job.state()

    @property
    def progress(self) -> PlanProgress:
        """Progress of the job."""
        done, left, silent = self._job.progress()
        return PlanProgress(done, self._steps, left, silent)

    async def pause(self) -> None:
        """Pauses the job, and returns when it is paused: the current stroke has ended, the queue is empty, the laser is
        off, the pen is up. The arm may then be moved. During the check the job pauses before anything is sent.

        :raises ClosedError: The job is ending or has ended.
        """
        await until(self._job.pause())

    @property
    def pause_reason(self) -> str | None:
        """Reason of the pause: ``person`` (requested), ``part`` (between two parts of a drawing), ``program`` (a pause
        in the plan). ``None`` while it is not paused.
        """
        found = self._job.pause_reason()
        return None if found is None else found[0]

    @property
    def pause_text(self) -> str | None:
        """Message for the operator at a pause, such as which pen to mount."""
        found = self._job.pause_reason()
        return None if found is None else found[2]

    async def paused(self) -> str | None:
        """Waits until the job is paused, and returns the message for the operator; it is empty at a requested pause.
        ``None`` if the job has ended; :meth:`wait` returns its result.

        >>> job = arm.start(magician.load("two.svg", surface=-60, parts="layer"))
        >>> while (text := job.paused()) is not None:
        ...     input(text)
        ...     job.resume()
        >>> result = job.wait()
        """
        return await until(self._job.paused())

    async def resume(self) -> None:
        """Resumes a paused job: moves above the point of the pause, down, and continues. A laser job burns again.

        :raises UnexpectedError: The arm was reset meanwhile, or its pose is uncertain: home it first.
        :raises InvalidInputError: The job is not paused, or the arm moves. After any error the job stays paused.
        """
        await until(self._job.resume())

    @property
    def speed(self) -> int:
        """Speed of unsent commands, percent of the plan's speed; initially 100."""
        return self._job.speed()

    def set_speed(self, percent: int) -> None:
        """Sets the speed of unsent commands, also after a pause, as a percentage of the plan's speed.

        Commands already in the arm keep their speed. The speed of a laser job can change only if all of its laser power
        is proportional to speed (M4); the power then follows.

        :param percent: 10 to 100.
        :raises InvalidInputError: The laser power of the job is set for one speed only.
        :raises ClosedError: The job is ending or has ended.
        """
        self._job.set_speed(int(number("percent", percent, least=10, most=100, unit="%")))

    def stop(self) -> None:
        """Stops the job, and returns at once. The arm stops, the laser is switched off, the pen is lifted; :meth:`wait`
        waits for this. A second stop ends the job without moving the pen.
        """
        self._job.stop()

    def cancel(self) -> None:
        """:meth:`stop`, under the common name of handles."""
        self.stop()

    def done(self) -> bool:
        """True if it has ended, successfully or not."""
        return self.state == "ended"

    # [aio]
    def __await__(self) -> Generator[Any, Any, RunResult]:
        return self.wait().__await__()

    # [both]
    async def wait(self, timeout: float | None = None, *, progress: Watcher = False) -> RunResult:
        """Waits for the end of the job. Interrupting the wait stops the job, as in :meth:`Arm.run`.

        :param timeout: Maximum time to wait, s; the job continues after it.
        :param progress: As in :meth:`Arm.run`.
        :raises ResponseTimeoutError: It was still under way after ``timeout``.
        :raises ClosedError: It was stopped; else as :meth:`Arm.run`.
        """
        check_progress(progress)
        telling = ProgressReporter(self._steps, progress)
        if timeout is not None:
            end = monotonic() + seconds("timeout", timeout)
            try:
                while not self.done() and monotonic() < end:
                    telling(self._job.progress())
                    await until_moment()
            except BaseException:
                self.stop()
                raise
            if not self.done():
                raise ResponseTimeoutError(f"the job is still under way after {timeout:g} s; it goes on")
        try:
            found = await until(self._job.outcome(), telling)
        except GeneratorExit:
            raise
        except BaseException as error:
            self._job.interrupted()
            telling.broken(error, await until_over(self._job))
            raise
        return telling.ended(found)


def record(
    arm: Arm | Where,
    path: str | os.PathLike[str],
    *,
    rate: float = 20.0,
    tolerance: float = 0.5,
    units: bool = False,
    overwrite: bool = False,
) -> Recording:
    """Records the motion of an arm to a file while a ``with`` block runs.

    ``async with record("/dev/ttyUSB0", "day.csv") as recording``

    :param arm: An arm, or a port as for :class:`Arm`, to which it connects for the duration of the recording.

    Other parameters as for :meth:`Arm.record`.
    """
    if isinstance(arm, Arm):
        return arm.record(path, rate=rate, tolerance=tolerance, units=units, overwrite=overwrite)
    return Recording(None, arm, _recorded(path, rate, tolerance, units, overwrite))


def _recorded(path: str | os.PathLike[str], rate: float, tolerance: float, units: bool, overwrite: bool) -> _Recorded:
    rate = number("rate", rate, least=0.1, most=500, unit="Hz")
    tolerance = number("tolerance", tolerance, least=0.01, most=100, unit="mm")
    return os.fspath(path), rate, tolerance, flag("units", units), flag("overwrite", overwrite)


class Recording(Bound):
    """A recording of an arm: see :meth:`Arm.record`. It starts with its ``with`` block, or with :meth:`begin`; at the
    end of the block, or after :meth:`finish`, the file is complete. Readings are written within a second, even if the
    program crashes. An existing file is replaced only at the end: until then the new one is ``NAME.partial``.
    """

    def __init__(self, core: Core | None, port: Where, how: _Recorded) -> None:
        self._core = core
        self._port = port
        self._how = how
        self._own: Core | None = None
        self._native: NativeRecording | None = None
        self._ended: tuple[float, int, float, int | None] | None = None

    async def begin(self) -> Recording:
        """Starts the recording, and returns when the arm has answered.

        :raises InvalidInputError: The file extension is not a recording format.
        :raises FileExistsError: The file exists, and ``overwrite`` was not given.
        :raises OSError: The file cannot be written.
        :raises ClosedError: The recording was started before.
        """
        if self._native is not None:
            raise ClosedError("the recording was begun before: make another one")
        path, rate, tolerance, units, overwrite = self._how
        if not overwrite and os.path.exists(path):
            raise FileExistsError(f"{path} already exists; overwrite=True replaces it")
        core = self._core
        if core is None:
            call = connecting(self._port, timeout=3.0, window=1, echo=0.1, probe=True, reconnect=True)
            core = self._own = opened(await until(call))
        try:
            self._native = await until(core.record(path, rate, tolerance, units))
        except BaseException:
            await self._leave()
            raise
        return self

    async def finish(self) -> Recording:
        """Takes a last reading and completes the file. A second call does nothing.

        :raises PortError: The line was lost; earlier readings are in the file.
        :raises OSError: The file cannot be written.
        """
        native = self._native
        if native is None:
            raise ClosedError("the recording has not begun")
        if not self._over:
            self._over = True
            try:
                self._ended = await until(native.finish())
            finally:
                await self._leave()
        return self

    _over = False

    async def _leave(self) -> None:
        own, self._own = self._own, None
        if own is not None:
            await until(own.close())

    async def __aenter__(self) -> Recording:
        return await self.begin()

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self.finish()
        except (Error, OSError):
            if error is None:
                raise

    @property
    def path(self) -> str:
        """Path of the file."""
        return self._how[0]

    @property
    def is_open(self) -> bool:
        """True while it records: started, not finished, and not ended by an error such as a lost line, which
        :meth:`finish` raises."""
        return self._native is not None and self._native.is_open()

    @property
    def seconds(self) -> float:
        """Time of the last reading, s, by the host's clock, or by that of an in-process virtual arm."""
        return self._tally()[0] if self._ended is None else self._ended[0]

    @property
    def readings(self) -> int:
        """Number of readings so far."""
        return self._tally()[1] if self._ended is None else self._ended[1]

    @property
    def length(self) -> float:
        """Length of the tool's path so far, mm."""
        return self._tally()[3] if self._ended is None else self._ended[2]

    @property
    def position(self) -> Position | None:
        """Position of the tool at the last reading; ``None`` before the first."""
        return self._tally()[2]

    @property
    def steps(self) -> int | None:
        """Number of steps of the finished program; ``None`` for a file of readings."""
        return None if self._ended is None else self._ended[3]

    def _tally(self) -> tuple[float, int, Position | None, float]:
        if self._native is None:
            return 0.0, 0, None, 0.0
        seconds, readings, position, _, length = self._native.tally()
        return seconds, readings, Position(*position) if readings else None, length

    def __repr__(self) -> str:
        state = "open" if self.is_open else "not begun" if self._native is None else "finished"
        return (
            f"<Recording {self.path!r}, {state}: {self.seconds:.1f} s, {self.readings} readings, {self.length:.1f} mm>"
        )


class Lesson(Bound):
    """A program taught by hand: see :meth:`Arm.teach`. It starts with its ``with`` block; its points remain available
    after it. Iteration waits for and yields each point taught by hand, until :meth:`close`.
    """

    def __init__(self, core: Core, title: str, by: str, unhomed: bool) -> None:
        self._core = core
        self._how = (title, by, unhomed)
        self._native: NativeLesson | None = None
        self._open = False
        self._given = 0

    async def __aenter__(self) -> Lesson:
        if self._native is not None:
            raise ClosedError("the lesson was begun before: arm.teach() begins another one")
        self._native = await until(self._core.teach(*self._how))
        self._open = True
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self.close()
        except Error:
            if error is None:
                raise

    async def close(self) -> None:
        """Ends the lesson: no more points are taken, and the arm's settings are restored. A second call does
        nothing."""
        if self._open:
            self._open = False
            await until(self._begun().close())

    @property
    def guided(self) -> bool:
        """True if the arm reports its unlock key. If not, :meth:`point` takes each point."""
        return self._begun().is_guided()

    @property
    def points(self) -> list[Point]:
        """All points so far, from the hand and from :meth:`point`, in order."""
        return [_point(*each) for each in self._begun().points()]

    async def wait(self, timeout: float | None = None) -> Point:
        """Waits for the next point taught by hand that was not returned before.

        :param timeout: Maximum time to wait, seconds.
        :raises ResponseTimeoutError: The key was not released before the timeout.
        :raises UnsupportedError: The arm does not report its unlock key.
        :raises ClosedError: The lesson or the connection was closed.
        :raises PortError: The line was lost.
        """
        native = self._begun()
        if not native.is_guided():
            raise UnsupportedError("this arm does not report its unlock key: point() takes where it stands")
        if not self._open and native.by_hand() <= self._given:
            raise ClosedError("the lesson has ended")
        call = native.next(self._given)
        if timeout is not None:
            end = monotonic() + seconds("timeout", timeout)
            while not call.over() and monotonic() < end:
                await until_moment()
            if not call.over():
                call.cancel()
                raise ResponseTimeoutError(f"the unlock key was not released within {timeout:g} s")
        found = _point(*await until(call))
        self._given += 1
        return found

    def __aiter__(self) -> Lesson:
        return self

    async def __anext__(self) -> Point:
        if not self._open and self._begun().by_hand() <= self._given:
            raise StopAsyncIteration
        return await self.wait()

    async def point(
        self,
        name: str | None = None,
        *,
        suction: bool | None = None,
        gripper: Literal["close", "open", "off"] | None = None,
        pause: float = 0.0,
    ) -> Point:
        """Adds the arm's current pose as a point; if the arm moves, the pose at which it comes to rest.

        :param name: Name of the point; ``"P1"``, ``"P2"`` and so on if left out.
        :param suction: Whether the suction cup is switched on or off there; unchanged if left out.
        :param gripper: Action of the gripper there; unchanged if left out.
        :param pause: Dwell time at the point, s.
        :raises InvalidInputError: The gripper has no such action.
        """
        native = self._begun()
        if not self._open:
            raise ClosedError("the lesson has ended")
        if gripper is not None and gripper not in _GRIPS:
            raise InvalidInputError(f'gripper is {gripper!r}; it takes "close", "open" or "off"')
        cup = None if suction is None else flag("suction", suction)
        stays = round(seconds("pause", pause) * 1000)
        name = text("name", name)
        return _point(*await until(native.store(name, cup, None if gripper is None else _GRIPS[gripper], stays)))

    def pop(self) -> Point:
        """Removes and returns the last point.

        :raises IndexError: There are no points.
        """
        native = self._begun()
        last = native.pop()
        if last is None:
            raise IndexError("the lesson has no points")
        return _point(*last)

    def plan(self) -> Plan:
        """Returns the program as a plan: ``arm.run(lesson.plan())``. It contains the points so far, for the tool that
        was set when the lesson began.
        """
        return Plan(self._begun().plan())

    def save(self, path: str | os.PathLike[str]) -> list[str]:
        """Writes the program to a ``.plan.json`` or, for DobotStudio, ``.playback`` file, as :meth:`Plan.save`."""
        return self.plan().save(path)

    def _begun(self) -> NativeLesson:
        if self._native is None:
            raise ClosedError("the lesson has not begun: it runs inside `with arm.teach() as lesson`")
        return self._native

    def __len__(self) -> int:
        return 0 if self._native is None else len(self._native.points())

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        state = "not begun" if self._native is None else "open" if self._open else "ended"
        return f"<Lesson, {state}: {len(self)} points>"


_GRIPS = {"close": 1, "open": 0, "off": -1}


def _point(name: str, place: tuple[float, float, float, float]) -> Point:
    return Point(name, Position(*place))


class StateWatch(Bound):
    """Periodic readings of the arm's state: see :meth:`Arm.state`. The watch ends with the connection, with its
    ``with`` block, or when it is garbage-collected.
    """

    def __init__(self, watch: NativeStateWatch) -> None:
        self._watch: NativeStateWatch | None = watch

    def close(self) -> None:
        """Ends the watch. A pending wait still gets the next reading; then the loop ends."""
        self._watch = None

    def __enter__(self) -> StateWatch:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._watch is None:
            return "<StateWatch, closed>"
        latest = self.latest
        return f"<StateWatch, {'nothing read yet' if latest is None else f'the line is {latest.link.state}'}>"

    @property
    def latest(self) -> Status | None:
        """Latest state, read by this watch or another one; ``None`` before the first complete reading, and after the
        watch was closed."""
        latest = None if self._watch is None else self._watch.latest()
        return None if latest is None else _conversion.status(latest)

    async def changed(self) -> Status:
        """Waits for the next reading, without timeout. Losing or regaining the line counts as a reading.

        Raises :class:`~magician.errors.ClosedError` when the connection has ended, or the watch was closed.
        """
        if self._watch is None:
            raise ClosedError("the watch was closed: arm.state() starts another one")
        return _conversion.status(await until(self._watch.changed()))

    def __aiter__(self) -> StateWatch:
        return self

    async def __anext__(self) -> Status:
        try:
            return await self.changed()
        except ClosedError:
            raise StopAsyncIteration from None


class Events(Bound):
    """Events of the arm: see :meth:`Arm.events`. The subscription ends with the connection, with its ``with`` block, or
    when it is garbage-collected.
    """

    def __init__(self, native: NativeEvents) -> None:
        self._events: NativeEvents | None = native

    def close(self) -> None:
        """Ends the subscription. A pending wait still gets the next event; then the loop ends."""
        self._events = None

    def __enter__(self) -> Events:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return "<Events of an arm>"

    def __aiter__(self) -> Events:
        return self

    async def __anext__(self) -> events.Event:
        parts = None if self._events is None else await until(self._events.next())
        if parts is None:
            raise StopAsyncIteration
        return _conversion.event(parts)


class Run(Bound):
    """A resumable run of a program: see :meth:`Arm.begin`.

    :meth:`finish` runs it. If that fails and it :attr:`is_interrupted`, the line was lost, or it was not known whether
    the arm took a command. The arm then finishes its queue, and another call of :meth:`finish` goes on with the first
    command that the arm did not take. After any other error the run is over, and :meth:`finish` fails::

        run = arm.begin(program)
        while True:
            try:
                await run.finish()
                break
            except errors.PortError:
                if not run.is_interrupted:
                    raise
                await arm.reconnected()  # and ask the user whether to go on
    """

    def __init__(self, core: Core, native: NativeProgram) -> None:
        self._core = core
        self._run = native
        self._ran = Ran(0, None, None)

    def __repr__(self) -> str:
        return f"<Run, {self.ran.commands} commands done{', interrupted' if self.is_interrupted else ''}>"

    async def finish(self, *, progress: Callable[[Progress], object] | None = None) -> Ran:
        """Runs the rest of the program, and waits for the end.

        Raises as :meth:`Arm.perform`, except for the check. After an interruption it raises
        :class:`~magician.errors.UnexpectedError` if the arm is not where it should be, and
        :class:`~magician.errors.ClosedError` if the run is over.
        """
        return Ran(*await until_done(self._run.finish(), self._core, _hearing(progress)))

    @property
    def is_interrupted(self) -> bool:
        """True if the run was interrupted and :meth:`finish` may resume it. A later stop ends it for good."""
        return self._run.is_interrupted()

    @property
    def ran(self) -> Ran:
        """Finished commands so far; during a run, those finished before the current :meth:`finish`."""
        ran = self._run.ran()
        if ran is not None:
            self._ran = Ran(*ran)
        return self._ran


# [aio]
def __getattr__(name: str) -> Any:
    if name != "Station":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from ._aio_station import Station

    globals()[name] = Station
    return Station
