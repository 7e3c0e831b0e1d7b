"""Waiting for calls of the native part, in a thread or in an event loop."""

from __future__ import annotations

import atexit
import contextlib
import os
import time
import weakref
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable, Iterator, Mapping
from typing import Any, Protocol, TypeVar, cast, overload

from . import _magician
from ._arguments import flags, not_a_file, seconds, whole
from ._magician import Call, Core, Job
from ._motions import FinishedMotion, RunningMotion, Steps, add_doubt_note
from .errors import Error, ResponseTimeoutError

_POLL_INTERVAL = 0.1
"""Interval at which a thread that waits for a motion checks for an interrupt, s."""
_SHORT_WAIT = 0.02
"""Polling interval for objects without notification, s."""

__version__ = _magician.__version__

T = TypeVar("T")
Listener = Callable[[Any], object]


class GeneratorEnd(Exception):
    """Raised at the end of a generator, or of the run that it feeds."""


@overload
def iterator_of(program: AsyncIterable[T]) -> AsyncIterator[T]: ...
@overload
def iterator_of(program: Iterable[T]) -> Iterator[T]: ...
@overload
def iterator_of(program: Iterable[T] | AsyncIterable[T]) -> Iterator[T] | AsyncIterator[T]: ...
def iterator_of(program: Iterable[T] | AsyncIterable[T]) -> Iterator[T] | AsyncIterator[T]:
    """Iterator over a program, synchronous or asynchronous."""
    if isinstance(program, AsyncIterable):
        return aiter(program)
    return iter(not_a_file(program))


def start_call(call: Call[Any]) -> None:
    """Starts a call that is awaited later."""
    call.listen(lambda: None)


class Connectable(Protocol):
    """Connection target other than a port: a virtual arm created by the program."""

    def connect_core(
        self,
        *,
        timeout: float,
        window: int,
        probe: bool,
        reconnect: bool,
        echo: float,
        fence: str | None,
        trace: str | None,
    ) -> Call[Core]:
        """Starts a connection."""
        ...


Where = str | os.PathLike[str] | Connectable | None
"""Target of a connection."""


def fence_text(fence: Mapping[str, object]) -> str:
    """Converts a fence to the format of the settings file, which the driver parses."""
    import json

    try:
        bounds = [f"{json.dumps(str(name))} = {json.dumps(value)}" for name, value in fence.items()]
    except TypeError as error:
        raise TypeError(f"fence is made of numbers and lists of them: {error}") from None
    return "{" + ", ".join(bounds) + "}"


def connecting(
    port: Where,
    *,
    timeout: float,
    window: int,
    probe: bool,
    reconnect: bool,
    echo: float,
    fence: Mapping[str, object] | None = None,
    trace: str | os.PathLike[str] | None = None,
) -> Call[Core]:
    """Starts a connection to a port or a virtual arm."""
    timeout = seconds("timeout", timeout, above=0)
    window = whole("window", window, 1, 8)
    echo = seconds("echo", echo)
    options: dict[str, Any] = {
        "timeout": timeout,
        "window": window,
        "echo": echo,
        "fence": None if fence is None else fence_text(fence),
        "trace": None if trace is None else os.fspath(trace),
        **flags(probe=probe, reconnect=reconnect),
    }
    # Not isinstance() with a protocol: from Python 3.12 on that imports inspect, which is slow.
    if begin := getattr(port, "connect_core", None):
        call: Call[Core] = begin(**options)
        return call
    try:
        path: object = None if port is None else os.fspath(cast("str | os.PathLike[str]", port))
    except TypeError:
        path = port
    if path is not None and not isinstance(path, str):
        raise TypeError(f"port is {port!r} ({type(port).__name__}); it takes a name, a path or a virtual arm")
    return Core.connect(path, **options)


def wait(call: Call[T], listener: Listener | None = None) -> T:
    """Waits in this thread."""
    return call.wait(listener)


def wait_done(call: Call[T], core: Core, listener: Listener | None = None) -> T:
    """Waits in this thread for a motion. An interrupt stops the arm."""
    try:
        return call.wait(listener)
    except BaseException as interruption:
        if not call.taken():
            wait_stopped(core, interruption)
        raise


def wait_with_cleanup(call: Call[T], cleanup: Call[None], listener: Listener | None = None) -> T:
    """Waits in this thread for a call with a cleanup.

    An interrupt is raised only after ``cleanup`` has ended.
    """
    try:
        return call.wait(listener)
    except BaseException:
        if not call.taken():
            while not cleanup.over():
                # Ignore a second interrupt: the orderly end has to finish.
                with contextlib.suppress(KeyboardInterrupt):
                    cleanup.wait()
        raise


def wait_over(job: Job) -> str | None:
    """Waits in this thread for the cleanup of a stopped job, which has a time limit.

    A further interrupt may stop the job at once, but does not end the wait.
    """
    while True:
        over = job.over()
        try:
            return over.wait()
        except KeyboardInterrupt:
            job.interrupted()


def wait_steps(steps: Steps, core: Core) -> Any:
    """Waits in this thread for a sequence of calls."""
    try:
        call, moves = next(steps)
        while True:
            try:
                value = wait_done(call, core) if moves else wait(call)
            except BaseException as error:
                call, moves = steps.throw(error)
            else:
                call, moves = steps.send(value)
    except StopIteration as end:
        return end.value


def wait_next(items: Iterator[T], running: Call[Any]) -> T:
    """Returns the next item of a generator.

    Raises :exc:`GeneratorEnd` at its end, and at the end of the run that it feeds.
    """
    if running.over():
        raise GeneratorEnd
    try:
        return next(items)
    except StopIteration:
        raise GeneratorEnd from None


def wait_ended(motion: RunningMotion | FinishedMotion, core: Core, timeout: float | None = None) -> Any:
    """Waits in this thread for a background motion. An interrupt stops the arm."""
    if not motion.over:
        import threading

        ended = threading.Event()
        motion.when_over(ended.set)
        until = None if timeout is None else time.monotonic() + timeout
        try:
            # Wait in slices: on some systems an endless wait ignores interrupts.
            while not ended.wait(
                _POLL_INTERVAL if until is None else max(0.0, min(_POLL_INTERVAL, until - time.monotonic()))
            ):
                if until is not None and time.monotonic() >= until:
                    break
        except BaseException as interruption:
            motion.cancel(rests=False)
            wait_stopped(core, interruption)
            raise
    return _ended(motion, timeout)


def wait_settled(motion: RunningMotion, core: Core) -> None:
    """Waits in this thread until a background motion is over. Raises its error if the caller has not seen it."""
    was_reported = motion.is_reported
    try:
        wait_ended(motion, core)
    except Error as failure:
        if failure is not motion.failure or not (was_reported or motion.is_given_up()):
            raise


def wait_moment() -> None:
    """Waits briefly."""
    time.sleep(_SHORT_WAIT)


def wait_stopped(core: Core, interruption: BaseException) -> None:
    """Stops the arm because of an exception, and adds a note to it if the stop is uncertain."""
    try:
        core.stop().wait()
    except Error as failure:
        add_doubt_note(interruption, failure)


async def until(call: Call[T], listener: Listener | None = None) -> T:
    """Waits in the running event loop. Cancelling the task abandons the call."""
    return await _until(call, listener)


async def until_done(call: Call[T], core: Core, listener: Listener | None = None) -> T:
    """Waits in the running event loop for a motion. Cancelling it stops the arm."""
    try:
        return await _until(call, listener)
    except GeneratorExit:
        # The coroutine is being closed and cannot await. The stop has been requested.
        raise
    except BaseException as interruption:
        if not call.taken():
            await until_stopped(core, interruption)
        raise


async def until_with_cleanup(call: Call[T], cleanup: Call[None], listener: Listener | None = None) -> T:
    """Waits in the running event loop for a call with a cleanup, as :func:`wait_with_cleanup`."""
    try:
        return await _until(call, listener)
    except GeneratorExit:
        # The coroutine is being closed and cannot await. The operation ends by itself.
        raise
    except BaseException:
        if not call.taken():
            await _until(cleanup, None)
        raise


async def until_over(job: Job) -> str | None:
    """Waits in the running event loop for the cleanup of a stopped job, as :func:`wait_over`."""
    from asyncio import CancelledError

    while True:
        try:
            return await _until(job.over(), None)
        except (CancelledError, KeyboardInterrupt):
            job.interrupted()


async def until_steps(steps: Steps, core: Core) -> Any:
    """Waits in the running event loop for a sequence of calls."""
    try:
        call, moves = next(steps)
        while True:
            try:
                value = await (until_done(call, core) if moves else until(call))
            except GeneratorExit:
                steps.close()
                raise
            except BaseException as error:
                call, moves = steps.throw(error)
            else:
                call, moves = steps.send(value)
    except StopIteration as end:
        return end.value


async def until_next(items: Iterator[T] | AsyncIterator[T], running: Call[Any]) -> T:
    """Returns the next item of a synchronous or asynchronous generator, as :func:`wait_next`. The end of the run
    cancels an asynchronous one."""
    if not isinstance(items, AsyncIterator):
        return wait_next(items, running)
    import asyncio

    loop = asyncio.get_running_loop()
    following = asyncio.ensure_future(_next_of(items))

    def end() -> None:
        if running.over():
            following.cancel()

    def notify() -> None:
        # A closed loop has no waiter left.
        with contextlib.suppress(RuntimeError):
            loop.call_soon_threadsafe(end)

    running.listen(notify)
    try:
        return await following
    except StopAsyncIteration:
        raise GeneratorEnd from None
    except asyncio.CancelledError:
        if following.cancelled() and running.over():
            raise GeneratorEnd from None
        following.cancel()
        raise


async def _next_of(items: AsyncIterator[T]) -> T:
    return await anext(items)


async def until_ended(motion: RunningMotion | FinishedMotion, core: Core, timeout: float | None = None) -> Any:
    """Waits in the running event loop for a background motion. Cancelling the wait stops the arm."""
    if not motion.over:
        import asyncio

        loop = asyncio.get_running_loop()
        ended: asyncio.Future[None] = loop.create_future()

        def end() -> None:
            if not ended.done():
                ended.set_result(None)

        def notify() -> None:
            # A closed loop has no waiter left.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(end)

        motion.when_over(notify)
        try:
            await asyncio.wait((ended,), timeout=timeout)
        except GeneratorExit:
            motion.cancel(rests=False)
            raise
        except BaseException as interruption:
            motion.cancel(rests=False)
            await until_stopped(core, interruption)
            raise
    return _ended(motion, timeout)


async def until_settled(motion: RunningMotion, core: Core) -> None:
    """Waits in the running event loop until a background motion is over, as :func:`wait_settled`."""
    was_reported = motion.is_reported
    try:
        await until_ended(motion, core)
    except Error as failure:
        if failure is not motion.failure or not (was_reported or motion.is_given_up()):
            raise


async def until_moment() -> None:
    """Waits briefly."""
    import asyncio

    await asyncio.sleep(_SHORT_WAIT)


async def until_stopped(core: Core, interruption: BaseException) -> None:
    """Stops the arm because of an exception, and adds a note to it if the stop is uncertain.

    If this wait is cancelled, the stop still continues.
    """
    try:
        await _until(core.stop(), None)
    except Error as failure:
        add_doubt_note(interruption, failure)


async def _until(call: Call[T], listener: Listener | None) -> T:
    import asyncio

    loop = asyncio.get_running_loop()
    ended: asyncio.Future[None] = loop.create_future()

    def check_call() -> None:
        if ended.done():
            return
        over, report = call.over(), call.report()
        try:
            if report is not None and listener is not None:
                listener(report)
        except StopIteration as error:
            # A future does not accept StopIteration. Coroutines convert it in the same way.
            failure = RuntimeError("a listener raised StopIteration")
            failure.__cause__ = error
            ended.set_exception(failure)
        except BaseException as error:
            ended.set_exception(error)
        else:
            if over:
                ended.set_result(None)

    def notify() -> None:
        try:
            loop.call_soon_threadsafe(check_call)
        except RuntimeError:
            # The loop is closed: no waiter is left.
            call.cancel()

    call.listen(notify)
    try:
        await ended
    except BaseException:
        call.cancel()
        raise
    return call.result()


def _ended(motion: RunningMotion | FinishedMotion, timeout: float | None) -> Any:
    if not motion.over:
        raise ResponseTimeoutError(f"the motion is still under way after {timeout:g} s; it goes on")
    if isinstance(motion, RunningMotion):
        motion.is_reported = True
    if motion.failure is not None:
        raise motion.failure
    return motion.value


class Closeable(Protocol):
    """Connection to an arm, or session at a station."""

    def close(self) -> Call[None]:
        """Starts to close the connection."""
        ...

    def is_here(self) -> bool:
        """True if it was created in this process, False in a forked child."""
        ...


_C = TypeVar("_C", bound=Closeable)
_open: weakref.WeakSet[Any] = weakref.WeakSet()


def opened(core: _C) -> _C:
    """Registers a connection to be closed when the interpreter ends."""
    _open.add(core)
    return core


def _end() -> None:
    """Closes all open connections at the same time, and flushes the log of the native part."""
    closing = [core.close() for core in list(_open) if core.is_here()]
    try:
        for call in closing:
            call.wait()
    finally:
        _magician.end()


atexit.register(_end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_magician.forked)
