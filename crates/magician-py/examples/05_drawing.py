"""Streams a drawing of any number of short segments through the arm's queue, which holds 32.

``python 05_drawing.py PORT [SEGMENTS [WINDOW]]`` (a virtual arm and 1000 segments unless they are given)

The arm draws a ring of 20 mm through where it stands, in segments of 0.05 mm: the line to it, not the arm, is what
takes time. The driver asks for the room in the queue as seldom as it can, and accounts for every segment by its index.
A WINDOW above 1 sends that many segments before the answer to the first has come; ``magician doctor`` finds out what an
arm takes. The last line is an object with the seconds it took.
"""

from __future__ import annotations

import json
import math
import sys
import time

import magician
from magician import Pose, commands, words

RADIUS = 10.0
"""Radius of the ring, mm."""
SEGMENT = 0.05
"""Length of a segment, mm."""


def point(start: Pose, count: int) -> commands.CpCmd:
    """Where the pen is after so many segments."""
    angle = count * SEGMENT / RADIUS
    return words.path_to(
        start.x - RADIUS + RADIUS * math.cos(angle),
        start.y + RADIUS * math.sin(angle),
        start.z,
    )


def main(port: str = "sim", segments: str = "1000", window: str = "1") -> None:
    """Draws, and leaves the speeds as they were."""
    with magician.Arm(port, window=int(window)) as arm:
        before = arm.get(commands.CpParams)
        arm.path_speed(100, 1000)
        start = arm.pose()
        path = [point(start, count) for count in range(1, int(segments) + 1)]
        arm.estimate(path)  # refuses a ring that does not fit where the arm stands

        begun = time.perf_counter()
        ran = arm.begin(path).finish()
        seconds = time.perf_counter() - begun
        arm.set(before)

    rate = round(ran.commands / seconds, 1)
    print(json.dumps({"segments": ran.commands, "window": int(window), "seconds": round(seconds, 6), "per_s": rate}))


if __name__ == "__main__":
    main(*sys.argv[1:])
