#!/usr/bin/env python3
"""Draw the same with pydobot, pydobotplus, pydobotlab, this driver and its Python package on the same virtual arm:
interop/bench_pydobot.py [--segments N] [--package PYTHON]

Every drawing has a fresh `magician sim` on a pseudo-terminal, paced at 115200 baud, with 0, 2 and 4 ms that the arm takes
besides. It is the ring of crates/magician/examples/drawing.rs: segments so short that the line is what takes time. The
seconds are from the first segment sent to the last one executed, without connecting; the arm's pose at the end is
compared with the last point, so that nobody gains by leaving something out; what a full queue refuses is sent again.
pydobot takes 0.2 s a segment by itself: 1,000 of them, three times, ten minutes.

With --package the Python package draws too: as its users write it at windows 1 and 4, and in place of each library
(`python -m magician.compat`). Of every Python program the share of the time is shown in which its interpreter computes; and
last all but pydobot draw over a line without a pace, on an arm that is 20 times as fast, where there is little else.
"""

import argparse
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

from sim import Sim
from venvs import ROOT, TARGET, python_for

RADIUS, SEGMENT = 10.0, 0.05
# Joint angles 0, 45, 45, 0, at which the arm is after power-up.
START = (259.1041, 0.0, -8.4853)
SPEEDS = ("plan_acc=1000", "junction_vel=100", "acc_or_period=1000", "real_time_track=0")
# pydobotlab needs Python 3.11.
LIBRARIES = {name: f"{name}.txt" for name in ("pydobot", "pydobotplus", "pydobotlab")[: 3 if sys.version_info >= (3, 11) else 2]}
WINDOWS = (1, 4)
# Speed of the arm relative to a real one for the runs without a paced line, so that the line
# remains the bottleneck.
FAST = "20"


def point(count):
    """Returns the position of the pen after a number of segments."""
    angle = count * SEGMENT / RADIUS
    return START[0] - RADIUS + RADIUS * math.cos(angle), START[1] + RADIUS * math.sin(angle), START[2]


def client(library, port, segments, window):
    """Draws with a library in its own interpreter. Prints the elapsed seconds, and the CPU time of
    this thread."""
    begin = {"magician": package, "pydobotlab": lab}.get(library, command_by_command)
    draw = begin(library, port, segments, window)
    begun, computed = time.perf_counter(), time.thread_time()
    draw()
    spent = {"seconds": time.perf_counter() - begun, "interpreter": time.thread_time() - computed}
    print(json.dumps(spent), flush=True)


def package(_, port, segments, window):
    """Our package, as its users write it."""
    import magician
    from magician import words

    arm = magician.Arm(port, window=window)
    return lambda: arm.begin([words.path_to(*point(count)) for count in range(1, segments + 1)]).finish()


def lab(_, port, segments, __):
    """pydobotlab without its panel. It stores its settings in the home directory."""
    os.environ["XDG_CONFIG_HOME"] = os.path.dirname(port)
    from pydobotlab import Magician

    bot = Magician(port, require_panel=False, verbose=False)
    bot.connect()
    return drawn(segments, lambda count: bot.cp(*point(count)), bot.queued_cmd_current_index)


def command_by_command(library, port, segments, _):
    """A library that sends one command at a time."""
    if library == "pydobot":
        from pydobot import Dobot
    else:
        from pydobotplus import Dobot
    dobot = Dobot(port)

    cp = lambda count: struct.unpack_from("<Q", dobot._set_cp_cmd(*point(count)).params)[0]
    return drawn(segments, cp, dobot._get_queued_cmd_current_index)


def drawn(segments, cp, current_index):
    """Returns a function that draws with a library. `cp` sends a segment and returns its index."""

    def draw():
        for count in range(1, segments + 1):
            # A full queue answers with index 0. The libraries do not check for it and would omit
            # the segment.
            while (last := cp(count)) == 0:
                pass
        while current_index() < last:
            pass

    return draw


def draw(magician, client_on, turnaround, segments):
    """Makes one drawing on an arm of its own, with the command that `client_on` returns for the
    arm's path. Returns the elapsed seconds, and the CPU time of the interpreter if there is one."""
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        path = f"{home}/arm"
        pace = [FAST] if turnaround is None else ["1", "--baud", "115200", "--turnaround", str(turnaround)]
        arm = Sim(magician, path, *pace, quiet=True)
        try:
            observer = [magician, "--port", f"udp:127.0.0.1:{arm.udp}", "--json"]
            subprocess.run([*observer, "set", "CPParams", *SPEEDS], check=True, capture_output=True, timeout=60)
            done = subprocess.run(client_on(path), check=True, stdout=subprocess.PIPE, timeout=600, text=True)
            pose = json.loads(subprocess.run([*observer, "pose"], check=True, capture_output=True, timeout=60).stdout)
        finally:
            arm.stop()
    off = math.dist((pose["x"], pose["y"], pose["z"]), point(segments))
    if off > 0.01:
        sys.exit(f"the drawing is not whole: its end is {off:.2f} mm off")
    spent = json.loads(done.stdout.splitlines()[-1])
    return {name: spent[name] for name in ("seconds", "interpreter") if name in spent}


def compare(given, turnaround):
    """Returns the times of all clients at one turnaround, by name."""
    spent = {}
    ask = [__file__, "--client"]
    for window in WINDOWS:
        ours = lambda path, window=window: [given.drawing, path, str(given.segments), str(window)]
        spent[f"window {window}"] = draw(given.magician, ours, turnaround, given.segments)
    if given.package:
        for window in WINDOWS:
            ours = lambda path, window=window: [
                given.package, "-B", *ask, "magician", path, str(given.segments), str(window)
            ]
            spent[f"Python, window {window}"] = draw(given.magician, ours, turnaround, given.segments)
        for library in LIBRARIES:
            compat = [given.package, "-B", "-m", "magician.compat", "--pydobot", "pydobot"]
            ours = lambda path, compat=compat, library=library: [*compat, *ask, library, path, str(given.segments), "1"]
            spent[f"compat.{library}"] = draw(given.magician, ours, turnaround, given.segments)
    for library, pins in LIBRARIES.items():
        if library == "pydobot" and turnaround is None:
            continue
        segments = min(given.segments, given.slow) if library == "pydobot" else given.segments
        theirs = [python_for(pins), "-B", *ask, library]
        found = draw(given.magician, lambda path: [*theirs, path, str(segments), "1"], turnaround, segments)
        spent[library] = {name: value * given.segments / segments for name, value in found.items()}
    return spent


def goals(turnaround, package):
    """Goals as (description, client, compared client, least factor)."""
    if turnaround is not None:
        yield "window 1 to pydobot", "window 1", "pydobot", 50.0
    yield "window 1 to pydobotplus", "window 1", "pydobotplus", 1.0
    beside = {0: 1.4, 4: 3.0}.get(turnaround)
    yield "window 4 to pydobotplus", "window 4", "pydobotplus", beside
    if "pydobotlab" in LIBRARIES:
        for window in WINDOWS:
            yield f"window {window} to pydobotlab", f"window {window}", "pydobotlab", None
    if not package:
        return
    for window in WINDOWS:
        yield f"Python to Rust, window {window}", f"Python, window {window}", f"window {window}", None
        for library in LIBRARIES:
            if library != "pydobot" or turnaround is not None:
                yield f"Python, window {window}, to {library}", f"Python, window {window}", library, None
    for library in LIBRARIES:
        if library != "pydobot" or turnaround is not None:
            yield f"compat.{library} to {library}", f"compat.{library}", library, None


def main():
    """Draws and prints the figures."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--magician", help="the program to test (otherwise it is built, optimised)")
    options.add_argument("--drawing", help="the example drawing (otherwise it is built, optimised)")
    options.add_argument("--package", help="an interpreter with our Python package, built optimised")
    options.add_argument("--segments", type=int, default=1000)
    options.add_argument("--slow", type=int, default=1000, help="segments for pydobot at most; its seconds are scaled")
    options.add_argument("--turnaround", type=int, nargs="*", default=[0, 2, 4], help="milliseconds")
    options.add_argument("--json", action="store_true", help="print one object instead")
    options.add_argument("--client", nargs=4, help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.client:
        library, port, segments, window = given.client
        client(library, port, int(segments), int(window))
        return
    release = pathlib.Path(TARGET) / "release"
    if not (given.magician and given.drawing):
        build = ["cargo", "build", "--quiet", "--release"]
        subprocess.run([*build, "-p", "magician-cli"], cwd=ROOT, check=True)
        subprocess.run([*build, "-p", "magician", "--example", "drawing"], cwd=ROOT, check=True)
    given.magician = given.magician or str(release / "magician")
    given.drawing = given.drawing or str(release / "examples" / "drawing")

    results = []
    for turnaround in [*given.turnaround, *([None] if given.package else [])]:
        spent = compare(given, turnaround)
        seconds = {name: each["seconds"] for name, each in spent.items()}
        ratios = {
            what: {"ratio": round(seconds[other] / seconds[ours], 3), "goal": goal}
            for what, ours, other, goal in goals(turnaround, given.package)
        }
        results.append({
            "turnaround_ms": turnaround,
            "seconds": {name: round(value, 3) for name, value in seconds.items()},
            "interpreter": {name: round(each["interpreter"], 4) for name, each in spent.items() if "interpreter" in each},
            "h6": ratios,
        })
        if not given.json:
            show(results[-1], given.segments)
    if given.json:
        print(json.dumps({"segments": given.segments, "results": results}))


def show(result, segments):
    """Prints the result for one turnaround."""
    turnaround = result["turnaround_ms"]
    line = "a line without a pace" if turnaround is None else f"turnaround {turnaround} ms"
    print(f"{line}, {segments} segments", flush=True)
    for name, seconds in result["seconds"].items():
        computed = result["interpreter"].get(name)
        share = ""
        if computed is not None:
            share = f"  interpreter {100 * computed / seconds:5.1f} %, {1e6 * computed / segments:6.1f} us a segment"
        print(f"  {name:<20} {seconds:8.3f} s {segments / seconds:8.1f} /s{share}")
    for what, found in result["h6"].items():
        goal = found["goal"]
        verdict = "" if goal is None else f"goal {goal:g}: {'met' if found['ratio'] >= goal else 'not met'}"
        print(f"  {what:<32} {found['ratio']:7.2f} times  {verdict}", flush=True)


if __name__ == "__main__":
    main()
