"""Motions in the background, one after the other, while the program does something else.

A motion takes a generator of calls of the native part. A wait drives it; without one, the thread that reports ended
calls does.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Generator, Sequence
from typing import Any

from . import words
from ._magician import Call, Core
from ._targets import keeps_r, kept
from .commands import Pose, PtpCommonParams, Queueable
from .errors import ClosedError, Error
from .readings import Ran

__all__ = ["Ended", "Going", "Steps", "homing", "performing"]

Steps = Generator[tuple[Call[Any], bool], Any, Any]
"""Calls, one after the other, and whether each of them moves the arm. It is sent what they come to."""


def homing(core: Core) -> Steps:
    """Homes the arm."""
    yield core.home(), True


def performing(
    core: Core,
    made: Sequence[Queueable] | Callable[[Pose | None], Sequence[Queueable]],
    *,
    asks: bool = False,
    speed: float | None = None,
    skip: Collection[str] = (),
    require_homed: bool = False,
    keep: bool = False,
    allow_laser: bool = False,
) -> Steps:
    """Runs commands, or what makes them when it is their turn.

    :param asks: Whether they depend on where the arm is.
    :param speed: Share of the set speeds for them alone, percent.
    """
    pose: Pose | None = None
    if asks:
        pose = yield core.known_pose(Pose), False
    program = made(pose) if callable(made) else made
    if any(map(keeps_r, program)):
        if pose is None:
            pose = yield core.known_pose(Pose), False
        program = kept(program, None if pose is None else pose.r)
    how = list(skip), require_homed, keep, allow_laser
    if speed is None:
        return Ran(*(yield core.perform(program, *how), True))
    before: PtpCommonParams = yield core.get(PtpCommonParams), False
    try:
        return Ran(*(yield core.perform([words.speed(speed), *program, before], *how), True))
    except GeneratorExit:
        raise
    except BaseException as error:
        if isinstance(error, Error) and error.step:
            error.step -= 1
        # The command that would have given it back may have been dropped.
        with contextlib.suppress(Error):
            yield core.set(before, False, False), False
        raise


class Ended:
    """A motion that has ended well."""

    over = True
    failure: BaseException | None = None

    def __init__(self, value: Any) -> None:
        self.value = value

    def when_over(self, tell: Callable[[], object]) -> None:
        """Calls this when it is over."""
        tell()

    def cancel(self) -> None:
        """There is nothing left of it."""


class Going:
    """A motion on its way, or waiting for the one before it."""

    def __init__(self, steps: Steps, after: Going | None) -> None:
        import threading

        self._lock = threading.RLock()
        self._steps = steps
        self._call: Call[Any] | None = None
        self._begun = False
        self._dropped = False
        self._after = after
        self._tell: list[Callable[[], object]] = []
        self.over = False
        self.told = False
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
                self._tell.append(tell)
                return
        tell()

    def cancel(self) -> None:
        """Stops it, if it has begun, and what waits for it."""
        with self._lock:
            call, self._call = self._call, None
            if self.over or (self._begun and call is None):
                return
            # Who cancels it knows how it ends.
            self._begun = self.told = True
        if call is not None:
            call.cancel()
        self._step(failure=_stopped("the motion was cancelled"))

    def drop(self) -> None:
        """Nothing more of it is sent, nor of those before it: the arm is about to be stopped."""
        going: Going | None = self
        while going is not None:
            with going._lock:
                going._dropped = True
                after = going._after
            going = after

    def _begin(self) -> None:
        after, self._after = self._after, None
        with self._lock:
            if self._begun:
                return
            self._begun = True
        if after is not None and after.failure is not None:
            self._step(failure=_stopped("the motion before this one did not come to its end"))
        else:
            self._step()

    def _step(self, value: Any = None, failure: BaseException | None = None) -> None:
        try:
            with self._lock:
                if self._dropped and failure is None:
                    failure = _stopped("the arm was stopped before this motion")
                call, _ = self._steps.send(value) if failure is None else self._steps.throw(failure)
                self._call = call
        except StopIteration as end:
            self._end(end.value, None)
        except BaseException as error:
            self._end(None, error)
        else:
            call.listen(self._look)

    def _look(self) -> None:
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
            self.value, self.failure, self.over = value, failure, True
            tell, self._tell = self._tell, []
        for each in tell:
            each()


def _stopped(message: str) -> ClosedError:
    return ClosedError(message, code="stopped")
