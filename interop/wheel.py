"""Checks for an installed package on any platform: wheel.py SAMPLE

Prints only a verdict for each check. Runs in the Python for which the package is installed,
possibly of another system or processor, and needs only the package and checks.py.
"""

import asyncio
import contextlib
import os
import pathlib
import sys
import tempfile
import threading

import magician
from magician import aio, commands, words
from magician.compat import pydobot

from checks import Checks


def drives(checks):
    with magician.Arm("sim") as arm:
        arm.home()
        arm.move_to(220, 60, 20, 0)
        pose = arm.pose()
        checks.near("move_to", (pose.x, pose.y, pose.z, pose.r), (220, 60, 20, 0))
        arm.set(commands.PtpCommonParams(30, 40))
        checks.equal("set and get", arm.get(commands.PtpCommonParams), commands.PtpCommonParams(30, 40))
        ran = arm.perform([words.line_to(220, 60 - 10 * n, 20, 0) for n in range(12)])
        checks.equal("a program", ran.commands, 12)
        try:
            arm.move_to(500, 0, 0)
            checks.ok("out of reach is refused", False)
        except magician.errors.UnreachableError as error:
            checks.ok("out of reach is refused", error.value > error.limit, error)


def rehearses(checks, sample):
    plan = magician.load(sample, surface=-60)
    report = plan.check()
    checks.ok("a plan is rehearsed", report.ok and report.seconds > 0, f"{report.seconds:.1f} s of drawing")
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder, "plan.svg")
        plan.preview(picture)
        checks.ok("its preview", picture.read_text(encoding="utf-8").startswith("<svg"), f"{picture.stat().st_size} bytes")
        saved = pathlib.Path(folder, "plan.json")
        plan.save(saved)
        checks.equal("saved and loaded", len(magician.load(saved)), len(plan))
    cell = magician.VirtualArm()
    with cell.arm() as arm:
        done = arm.run(plan)
        checks.equal("run on a virtual arm", done.steps, len(plan))


def both_ways(checks):
    async def two():
        async with aio.Arm.connect("sim") as one, aio.Arm.connect("sim") as other:
            await asyncio.gather(one.move_to(220, 40, 20), other.move_to(220, -40, 20))
            return (await one.pose()).y, (await other.pose()).y

    checks.near("two arms with asyncio", asyncio.run(two()), (40, -40))
    device = pydobot.Dobot("sim")
    before = device.pose()[0]
    device.move_to(before + 20, 0, 20, 0, wait=True)
    checks.near("a program for pydobot", device.pose()[0] - before, 20)
    device.close()


def looks(checks):
    checks.ok("a list of ports", isinstance(magician.ports(), list))
    try:
        magician.Arm("COM99" if sys.platform == "win32" else "/dev/ttyUSB99")
        checks.ok("a port that is not there", False)
    except magician.errors.PortError as error:
        checks.ok("a port that is not there", True, error)


def leaves_a_thread():
    """Leaves a thread in a call when the interpreter ends. Its stack is unwound through our
    code."""
    arm = magician.Arm("sim:1")
    arm.clear_alarms()

    def for_ever():
        while True:
            with contextlib.suppress(magician.errors.ClosedError):
                arm.pose()

    threading.Thread(target=for_ever, daemon=True).start()


def main():
    checks = Checks()
    # The module platform asks Windows for information that Wine does not have.
    machine = os.uname().machine if hasattr(os, "uname") else ""
    print(f"  Python {sys.version.split()[0]}, {sys.platform} {machine}".rstrip())
    checks.section(drives)
    checks.section(rehearses, sys.argv[1])
    checks.section(both_ways)
    checks.section(looks)
    leaves_a_thread()
    checks.finish()


main()
