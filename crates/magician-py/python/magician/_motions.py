"""Background motions, which run one after another while the program does other work.

A motion takes a generator of calls of the native part. A wait drives it; without one, the thread that reports ended
calls does.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Generator, Sequence
from typing import Any

from . import words
from ._magician import Call, Core
from ._targets import fill_r, keeps_r
from .commands import ArcCommonParams, DeviceTime, Pose, PtpCommonParams, Queueable
from .errors import ClosedError, Error, ResponseTimeoutError
from .readings import Ran

__all__ = ["FinishedMotion", "RunningMotion", "Steps", "add_doubt_note", "homing", "intercepting", "performing"]

_START_TIME = 0.3
"""Time to start a motion, s; a meeting on a belt is at least this far in the future."""

Steps = Generator[tuple[Call[Any], bool], Any, Any]
"""Generator of calls, each with True if it moves the arm. It receives their results."""


def homing(core: Core) -> Steps:
    """Homes the arm."""
    yield core.home(), True


def performing(
    core: Core,
    made: Sequence[Queueable] | Callable[[Pose | None], Sequence[Queueable]],
    *,
    asks: bool = False,
    speed: float | None = None,
    arc: bool = False,
    skip: Collection[str] = (),
    require_homed: bool = False,
    keep: bool = False,
    allow_laser: bool = False,
) -> Steps:
    """Runs commands, or a function that builds them when their turn comes.

    :param asks: Whether they depend on the arm's pose.
    :param speed: Speed ratio for these commands alone, percent.
    :param arc: Whether the commands are arcs: the share of arcs is set as well. The document has arcs obey that one,
        and the vendor's code the one of point-to-point moves and lines (model section 9).
    """
    pose: Pose | None = None
    if asks:
        pose = yield core.known_pose(Pose), False
    program = made(pose) if callable(made) else made
    if any(map(keeps_r, program)):
        if pose is None:
            pose = yield core.known_pose(Pose), False
        program = fill_r(program, None if pose is None else pose.r)
    how = list(skip), require_homed, keep, allow_laser
    if speed is None:
        return Ran(*(yield core.perform(program, *how), True))
    ratios: list[type[PtpCommonParams | ArcCommonParams]] = [PtpCommonParams]
    if arc:
        ratios.append(ArcCommonParams)
    before: list[PtpCommonParams | ArcCommonParams] = []
    for ratio in ratios:
        before.append((yield core.get(ratio), False))
    try:
        own = [ratio(speed, speed) for ratio in ratios]
        return Ran(*(yield core.perform([*own, *program, *before], *how), True))
    except GeneratorExit:
        raise
    except BaseException as error:
        if isinstance(error, Error) and error.step:
            error.step -= len(ratios)
        # Restore the settings here: the queued commands that would restore them may have been dropped.
        for setting in before:
            with contextlib.suppress(Error):
                yield core.set(setting, False, False), False
        raise


def intercepting(
    core: Core,
    at: tuple[float, float, float],
    r: float | None,
    velocity: tuple[float, float, float],
    since: float | None,
    made: Callable[[tuple[float, float, float], float], tuple[list[Queueable], list[Queueable]]],
    approach: float,
    lead: float,
    speed: float | None,
) -> Steps:
    """Picks up a moving object: moves above the meeting point, waits there, and descends.

    :param made: Builds the commands for a position and a rotation: those until the tool is above, and the rest.
    :param speed: Speed ratio for these commands, percent; restored afterwards.
    """
    pose: Pose = yield core.known_pose(Pose), False
    turn = pose.r if r is None else r
    before: PtpCommonParams | None = None if speed is None else (yield core.get(PtpCommonParams), False)
    first, _ = made(at, turn)
    arrives, place, down = yield core.meet((*at, turn), velocity, since, first[:-1], approach, _START_TIME), False
    first, then = made(place, turn)
    if before is not None:
        then.append(before)
    yield core.estimate([*first, *then], []), False
    feed, running = core.stream(len(first) + len(then) + 1, [], False)
    try:
        running.listen(lambda: None)
        for command in first:
            feed.push(command)
        while feed.finished() < len(first) and not running.over():
            yield feed.rest(), False
        if not running.over():
            clock: DeviceTime = yield core.get(DeviceTime), False
            left = arrives - down - lead - clock.g_systick / 1000
            if left < 0:
                raise ResponseTimeoutError(f"the arm was above the belt {-left:.2f} s too late")
            for command in (words.wait(left), *then):
                feed.push(command)
        feed.end()
        return Ran(*(yield running, True))
    except GeneratorExit:
        running.cancel()
        raise
    except BaseException as error:
        if not running.taken():
            running.cancel()
            try:
                yield core.stop(), False
            except Error as failure:
                add_doubt_note(error, failure)
        if before is not None:
            # Restore the setting here: the queued command that would restore it may have been dropped.
            with contextlib.suppress(Error):
                yield core.set(before, False, False), False
        raise


def add_doubt_note(interruption: BaseException, failure: Error) -> None:
    """Adds a note to the exception that ended a wait: the stop failed."""
    said = f"the arm was told to stop, but has not confirmed it: {failure}"
    add_note: Callable[[str], None] | None = getattr(interruption, "add_note", None)
    if add_note is not None:
        add_note(said)
    else:
        interruption.args = (*interruption.args, said)


class FinishedMotion:
    """A successfully finished motion."""

    over = True
    failure: BaseException | None = None

    def __init__(self, value: Any) -> None:
        self.value = value

    def when_over(self, tell: Callable[[], object]) -> None:
        """Calls a function when the motion is over."""
        tell()

    def cancel(self, *, rests: bool = True) -> None:
        """Does nothing: the motion is over."""


class RunningMotion:
    """A running motion, or one that waits for its predecessor."""

    def __init__(self, core: Core, steps: Steps, after: RunningMotion | None) -> None:
        import threading

        self._lock = threading.RLock()
        self._core = core
        self._steps = steps
        self._call: Call[Any] | None = None
        self._moves = False
        self._begun = False
        self._dropped = False
        self._cancelled = False
        # True while the arm brakes after a cancel. The motion is over once the arm stands.
        self._is_braking = False
        self._after = after
        # True if the motion before was already cancelled: then this one waits for the arm to stand, and is not dropped.
        self._follows_failure = after is not None and after.is_given_up()
        self._callbacks: list[Callable[[], object]] = []
        self.over = False
        self.is_reported = False
        self.value: Any = None
        self.failure: BaseException | None = None
        if after is None:
            self._begin()
        else:
            after.when_over(self._begin)

    def when_over(self, tell: Callable[[], object]) -> None:
        """Calls this when it is over, from any thread."""
        with self._lock:
            if not self.over:
                self._callbacks.append(tell)
                return
        tell()

    def cancel(self, *, rests: bool = True) -> None:
        """Stops the motion if it has begun, and drops its successors.

        :param rests: Whether the motion is over only once the arm is at rest. Otherwise it is over at once, for a
            caller that waits for its own stop.
        """
        with self._lock:
            if self.over or self._cancelled:
                return
            # The caller knows about the cancel: do not report it again.
            self._cancelled = self.is_reported = True
            call, self._call = self._call, None
            between, self._begun = self._begun and call is None, True
            self._is_braking = rests and call is not None and self._moves
        if call is not None:
            call.cancel()
        # Between two calls another thread takes the next step and finds the cancel.
        if not between:
            self._step()

    def is_given_up(self) -> bool:
        """True if it was cancelled, or a motion that it waits for was."""
        going: RunningMotion | None = self
        while going is not None:
            with going._lock:
                if going._cancelled:
                    return True
                after = going._after
            going = after
        return False

    def drop(self) -> None:
        """Stops sending this motion and its predecessors, because the arm is about to be stopped."""
        going: RunningMotion | None = self
        while going is not None:
            with going._lock:
                going._dropped = True
                after = going._after
            going = after

    def _begin(self) -> None:
        with self._lock:
            after, self._after = self._after, None
            if self._begun:
                return
            self._begun = True
            if after is not None and after.is_given_up() and not self._follows_failure:
                self._cancelled = self.is_reported = True
        if after is not None and after.failure is not None and not self._follows_failure:
            self._step(failure=_stopped("the motion before this one did not come to its end"))
        else:
            self._step()

    def _step(self, value: Any = None, failure: BaseException | None = None) -> None:
        try:
            with self._lock:
                if self._dropped and failure is None:
                    failure = _stopped("the arm was stopped before this motion")
                if self._cancelled and failure is None:
                    failure = _stopped("the motion was cancelled")
                call, moves = self._steps.send(value) if failure is None else self._steps.throw(failure)
                self._call, self._moves = call, moves
        except StopIteration as end:
            self._end(end.value, None)
        except BaseException as error:
            self._end(None, error)
        else:
            call.listen(self._on_call_end)

    def _on_call_end(self) -> None:
        with self._lock:
            call = self._call
            if call is None or not call.over():
                return
            self._call = None
        try:
            value = call.result()
        except BaseException as error:
            self._step(failure=error)
        else:
            self._step(value)

    def _end(self, value: Any, failure: BaseException | None) -> None:
        with self._lock:
            brakes, self._is_braking = self._is_braking, False
        if brakes and failure is not None:
            self._rest(failure)
            return
        with self._lock:
            self.value, self.failure, self.over = value, failure, True
            tell, self._callbacks = self._callbacks, []
        for each in tell:
            each()

    def _rest(self, failure: BaseException) -> None:
        """Ends the motion once the arm is at rest, or does not confirm the stop."""
        try:
            resting = self._core.wait_still()
        except Error as error:
            add_doubt_note(failure, error)
            self._end(None, failure)
            return

        def look() -> None:
            with self._lock:
                if resting.taken() or not resting.over():
                    return
                try:
                    resting.result()
                except Error as error:
                    add_doubt_note(failure, error)
            self._end(None, failure)

        resting.listen(look)


def _stopped(message: str) -> ClosedError:
    return ClosedError(message, code="stopped")
