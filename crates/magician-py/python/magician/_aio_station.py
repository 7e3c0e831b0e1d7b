"""Stations for programs on asyncio: many programs share an arm, and one of them controls it.

``tools/blocking.py`` generates the blocking interface, :class:`magician.Station`, from this file.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import TracebackType
from typing import Any

from . import _conversion
from ._arguments import check_progress, flag, number, seconds, text, whole
from ._bound import Bound
from ._magician import Notices as NativeNotices
from ._magician import Station as NativeStation
from ._native import opened, until
from ._stations import (
    ArmAt,
    ArmEntry,
    ArmState,
    Holder,
    JobState,
    Notice,
    StationEvent,
    ToolState,
    connecting,
    event,
    from_json,
    require_done,
    source,
    to_json,
    value_of,
)
from .errors import Error, PortError
from .programs import Plan

__all__ = [
    "ArmEntry",
    "ArmState",
    "Connecting",
    "Holder",
    "JobState",
    "Jobs",
    "Lease",
    "Notice",
    "Station",
    "StationEvent",
    "StationJob",
    "ToolState",
]

# [aio]
from collections.abc import AsyncIterator, Coroutine, Generator
from typing import Generic, TypeVar

from .aio import Arm
from .aio import Connecting as ConnectingArm

_T = TypeVar("_T")

# [blocking]
# from collections.abc import Iterator
#
# from ._blocking import Arm
# [both]


# [aio]
class Connecting(Bound, Generic[_T]):
    """A session or lease that is not open yet: ``await`` it, or enter it with ``async with``."""

    def __init__(self, create: Callable[[], Coroutine[Any, Any, _T]]) -> None:
        self._create = create
        self._entered: Any = None

    def __await__(self) -> Generator[Any, Any, _T]:
        return self._create().__await__()

    async def __aenter__(self) -> _T:
        found = self._entered = await self._create()
        return found

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._entered is not None:
            await self._entered.__aexit__(kind, error, trace)


# [both]
class Station(Bound):
    """A session at a station (``magician serve``). Many programs can watch an arm of the station; one of them controls
    it, and any of them may stop it.

    A lost connection is retried with a backoff from 0.2 s to 5 s. If it is back within 5 s, the session resumes with
    its leases. Watches continue automatically. A request whose answer was lost raises
    :class:`~magician.errors.PortError` and is not sent again.

    Refusals of the station raise :class:`~magician.errors.StationError`. Errors of the arm raise the other exceptions
    of :mod:`magician.errors`. The end of a ``with`` block ends the session and releases its leases.
    """

    # [aio]
    def __init__(self, core: NativeStation) -> None:
        self._core = opened(core)
        self._hello: dict[str, Any] = from_json(core.hello())

    @classmethod
    def connect(
        cls, url: str = "http://127.0.0.1:8910", *, name: str = "python", token: str | None = None
    ) -> Connecting[Station]:
        """Starts a session: ``async with Station.connect() as station``, or ``station = await Station.connect()``.

        :param url: ``http://HOST:PORT``.
        :param name: name shown to other sessions.
        :param token: a token from ``magician station token``, if required; defaults to ``MAGICIAN_TOKEN`` of the
            environment.

        Raises :class:`~magician.errors.PortError` when there is no station,
        :class:`~magician.errors.ForbiddenError` when the token is invalid.
        """

        async def create() -> Station:
            return cls(await until(connecting(url, name, token)))

        return Connecting(create)

    # [blocking]
    # def __init__(
    #     self, url: str = "http://127.0.0.1:8910", *, name: str = "python", token: str | None = None
    # ) -> None:
    #     """Starts a session.
    #
    #     :param url: ``http://HOST:PORT``.
    #     :param name: name shown to other sessions.
    #     :param token: a token from ``magician station token``, if required; defaults to ``MAGICIAN_TOKEN`` of the
    #         environment.
    #
    #     Raises :class:`~magician.errors.PortError` when there is no station,
    #     :class:`~magician.errors.ForbiddenError` when the token is invalid.
    #     """
    #     self._core = opened(wait(connecting(url, name, token)))
    #     self._hello: dict[str, Any] = from_json(self._core.hello())
    # [both]

    async def __aenter__(self) -> Station:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    def __repr__(self) -> str:
        if not hasattr(self, "_core"):
            return "<Station, not connected>"
        return f"<Station, session {self.session}, {self._core.connection()}>"

    async def close(self) -> None:
        """Ends the session and releases its leases. A second call does nothing."""
        if self._core.is_here():
            await until(self._core.close())

    @property
    def session(self) -> str:
        """Id of the session."""
        return str(self._hello["session"])

    @property
    def role(self) -> str:
        """``"viewer"``, ``"student"`` or ``"teacher"``."""
        return str(self._hello["role"])

    @property
    def version(self) -> str:
        """Version of the station."""
        return str(self._hello["version"])

    @property
    def connected(self) -> bool:
        """True while the session is connected."""
        return self._core.connection() == "up"

    @property
    def jobs(self) -> Jobs:
        """Jobs: programs that the station runs."""
        return Jobs(self)

    async def call(self, method: str, **params: Any) -> Any:
        """Calls a method of the station's API by name and returns the result.

        ``station.call("arm.move", to=[220, 0, 50, 0])``. Parameters that are ``None`` are omitted; ``from_`` is sent as
        ``from``.
        """
        return from_json(await until(self._core.call(text("method", method), to_json(params))))

    async def arms(self) -> list[ArmEntry]:
        """Returns the arms of the station."""
        found = await self.call("arm.list")
        return [value_of(ArmEntry, each) for each in found["arms"]]

    async def state(self, arm: str | None = None) -> ArmState:
        """Returns the state of an arm, or of the only arm."""
        return value_of(ArmState, await self.call("arm.state", arm=arm))

    async def stop(self, arm: str | None = None) -> dict[str, Mapping[str, float]]:
        """Stops an arm, or all arms, also those of other sessions, and returns the resting pose of each."""
        stopped = await self.call("arm.stop", arm=arm)
        return {each["arm"]: each["pose"] for each in stopped["arms"]}

    # [aio]
    def arm(
        self,
        name: str | None = None,
        *,
        timeout: float = 5.0,
        reconnect: bool = True,
        fence: Mapping[str, object] | None = None,
    ) -> ConnectingArm:
        """Connects to an arm of the station, as :class:`magician.aio.Arm`: ``async with station.arm("left") as arm``.

        The whole package works with it as with an arm at a port. The first call that moves the arm or sets a value
        acquires the lease, which is released when the arm is closed; :meth:`lease` acquires it earlier, and can wait
        for it.

        :param name: name of the arm; optional if the station has only one.
        :param timeout: timeout of a single call to the arm, s.
        :param reconnect: whether to continue after the connection to the station was lost and restored.
        :param fence: limits for everything sent to the arm, in addition to those of the station.
        """
        return Arm.connect(ArmAt(self._core, name), timeout=timeout, reconnect=reconnect, fence=fence)

    def lease(
        self, arm: str | None = None, *, wait: float = 0.0, ask: str | None = None, take: bool = False
    ) -> Connecting[Lease]:
        """Acquires the lease of an arm, the right to move it: ``async with station.lease(wait=60)``.

        :param arm: name of the arm; optional if the station has only one.
        :param wait: maximum time to wait in the queue, s.
        :param ask: message to the holder, who may grant or refuse the lease; without an answer within 20 s it is
            transferred.
        :param take: whether to take the lease from its holder; for teachers.

        Raises :class:`~magician.errors.LeaseError` when another session has it.
        """

        async def create() -> Lease:
            return await self._lease(arm, wait, ask, take)

        return Connecting(create)

    # [blocking]
    # def arm(
    #     self,
    #     name: str | None = None,
    #     *,
    #     timeout: float = 5.0,
    #     reconnect: bool = True,
    #     fence: Mapping[str, object] | None = None,
    # ) -> Arm:
    #     """Connects to an arm of the station, as :class:`magician.Arm`: ``with station.arm("left") as arm``.
    #
    #     The whole package works with it as with an arm at a port. The first call that moves the arm or sets a value
    #     acquires the lease, which is released when the arm is closed; :meth:`lease` acquires it earlier, and can wait
    #     for it.
    #
    #     :param name: name of the arm; optional if the station has only one.
    #     :param timeout: timeout of a single call to the arm, s.
    #     :param reconnect: whether to continue after the connection to the station was lost and restored.
    #     :param fence: limits for everything sent to the arm, in addition to those of the station.
    #     """
    #     return Arm(ArmAt(self._core, name), timeout=timeout, reconnect=reconnect, fence=fence)
    #
    # def lease(
    #     self, arm: str | None = None, *, wait: float = 0.0, ask: str | None = None, take: bool = False
    # ) -> Lease:
    #     """Acquires the lease of an arm, the right to move it: ``with station.lease(wait=60)``.
    #
    #     :param arm: name of the arm; optional if the station has only one.
    #     :param wait: maximum time to wait in the queue, s.
    #     :param ask: message to the holder, who may grant or refuse the lease; without an answer within 20 s it is
    #         transferred.
    #     :param take: whether to take the lease from its holder; for teachers.
    #
    #     Raises :class:`~magician.errors.LeaseError` when another session has it.
    #     """
    #     return self._lease(arm, wait, ask, take)
    # [both]

    async def _lease(self, arm: str | None, max_wait: float, ask: str | None, take: bool) -> Lease:
        params: dict[str, Any] = {"arm": arm}
        if flag("take", take):
            method = "lease.take"
        elif ask is not None:
            method, params["message"] = "lease.ask", text("ask", ask)
        else:
            method, params["wait_s"] = "lease.acquire", seconds("wait", max_wait, most=3600)
        answer = from_json(await until(self._core.lease(method, to_json(params))))
        if answer.get("granted") is False:
            raise _conversion.failure("the holder keeps the lease", {"kind": "lease"})
        return Lease(self._core, arm, answer["lease"])

    async def answer(self, session: str, grant: bool, *, arm: str | None = None) -> None:
        """Grants or refuses the lease to a session that requested it: ``session`` of the notice ``"lease.asked"``."""
        await self.call("lease.answer", session=session, grant=flag("grant", grant), arm=arm)

    def notices(self) -> AsyncIterator[Notice]:
        """Subscribes to notifications of the station from now on. The subscription ends with the session."""
        return self._notices(self._core.notices())

    async def _notices(self, stream: NativeNotices) -> AsyncIterator[Notice]:
        while (notice := await until(stream.next())) is not None:
            method, payload = notice
            yield Notice(method, from_json(payload))

    async def watch(self, arm: str | None = None, *, rate: int = 20) -> AsyncIterator[ArmState]:
        """Watches an arm: yields its latest state after each change.

        :param arm: name of the arm; optional if the station has only one.
        :param rate: states per second, 1 to 50.

        The watch continues after a reconnect, and raises :class:`~magician.errors.PortError` when the session
        has ended.
        """
        state: dict[str, Any] = {}
        rate = whole("rate", rate, 1, 50)
        stream = self._core.notices()
        subscription = (await self.call("arm.subscribe", arm=arm, rate=rate))["subscription"]
        try:
            while (notice := await until(stream.next())) is not None:
                method, payload = notice
                if method == "connection" and payload == '"up"':
                    state.clear()
                    with suppress(PortError):
                        subscription = (await self.call("arm.subscribe", arm=arm, rate=rate))["subscription"]
                elif method == "arm.state" and (params := from_json(payload))["subscription"] == subscription:
                    state.update(params["state"])
                    if "arm" in state:
                        yield value_of(ArmState, state)
        finally:
            with suppress(Error):
                await self.call("arm.unsubscribe", subscription=subscription)
        raise PortError("the session at the station has ended")

    async def events(self, arm: str | None = None, *, since: int | None = None) -> AsyncIterator[StationEvent]:
        """Subscribes to events of an arm: alarms, finished commands, stops, leases, jobs.

        :param arm: name of the arm; optional if the station has only one.
        :param since: number of the last known event. The events after it are delivered first, then new ones. If left
            out, only new events are delivered.

        Events during a lost connection are delivered after the reconnect.
        """
        stream = self._core.notices()
        subscription = (await self.call("arm.subscribe", arm=arm, rate=1))["subscription"]
        history = await self.call("events.since", arm=arm, seq=0 if since is None else since)
        last: int = history["seq"] if since is None else since
        pending: list[Any] = [] if since is None else history["events"]
        arm = (await self.call("arm.state", arm=arm))["arm"]
        try:
            while True:
                for each in pending:
                    if each["seq"] > last:
                        last = each["seq"]
                        yield event(each)
                if (notice := await until(stream.next())) is None:
                    break
                method, payload = notice
                pending = []
                if method == "arm.event" and (params := from_json(payload))["arm"] == arm:
                    pending = [params]
                elif method == "connection" and payload == '"up"':
                    with suppress(PortError):
                        subscription = (await self.call("arm.subscribe", arm=arm, rate=1))["subscription"]
                        pending = (await self.call("events.since", arm=arm, seq=last))["events"]
        finally:
            with suppress(Error):
                await self.call("arm.unsubscribe", subscription=subscription)
        raise PortError("the session at the station has ended")


class Lease(Bound):
    """The right to move an arm, until :meth:`release` or the end of its ``with`` block."""

    def __init__(self, core: NativeStation, arm: str | None, lease: str) -> None:
        self._core = core
        self._held = True
        self.arm = arm
        """Name of the arm, if one was given."""
        self.lease = lease
        """Id of the lease."""

    def __repr__(self) -> str:
        return f"<Lease {self.lease}{'' if self._held else ', given back'}>"

    async def __aenter__(self) -> Lease:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(Error):
            await self.release()

    async def release(self) -> None:
        """Releases the lease; queued commands continue. If an arm of the session still needs the lease, it is kept."""
        if self._held:
            self._held = False
            await until(self._core.release(self.lease))


class Jobs(Bound):
    """Jobs of a station. The station checks programs, counts their completed steps, and pauses, resumes and stops
    them."""

    def __init__(self, station: Station) -> None:
        self._station = station

    def __repr__(self) -> str:
        return f"<Jobs of {self._station!r}>"

    async def check(
        self,
        program: Plan | str | os.PathLike[str] | bytes | None = None,
        *,
        name: str | None = None,
        arm: str | None = None,
        **options: Any,
    ) -> dict[str, Any]:
        """Checks a program from the arm's current pose. Nothing moves.

        Returns the result of ``magician run --check --json``. Parameters as for :meth:`start`.
        """
        found: dict[str, Any] = await self._station.call("job.check", arm=arm, **source(program, name, options))
        return found

    async def start(
        self,
        program: Plan | str | os.PathLike[str] | bytes | None = None,
        *,
        name: str | None = None,
        arm: str | None = None,
        **options: Any,
    ) -> StationJob:
        """Checks a program, starts it, and returns as soon as it runs. Requires the lease of the arm.

        :param program: a :class:`magician.Plan`, the path of a file, or a file's bytes.
        :param name: name of a program stored at the station, instead of ``program``.
        :param arm: name of the arm; optional if the station has only one.
        :param options: further parameters of ``job.start``: ``setup``, ``loops``, ``from_``, ``unhomed``, ..

        Raises :class:`~magician.errors.CheckFailedError` when the check fails; nothing was sent then.
        """
        started = await self._station.call("job.start", arm=arm, **source(program, name, options))
        return StationJob(self._station, started["job"])

    async def list(self, arm: str | None = None) -> list[JobState]:
        """Returns the last 50 jobs of an arm, newest last."""
        found = await self._station.call("job.list", arm=arm)
        return [value_of(JobState, each) for each in found["jobs"]]

    def get(self, job: str) -> StationJob:
        """Returns the job with this id."""
        return StationJob(self._station, text("job", job))


class StationJob(Bound):
    """A job of a station. It outlives this program, but pauses when its lease ends."""

    def __init__(self, station: Station, job: str) -> None:
        self._station = station
        self.job = job
        """Id of the job."""

    def __repr__(self) -> str:
        return f"<StationJob {self.job}>"

    async def _call(self, method: str, **params: Any) -> JobState:
        return value_of(JobState, await self._station.call(method, job=self.job, **params))

    async def state(self) -> JobState:
        """Returns the progress of the job."""
        return await self._call("job.get")

    async def pause(self) -> JobState:
        """Pauses the job: the pen is up, the laser off, and the arm may be moved."""
        return await self._call("job.pause")

    async def resume(self, *, approach: bool = True, yes: bool = False, overlap: float | None = None) -> JobState:
        """Resumes the job, also after a stop, a failure, or a crash of the station.

        :param approach: whether to approach the drawing safely, because the arm may have been moved.
        :param yes: confirms that the job may burn on a real arm.
        :param overlap: distance along the line by which a burn overlaps the burnt part, mm; for a job that has ended.
        """
        return await self._call(
            "job.resume",
            approach=flag("approach", approach),
            yes=flag("yes", yes) or None,
            overlap=number("overlap", overlap, least=0, most=1000, unit="mm"),
        )

    async def stop(self) -> JobState:
        """Stops the job and lifts its pen. No lease is required."""
        return await self._call("job.stop")

    async def changes(self) -> AsyncIterator[JobState]:
        """Yields the current progress and each change, at most ten per second, until the job ends.

        Raises :class:`~magician.errors.PortError` when the session has ended.
        """
        stream = self._station._core.notices()  # pyright: ignore[reportPrivateUsage]
        state = await self.state()
        yield state
        while not state.over:
            if (notice := await until(stream.next())) is None:
                raise PortError("the session at the station has ended")
            method, payload = notice
            new: JobState | None = None
            if method == "job.changed" and (job := from_json(payload)["job"])["job"] == self.job:
                new = value_of(JobState, job)
            elif method in ("connection", "missed") and payload != '"lost"':
                with suppress(PortError):
                    new = await self.state()
            if new is not None and new != state:
                state = new
                yield state

    async def wait(self, progress: Callable[[JobState], object] | None = None) -> JobState:
        """Waits until the job is done.

        :param progress: called with each change, at most ten times per second.

        Raises the error of a failed job, :class:`~magician.errors.StoppedError` if it was stopped, and
        :class:`~magician.errors.PortError` if it was interrupted or the session has ended. Interrupting the wait does
        not affect the job.
        """
        check_progress(progress)
        last: JobState | None = None
        async for last in self.changes():
            if progress is not None:
                progress(last)
        return require_done(last)
