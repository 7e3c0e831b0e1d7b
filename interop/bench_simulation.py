#!/usr/bin/env python3
"""How many steps a second virtual arms take: one, many on one thread, many on two, and one that is driven.

python3 interop/bench_simulation.py [--seconds 2] [--arms 64]

A reach step tells each arm a target at random and lets it come to rest there. Needs the package and NumPy.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from magician import VirtualArm, words
from magician.simulation import Simulation, Simulations

CELL = """
tool = { kind = "suction" }
table = { height = -60 }
object = [
    { name = "red", size = [20, 20, 20], at = [220, 80], color = "red" },
    { name = "blue", size = [20, 20, 20], at = [220, -80], color = "blue" },
]
"""


def rate(seconds: float, act: Callable[[], int]) -> float:
    """Returns the number of calls per second, after a first call that is not counted."""
    act()
    begun, done = time.perf_counter(), 0
    while (passed := time.perf_counter() - begun) < seconds:
        done += act()
    return done / passed


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=2.0)
    options.add_argument("--arms", type=int, default=64)
    given = options.parse_args()
    chances = np.random.default_rng(1)
    low, high = (180, -120, 10, -20), (280, 120, 100, 20)
    targets = [chances.uniform(low, high, (given.arms, 4)) for _ in range(64)]
    count = iter(range(1 << 62))

    def driven() -> int:
        arm.perform([words.move_to(*targets[next(count) % 64][0])])
        return 1

    with VirtualArm().arm() as arm:
        base = rate(given.seconds, driven)
    print(f"{'':34}{'steps/s':>12}{'to driven':>12}")
    print(f"{'driven, move_to':34}{base:12.0f}{1:12.1f}")
    for scenario in (None, CELL):
        for action in ("move_to", "line_to"):
            where = "in a cell" if scenario else "empty"
            one = Simulation(scenario, action=action)

            def alone(one: Simulation = one) -> int:
                one.step(targets[next(count) % 64][0])
                return 1

            found = {"one": rate(given.seconds, alone)}
            for threads in (1, 2):
                many = Simulations(given.arms, scenario, action=action, threads=threads)

                def together(many: Simulations = many) -> int:
                    many.step(targets[next(count) % 64])
                    return given.arms

                found[f"{given.arms}, {threads} threads"] = rate(given.seconds, together)
            for name, steps in found.items():
                print(f"{f'{name}, {action}, {where}':34}{steps:12.0f}{steps / base:12.1f}")
    arm_alone = Simulation(CELL)
    for view in ("top", "side"):
        for size in (84, 256):
            images = rate(given.seconds, lambda v=view, s=size: arm_alone.image(v, (s, s)).ndim // 3)
            print(f"image {view}, {size} by {size}: {1000 / images:.2f} ms")
    kept = arm_alone.snapshot()
    print(f"snapshot: {1e6 / rate(given.seconds, lambda: bool(arm_alone.snapshot())):.1f} us")
    print(f"restore: {1e6 / rate(given.seconds, lambda: len(arm_alone.restore(kept)) // 7):.1f} us")


if __name__ == "__main__":
    main()
