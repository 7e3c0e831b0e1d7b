from __future__ import annotations

import contextlib
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import errors
from stationed import Server

ANY = "127.0.0.1:0"
WORLD = 'tool = { kind = "suction" }\ntable = { height = -60 }\n'


@pytest.mark.parametrize("kind", ["tcp", "udp"])
def test_served_arm_accepts_connections(kind: str) -> None:
    tcp, udp = (ANY, None) if kind == "tcp" else (None, ANY)
    with magician.sim(speed="max", tcp=tcp, udp=udp) as served:
        where = served.tcp or served.udp or ""
        assert where.startswith(f"{kind}:127.0.0.1:")
        assert served.endpoints == (where,)
        with magician.Arm(where) as arm:
            arm.home()
            arm.move_to(220, 60, 20)
            assert arm.pose().x == pytest.approx(220, abs=0.01)
        assert served.is_open
    assert not served.is_open
    assert repr(served).endswith(", closed>")
    served.close()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_pseudo_terminal_is_gone_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "arm"
    with magician.sim(pty=path, tcp=ANY, speed="max") as served:
        assert served.pty == str(path)
        assert path.is_symlink()
        with magician.Arm(path) as one, magician.Arm(served.tcp) as other:
            one.home()
            assert other.pose() == one.pose()
        with pytest.raises(errors.PortError, match="is served already"):
            magician.sim(pty=path)
    assert not path.is_symlink()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_port_of_a_station_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = tmp_path / "arm"
    where = ("--port", str(path), "--listen", "127.0.0.1:0")
    with magician.sim(pty=path, speed="max"), Server(tmp_path, *where) as server:
        with pytest.raises(errors.PortError) as caught:
            magician.Arm(path)
        for error in (caught.value, magician.doctor(str(path)).error):
            assert isinstance(error, errors.PortError)
            assert error.station == f"{server.url}/"
            assert error.remedies == (f"use-station {error.station}",)
            way = f'`magician.Station("{error.station}")` uses the arm through the station that has its port'
            assert way in str(error)


def test_exception_in_with_block_closes_the_server() -> None:
    with pytest.raises(ZeroDivisionError), magician.sim(tcp=ANY) as served:
        raise ZeroDivisionError
    assert not served.is_open
    port = int(str(served.tcp).rsplit(":", 1)[1])
    with pytest.raises(OSError), socket.create_connection(("127.0.0.1", port), timeout=5):
        pass


def test_scenario_and_tool_reach_the_virtual_arm() -> None:
    with magician.sim(WORLD, tcp=ANY, speed="max", tool=(70, 0, 0)) as served, magician.Arm(served.tcp) as arm:
        assert arm.bias() == (70, 0, 0)


def test_invalid_endpoints_are_refused() -> None:
    with pytest.raises(errors.InvalidInputError, match="no endpoint to serve: give pty, udp or tcp"):
        magician.sim()
    with pytest.raises(errors.InvalidInputError, match="nowhere"):
        magician.sim(tcp="nowhere")
    with pytest.raises(errors.InvalidInputError, match="speed is 0"):
        magician.sim(tcp=ANY, speed=0)
    with pytest.raises(errors.InvalidInputError, match="scenario: "):
        magician.sim("table = 5\n", tcp=ANY)
    with pytest.raises(FileNotFoundError):
        magician.sim("no such scenario.toml", tcp=ANY)


def test_a_port_that_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        where = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(errors.PortError, match="cannot"):
            magician.sim(tcp=where)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_interrupts_wait() -> None:
    with magician.sim(tcp=ANY) as served:
        assert served.wait(0)
        timer = threading.Thread(target=lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            served.wait()
        timer.join()
    assert not served.wait()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_unclosed_server_removes_its_symlink_at_exit(tmp_path: Path) -> None:
    path = tmp_path / "arm"
    # Leak a reference, so that only the end of the program closes it.
    hold = "import ctypes; ctypes.pythonapi.Py_IncRef(ctypes.py_object(served))"
    program = f"import magician; served = magician.sim(pty={str(path)!r}); print(served.pty); {hold}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == str(path)
    assert not path.is_symlink()


def test_programs_share_an_arm() -> None:
    with magician.sim(tcp=ANY, speed="max") as behind, magician.proxy(behind.tcp, tcp=ANY) as shared:
        assert shared.endpoints == (shared.tcp,)
        assert shared.tcp != behind.tcp
        with magician.Arm(shared.tcp) as one, magician.Arm(shared.tcp) as other:
            one.home()
            one.move_to(220, 60, 20)
            assert other.pose().x == pytest.approx(220, abs=0.01)
    assert not shared.is_open
    assert not behind.is_open


def test_a_trace_of_what_was_shared(tmp_path: Path) -> None:
    path = tmp_path / "session.pcapng"
    with magician.proxy("sim", tcp=ANY, trace=path) as shared, magician.Arm(shared.tcp, probe=False) as arm:
        arm.pose()
    links = {piece.link for piece in magician.decode(path)}
    assert "arm sim" in links
    assert any(str(link).startswith("tcp:") for link in links)
    missing = tmp_path / "nowhere" / "session.pcapng"
    with pytest.raises(FileNotFoundError, match="cannot be written"):
        magician.proxy("sim", tcp=ANY, trace=missing)


def test_faults_on_the_line_that_is_shared() -> None:
    cell = magician.VirtualArm()
    with magician.proxy(cell, tcp=ANY, faults={"drop": 1.0, "seed": 7}) as shared:
        with pytest.raises(errors.ResponseTimeoutError):
            magician.Arm(shared.tcp, timeout=0.2)
        with pytest.raises(errors.InvalidInputError, match="is connected"):
            cell.restore(cell.snapshot())
    cell.restore(cell.snapshot())


def test_arguments_reach_the_proxy(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, object]] = []

    class StubCalled(Exception):
        pass

    def takes(*places: object, **how: object) -> None:
        asked.append(how)
        raise StubCalled

    monkeypatch.setattr("magician.serving._magician.serve_proxy", takes)
    anything: Any = magician
    for how in ({}, {"transparent": True}, {"keep_going": True}, {"fresh": 0.5}):
        with pytest.raises(StubCalled):
            anything.proxy("sim", tcp=ANY, **how)
    usual = {"faults": "", "trace": None, "fresh": 0.02, "transparent": False, "keep_going": False}
    assert asked == [usual, {**usual, "transparent": True}, {**usual, "keep_going": True}, {**usual, "fresh": 0.5}]


def test_closed_server_unregisters_its_exit_handler(monkeypatch: pytest.MonkeyPatch) -> None:
    forgotten: list[object] = []
    monkeypatch.setattr("magician.serving.atexit.unregister", forgotten.append)
    with magician.sim(tcp=ANY) as served:
        assert forgotten == []
    assert forgotten == [served.close]


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_path_for_each_program(tmp_path: Path) -> None:
    paths = [tmp_path / "a", tmp_path / "b"]
    with magician.proxy("sim", pty=paths) as shared:
        assert shared.endpoints == tuple(map(str, paths))
        assert shared.pty == str(paths[0])
        with magician.Arm(paths[0]) as one, magician.Arm(paths[1]) as other:
            assert one.pose() == other.pose()
    assert not any(path.is_symlink() for path in paths)
    with pytest.raises(errors.InvalidInputError, match="give each program a path of its own"):
        magician.proxy("sim", pty=[paths[0], paths[0]])


def test_invalid_proxies_are_refused(tmp_path: Path) -> None:
    trace = tmp_path / "kept"
    trace.write_text("what was written before")
    with pytest.raises(errors.InvalidInputError, match="no endpoint to serve"):
        magician.proxy("sim", trace=trace)
    with pytest.raises(errors.InvalidInputError, match="nowhere"):
        magician.proxy("sim", tcp="nowhere", trace=trace)
    with pytest.raises(errors.InvalidInputError, match="teleport"):
        magician.proxy("sim", tcp=ANY, faults={"teleport": 1})
    with pytest.raises(errors.InvalidInputError, match="fresh is -1"):
        magician.proxy("sim", tcp=ANY, fresh=-1)
    with pytest.raises(errors.PortError):
        magician.proxy("/dev/no-such-arm", tcp=ANY, trace=trace)
    assert trace.read_text() == "what was written before"


def test_log_reports_the_state_of_the_line() -> None:
    heard = threading.Event()

    class Hears(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if "looking for the line" in record.getMessage():
                heard.set()

    handler = Hears()
    logging.getLogger("magician").addHandler(handler)
    try:
        with magician.sim(tcp=ANY) as behind, magician.proxy(behind.tcp, tcp=ANY) as shared:
            behind.close()
            assert heard.wait(60)
            assert shared.is_open
    finally:
        logging.getLogger("magician").removeHandler(handler)


def test_served_virtual_arm_reflects_other_programs() -> None:
    cell = magician.VirtualArm(WORLD)
    before = cell.snapshot()
    with cell.serve(tcp=ANY) as served:
        program = f"import magician; magician.Arm({served.tcp!r}).move_to(220, 60, 20)"
        subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
        assert cell.position.x == pytest.approx(220, abs=0.01)
        with cell.arm() as own, magician.Arm(served.tcp) as other:
            own.suction(True)
            assert cell.suction
            assert other.pose() == own.pose()
    assert not served.is_open
    cell.restore(before)
    assert cell.position.x != pytest.approx(220, abs=0.01)
    with pytest.raises(errors.InvalidInputError, match="no endpoint to serve"):
        cell.serve()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_an_arm_is_put_back_while_it_is_served(tmp_path: Path) -> None:
    cell = magician.VirtualArm()
    before = cell.snapshot()
    with cell.serve(pty=tmp_path / "arm") as served:
        for x in (220, 240):
            cell.restore(before)
            program = f"import magician; magician.Arm({served.pty!r}).move_to({x}, 60, 20)"
            subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
            assert cell.position.x == pytest.approx(x, abs=0.01)
            while True:
                with contextlib.suppress(errors.InvalidInputError):
                    cell.restore(before)
                    break
