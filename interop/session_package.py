"""Our Python package on a pseudo-terminal and in process: session_package.py PTY UDP TCP SPEED
MAGICIAN

Compares poses with the model in arm.py, and indices with those that an observer reads over UDP.
"""

import asyncio
import pathlib
import sys
import tempfile

import magician
from magician import aio, commands, words

import arm as model
from checks import Checks
from wire import Observer

MOVES = [(220.0, 60.0, 40.0, 15.0), (240.0, -50.0, 10.0, -20.0), (200.0, 80.0, 20.0, 0.0)]


def pose_values(pose):
    """Returns the numbers of a pose."""
    return pose.x, pose.y, pose.z, pose.r, pose.j1, pose.j2, pose.j3, pose.j4


def drive(checks, arm, reference):
    arm.home()
    checks.near("after homing", pose_values(arm.pose()), (*reference.pose, *reference.joints))
    for target in MOVES:
        arm.move_to(*target)
        reference.move(model.MOVJ_XYZ, *target)
        checks.near(f"move_to{target}", pose_values(arm.pose()), (*reference.pose, *reference.joints))
    arm.move_to(210.0, 0.0, 20.0, linear=True)
    checks.near("in a line, r kept", pose_values(arm.pose())[:4], (210, 0, 20, 0))
    summary = arm.perform([words.move_to(200 + n, 0, 20, 0) for n in range(50)])
    checks.equal("a program longer than the queue", (summary.commands, summary.last - summary.first), (50, 49))
    arm.set(commands.PtpCommonParams(30, 40))
    checks.equal("set and get", arm.get(commands.PtpCommonParams), commands.PtpCommonParams(30, 40))
    try:
        arm.move_to(500.0, 0.0, 0.0)
        checks.ok("out of reach is refused", False)
    except magician.errors.UnreachableError as error:
        checks.ok("out of reach is refused", error.value > error.limit, error)
    return summary.last


def refuses_unhomed(checks, port):
    """Checks that a drawing is refused on an arm that was not homed after power-up."""
    with tempfile.TemporaryDirectory() as folder, magician.Arm(port) as arm:
        file = pathlib.Path(folder, "pen.gcode")
        file.write_text("G21 G90\nG0 X220 Y0 Z10\nG1 Z-10 F900\nG1 X230\n")
        plan = magician.load(file)
        try:
            arm.run(plan)
            checks.ok("an arm that was not homed is not drawn with", False)
        except magician.errors.InvalidInputError as error:
            named = all(name in str(error) for name in ("`arm.home()`", "unhomed=True"))
            checks.ok("an arm that was not homed is not drawn with", named and arm.current_index() == 0, error)
        checks.equal("unhomed=True goes on", arm.run(plan, unhomed=True).pen, "up")
        checks.near("and lifts the pen", arm.pose().z, 0)


def main():
    port, udp = sys.argv[1], int(sys.argv[2])
    checks = Checks()
    observer = Observer(udp)
    print("on the pseudo-terminal")
    refuses_unhomed(checks, port)
    with magician.Arm(port) as arm:
        last = drive(checks, arm, model.Arm())
    observer.reached(last)
    checks.equal("what an observer sees last", observer.looks[-1][1], last)
    print("in process")
    with magician.Arm("sim") as arm:
        drive(checks, arm, model.Arm())
    print("asyncio")

    async def both():
        async with aio.Arm.connect(port) as one, aio.Arm.connect("sim") as other:
            return await asyncio.gather(one.pose(), other.pose())

    there, here = asyncio.run(both())
    checks.ok("two arms at once", there.x > 200 and here.x > 190, f"{there.x:.1f}, {here.x:.1f}")
    observer.close()
    checks.equal("nothing disturbed the observer on UDP", observer.error, None)
    checks.finish()


if __name__ == "__main__":
    main()
