"""Makes the files of the workshop's gallery that are computed.

    python3 docs/evidence/workshop/files/make.py

Needs Python, and for bracket.dxf ezdxf (pip install ezdxf), without which that one is left as it is. It is in the public domain, and so
is what it makes.
"""

import math
from pathlib import Path

HERE = Path(__file__).parent


def write(name, text):
    (HERE / name).write_text(text, encoding="utf-8")


def number(value):
    return f"{value:.2f}".rstrip("0").rstrip(".").replace("-0", "0") if abs(value) < 0.005 else f"{value:.2f}".rstrip("0").rstrip(".")


def path(points, close=False):
    text = "M" + "L".join(f"{number(x)} {number(y)}" for x, y in points)
    return text + ("Z" if close else "")


# Two pens: a rosette of a spirograph in blue, its frame and words in black.


def rosette():
    def wheel(outer, inner, pen, turns, steps):
        points = []
        for step in range(turns * steps):
            angle = 2 * math.pi * step / steps
            other = angle * (outer - inner) / inner
            points.append(
                (
                    50 + (outer - inner) * math.cos(angle) + pen * math.cos(other),
                    50 + (outer - inner) * math.sin(angle) - pen * math.sin(other),
                )
            )
        return points

    def ring(radius, teeth, depth):
        points = []
        for step in range(teeth * 2):
            angle = math.pi * step / teeth
            reach = radius + (depth if step % 2 else 0)
            points.append((50 + reach * math.cos(angle), 50 + reach * math.sin(angle)))
        return points

    style = 'fill="none" stroke-width="0.4"'
    write(
        "rosette.svg",
        f"""<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="116mm" viewBox="0 0 100 116">
<path d="{path(wheel(40, 22, 14, 11, 72), True)}" stroke="#1f5fbf" {style}/>
<path d="{path(ring(42, 60, 2.5), True)}" stroke="#1a1a1a" {style}/>
<circle cx="50" cy="50" r="47" stroke="#1a1a1a" {style}/>
<circle cx="50" cy="50" r="6" stroke="#1f5fbf" {style}/>
<text x="50" y="110" font-size="9" text-anchor="middle" fill="#1a1a1a" font-family="Hershey Script">Spirograph 40 : 22</text>
</svg>
""",
    )


# A box of six panels with finger joints, for a board of 2 mm.

BOARD = 2.0
FINGER = 6.0


def edge(length, out):
    """An edge along x: its odd fingers stand out (out = 1), or the even ones, into what those leave free (out = 0); the same from both ends."""
    count = max(3, int(length / FINGER) | 1)
    width = length / count
    points = []
    for nth in range(count):
        deep = BOARD if (nth % 2 == 1) == bool(out) else 0.0
        points += [(nth * width, deep), ((nth + 1) * width, deep)]
    return points


def panel(x, y, width, height, sides):
    """The outline of a panel of this inner size; `sides` are the edges that begin at each of its corners, in their order."""
    corners = []
    turned = [
        (width, lambda u, v: (u, -v)),
        (height, lambda u, v: (width + v, u)),
        (width, lambda u, v: (width - u, height + v)),
        (height, lambda u, v: (-v, height - u)),
    ]
    for (length, turn), out in zip(turned, sides):
        corners += [turn(u, v) for u, v in edge(length, out)]
        if not any(sides):
            # No other panel reaches into this corner of the box.
            corners.append(turn(length + BOARD, BOARD))
    points = [(x + a, y + b) for a, b in corners]
    return [point for nth, point in enumerate(points) if math.dist(point, points[nth - 1]) > 1e-9]


def box():
    # The inner size of the box.
    long, deep, high = 36.0, 27.0, 21.0
    gap = 2 * BOARD + 2.0
    cuts = []
    row = BOARD + 1
    column = BOARD + 1
    second = row + deep + gap
    for name, x, y, w, h, sides in [
        ("bottom", column, row, long, deep, (1, 1, 1, 1)),
        ("lid", column + long + gap, row, long, deep, (1, 1, 1, 1)),
        ("front", column, second, long, high, (0, 1, 0, 1)),
        ("back", column + long + gap, second, long, high, (0, 1, 0, 1)),
        ("left", column + 2 * (long + gap), row, deep, high, (0, 0, 0, 0)),
        ("right", column + 2 * (long + gap), second, deep, high, (0, 0, 0, 0)),
    ]:
        cuts.append((name, panel(x, y, w, h, sides)))
    lid = (column + long + gap + long / 2, row + deep / 2)
    star = [
        (
            lid[0] + (7 if step % 2 == 0 else 2.8) * math.sin(math.pi * step / 5),
            lid[1] - 2 - (7 if step % 2 == 0 else 2.8) * math.cos(math.pi * step / 5),
        )
        for step in range(10)
    ]
    width = column + 2 * (long + gap) + deep + BOARD + 1
    height = second + high + BOARD + 1
    outlines = "\n".join(f'  <path id="{name}" d="{path(points, True)}"/>' for name, points in cuts)
    write(
        "box.svg",
        f"""<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="{number(width)}mm" height="{number(height)}mm" viewBox="0 0 {number(width)} {number(height)}">
 <g inkscape:groupmode="layer" inkscape:label="engrave" fill="#1f5fbf" stroke="none">
  <path d="{path(star, True)}"/>
  <text x="{number(lid[0])}" y="{number(lid[1] + 11.5)}" font-size="6" text-anchor="middle" font-family="Hershey Sans">TREASURE</text>
 </g>
 <g inkscape:groupmode="layer" inkscape:label="cut" fill="none" stroke="#d6281e" stroke-width="0.2">
{outlines}
 </g>
</svg>
""",
    )


# A typical Inkscape drawing: hidden guides, and a layer for another pen.


def layers():
    def hills(*across):
        return path([(x, 46 - 7 * math.sin(x / 13) - 2 * math.sin(x / 4 + 1)) for x in range(*across, 2)])

    rays = [
        f"M{number(88 + 13 * math.cos(a))} {number(20 + 13 * math.sin(a))}L{number(88 + 18 * math.cos(a))} {number(20 + 18 * math.sin(a))}"
        for a in (math.pi * n / 8 for n in range(16))
    ]
    write(
        "layers.svg",
        f"""<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="120mm" height="80mm" viewBox="0 0 120 80">
 <g inkscape:groupmode="layer" inkscape:label="%guides" fill="none" stroke="#66aaff" stroke-width="0.2">
  <path d="M60 0V80M0 40H120M2 2H118V78H2Z"/>
 </g>
 <g inkscape:groupmode="layer" inkscape:label="1 landscape" fill="none" stroke="#1a1a1a" stroke-width="0.5">
  <path d="{hills(4, 27)}{hills(50, 117)}"/>
  <path d="M4 60C30 54 44 66 66 60S104 54 116 60M10 67C30 63 50 71 70 67S96 63 110 67M22 73C40 70 60 76 84 73"/>
  <path d="M30 52V34H48V52M27 36L39 24L51 36M36 52V43H42V52"/>
 </g>
 <g inkscape:groupmode="layer" inkscape:label="!2 sun, in red" fill="none" stroke="#d6281e" stroke-width="0.5">
  <circle cx="88" cy="20" r="10"/>
  <path d="{''.join(rays)}"/>
 </g>
</svg>
""",
    )


# A plot in the language of pen plotters: a surface, with what lies behind hidden.


def surface():
    rows, columns = 34, 90
    horizon = [-1e9] * (columns + 1)
    text = ["IN;SP1;"]
    for row in range(rows):
        y = row / (rows - 1) * 2 - 1
        line, runs = [], []
        for column in range(columns + 1):
            x = column / columns * 2 - 1
            r = 11 * math.hypot(x, y)
            z = 24 * (math.sin(r) / r if r else 1)
            at = (12 + 96 * column / columns, 14 + 46 * row / (rows - 1) + z)
            if at[1] > horizon[column] + 1e-9:
                horizon[column] = at[1]
                line.append(at)
            else:
                runs.append(line)
                line = []
        for line in [*runs, line]:
            if len(line) > 1:
                units = [f"{round(40 * a)},{round(40 * b)}" for a, b in line]
                text.append(f"PU{units[0]};PD{','.join(units[1:])};")
    text.append("PU;SP2;PU160,160;PD4640,160,4640,3560,160,3560,160,160;PU;SP0;")
    write("surface.plt", "\n".join(text) + "\n")


# A job in the form in which LightBurn writes for GRBL: a key tag, filled line by line and then cut.


def lightburn():
    middle, star = (22.0, 18.0), []
    for step in range(10):
        reach = 11 if step % 2 == 0 else 4.4
        star.append(
            (middle[0] + reach * math.sin(math.pi * step / 5), middle[1] + reach * math.cos(math.pi * step / 5))
        )
    out = [
        "; LightBurn 1.4.05",
        "; GRBL device profile, absolute coords",
        "; Bounds: X2 Y2 to X42 Y34",
        "G00 G17 G40 G21 G54",
        "G90",
        "M4",
        "; Scan @ 1500 mm/min, 30% power",
        "M8",
    ]
    at, first = None, True
    rows = int(22 / 0.4)
    for row in range(rows):
        y = middle[1] - 9 + 0.4 * row
        crossings = []
        for (x1, y1), (x2, y2) in zip(star, star[1:] + star[:1]):
            if (y1 > y) != (y2 > y):
                crossings.append(x1 + (y - y1) / (y2 - y1) * (x2 - x1))
        crossings.sort()
        if row % 2:
            crossings.reverse()
        for begin, end in zip(crossings[::2], crossings[1::2]):
            begin, end = round(begin, 2), round(end, 2)
            if first:
                out += [f"G0X{number(begin)}Y{number(y)}", "; Layer C00", "G91"]
                at = (begin, round(y, 2))
            else:
                dx, dy = round(begin - at[0], 2), round(round(y, 2) - at[1], 2)
                words = (f"X{number(dx)}" if dx else "") + (f"Y{number(dy)}" if dy else "")
                out.append(f"G1{words}S0")
                at = (begin, round(y, 2))
            feed = "F1500" if first else ""
            out.append(f"G1X{number(round(end - at[0], 2))}{feed}S300")
            at, first = (end, at[1]), False
    out += ["G90", "; Cut @ 300 mm/min, 90% power", "M8", "G0X8Y2", "; Layer C01"]
    out += ["G1X36S900F300", "G3X42Y8I0J6", "G1Y28", "G3X36Y34I-6J0", "G1X8", "G3X2Y28I0J-6", "G1Y8", "G3X8Y2I6J0"]
    out += ["G0X8Y30.5", "G3X8Y26.5I0J-2S900", "G3X8Y30.5I0J2", "M9", "G1S0", "M5", "G90"]
    out += ["; return to user-defined finish pos", "G0 X0 Y0", "M2"]
    write("lightburn.gcode", "\n".join(out) + "\n")


# An image as G-code, line by line, as LaserGRBL and its kin write it: a sphere in a beam of light.


def lines():
    spacing, size = 0.5, 30.0
    out = ["G90", "G21", "M4 S0", "F1800"]
    rows = int(size / spacing)
    for row in range(rows + 1):
        y = row * spacing
        pixels = []
        for column in range(rows):
            x = (column + 0.5) * spacing
            a, b = (x - size / 2) / (size / 2), (y - size / 2) / (size / 2)
            inside = 1 - a * a - b * b
            if inside <= 0:
                pixels.append(0)
                continue
            light = (-0.5 * a + 0.6 * b + 0.62 * math.sqrt(inside)) / math.hypot(0.5, 0.6, 0.62)
            pixels.append(round(255 * min(1.0, max(0.06, 1 - max(0.0, light)))) // 8 * 8)
        marked = [n for n, s in enumerate(pixels) if s]
        if not marked:
            continue
        order = range(marked[0], marked[-1] + 1)
        back = row % 2 == 1
        order = list(reversed(order)) if back else list(order)
        start = (order[0] + (1 if back else 0)) * spacing
        out.append(f"G0 X{number(start)} Y{number(y)} S0")
        out.append("G1")
        for nth, column in enumerate(order):
            after = order[nth + 1] if nth + 1 < len(order) else None
            if after is not None and pixels[after] == pixels[column]:
                continue
            end = (column + (0 if back else 1)) * spacing
            out.append(f"X{number(end)} S{pixels[column]}")
    out += ["M5 S0", "G0 X0 Y0"]
    write("sphere.nc", "\n".join(out) + "\n")


# Characters by the strokes that they are written with, in the form of hanzi-writer: the middle of each stroke, in a square of 1024 units
# with y up.


def characters():
    def bend(*corners):
        """A stroke through corners, each (x, y), with the pieces between rounded off."""
        points = [corners[0]]
        for nth in range(1, len(corners) - 1):
            (ax, ay), (bx, by), (cx, cy) = corners[nth - 1 : nth + 2]
            start = (bx + (ax - bx) * 0.2, by + (ay - by) * 0.2)
            end = (bx + (cx - bx) * 0.2, by + (cy - by) * 0.2)
            for share in (0, 0.25, 0.5, 0.75, 1):
                u = 1 - share
                points.append(
                    tuple(u * u * s + 2 * u * share * m + share * share * e for s, m, e in zip(start, (bx, by), end))
                )
        return [[round(x), round(y)] for x, y in [*points, corners[-1]]]

    def sweep(a, by, b):
        """A stroke that curves towards a point."""
        shares = [n / 8 for n in range(9)]
        return [
            [round((1 - t) ** 2 * p + 2 * t * (1 - t) * m + t * t * q) for p, m, q in zip(a, by, b)] for t in shares
        ]

    strokes = {
        "山": [bend((512, 730), (512, 120)), bend((200, 500), (200, 110), (824, 110)), bend((824, 500), (824, 60))],
        "水": [
            bend((512, 780), (512, 30), (420, 80)),
            bend((160, 540), (380, 540), (300, 330), (150, 170)),
            sweep((780, 640), (690, 530), (560, 470)),
            sweep((530, 480), (650, 240), (880, 120)),
        ],
        "中": [
            bend((240, 620), (240, 310)),
            bend((240, 600), (784, 600), (784, 310)),
            bend((240, 340), (784, 340)),
            bend((512, 790), (512, -20)),
        ],
        "文": [
            sweep((480, 800), (530, 760), (560, 700)),
            bend((150, 620), (870, 620)),
            sweep((650, 610), (560, 240), (160, 30)),
            sweep((370, 610), (480, 220), (880, 20)),
        ],
    }
    rows = ",\n".join(
        f'"{letter}":{{"medians":{medians}}}'.replace(" ", "") for letter, medians in strokes.items()
    )
    write("hanzi.json", "{\n" + rows + "\n}\n")


# A part as CAD programs hand it over: dimensions, texts, layers.


def bracket():
    try:
        import ezdxf
    except ImportError:
        print("bracket.dxf is left as it is: ezdxf is not installed")
        return
    document = ezdxf.new("R12", setup=True)
    document.header["$INSUNITS"] = 4
    for name, colour in (("PART", 7), ("DIM", 5), ("CENTRE", 1), ("TEXT", 3)):
        document.layers.add(name, color=colour)
    space = document.modelspace()
    part = {"layer": "PART"}
    outline = [(0, 0), (90, 0), (90, 18), (60, 18), (48, 30), (48, 50), (0, 50)]
    space.add_polyline2d(outline, close=True, dxfattribs=part)
    for x, y, r in ((14, 36, 7), (34, 12, 5), (76, 9, 4)):
        space.add_circle((x, y), r, dxfattribs=part)
        for dx, dy in ((1, 0), (0, 1)):
            reach = r + 2.5
            space.add_line((x - dx * reach, y - dy * reach), (x + dx * reach, y + dy * reach), dxfattribs={"layer": "CENTRE"})
    style = {"dimtxt": 3.2, "dimasz": 2.2, "dimexe": 1.2, "dimexo": 1.2, "dimgap": 0.8, "dimdec": 0, "dimtad": 1, "dimtih": 0, "dimtoh": 0, "dimlfac": 1}
    for base, first, second, angle in (
        ((0, -10), (0, 0), (90, 0), 0),
        ((100, 0), (90, 0), (90, 18), 90),
        ((-10, 0), (0, 0), (0, 50), 90),
        ((0, 60), (0, 50), (48, 50), 0),
    ):
        dimension = space.add_linear_dim(base, first, second, angle=angle, override=style, dxfattribs={"layer": "DIM"})
        dimension.render()
    space.add_text("BRACKET  1:1", height=5, dxfattribs={"layer": "TEXT"}).set_placement((54, 44))
    space.add_text("steel 3 mm, holes %%c14 %%c10 %%c8", height=2.6, dxfattribs={"layer": "TEXT"}).set_placement((54, 38))
    document.saveas(HERE / "bracket.dxf")


for make in (rosette, box, layers, surface, lightburn, lines, characters, bracket):
    make()
