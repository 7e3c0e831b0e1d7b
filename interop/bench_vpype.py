#!/usr/bin/env python3
"""Compares the drawing order of vpype with ours on ten drawings: travel of the pen, number of
lines, and duration on the arm.

    python3 -m venv VENV && VENV/bin/pip install -r interop/vpype.txt
    interop/bench_vpype.py --vpype VENV/bin/vpype [--magician target/debug/magician] [--before OTHER] [--json]

`magician convert --no-order` converts each drawing to lines, which are written as one SVG in mm.
vpype orders this file by `vpype read .. linemerge linesort write ..`, and again with `reloop` and
`linesimplify` before `linesort`; `draw --no-order` draws the results. We order the same file by
`draw` with its defaults. Both join ends within 0.1 mm. The columns are those of the check on the
virtual arm, which predicts the duration of the run. `off` is the Hausdorff distance of the lines
from those of the file, mm: the larger of what is lost and what is new.
"""

import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
SAMPLES = ROOT / "crates" / "magician-program" / "samples"
# Four lines in the built-in single-line font, about 4 mm high.
WORDS = (
    "The quick brown fox jumps over the",
    "lazy dog. Pack my box with five dozen",
    "liquor jugs. Sphinx of black quartz,",
    "judge my vow. 0123456789",
)
TEXT = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="130mm" height="40mm" viewBox="0 0 130 40" font-family="Hershey Sans" font-size="5.5">'
    + "".join(f'<text x="3" y="{8 * nth + 8}">{words}</text>' for nth, words in enumerate(WORDS))
    + "</svg>"
)


def ring():
    """A ring filled with lines 0.8 mm apart as hatching programs produce them: separate lines, all
    in the same direction."""
    lines = []
    for nth in range(-49, 50):
        y = 0.8 * nth
        ends = [math.sqrt(radius**2 - y**2) for radius in (40, 22) if abs(y) < radius]
        for side in (-1, 1) if len(ends) == 2 else (1,):
            a, b = (side * ends[0], side * ends[1]) if len(ends) == 2 else (-ends[0], ends[0])
            lines.append(
                f'<line x1="{min(a, b) + 41:.4f}" y1="{y + 41:.4f}" x2="{max(a, b) + 41:.4f}" y2="{y + 41:.4f}"/>'
            )
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="82mm" height="82mm" viewBox="0 0 82 82" stroke="black">{"".join(lines)}</svg>'


RING = ring()
# Name, file, and flags of each drawing.
DRAWINGS = (
    ("curves", "curves.svg"),
    ("house", "house.svg", "--fit"),
    ("rabbit", "rabbit.svg", "--fit"),
    ("plate", "plate.dxf", "--fit"),
    ("poster", ROOT / "docs" / "evidence" / "workshop" / "files" / "poster.svg", "--fit"),
    ("text", TEXT, "--fit"),
    ("ring, hatched", RING, "--fit"),
    ("lake, hatched", "landscape.png", "--image", "hatch", "--width", "100"),
    ("lake, squiggles", "landscape.png", "--image", "squiggle", "--width", "100"),
    ("lake, dots", "landscape.png", "--image", "halftone", "--width", "80"),
)
PAPER = -60.0
# Approximate number of points, in addition to all corners, at which lines are compared.
POINTS = 5000


def run_command(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{words[0]} {words[1]}: {done.stderr.strip()}")
    return done.stdout


def lines_of(plan):
    """Returns the lines of a plan in drawing order."""
    lines, at = [], None
    for step in json.loads(plan.read_text())["steps"]:
        if "path" in step:
            if not lines or lines[-1][-1] is not at:
                lines.append([at])
            at = tuple(step["path"][:2])
            lines[-1].append(at)
        elif "wait" in step and at is not None:
            lines.append([at, at])
        elif "move" in step:
            at = tuple(step["move"][:2])
    return lines


def write(lines, path):
    xs, ys = zip(*(point for line in lines for point in line))
    left, top = min(xs), max(ys)
    width, height = max(xs) - left, top - min(ys)
    polylines = "\n".join(
        '<polyline points="' + " ".join(f"{x - left:.4f},{top - y:.4f}" for x, y in line) + '"/>' for line in lines
    )
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.4f}mm" height="{height:.4f}mm" '
        f'viewBox="0 0 {width:.4f} {height:.4f}"><g fill="none" stroke="black">\n{polylines}\n</g></svg>\n'
    )


def read(path):
    """Returns the lines of an SVG of polylines, polygons and straight lines, as vpype writes it, in
    mm."""
    root = ElementTree.parse(path).getroot()
    width = float(re.match(r"[\d.]+", root.get("width"))[0]) * (
        25.4 / 2.54 if root.get("width").endswith("cm") else 1.0
    )
    scale = width / float(root.get("viewBox").split()[2])
    lines = []
    for element in root.iter():
        kind = element.tag.rpartition("}")[2]
        if kind in ("polyline", "polygon"):
            numbers = [scale * float(number) for number in re.findall(r"-?[\d.]+(?:e-?\d+)?", element.get("points"))]
        elif kind == "line":
            numbers = [scale * float(element.get(key)) for key in ("x1", "y1", "x2", "y2")]
        elif kind == "path":
            sys.exit(f"{path}: a path, where lines are expected")
        else:
            continue
        line = list(zip(numbers[::2], numbers[1::2]))
        lines.append(line + line[:1] if kind == "polygon" else line)
    return lines


class SegmentGrid:
    """Index of straight segments by the grid cells that they pass."""

    CELL = 2.0

    def __init__(self, lines):
        self.cells = {}
        for line in lines:
            for a, b in zip(line, line[1:] if len(line) > 1 else line):
                length = math.dist(a, b)
                for nth in range(int(length / self.CELL * 2) + 2):
                    fraction = nth / (int(length / self.CELL * 2) + 1)
                    x, y = (a[axis] + fraction * (b[axis] - a[axis]) for axis in (0, 1))
                    self.cells.setdefault((int(x // self.CELL), int(y // self.CELL)), {})[(a, b)] = None

    def distance(self, point):
        column, row = (int(value // self.CELL) for value in point)
        best = math.inf
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                for a, b in self.cells.get((column + i, row + j), ()):
                    delta = [b[axis] - a[axis] for axis in (0, 1)]
                    length_squared = delta[0] ** 2 + delta[1] ** 2
                    fraction = 0.0
                    if length_squared:
                        fraction = sum((point[axis] - a[axis]) * delta[axis] for axis in (0, 1)) / length_squared
                    fraction = min(1.0, max(0.0, fraction))
                    best = min(best, math.dist(point, [a[axis] + fraction * delta[axis] for axis in (0, 1)]))
        return best


def sample_points(lines, step):
    for line in lines:
        yield line[0]
        for a, b in zip(line, line[1:]):
            count = max(1, math.ceil(math.dist(a, b) / step))
            for nth in range(1, count + 1):
                yield tuple(a[axis] + nth / count * (b[axis] - a[axis]) for axis in (0, 1))


def hausdorff_distance(one, other):
    """Returns the largest distance of any point of one drawing from the other, mm (Hausdorff
    distance)."""
    other_grid, own_grid = SegmentGrid(other), SegmentGrid(one)
    step = max(0.5, sum(math.dist(a, b) for line in one for a, b in zip(line, line[1:])) / POINTS)
    return max(max(map(other_grid.distance, sample_points(one, step))), max(map(own_grid.distance, sample_points(other, step))))


def travel(lines):
    return sum(math.dist(one[-1], other[0]) for one, other in zip(lines, lines[1:]))


def check(magician, path, *words):
    """Returns the duration on the arm and the time that the check took, s."""
    words = ("draw", path, "--surface", PAPER, "--port", "sim", "--system-fonts", "off", *words)
    begun = time.perf_counter()
    report = json.loads(run_command(magician, *words, "--check", "--json").splitlines()[-1])
    elapsed = time.perf_counter() - begun
    return report["seconds"], elapsed


def converted_lines(magician, path, output, *words):
    run_command(magician, "convert", path, output, "--surface", PAPER, *words)
    return lines_of(output)


def measure_drawing(magician, vpype, before, folder, name, file, words):
    raw, plan = folder / "raw.svg", folder / "plan.json"
    source = folder / "made.svg"
    if str(file).startswith("<svg"):
        source.write_text(file)
    else:
        source = SAMPLES / file
    run_command(magician, "convert", source, plan, "--surface", PAPER, "--no-order", *words)
    write(lines_of(plan), raw)
    file_lines = read(raw)
    rows = []

    def row(order, path, *words, spent=None, magician=magician):
        seconds, check_time = check(magician, path, *words)
        lines = converted_lines(magician, path, plan, *words)
        # Translates back to the page, whose upper left corner is that of the lines.
        left, top = min(x for line in lines for x, _ in line), max(y for line in lines for _, y in line)
        page = [[(x - left, top - y) for x, y in line] for line in lines]
        rows.append(
            {
                "drawing": name,
                "order": order,
                "lines": len(lines),
                "travel_mm": round(travel(lines), 1),
                "seconds": round(seconds, 1),
                "seconds_a_line": round(seconds / len(lines), 3),
                "off_mm": round(hausdorff_distance(page, file_lines), 3),
                "computed_s": round(check_time if spent is None else spent, 2),
            }
        )

    if before:
        row("before", raw, magician=before)
    row("of the file", raw, "--no-order")
    row("ours", raw)
    for order, first in (("vpype", ()), ("vpype, all", ("reloop", "linesimplify", "--tolerance", "0.02mm"))):
        sorted_by_vpype = folder / "vpype.svg"
        begun = time.perf_counter()
        run_command(
            vpype, "read", "--no-crop", raw, "linemerge", "--tolerance", "0.1mm", *first, "linesort", "write", sorted_by_vpype,
        )  # fmt: skip
        row(order, sorted_by_vpype, "--no-order", spent=time.perf_counter() - begun)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vpype", default="vpype", help="its command")
    parser.add_argument("--magician", default=ROOT / "target" / "debug" / "magician", help="the command")
    parser.add_argument("--before", help="the command of another version, whose figures come first")
    parser.add_argument("--only", action="append", help="a drawing, by its name")
    parser.add_argument("--json", action="store_true", help="one object a line")
    args = parser.parse_args()
    if not args.json:
        print("drawing          order        lines   travel, mm   seconds   a line   off, mm   computed, s")
    for name, file, *words in DRAWINGS:
        if args.only and name not in args.only:
            continue
        with tempfile.TemporaryDirectory() as folder:
            for row in measure_drawing(args.magician, args.vpype, args.before, pathlib.Path(folder), name, file, words):
                if args.json:
                    print(json.dumps(row), flush=True)
                    continue
                numbers = (
                    "{lines:7d} {travel_mm:12.1f} {seconds:9.1f} {seconds_a_line:8.3f} {off_mm:9.3f} {computed_s:13.2f}"
                )
                print(f"{row['drawing']:16s} {row['order']:11s}" + numbers.format(**row), flush=True)


if __name__ == "__main__":
    main()
