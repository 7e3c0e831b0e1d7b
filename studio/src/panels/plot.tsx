// Plots of the last two minutes of readings, which can be paused, scrolled back and saved.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { wallTime } from "../clock";
import { t } from "../i18n";
import { save } from "../log";
import { io, levels, watchKind, watchPins } from "../pins";
import { COLUMN, POSE, type Readings, readingCounter, readings, snapshot } from "../ring";
import { theme } from "../settings";
import * as store from "../store";
import { colorAt } from "../ui/color";
import { Button, Card, Choice, ColumnHeads, Range } from "../ui/parts";
import { sentencesOf } from "../words";
import "./plot.css";
import texts from "./plot.json";

const w = sentencesOf(texts);

type Group = "tip" | "joints" | "speed" | "queue" | "pins";
const GROUPS: readonly Group[] = ["tip", "joints", "speed", "queue", "pins"];
const SPANS = ["10", "30", "120"] as const;
/** Rows of the table, and the shortest time between updates, ms. */
const TABLE_ROWS = 8;
const TABLE_INTERVAL = 400;

interface Line {
  name: string;
  unit: string;
  column: number;
  /** Factor that values are multiplied by. */
  scale: number;
}

function linesOf(group: Group): Line[] {
  const line = (name: string, unit: string, column: number, scale = 1): Line => ({ name, unit, column, scale });
  if (group === "tip")
    return [line("x", "mm", COLUMN.x), line("y", "mm", COLUMN.y), line("z", "mm", COLUMN.z), line("r", "°", COLUMN.r)];
  if (group === "joints")
    return (["j1", "j2", "j3", "j4"] as const).map((name) => line(name.toUpperCase(), "°", COLUMN[name]));
  if (group === "speed") return [line(w("plot.speed"), "mm/s", COLUMN.speed)];
  if (group === "queue") return [line(w("plot.left"), "", COLUMN.left)];
  const { counts = 1, volts = 1 } = io.value?.analog ?? {};
  return (io.value?.pins ?? []).flatMap(({ address, function: own }) => {
    const kind = watchKind(own);
    const name = w("plot.pin", { n: address });
    return kind === null
      ? []
      : [
          kind === "analog"
            ? line(name, "V", COLUMN.pin + address, volts / counts)
            : line(name, "", COLUMN.pin + address),
        ];
  });
}
const COLORS = ["--p1", "--p2", "--p3", "--p4", "--p5", "--p6"];
const colorOf = (nth: number) => COLORS[nth % COLORS.length] ?? "--p1";

/** Row range of a time window that ends `end` seconds before the last reading. */
function rowRange(from: Readings, span: number, end: number): [number, number] {
  const last = from.count === 0 ? 0 : from.value(from.count - 1, COLUMN.t) - end;
  let [low, high] = [0, from.count];
  while (high > 0 && from.value(high - 1, COLUMN.t) > last) high--;
  low = high;
  while (low > 0 && from.value(low - 1, COLUMN.t) >= last - span) low--;
  return [low, high];
}

/** Columns of a time window, with times relative to its end. */
function columns(
  from: Readings,
  lines: readonly Line[],
  span: number,
  end: number,
): { data: uPlot.AlignedData; marks: Array<[number, string]> } {
  const [low, high] = rowRange(from, span, end);
  const zero = from.count === 0 ? 0 : from.value(from.count - 1, COLUMN.t);
  const times: number[] = [];
  const values: Array<Array<number | null>> = lines.map(() => []);
  const marks: Array<[number, string]> = [];
  for (let row = low; row < high; row++) {
    const time = from.value(row, COLUMN.t) - zero;
    times.push(time);
    lines.forEach(({ column, scale }, nth) => {
      const value = from.value(row, column);
      values[nth]?.push(Number.isNaN(value) ? null : value * scale);
    });
    const before = row > low ? codesOf(from, row - 1) : [];
    for (const code of codesOf(from, row)) if (!before.includes(code)) marks.push([time, code]);
  }
  return { data: [times, ...values] as uPlot.AlignedData, marks };
}

/** Alarms of a row as hexadecimal codes. */
const codesOf = (from: Readings, row: number) =>
  from.alarms(row).map((code) => `0x${code.toString(16).padStart(2, "0")}`);

/** Readings as CSV, in the format of `magician record`. */
function csv(from: Readings): string {
  const rows = ["time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms"];
  const first = from.count === 0 ? 0 : from.value(0, COLUMN.t);
  for (let row = 0; row < from.count; row++) {
    const pose = POSE.map((name) => from.value(row, COLUMN[name]));
    const t = from.value(row, COLUMN.t);
    rows.push(
      [
        wallTime(t).toISOString(),
        (t - first).toFixed(3),
        ...pose,
        from.value(row, COLUMN.index),
        from.value(row, COLUMN.left),
        codesOf(from, row).join(" "),
      ].join(","),
    );
  }
  return `${rows.join("\n")}\n`;
}

/** Chart shown last. It is reused, because uPlot does not release the nodes of a discarded chart. */
let cachedChart: { key: string; chart: uPlot; draws: (chart: uPlot) => void } | null = null;

/** Creates a chart of these lines, with the colours of axes, grid and lines. `draws` is called at each redraw. */
function chartOf(names: readonly string[], colors: readonly string[], draws: (chart: uPlot) => void): uPlot {
  const key = JSON.stringify([names, colors, devicePixelRatio]);
  if (cachedChart?.key === key) {
    cachedChart.draws = draws;
    return cachedChart.chart;
  }
  cachedChart?.chart.destroy();
  const [muted = "", line = "", ...own] = colors;
  const axis = {
    stroke: muted,
    grid: { stroke: line, width: 1 },
    ticks: { stroke: line, width: 1 },
    font: "12px system-ui",
  };
  const chart = new uPlot(
    {
      width: 600,
      height: 300,
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { size: 7 } },
      scales: { x: { time: false, auto: false }, y: { range: (_, least, most) => axisRange(least, most) } },
      axes: [
        { ...axis, values: (_, ticks) => ticks.map((tick) => `${Math.round(tick * 10) / 10} s`) },
        { ...axis, size: 56 },
      ],
      series: [
        {},
        ...names.map((label, nth) => ({ label, stroke: own[nth] ?? muted, width: 2, points: { show: false } })),
      ],
      hooks: { draw: [(chart) => cachedChart?.draws(chart)] },
    },
    [[]],
    document.createElement("div"),
  );
  cachedChart = { key, chart, draws };
  return chart;
}

interface ChartProps {
  lines: readonly Line[];
  source: () => Readings;
  span: number;
  back: number;
  live: boolean;
}

function Chart({ lines, source, span, back, live }: ChartProps) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = place.current;
    if (element === null) return;
    let chart: uPlot | null = null;
    let [frame, began] = [0, 0];
    let marks: Array<[number, string]> = [];
    const css = (name: string) => colorAt(element, name);
    let markColor = "";
    const size = () => ({ width: element.clientWidth, height: element.clientHeight });
    const draw = () => {
      frame = 0;
      if (chart === null) return;
      began = performance.now();
      const seen = columns(source(), lines, span, back);
      marks = seen.marks;
      chart.batch(() => {
        chart?.setData(seen.data, false);
        chart?.setScale("x", { min: -back - span, max: -back });
      });
      element.dataset.rows = String(seen.data[0].length);
    };
    const wake = () => {
      if (frame === 0) frame = requestAnimationFrame(draw);
    };
    const drawMarks = ({ ctx, bbox, valToPos }: uPlot) => {
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = markColor;
      ctx.textAlign = "left";
      ctx.font = `600 ${12 * devicePixelRatio}px system-ui`;
      for (const [time, code] of marks) {
        const x = Math.round(valToPos(time, "x", true));
        ctx.fillRect(x, bbox.top, Math.max(1, devicePixelRatio), bbox.height);
        ctx.fillText(code, x + 4 * devicePixelRatio, bbox.top + 14 * devicePixelRatio);
      }
      ctx.restore();
      // The time of drawing, for tests.
      element.dataset.ms = (performance.now() - began).toFixed(2);
    };
    const make = () => {
      chart?.root.remove();
      markColor = css("--stop");
      const colors = [css("--muted"), css("--line"), ...lines.map((_, nth) => css(colorOf(nth)))];
      chart = chartOf(
        lines.map(({ name }) => name),
        colors,
        drawMarks,
      );
      element.append(chart.root);
      chart.setSize(size());
      draw();
    };
    make();
    const ends = [
      effect(() => {
        void readingCounter.value;
        if (live) wake();
      }),
      effect(() => {
        void theme.value;
        make();
      }),
    ];
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", make);
    const sizes = new ResizeObserver(() => chart?.setSize(size()));
    sizes.observe(element);
    return () => {
      cancelAnimationFrame(frame);
      for (const end of ends) end();
      dark.removeEventListener("change", make);
      sizes.disconnect();
      chart?.root.remove();
      if (cachedChart !== null) cachedChart.draws = () => {};
    };
  }, [lines.map(({ name }) => name).join(), source, span, back, live]);
  return (
    <div
      class="plot-place"
      ref={place}
      role="img"
      aria-label={w("plot.name")}
      aria-describedby="plot-table"
      data-testid="plot"
    />
  );
}

/** Axis range. A minimum width keeps the noise of an arm at rest from filling the plot. */
function axisRange(least: number, most: number): [number, number] {
  if (!Number.isFinite(least) || !Number.isFinite(most)) return [0, 1];
  const room = Math.max((most - least) * 0.08, (2 - (most - least)) / 2, 0);
  return [least - room, most + room];
}

const formatNumber = (value: number, digits = 2) => (Number.isNaN(value) ? "–" : value.toFixed(digits));

export function Plots() {
  const group = useSignal<Group>("tip");
  const span = useSignal<(typeof SPANS)[number]>("30");
  const held = useSignal<(() => Readings) | null>(null);
  const back = useSignal(0);
  const shown = useSignal(0);
  useEffect(watchPins, []);
  useEffect(() => {
    const timer = setInterval(() => (shown.value = readingCounter.peek()), TABLE_INTERVAL);
    return () => clearInterval(timer);
  }, []);
  void shown.value;
  // A different set of pins has different lines.
  if (group.value === "pins") void levels.value;
  const source = held.value ?? readings;
  const from = source();
  const lines = linesOf(group.value);
  const [, high] = rowRange(from, Number(span.value), back.value);
  const rows = Array.from({ length: Math.min(TABLE_ROWS, high) }, (_, nth) => high - 1 - nth);
  const zero = from.count === 0 ? 0 : from.value(from.count - 1, COLUMN.t);
  const all = from.count === 0 ? 0 : zero - from.value(0, COLUMN.t);
  const scrub = (to: number) => {
    if (held.value === null) hold(true);
    back.value = Math.abs(to);
  };
  const hold = (is: boolean) => {
    const seen = snapshot();
    held.value = is ? () => seen : null;
    if (!is) back.value = 0;
  };
  return (
    <div class="plots">
      <Card
        title={t("nav.plots")}
        more={
          <div class="sheet-buttons">
            <Button
              id="plot-pause"
              aria-pressed={held.value !== null}
              text={w(held.value === null ? "plot.pause" : "plot.go")}
              press={() => hold(held.value === null)}
            />
            <Button
              id="plot-export"
              class="quiet"
              off={from.count === 0}
              press={() => save(`${store.armName.value ?? "arm"}-readings.csv`, csv(source()))}
            >
              {w("plot.export")}
            </Button>
          </div>
        }
      >
        <div class="plot-bar">
          <Choice<Group>
            name="plot"
            label={w("plot.group")}
            value={group.value}
            choose={(value) => (group.value = value)}
            options={GROUPS.map((value) => ({ value, text: w(`plot.${value}`) }))}
          />
          <Choice
            name="plot-span"
            label={w("plot.span")}
            value={span.value}
            choose={(value) => (span.value = value)}
            options={SPANS.map((value) => ({ value, text: `${value} s` }))}
          />
        </div>
        <div class="plot-legend">
          {lines.map((line, nth) => (
            <span key={line.name} style={{ color: `var(${colorOf(nth)})` }}>
              <i />
              {line.name}
              <b>{high === 0 ? "–" : `${formatNumber(from.value(high - 1, line.column) * line.scale)} ${line.unit}`}</b>
            </span>
          ))}
          {lines.length === 0 ? <p class="hint">{w("plot.noPins")}</p> : null}
        </div>
        <Chart lines={lines} source={source} span={Number(span.value)} back={back.value} live={held.value === null} />
        <label class="plot-scrub">
          {w("plot.scrub")}
          <Range
            id="plot-scrub"
            least={-Math.floor(all)}
            most={0}
            value={-back.value}
            text={w("plot.back", { n: back.value })}
            set={scrub}
          />
          <output>{w("plot.back", { n: back.value })}</output>
        </label>
      </Card>
      <Card title={w("plot.last")}>
        <div class="plot-table" role="region" aria-label={w("plot.last")} tabIndex={0}>
          <table id="plot-table" data-testid="plot-table">
            <ColumnHeads names={["s", ...POSE, "mm/s", w("plot.index"), w("plot.left"), t("alarms.title")]} />
            <tbody>
              {rows.map((row, nth) => (
                <tr key={nth}>
                  <td>{formatNumber(from.value(row, COLUMN.t) - zero)}</td>
                  {POSE.map((name) => (
                    <td key={name}>{formatNumber(from.value(row, COLUMN[name]))}</td>
                  ))}
                  <td>{formatNumber(from.value(row, COLUMN.speed), 1)}</td>
                  <td>{from.value(row, COLUMN.index)}</td>
                  <td>{from.value(row, COLUMN.left)}</td>
                  <td>{codesOf(from, row).join(" ") || "–"}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      </Card>
    </div>
  );
}
