"""Programs that speak the protocol over a serial port of their own: as public ones open it, write and read."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HEAD = """
import glob, struct, threading, time
import serial
from serial.tools import list_ports

def package(id, ctrl, params=b""):
    body = bytes((id, ctrl)) + params
    return b"\\xaa\\xaa" + bytes((len(body),)) + body + bytes((-sum(body) & 255,))

POSE = package(10, 0)
"""
EXACT = """
port.write(POSE)
port.flush()
head = port.read(2) + port.read(1)
body = port.read(head[2])
port.read(1)
print(head[:2] == b"\\xaa\\xaa", round(struct.unpack_from("<f", body, 2)[0], 1), port.in_waiting)
"""
WHOLE = """
port.write(POSE)
answer = port.read_all()
print(answer[:2] == b"\\xaa\\xaa", round(struct.unpack_from("<f", answer, 5)[0], 1), port.inWaiting())
"""
HUNTED = """
port.write(POSE[:4])
port.write(POSE[4:])
two = 0
while two < 2:
    two = two + 1 if ord(port.read(1)) == 0xAA else 0
body = port.read(ord(port.read(1)))
print(port.read(1) != b"", round(struct.unpack_from("<f", body, 2)[0], 1), port.in_waiting)
"""
THREAD = """
found = []
reader = threading.Thread(target=lambda: found.append(port.read(38)))
reader.start()
port.write(POSE)
reader.join()
print(len(found[0]) == 38, round(struct.unpack_from("<f", found[0], 5)[0], 1), port.in_waiting)
"""
OPENINGS = {
    "by name": "port = serial.Serial(port='COM3', baudrate=115200, parity=serial.PARITY_NONE,"
    " stopbits=serial.STOPBITS_ONE, bytesize=serial.EIGHTBITS)",
    "in order": "port = serial.Serial(list_ports.comports()[1].device, 115200, timeout=60)",
    "later": "port = serial.Serial(); port.port, port.baudrate = 'COM3', 115200; port.open()",
    "globbed": "port = serial.Serial(glob.glob('/dev/cu*usb*')[0], 115200, write_timeout=1.0)",
}


def run(folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    path = folder / "script.py"
    path.write_text(HEAD + script)
    command = [sys.executable, "-m", "magician.compat", "--port", "sim", str(path)]
    return subprocess.run(command, capture_output=True, text=True, env={"PATH": ""}, timeout=300)


@pytest.mark.parametrize("opening", OPENINGS)
def test_a_port_is_opened_as_programs_open_it(tmp_path: Path, opening: str) -> None:
    done = run(
        tmp_path, f"{OPENINGS[opening]}\nassert port.isOpen(), port.name\n{EXACT}port.close()\nprint(port.is_open)"
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "True 259.1 0\nFalse\n", "")


@pytest.mark.parametrize("reading", [EXACT, WHOLE, HUNTED, THREAD], ids=["exact", "whole", "hunted", "thread"])
def test_answers_are_read_as_programs_read_them(tmp_path: Path, reading: str) -> None:
    done = run(tmp_path, OPENINGS["by name"] + reading)
    assert (done.returncode, done.stdout, done.stderr) == (0, "True 259.1 0\n", "")


def test_a_read_without_an_answer_ends_with_its_timeout(tmp_path: Path) -> None:
    script = "with serial.Serial('COM3', 115200, timeout=0) as port:\n    print(port.read(4), port.readline())"
    assert run(tmp_path, script).stdout == "b'' b''\n"


def test_a_closed_port_is_pyserial_s_exception(tmp_path: Path) -> None:
    script = """
port = serial.Serial("COM3", 115200)
port.close()
try:
    port.write(POSE)
except serial.SerialException as error:
    print("not open" in str(error))
"""
    assert run(tmp_path, script).stdout == "True\n"


def test_moves_end_and_an_exception_stops_the_arm(tmp_path: Path) -> None:
    script = """
port = serial.Serial("COM3", 115200)
def ask(*frame):
    port.write(package(*frame))
    head = port.read(3)
    return port.read(head[2] + 1)[2:-1]
ask(245, 1)
ask(240, 1)
index = struct.unpack("<Q", ask(84, 3, struct.pack("<B4f", 1, 220, 20, 30, 5)))[0]
while struct.unpack("<Q", ask(246, 0))[0] < index:
    pass
print(*(round(value) for value in struct.unpack_from("<4f", ask(10, 0))))
raise ValueError("so it goes")
"""
    done = run(tmp_path, script)
    assert done.stdout == "220 20 30 5\n"
    assert done.stderr.startswith("magician.compat: ended by an exception, so the arm at sim is stopped\n")


def test_a_program_that_waits_for_the_index_to_grow_ends(tmp_path: Path) -> None:
    """On an arm that takes no time too: all is done before the program asks."""
    script = """
port = serial.Serial("COM3", 115200)
def index():
    port.write(package(246, 0))
    return struct.unpack("<Q", port.read(14)[5:-1])[0]
port.write(package(240, 1))
port.read(6)
for y in (20, 40):
    port.write(package(84, 3, struct.pack("<B4f", 1, 220, y, 30, 5)) + package(110, 3, bytes(4)))
    port.read(28)
    asked = index()
    while index() <= asked:
        pass
print(index() == index())
"""
    assert run(tmp_path, script).stdout == "True\n"


def test_other_devices_are_not_the_arm(tmp_path: Path) -> None:
    script = """
board = serial.Serial("COM9", 115200, timeout=0)
board.write(b"led on")
print(board.readline())
try:
    serial.Serial("/dev/not-there", 9600, timeout=0).write(b"led on")
except (serial.SerialException, OSError) as error:
    print("elsewhere")
"""
    done = run(tmp_path, script)
    assert done.stdout.splitlines()[0] == "b''" and done.returncode == 0
