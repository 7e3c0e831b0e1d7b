from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import magician
import pytest
from magician import errors

ANY = "127.0.0.1:0"
WORLD = 'tool = { kind = "suction" }\ntable = { height = -60 }\n'


@pytest.mark.parametrize("kind", ["tcp", "udp"])
def test_it_is_an_arm_for_whoever_connects(kind: str) -> None:
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


def test_an_exception_ends_it_too() -> None:
    with pytest.raises(ZeroDivisionError), magician.sim(tcp=ANY) as served:
        raise ZeroDivisionError
    assert not served.is_open
    port = int(str(served.tcp).rsplit(":", 1)[1])
    with pytest.raises(OSError), socket.create_connection(("127.0.0.1", port), timeout=5):
        pass


def test_its_world_and_its_tool() -> None:
    with magician.sim(WORLD, tcp=ANY, speed="max", tool=(70, 0, 0)) as served, magician.Arm(served.tcp) as arm:
        assert arm.bias() == (70, 0, 0)


def test_what_cannot_be_served() -> None:
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
def test_ctrl_c_is_heard_while_it_serves() -> None:
    with magician.sim(tcp=ANY) as served:
        assert served.wait(0)
        timer = threading.Thread(target=lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            served.wait()
        timer.join()
    assert not served.wait()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_program_that_forgets_it_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "arm"
    # Held for ever: only the end of the program ends it.
    hold = "import ctypes; ctypes.pythonapi.Py_IncRef(ctypes.py_object(served))"
    program = f"import magician; served = magician.sim(pty={str(path)!r}); print(served.pty); {hold}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == str(path)
    assert not path.is_symlink()
