"""Looking, listening and jogging, without asyncio."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Callable
from typing import Any

import magician
import pytest
from magician import Arm, commands, errors, events, words
from magician.commands import IoFunction


def test_state(arm: Arm) -> None:
    arm.multiplex(19, IoFunction.DIGITAL_INPUT)
    arm.multiplex(17, IoFunction.DIGITAL_OUTPUT)
    arm.multiplex(12, IoFunction.ANALOG_INPUT)
    arm.output(17, True)
    watch = arm.state(200, inputs=[19], outputs=[17], analogs=[12])
    status = watch.changed()
    assert status.pose == arm.pose() and status.left_space == 32 and status.alarms == ()
    assert status.current_index == arm.current_index() and status.link
    assert (status.inputs, status.outputs, status.analogs) == ({19: False}, {17: True}, {12: 0})
    assert status.time <= time.monotonic()
    seen = [status for status, _ in zip(watch, range(3), strict=False)]
    assert len(seen) == 3 and watch.latest is not None
    arm.close()
    assert list(watch) == []
    with pytest.raises(errors.ClosedError):
        watch.changed()


def test_a_watch_that_cannot_be(arm: Arm) -> None:
    with pytest.raises(errors.InvalidInputError, match=r"0\.01 to 1000"):
        arm.state(0)
    for address in (-1, 300):
        with pytest.raises(errors.InvalidInputError, match=f"analogs.0. is {address}; .* 1 to 20"):
            arm.state(analogs=[address])
    with pytest.raises(errors.InvalidInputError, match="1 to 20"):
        arm.state(10, inputs=[21])


def test_events(arm: Arm) -> None:
    happened = arm.events()
    arm.perform([words.wait(0.1)])
    arm.set(words.move_to(500, 0, 0, 0))
    arm.alarms()
    arm.clear_alarms()
    arm.alarms()
    arm.close()
    last = list(happened)
    finished = [event for event in last if isinstance(event, events.CommandFinished)]
    assert finished and finished[-1].last >= finished[0].first
    assert events.AlarmRaised(magician.Alarm.PLAN_INV_CALC) in last
    assert events.AlarmCleared(magician.Alarm.PLAN_INV_CALC) in last


def test_jog(slow: Arm) -> None:
    before = slow.pose()
    with slow.jog("j1+", ratio=50, keep=2) as jog:
        for status in slow.state(100):
            jog.keep()
            if status.pose.j1 > before.j1 + 1:
                break
    after = slow.pose()
    assert after.j1 > before.j1 + 1 and after == slow.pose()
    assert slow.get(commands.JogCommonParams).velocity_ratio == 50
    with pytest.raises(errors.ClosedError, match="ended"):
        jog.keep()


def test_jog_without_keep_alive_ends(slow: Arm) -> None:
    too_late = pytest.raises(errors.ResponseTimeoutError, match="it was not renewed")
    with slow.jog(words.jog("x+"), keep=0.02) as jog, too_late:
        while True:
            slow.wait_still()
            jog.keep()
    slow.wait_still()


def test_a_jog_that_is_stopped(slow: Arm) -> None:
    with slow.jog("z+", keep=2) as jog:
        slow.stop()
        with pytest.raises(errors.ClosedError, match="stop"):
            jog.keep()
    with slow.jog("z-", keep=2) as first, slow.jog("z+", keep=2) as second:
        with pytest.raises(errors.ClosedError, match="another jog"):
            first.keep()
        second.keep()
    slow.stop_jog()

    class Mine(Exception):
        pass

    with pytest.raises(Mine), slow.jog("y+", keep=2):
        raise Mine
    slow.wait_still()


def test_jog_of_another_axis_begins_when_the_arm_stands(slow: Arm) -> None:
    with slow.jog("x+", keep=2) as first:
        time.sleep(0.5)
        with slow.jog("y+", keep=2) as second:
            stood = slow.pose()
            with pytest.raises(errors.ClosedError, match="another jog"):
                first.keep()
            time.sleep(0.3)
            second.keep()
            moved = slow.pose()
    # Only y moves now. A real arm would carry the speed of x over to y.
    assert moved.x == pytest.approx(stood.x, abs=0.001)
    assert moved.y > stood.y


def test_jog_that_nothing_holds_is_refused(slow: Arm) -> None:
    before = slow.pose()
    jog = words.jog("j1+")
    sends: list[Callable[[], object]] = [
        lambda: slow.set(jog),
        lambda: slow.enqueue(jog),
        lambda: slow.run([jog]),
        lambda: slow.raw(73, 1, bytes([1, 1])),
    ]
    for send in sends:
        with pytest.raises(errors.InvalidInputError, match=r"arm\.jog\(\.\.\)"):
            send()
    slow.set(commands.JogCmd(False, commands.JogCommand.STOP))
    assert slow.pose() == before


def test_jog_into_the_end_of_its_axis_ends(slow: Arm) -> None:
    slow.move_joints(133, 45, 45, 0)
    with pytest.raises(errors.UnreachableError, match="end of its"), slow.jog("j1+", ratio=100, keep=1) as jog:
        while True:
            time.sleep(0.05)
            jog.keep()
    assert slow.pose().j1 == pytest.approx(135, abs=0.01)


def test_invalid_jogs_are_refused(arm: Arm) -> None:
    untyped: Any = arm
    jogs: list[Callable[[], magician.Jog]] = [
        lambda: untyped.jog("up"),
        lambda: untyped.jog(words.suction(True)),
        lambda: untyped.jog("x+", keep=3),
        lambda: untyped.jog("x+", ratio=0),
        lambda: untyped.jog(commands.JogCmd(False, commands.JogCommand.STOP)),
    ]
    for jog in jogs:
        with pytest.raises(errors.InvalidInputError), jog():
            pass
    with pytest.raises(errors.ClosedError, match="not begun"):
        arm.jog("x+").keep()


@contextlib.contextmanager
def bridge(meanwhile: Callable[[Callable[[], object]], object], end: Callable[[socket.socket], object]) -> Any:
    """A TCP port with a program behind it that takes one connection."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            connection, _ = server.accept()
            with connection:
                end(connection)

        meanwhile(serve)
        yield f"tcp:127.0.0.1:{server.getsockname()[1]}"


def test_a_line_that_breaks(meanwhile: Callable[[Callable[[], object]], object]) -> None:
    with bridge(meanwhile, lambda connection: connection.recv(1)) as port:
        arm = Arm(port, probe=False, reconnect=False)
        happened = arm.events()
        with pytest.raises(errors.PortError, match="broke off"):
            arm.pose()
        assert arm.link.state == "lost" and not arm.link.sought
        assert arm.link.why and arm.link.since is not None and arm.link.since <= time.monotonic()
        with pytest.raises(errors.PortError):
            arm.reconnected()
        arm.close()
        (lost,) = happened
        assert isinstance(lost, events.LinkLost) and lost.why


def test_a_stranger(meanwhile: Callable[[Callable[[], object]], object]) -> None:
    def talk(connection: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while connection.recv(100):
                connection.sendall(b"hello\n")

    with bridge(meanwhile, talk) as port, pytest.raises(errors.Error, match=r"not from this arm|another device"):
        Arm(port, timeout=3, reconnect=False)


def test_watches_end_with_their_blocks(arm: Arm) -> None:
    with arm.state(100) as watch:
        assert watch.changed().link and watch.latest is not None
    assert watch.latest is None and repr(watch) == "<StateWatch, closed>" and list(watch) == []
    with pytest.raises(errors.ClosedError, match="the watch was closed"):
        watch.changed()
    with pytest.raises(KeyError), arm.events() as happened:
        raise KeyError
    assert list(happened) == []
    assert arm.link
