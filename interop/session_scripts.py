"""Example programs of the libraries: session_scripts.py PTY UDP TCP SPEED MAGICIAN

pydobot, pydobotplus and pydobot2 have an example in their published description. Each runs
unmodified through `python -m magician.compat`, on a pseudo-terminal and in process, and with its
own library on a pseudo-terminal. The final pose and index are compared with each other and with
arm.py. Two of the three fail with their own library, and the corrections are listed with them.

Runs in an interpreter that has our package.
"""

import re
import subprocess
import sys
import time

import arm as model
from checks import Checks
from sim import run_on_sim
from venvs import HERE, python_for
from wire import Pty

# Runs a program with a list of ports in which the arm is at each of the first positions.
UNDER_THE_LIBRARY = """
import sys
sys.path.insert(0, sys.argv[2])
import whole_frames
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo
list_ports.comports = lambda *_: [ListPortInfo(sys.argv[1])] * 4
exec(compile(sys.stdin.read(), "example.py", "exec"), {"__name__": "__main__"})
"""
DESCRIPTION = "import importlib.metadata as m, sys; print(m.metadata(sys.argv[1]).get_payload() or m.metadata(sys.argv[1])['Description'])"
START = model.forward(model.POWER_UP_JOINTS)
# Index of the last of the four settings that the constructors queue.
PARAMETERS = model.FIRST_INDEX + 3

EXAMPLES = {
    # Two lines, there and back.
    "pydobot": ([], [], START, PARAMETERS + 2),
    # The example uses a name that it does not import, and the module has another name.
    "pydobotplus": (
        [(r"import Dobot\b", "import Dobot, CustomPosition")],
        [(r"from dobotplus\b", "from pydobotplus")],
        (200.0, 50.0, 50.0, 0.0),
        PARAMETERS + 4,
    ),
    # The library's move_to() has no parameter `wait`.
    "pydobot2": ([], [(r",\s*wait=(True|False)", "")], START, PARAMETERS + 2),
}


def example(library, python):
    """Returns the first program in the description of a library."""
    said = subprocess.run([python, "-c", DESCRIPTION, library], check=True, capture_output=True, text=True).stdout
    return re.search(r"```python\n(.*?)```", said, re.DOTALL)[1]


def apply_repairs(program, repairs):
    """Returns the program with the corrections that its own library needs."""
    for wrong, right in repairs:
        program, count = re.subn(wrong, right, program)
        if not count:
            raise AssertionError(f"the example has no {wrong!r} any more")
    return program


class Ended:
    """Output of a program, and the final state of the arm."""

    def __init__(self, magician, command, program):
        self.run, self.seconds, (self.pose, self.index) = run_on_sim(magician, command, program, standing)

    def is_good(self):
        """True if the program succeeded. Prints its output otherwise."""
        if self.run.returncode:
            print(self.run.stderr)
        return self.run.returncode == 0

    @property
    def sent(self):
        """Returns the frames that it reports as sent, without checksums and without queries of the
        index."""
        lines = [line for line in self.run.stdout.splitlines() if line.startswith("pydobot: >>")]
        return [line.rpartition(":")[0] for line in lines if ":246:" not in line]


def standing(path):
    """Returns pose and index once both are constant."""
    line = Pty(path)
    try:
        last, since = None, time.monotonic()
        while time.monotonic() - since < 0.3:
            now = line.pose(), line.index()
            if now != last:
                last, since = now, time.monotonic()
            time.sleep(0.01)
        return last
    finally:
        line.close()


def main():
    magician = sys.argv[5]
    ours = sys.executable
    checks = Checks()
    for library, (repairs, under_its_own, pose, index) in EXAMPLES.items():
        print(f"the example of {library}")
        theirs = python_for(f"{library}.txt")
        program = apply_repairs(example(library, theirs), repairs)
        own = apply_repairs(program, under_its_own)
        compat = [ours, "-B", "-m", "magician.compat", "--port"]
        found = Ended(magician, lambda path, script: [*compat, path, script], program)
        checks.ok("through magician.compat it ends well", found.is_good())
        checks.near("ends at", found.pose[:4], pose)
        checks.equal("at index", found.index, index)
        other = Ended(magician, lambda path, _: [theirs, "-B", "-c", UNDER_THE_LIBRARY, path, HERE], own)
        checks.ok("under its own library it ends well", other.is_good())
        checks.near("both end at", found.pose, other.pose)
        checks.equal("both at index", found.index, other.index)
        checks.equal("both send, as far as they say", found.sent, other.sent)
        inside = Ended(magician, lambda _, script: [*compat, "sim", script], program)
        checks.ok("in process it ends well", inside.is_good())
        print(f"  {found.seconds:.2f} s, under its own library {other.seconds:.2f} s, in process {inside.seconds:.2f} s")
    checks.finish()


if __name__ == "__main__":
    main()
