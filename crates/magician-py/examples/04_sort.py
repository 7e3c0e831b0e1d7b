"""Sorts cubes by colour: a belt brings them, an infrared sensor tells when one is there, the suction cup takes it to
the colour sensor and from there to its place on the table.

``python 04_sort.py`` sorts in the virtual world of ``crates/magician-sim/scenarios/pick_and_sort.toml``; at the end the
program looks there whether every cube is where it belongs. To watch the same program in real time, start ``magician sim
--pty ./arm --scenario crates/magician-sim/scenarios/pick_and_sort.toml`` in one terminal and ``python 04_sort.py
./arm`` in another.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import magician
from magician import Arm, Color, words
from magician.commands import IoFunction, Port, Queueable, SensorVersion, Stepper

CELL = Path(__file__).parents[2] / "magician-sim" / "scenarios" / "pick_and_sort.toml"
BUTTON = 15
BELT = Stepper.STEPPER1
AT_THE_BELT = Port.GP2
ON_THE_TABLE = Port.GP1

BELT_SPEED = 50.0
"""mm/s."""
SENSOR_INTERVAL = 0.02
"""Time between two checks of the sensor while the belt runs, s: 1 mm of belt."""
MAX_CHECKS = 500
"""Checks without an object after which the belt counts as empty."""

Place = tuple[float, float, float]

PICK: Place = (260, 0, -10)
"""Where the cup goes, mm: on a cube that the sensor has stopped."""
SHOW: Place = (160, 180, -10)
"""Over the colour sensor with one."""
PLACES: dict[Color, Place] = {
    Color.RED: (140, -200, -50),
    Color.GREEN: (170, -200, -50),
    Color.BLUE: (200, -200, -50),
}
"""Where cubes of a colour belong, a cube's height above the table."""


def carry(to: Place, hold: bool) -> Iterator[Queueable]:
    """Up, over, down, and the cup holds or lets go."""
    yield words.jump_to(*to, 0)
    yield words.suction(hold)
    yield words.wait(0.5)


def cube_comes(arm: Arm) -> bool:
    """Runs the belt until a cube stands before the sensor; ``False`` if none comes."""
    arm.conveyor(BELT, BELT_SPEED)
    try:
        for _ in range(MAX_CHECKS):
            if arm.infrared_at(AT_THE_BELT):
                return True
            # Let the arm wait, not the program, so that this works on a virtual arm at full speed too.
            arm.wait(SENSOR_INTERVAL)
        return False
    finally:
        arm.conveyor(BELT, 0)


def sort(arm: Arm) -> list[Color]:
    """Sorts until the belt is empty. Returns the colours of the sorted cubes."""
    arm.home()
    arm.tool("suction")
    arm.jump_height(40, 100)
    arm.infrared(AT_THE_BELT, True, SensorVersion.V2)
    arm.color_sensor(ON_THE_TABLE, True, SensorVersion.V2)
    arm.multiplex(BUTTON, IoFunction.DIGITAL_INPUT)
    arm.wait_for_level(BUTTON, True)
    cubes: list[Color] = []
    while cube_comes(arm):
        arm.perform([*carry(PICK, True), *carry(SHOW, True)])
        color = arm.color_at(ON_THE_TABLE)
        if color is None:
            raise SystemExit("the sensor tells no colour")
        print(f"a {color.value} cube")
        arm.perform(carry(PLACES[color], False))
        cubes.append(color)
    return cubes


def main() -> None:
    """At a port, or in the virtual cell, where it is looked whether every cube lies in its place."""
    if len(sys.argv) > 1:
        with Arm(sys.argv[1]) as arm:
            print(f"{len(sort(arm))} cubes sorted")
        return
    cell = magician.VirtualArm(CELL)
    with Arm(cell) as arm:
        assert sort(arm) == [Color.RED, Color.GREEN, Color.BLUE]
    for color, (x, y, _) in PLACES.items():
        cube = cell.object(f"{color.value} cube")
        print(f"{color.value} cube: x {cube.position.x:.1f} y {cube.position.y:.1f} on the table")
        assert cube.on_table
        # The cup grips a cube wherever it touches it, off its centre by the way that the belt ran on.
        assert math.dist((cube.position.x, cube.position.y), (x, y)) < 10


if __name__ == "__main__":
    main()
