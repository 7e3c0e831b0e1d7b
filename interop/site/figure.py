"""Writes the measurements of `interop/site/scale` as a figure, and as a table of
docs/guide/SITE.md."""

import math

WIDTH, HEIGHT = 760, 420
LEFT, RIGHT, TOP, BOTTOM = 64, 190, 44, 52
BLUE, ORANGE, GREEN, INK, FAINT = "#0072b2", "#d55e00", "#009e73", "#3c3c3c", "#c8c8c8"
BEGIN, END = "<!-- scale: written by interop/site/scale -->", "<!-- /scale -->"


def write(root, result):
    rows = result["rows"]
    (root / "docs/guide/site/scale.svg").write_text(draw(rows))
    page = root / "docs/guide/SITE.md"
    text = page.read_text()
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    page.write_text(f"{before}{BEGIN}\n{table(result)}\n{END}{after}")


def table(result):
    lines = ["| arms, of which move | state p50, p99 | stop on the wire p50, p99 | all stand after | killed, gone after "
             "| cores of all stations: unheard, still, moving | of the hub | memory a station |", "|---|---|---|---|---|---|---|---|"]
    for row in result["rows"]:
        age, stop, gone = row["moving"]["age_ms"], row["stop_moving"], row["presence_lost_seconds"]
        wire = stop["wire_ms"]
        cores = ", ".join(f"{cores:.2f}" for cores in (
            row["idle_unheard_cores"], row["still"]["stations_cores"], row["moving"]["stations_cores"]))
        memory = row["moving"]["stations_memory"] / row["stations"] / 1e6
        lines.append(f"| {row['arms']}, {row['moving']['moving']} | {age['p50']:.0f}, {age['p99']:.0f} ms | "
                     f"{wire['p50']:.0f}, {wire['p99']:.0f} ms | {stop['answer_ms']['max']:.0f} ms | "
                     f"{'never' if gone is None else f'{gone:.2f} s'} | {cores} | {row['moving']['hub_cores']:.2f} | {memory:.0f} MB |")
    return "\n".join(lines)


def draw(rows):
    """Draws the CPU load in cores over the number of arms."""
    max_moving = max(row["moving"]["moving"] for row in rows)
    lines = [(f"stations, {max_moving} move", BLUE, [row["moving"]["stations_cores"] for row in rows]),
             ("stations, arms stand", GREEN, [row["still"]["stations_cores"] for row in rows]),
             (f"hub, {max_moving} move", ORANGE, [row["moving"]["hub_cores"] for row in rows])]
    max_arms = max(row["arms"] for row in rows)
    top = max(max(values) for _, _, values in lines)
    step = next(step for step in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10) if step * 6 > top)
    max_cores = step * math.ceil(top / step)

    def at(arms, value):
        x = LEFT + (WIDTH - LEFT - RIGHT) * arms / max_arms
        y = HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * value / max_cores
        return f"{x:.1f}", f"{y:.1f}"

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" '
           f'font-family="sans-serif" font-size="13" fill="{INK}">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="26" font-size="18">What a site costs on one machine, ten arms a station</text>']
    for part in range(round(max_cores / step) + 1):
        value = step * part
        _, y = at(0, value)
        out.append(f'<path d="M{LEFT} {y}H{WIDTH - RIGHT}" stroke="{FAINT}"/>'
                   f'<text x="{LEFT - 8}" y="{float(y) + 4:.1f}" text-anchor="end">{value:.2f}</text>')
    for row in rows:
        x, y = at(row["arms"], 0)
        out.append(f'<text x="{x}" y="{float(y) + 20:.1f}" text-anchor="middle">{row["arms"]}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 10}" text-anchor="middle">arms</text>'
               f'<text transform="translate(18 {HEIGHT / 2}) rotate(-90)" text-anchor="middle">cores</text>')
    for nth, (name, color, values) in enumerate(lines):
        points = [at(row["arms"], value) for row, value in zip(rows, values, strict=True)]
        path = " ".join(f"{x},{y}" for x, y in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2"/>')
        out += [f'<circle cx="{x}" cy="{y}" r="3" fill="{color}"/>' for x, y in points]
        y = TOP + 20 + 22 * nth
        x = WIDTH - RIGHT + 14
        out.append(f'<path d="M{x} {y}h18" stroke="{color}" stroke-width="2"/><text x="{x + 24}" y="{y + 4}">{name}</text>')
    return "\n".join([*out, "</svg>"]) + "\n"
