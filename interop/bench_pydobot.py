#!/usr/bin/env python3
"""Draw the same with pydobot, pydobotplus and this driver on the same virtual arm: interop/bench_pydobot.py [--segments N]

Every drawing has a fresh `magician sim` on a pseudo-terminal, paced at 115200 baud, with 0, 2 and 4 ms that the arm takes
besides. It is the ring of crates/magician/examples/05_drawing.rs: segments so short that the line is what takes time. The
seconds are from the first segment sent to the last one executed, without connecting; the arm's pose at the end is
compared with the last point, so that nobody gains by leaving something out. pydobot takes 0.2 s a segment by itself:
1,000 of them, three times, ten minutes.
"""

import argparse
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

from sim import Sim
from venvs import ROOT, TARGET, python_for

RADIUS, SEGMENT = 10.0, 0.05
# The fourfold as the arm has it at power-up: joints 0, 45, 45, 0.
START = (199.4041, 0.0, -8.4853)
SPEEDS = ("plan_acc=1000", "junction_vel=100", "acc_or_period=1000", "real_time_track=0")
LIBRARIES = {"pydobot": "pydobot.txt", "pydobotplus": "pydobotplus.txt"}
WINDOWS = (1, 4)


def point(count):
    """Where the pen is after so many segments."""
    angle = count * SEGMENT / RADIUS
    return START[0] - RADIUS + RADIUS * math.cos(angle), START[1] + RADIUS * math.sin(angle), START[2]


def client(library, port, segments):
    """Draw with a library, inside its own interpreter; print the seconds."""
    if library == "pydobot":
        from pydobot import Dobot
    else:
        from pydobotplus import Dobot
    dobot = Dobot(port)
    begun = time.monotonic()
    for count in range(1, segments + 1):
        reply = dobot._set_cp_cmd(*point(count))
    last = struct.unpack_from("<Q", reply.params)[0]
    while dobot._get_queued_cmd_current_index() < last:
        pass
    print(json.dumps({"seconds": time.monotonic() - begun}), flush=True)
    dobot.close()


def draw(magician, client_on, turnaround, segments):
    """One drawing on an arm of its own, by the command that `client_on` gives for its path; its seconds."""
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        path = f"{home}/arm"
        arm = Sim(magician, path, "1", "--baud", "115200", "--turnaround", str(turnaround), stderr=subprocess.DEVNULL)
        try:
            observer = [magician, "--port", f"udp:127.0.0.1:{arm.udp}", "--json"]
            subprocess.run([*observer, "set", "CPParams", *SPEEDS], check=True, capture_output=True, timeout=20)
            done = subprocess.run(client_on(path), check=True, capture_output=True, timeout=600, text=True)
            pose = json.loads(subprocess.run([*observer, "pose"], check=True, capture_output=True, timeout=20).stdout)
        finally:
            arm.stop()
    off = math.dist((pose["x"], pose["y"], pose["z"]), point(segments))
    if off > 0.01:
        sys.exit(f"the drawing is not whole: its end is {off:.2f} mm off")
    return json.loads(done.stdout.splitlines()[-1])["seconds"]


def compare(given, turnaround):
    """All clients at one turnaround: seconds by name."""
    seconds = {}
    for window in WINDOWS:
        ours = lambda path, window=window: [given.drawing, path, str(given.segments), str(window)]
        seconds[window] = draw(given.magician, ours, turnaround, given.segments)
    for library, pins in LIBRARIES.items():
        segments = min(given.segments, given.slow) if library == "pydobot" else given.segments
        theirs = [python_for(pins), "-B", __file__, "--client", library]
        spent = draw(given.magician, lambda path: [*theirs, path, str(segments)], turnaround, segments)
        seconds[library] = spent * given.segments / segments
    return seconds


def goals(turnaround):
    """(what, of whom, how many times as fast as whom, at least)."""
    yield "window 1 to pydobot", 1, "pydobot", 50.0
    yield "window 1 to pydobotplus", 1, "pydobotplus", 1.0
    beside = {0: 1.4, 4: 3.0}.get(turnaround)
    yield "window 4 to pydobotplus", 4, "pydobotplus", beside


def main():
    """Draw, and print the figures."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--magician", help="the program to test (otherwise it is built, optimised)")
    options.add_argument("--drawing", help="the example 05_drawing (otherwise it is built, optimised)")
    options.add_argument("--segments", type=int, default=1000)
    options.add_argument("--slow", type=int, default=1000, help="segments for pydobot at most; its seconds are scaled")
    options.add_argument("--turnaround", type=int, nargs="*", default=[0, 2, 4], help="milliseconds")
    options.add_argument("--json", action="store_true", help="print one object instead")
    options.add_argument("--client", nargs=3, help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.client:
        library, port, segments = given.client
        client(library, port, int(segments))
        return
    release = pathlib.Path(TARGET) / "release"
    if not (given.magician and given.drawing):
        build = ["cargo", "build", "--quiet", "--release"]
        subprocess.run([*build, "-p", "magician-cli"], cwd=ROOT, check=True)
        subprocess.run([*build, "-p", "magician", "--example", "05_drawing"], cwd=ROOT, check=True)
    given.magician = given.magician or str(release / "magician")
    given.drawing = given.drawing or str(release / "examples" / "05_drawing")

    results = []
    for turnaround in given.turnaround:
        seconds = compare(given, turnaround)
        ratios = {
            what: {"ratio": round(seconds[other] / seconds[ours], 3), "goal": goal}
            for what, ours, other, goal in goals(turnaround)
        }
        results.append({"turnaround_ms": turnaround, "seconds": {str(k): round(v, 3) for k, v in seconds.items()}, "h6": ratios})
        if not given.json:
            show(results[-1], given.segments)
    if given.json:
        print(json.dumps({"segments": given.segments, "results": results}))


def show(result, segments):
    """One turnaround, for people."""
    print(f"turnaround {result['turnaround_ms']} ms, {segments} segments", flush=True)
    for name, seconds in result["seconds"].items():
        name = f"window {name}" if name.isdigit() else name
        print(f"  {name:<12} {seconds:8.3f} s {segments / seconds:8.1f} /s")
    for what, found in result["h6"].items():
        goal = found["goal"]
        verdict = "" if goal is None else f"goal {goal:g}: {'met' if found['ratio'] >= goal else 'not met'}"
        print(f"  {what:<24} {found['ratio']:7.2f} times  {verdict}", flush=True)


if __name__ == "__main__":
    main()
