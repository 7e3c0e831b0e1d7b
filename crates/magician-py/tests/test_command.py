from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from importlib.metadata import entry_points

import pytest

COMMAND = [sys.executable, "-m", "magician"]


def run(*words: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAGICIAN_")}
    return subprocess.run([*COMMAND, *words], capture_output=True, text=True, timeout=60, check=False, env=environment)


def test_the_command_comes_with_the_package() -> None:
    ended = run("--port", "sim", "--json", "pose")
    assert ended.returncode == 0, ended.stderr
    assert set(json.loads(ended.stdout)) == {"x", "y", "z", "r", "j1", "j2", "j3", "j4"}


def test_its_errors_and_its_exit_status_are_the_commands() -> None:
    ended = run("--port", "sim", "--json", "move", "900", "0", "0")
    assert ended.returncode == 3
    assert json.loads(ended.stderr)["error"]["kind"] == "unreachable"
    assert run("drow").returncode == 2


def test_its_log_is_its_own() -> None:
    ended = run("-v", "--port", "sim:1000", "pose")
    assert ended.returncode == 0 and "Traceback" not in ended.stderr


def test_a_script_of_that_name_is_installed() -> None:
    (script,) = [each for each in entry_points(group="console_scripts") if each.name == "magician"]
    assert script.value == "magician._command:main"


@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C reaches the test too")
def test_ctrl_c_ends_it_as_it_ends_the_command() -> None:
    words = [*COMMAND, "sim", "--tcp", "127.0.0.1:0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as served:
        assert served.stdout is not None and served.stderr is not None
        assert served.stdout.readline() == "ready\n"
        served.send_signal(signal.SIGINT)
        said = served.stderr.read()
        assert served.wait(30) in (0, 130)
        assert "Traceback" not in said
