"""Sessions at a station: who moves, who looks, jobs, and what a cut line leaves."""

from __future__ import annotations

import json
import threading
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import errors
from magician.station import ArmState, JobState, Station
from stationed import Relay, Server

LINES = [(220.0, 30.0, 50.0), (220.0, -30.0, 50.0)]


def plan(times: int = 1) -> magician.Plan:
    return magician.Plan.path(LINES * times, title="to and fro")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    state = tmp_path_factory.mktemp("state")
    arms = ("--arm", "left=sim:20", "--arm", "right=sim:20", "--allow-host", "127.0.0.1")
    with Server(state, "--listen", "127.0.0.1:0", *arms) as server:
        yield server


@pytest.fixture
def station(server: Server) -> Iterator[Station]:
    with magician.Station(server.url, name="test") as station:
        yield station


@pytest.fixture
def other(server: Server) -> Iterator[Station]:
    with magician.Station(server.url, name="other") as station:
        yield station


@pytest.fixture
def relay(server: Server) -> Iterator[Relay]:
    with Relay(server.address) as relay:
        yield relay


def test_a_session_lists_arms_and_reads_them(station: Station) -> None:
    assert [(each.name, each.virtual, each.link) for each in station.arms()] == [
        ("left", True, "up"),
        ("right", True, "up"),
    ]
    state = station.state("left")
    assert isinstance(state, ArmState) and state.arm == "left" and state.tool.laser is False
    assert (station.role, station.connected) == ("teacher", True)
    assert station.version == magician.__version__
    assert repr(station) == f"<Station, session {station.session}, up>"
    pose = station.call("motion.forward", joints=[0, 45, 45, 0])
    assert pose["y"] == 0


def test_errors_have_their_classes(station: Station, other: Station) -> None:
    with pytest.raises(errors.InvalidInputError, match="unknown parameter"):
        station.call("arm.state", arm="left", speed=1)
    with pytest.raises(errors.UnsupportedError):
        station.call("arm.nonsense")
    with pytest.raises(errors.InvalidInputError, match="arm"):
        station.state()
    with pytest.raises(errors.LeaseError) as refused:
        station.call("arm.move", arm="left", to=[220, 0, 50, 0])
    assert refused.value.data["holder"] is None and isinstance(refused.value, errors.StationError)
    with other.lease("left"):
        with pytest.raises(errors.LeaseError) as refused:
            station.lease("left")
        assert refused.value.data["holder"]["name"] == "other"
    with station.lease("left"):
        with pytest.raises(errors.UnreachableError) as far:
            station.call("arm.move", arm="left", to=[900, 0, 50, 0])
        assert far.value.command == "SetPTPCmd"
        with pytest.raises(errors.DangerousError):
            station.call("arm.set", arm="left", command="DeviceSN", fields={"device_sn": "1"})
    with pytest.raises(TypeError, match="text, numbers"):
        station.call("arm.state", arm=object())
    with pytest.raises(errors.PortError):
        magician.Station("http://127.0.0.1:1")
    with pytest.raises(errors.InvalidInputError):
        magician.Station("ftp://here")


def test_a_wrong_token_is_refused(server: Server) -> None:
    with pytest.raises(errors.ForbiddenError):
        magician.Station(server.url, token="wrong")


def test_a_closed_session_is_over(server: Server) -> None:
    with magician.Station(server.url) as station:
        pass
    station.close()
    with pytest.raises(errors.ClosedError):
        station.arms()
    assert not station.connected


def test_the_lease_is_waited_for_asked_for_and_taken(
    station: Station, other: Station, meanwhile: Callable[[Callable[[], object]], threading.Thread]
) -> None:
    first = station.lease("left")
    notices = station.notices()
    asked = threading.Event()

    def answers() -> None:
        for notice in notices:
            if notice.method == "lease.asked":
                assert notice.params["message"] == "May I?"
                station.answer(notice.params["session"], asked.is_set(), arm="left")
                if asked.is_set():
                    return
                asked.set()

    # Listen before the first request.
    listening = meanwhile(answers)
    for wanted in (False, True):
        if not wanted:
            with pytest.raises(errors.LeaseError, match="keeps"):
                other.lease("left", ask="May I?")
        else:
            with other.lease("left", ask="May I?"):
                listening.join(60)
                with pytest.raises(errors.LeaseError):
                    station.call("arm.home", arm="left")
                with station.lease("left", take=True), pytest.raises(errors.LeaseError):
                    other.call("arm.home", arm="left")
    first.release()
    held = station.lease("left")
    got: list[str] = []

    def waits() -> None:
        with other.lease("left", wait=60) as lease:
            got.append(lease.lease)

    notices = other.notices()
    waiting = meanwhile(waits)
    assert next(notice for notice in notices if notice.method == "lease.queue").params["place"] == 1
    held.release()
    waiting.join(60)
    assert got


def test_an_arm_of_a_station_is_an_arm(station: Station, other: Station) -> None:
    with station.arm("left") as arm:
        assert arm.info().firmware
        assert other.state("left").holder is None
        arm.clear_alarms()
        arm.move_to(220, 40, 30)
        holder = other.state("left").holder
        assert holder is not None and holder.name == "test"
        assert round(arm.pose().y) == 40
        with other.arm("left") as another, pytest.raises(errors.Error, match="refused: test has the lease"):
            another.move_to(220, 0, 30)
        assert arm.run(plan()).steps > 1
        arm.suction(True)
    assert other.state("left").holder is None


def test_a_lease_outlives_the_arm_that_shares_it(station: Station, other: Station) -> None:
    with station.lease("right") as lease:
        with station.arm("right") as arm:
            arm.clear_alarms()
        holder = other.state("right").holder
        assert holder is not None and holder.session == station.session
        station.call("lease.renew", lease=lease.lease)
    assert other.state("right").holder is None


def test_an_arm_is_connected_to_by_the_address_of_its_station(server: Server) -> None:
    with magician.Arm(f"{server.url}/right") as arm:
        arm.home()
        arm.move_to(220, 0, 40)
        assert round(arm.pose().z) == 40
        # A station's virtual arm needs no laser permission.
        arm.set(magician.commands.SetEndEffectorLaser(enable_ctrl=True, on=True))
    with pytest.raises(errors.InvalidInputError, match="left, right"):
        magician.Arm(server.url)
    with pytest.raises(errors.InvalidInputError, match="left, right"):
        magician.Arm(f"{server.url}/middle")


def test_a_watch_gives_the_newest_states(station: Station, other: Station) -> None:
    with other.arm("right") as arm:
        arm.home()
        states = station.watch("right", rate=50)
        assert next(states).y == pytest.approx(0)
        arm.move_to(220, 60, 40)
        state = next(state for state in states if state.y == pytest.approx(60) and not state.moving)
        assert state.t > 0 and state.holder is not None
        states.close()  # type: ignore[attr-defined]


def test_events_are_numbered(station: Station) -> None:
    station.stop("left")
    events = station.events("left", since=0)
    seen = next(events)
    assert (seen.arm, seen.seq) == ("left", 1)
    with station.lease("left"):
        given = next(event for event in events if event.event == "lease" and event.data["holder"])
    assert given.seq > seen.seq


def test_jobs_are_checked_run_paused_and_stopped(station: Station, other: Station, tmp_path: Path) -> None:
    with station.arm("left") as arm:
        arm.home()
    assert station.jobs.check(plan(), arm="left")["ok"] is True
    far = magician.Plan.path([(200, 0, 0), (900, 0, 0)], title="far")
    with station.lease("left"):
        with pytest.raises(errors.CheckFailedError) as refused:
            station.jobs.start(far, arm="left")
        assert refused.value.data["report"]["refused"] >= 1
        told: list[JobState] = []
        job = station.jobs.start(plan(), arm="left")
        done = job.wait(told.append)
        assert (done.state, done.share, done.over) == ("done", 1.0, True)
        assert told[-1] == done and told[-1].title == "to and fro"
        path = tmp_path / "moves.plan.json"
        path.write_text(plan(20).to_json(), encoding="utf-8")
        job = station.jobs.start(path, arm="left", loops=0)
        with pytest.raises(errors.BusyError):
            station.call("arm.home", arm="left")
        assert job.pause().state == "paused"
        assert job.resume().state == "running"
        assert other.jobs.get(job.job).stop().state == "stopped"
        with pytest.raises(errors.StoppedError):
            job.wait()
    assert [each.state for each in station.jobs.list("left")][-2:] == ["done", "stopped"]


def test_a_drawing_is_placed_by_its_setup_and_a_kept_program_runs_by_its_name(station: Station) -> None:
    size = 'width="40mm" height="20mm" viewBox="0 0 40 20"'
    box = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><path d="M0 0H40V20H0Z"/></svg>'.encode()
    setup = {"tool": "pen", "surface": -40, "at": [220, -30], "rotate": 90}
    found = station.jobs.check(box, arm="left", format="svg", setup=setup)
    assert found["ok"] is True and found["drawn_mm"] == pytest.approx(120, abs=0.1)
    turned = found["bounds"]
    level = station.jobs.check(box, arm="left", format="svg", setup={**setup, "rotate": 0})["bounds"]
    assert turned["x"][1] - turned["x"][0] == pytest.approx(level["y"][1] - level["y"][0], abs=0.1)
    station.call("program.put", name="box.svg", text=box.decode())
    with station.lease("left"):
        done = station.jobs.start(name="box.svg", arm="left", setup=setup).wait()
    assert done.state == "done" and done.drawn_mm == pytest.approx(120, abs=0.1)
    with station.lease("left"), pytest.raises(errors.InvalidInputError, match="nothing"):
        station.jobs.start(box, arm="left", format="svg", setup={"nothing": 1})
    with pytest.raises(TypeError, match="one program"):
        station.jobs.check()
    with pytest.raises(TypeError, match="one program"):
        station.jobs.check(box, name="box.svg")


def test_a_stop_by_anybody_ends_the_wait_for_a_job(station: Station, other: Station) -> None:
    with station.lease("right"):
        station.call("arm.home", arm="right")
        job = station.jobs.start(plan(50), arm="right", loops=0)

        def stops(state: JobState) -> None:
            if state.state == "running":
                assert other.stop("right")["right"]["x"] > 0

        with pytest.raises(errors.StoppedError):
            job.wait(stops)


def until_cut(station: Station, relay: Relay) -> Iterator[Any]:
    """Cuts the line, and gives the notices until the connection is back."""
    notices = station.notices()
    station.call("arm.list")
    relay.cut()
    for notice in notices:
        yield notice
        if notice.method == "connection" and notice.params == "up":
            return


def test_a_session_comes_back_with_its_lease(relay: Relay, other: Station) -> None:
    with magician.Station(relay.url, name="cut") as station:
        lease = station.lease("left")
        news = [notice.params for notice in until_cut(station, relay) if notice.method == "connection"]
        assert news == ["lost", "up"]
        station.call("lease.renew", lease=lease.lease)
        holder = other.state("left").holder
        assert holder is not None and holder.name == "cut"


def test_a_watch_and_an_arm_go_on_after_a_cut(relay: Relay) -> None:
    with magician.Station(relay.url, name="cut") as station, station.arm("left") as arm:
        arm.clear_alarms()
        states = station.watch("left", rate=50)
        before = next(states)
        list(until_cut(station, relay))
        assert next(state for state in states if state.t > before.t).link == "up"
        # The pending call has failed. The line comes back soon after the session.
        try:
            arm.pose()
        except errors.PortError:
            arm.reconnected()
        arm.move_to(220, 20, 40)
        assert round(arm.pose().y) == 20
        states.close()  # type: ignore[attr-defined]


def test_a_job_waits_over_a_cut(relay: Relay) -> None:
    with magician.Station(relay.url, name="cut") as station:
        with station.arm("left") as arm:
            arm.home()
        with station.lease("left"):
            job = station.jobs.start(plan(3), arm="left")
            cuts = iter([relay.cut])

            def cuts_once(state: JobState) -> None:
                for cut in cuts:
                    cut()

            assert job.wait(cuts_once).state == "done"


def test_dead_station_is_notified(tmp_path: Path) -> None:
    server = Server(tmp_path, "--port", "sim", "--listen", "127.0.0.1:0")
    with server, magician.Station(server.url) as station:
        notices = station.notices()
        station.arms()
        server.kill()
        assert next(notice for notice in notices if notice.method == "connection").params == "lost"
        with pytest.raises(errors.PortError, match="station"):
            station.arms()


def test_asyncio_has_the_same(server: Server) -> None:
    import asyncio

    async def program() -> None:
        async with magician.aio.Station.connect(server.url, name="aio") as station:
            assert [each.name for each in await station.arms()] == ["left", "right"]
            async with station.lease("left"), station.arm("left") as arm:
                await arm.home()
                states = station.watch("left", rate=50)
                await arm.move_to(220, 25, 45)
                async for state in states:
                    if state.y == pytest.approx(25):
                        break
                await states.aclose()  # type: ignore[attr-defined]
                job = await station.jobs.start(plan(), arm="left")
                assert (await job.wait()).state == "done"
            with pytest.raises(errors.LeaseError):
                await station.call("arm.home", arm="left")
        again = await magician.aio.Station.connect(server.url)
        await again.close()

    asyncio.run(program())


def test_every_example_of_the_document_succeeds(tmp_path: Path) -> None:
    """As it says of itself: on `--port sim`, the ids being those of the call that `x-after` names."""
    with Server(tmp_path, "--port", "sim:20", "--listen", "127.0.0.1:0") as server:
        with urllib.request.urlopen(f"{server.url}/api/v1/openrpc.json") as answer:
            document = json.load(answer)
        with magician.Station(server.url) as station:
            results: dict[str, Any] = {"session.hello": {"session": station.session}}
            for method in document["methods"]:
                name = method["name"]
                (example,) = method["examples"]
                params = {each["name"]: each["value"] for each in example["params"]}
                if "x-after" in example:
                    # Some methods have only an effect and return null.
                    earlier: dict[str, Any] = results[example["x-after"]] or {}
                    params.update({each: earlier[each] for each in params if each in earlier})
                if name == "session.hello" or method["x-notification"]:
                    continue
                if method["x-lease"] or name == "lease.answer":
                    station.call("lease.acquire")
                results[name] = station.call(name, **params)
