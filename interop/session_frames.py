"""The same calls with a library and through our stand-in for it: session_frames.py PTY UDP TCP SPEED MAGICIAN

Every program runs under its own library on a pseudo-terminal, and with `python -m magician.compat` on a fresh arm; what each
writes to the arm is compared frame by frame. Left out are the looks that are repeated until an arm has come somewhere: at the
queue's index, and at the pose while the library waits.

It runs in an interpreter that has our package.
"""

import re
import sys

from checks import Checks
from sim import run_on_sim
from venvs import HERE, python_for

# Both say each frame on stderr, as id, Ctrl and parameters.
THEIRS = """
import sys
sys.path.insert(0, sys.argv[2])
import patient
import serial
write = serial.Serial.write
def said(port, data):
    data = bytes(data)
    print("##", data[3], data[4], data[5:-1].hex(), file=sys.stderr)
    return write(port, data)
serial.Serial.write = said
exec(compile(sys.stdin.read(), "program.py", "exec"), {"__name__": "__main__"})
"""
OURS = """
import sys
from magician.compat import _line
exchange = _line.Line.exchange
def said(line, id, ctrl, params, **named):
    print("##", id, ctrl, params.hex(), file=sys.stderr)
    return exchange(line, id, ctrl, params, **named)
_line.Line.exchange = said
from magician.compat.__main__ import main
sys.argv = ["magician.compat", *sys.argv[1:]]
sys.exit(main())
"""
CURRENT_INDEX, POSE = 246, 10

NEWER = """
from {library} import Dobot
dobot = Dobot(PORT)
dobot.speed(80, 70)
dobot.move_to(220, 20, 30, 5)
dobot.go_arc(210, 0, 30, 0, 220, 10, 30, 0)
dobot.suck(True)
dobot.suck(False)
dobot.grip(True)
dobot.grip(False)
dobot.set_io(4, True)
dobot.set_home(200, 0, 50)
dobot.wait_for_cmd(dobot.home())
dobot.clear_alarms()
dobot.get_alarms()
dobot.get_pose()
dobot.close()
"""
# What pydobot2 fails at by itself, or does not have.
PLUS = """
dobot.conveyor_belt(0.5)
dobot.conveyor_belt(0)
dobot.conveyor_belt_distance(50, 10)
dobot.set_color(True)
dobot.get_color()
dobot.set_ir(True)
dobot.get_ir()
dobot.move_rel(x=5, z=-5)
dobot.laze(20, True)
dobot.laze(0, False)
dobot.set_hht_trig_output(True)
dobot.get_hht_trig_output()
dobot.jog_x(-10)
dobot.jog_x(0)
dobot.close()
"""
PROGRAMS = {
    "pydobot": """
from pydobot import Dobot
dobot = Dobot(port=PORT)
dobot.speed(80, 70)
dobot.move_to(220, 20, 30, 5, wait=True)
dobot.go(210, 0, 30)
dobot.suck(True)
dobot.suck(False)
dobot.grip(True)
dobot.grip(False)
dobot.set_eio(4, 1)
dobot.get_eio(4)
dobot.wait(10)
dobot.pose()
dobot.close()
""",
    "pydobot2": NEWER.format(library="pydobot"),
    **{
        library: NEWER.format(library=library).replace("dobot.close()\n", PLUS)
        for library in ("pydobotplus", "pydobotpp")
    },
}


def frames(said):
    """The frames that a program said, without the looks."""
    found = [(int(id), int(ctrl), params) for id, ctrl, params in re.findall(r"^## (\d+) (\d+) ?(\w*)$", said, re.M)]
    return [frame for frame in found if frame[0] not in (CURRENT_INDEX, POSE)]


def run(magician, command, program):
    """A program on an arm of its own: what it wrote, and how it ended."""
    ended, _, _ = run_on_sim(magician, command, f"import sys\nPORT = sys.argv[1]\n{program}")
    if ended.returncode:
        print(ended.stderr)
    return frames(ended.stderr), ended.returncode


def main():
    magician, ours = sys.argv[5], sys.executable
    checks = Checks()
    for library, program in PROGRAMS.items():
        print(f"what {library} writes")
        theirs = python_for(f"{library}.txt")
        under = [theirs, "-B", "-c", THEIRS]
        wrote, status = run(magician, lambda path, _, under=under: [*under, path, HERE], program)
        checks.equal("its own library ends well", status, 0)
        options = ["--pydobot", library] if library in ("pydobot", "pydobot2") else []
        through = [ours, "-B", "-c", OURS, *options]
        stood_in, status = run(magician, lambda path, script, through=through: [*through, script, path], program)
        checks.equal("the stand-in ends well", status, 0)
        checks.ok("frames were written", len(wrote) > 10)
        checks.equal("and the stand-in writes the same", stood_in, wrote)
    checks.finish()


if __name__ == "__main__":
    main()
