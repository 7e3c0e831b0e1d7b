// Sheet as the reader in front of the arm sees it: the reachable part, and objects that can be
// dragged, scaled and turned.
import { computed, effect, signal, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Report } from "../api";
import type { Bench } from "../run/bench";
import { drawnItems, type Item, type Place, type Point } from "../run/items";
import * as jobs from "../run/jobs";
import * as paper from "../run/paper";
import { call } from "../session";
import * as store from "../store";
import { Button, Field, NumberInput } from "../ui/parts";
import { boundsOf, type Frame, pathOf, READER, ratioOf, viewBox } from "../view/flat";
import { watchWorld } from "../view/world";
import { sentencesOf } from "../words";
import "./sheet.css";
import texts from "./sheet.json";

const w = sentencesOf(texts);

/** Area shown before the station has reported the reach, and the margin around it. */
const DEFAULT_AREA = { x: -60, y: -340, width: 400, height: 680 };
const MARGIN = 14;
/** Edge of the visible area behind the arm's axis, mm: the arm stands there. */
const REAR_EDGE = -45;
/** Edge of the table in the picture, mm. */
const TABLE_EDGE = 345;
/** Smallest distance from the middle of a drawing to the edge of the picture. */
const MIN_HALF_VIEW = 80;
/** Share of the paper above which the whole paper is shown with a drawing. */
const WHOLE_PAPER_SHARE = 0.4;
/** Aspect ratio of the picture. */
const ASPECT_RATIO = 1.3;
/** Distance at which a turn snaps to multiples of an eighth, degrees. */
const SNAP_ANGLE = 3;
/**
 * Width of burnt lines in the picture, mm, so that lines of a photo appear separate where they are.
 */
const BURNT_LINE_WIDTH = 0.2;
/** Longest time in which the dot runs along the whole path, s. */
const MAX_DOT_DURATION = 20;
/** Factor of the size, and angle, for one key press. */
const [KEY_SCALE, KEY_ANGLE] = [1.05, 15];
const CORNERS: readonly Point[] = [
  [-1, -1],
  [1, -1],
  [1, 1],
  [-1, 1],
];

const outlines = signal<number[][][]>([]);

/** Keeps the reach at the drawing height up to date. */
function followReach(bench: Bench): () => void {
  const height = computed(() => bench.report.value?.preview?.strokes[0]?.height ?? null);
  return effect(() => {
    const z = height.value ?? store.model.value?.links[0]?.at[2];
    if (!store.isUp.value || z === undefined) return;
    call("motion.reach", { z, tool: bench.tool }).then(
      (reach) => (outlines.value = reach.outlines),
      () => {},
    );
  });
}

const sheetOf = () =>
  paper.corners()?.map((corner) => corner.map((value) => Math.max(-TABLE_EDGE, Math.min(TABLE_EDGE, value))));

/** Frame of the sheet with the arm's base, or of everything in reach. */
function wholeFrame(): Frame {
  const sheet = sheetOf();
  const points = sheet ?? outlines.value.flat();
  if (points.length === 0) return DEFAULT_AREA;
  const { x, y, width, height } = boundsOf(points, MARGIN);
  const top = sheet === undefined ? Math.max(x, REAR_EDGE) : Math.min(x, REAR_EDGE);
  return { x: top, y, width: x + width - top, height };
}

/**
 * Frame close to the objects. The current one is kept while they fit well, so that the sheet does
 * not move under the pointer.
 */
function closeFrame(bench: Bench, before: Frame): Frame {
  const boxes = bench.doc.now.value.items.flatMap((item) => {
    const place = bench.checkedObjects.value.has(item.id) ? bench.placeOf(item) : null;
    if (place === null) return [];
    const reach = Math.hypot(...bench.sizeOf(item)) / 2;
    const [x, y] = bench.cornerOf(item, [0, 0]);
    return [
      [x - reach, y - reach],
      [x + reach, y + reach],
    ];
  });
  if (boxes.length === 0) return wholeFrame();
  const all = boundsOf(boxes);
  const [x, y] = [all.x + all.width / 2, all.y + all.height / 2];
  const isSeen =
    all.x > before.x &&
    all.y > before.y &&
    all.x + all.width < before.x + before.width &&
    all.y + all.height < before.y + before.height;
  const sheet = boundsOf(sheetOf() ?? [], MARGIN);
  const isOnPaper = sheet.width > 0;
  // A drawing that takes much of the paper is shown with all of it.
  if (isOnPaper && (all.height > sheet.height * WHOLE_PAPER_SHARE || all.width > sheet.width * WHOLE_PAPER_SHARE))
    return boundsOf([...boxes, [sheet.x, sheet.y], [sheet.x + sheet.width, sheet.y + sheet.height]]);
  const half = Math.max((all.width / 2) * 1.25, (all.height / 2 / ASPECT_RATIO) * 1.1, MIN_HALF_VIEW);
  if (isSeen && before.width < 3 * half) return before;
  const [wide, high] = [2 * half * ASPECT_RATIO, 2 * half];
  // Beyond the paper, or out of reach, there is nothing to show.
  const room = isOnPaper ? sheet : wholeFrame();
  const within = (from: number, side: number, least: number, most: number) =>
    side > most ? least - (side - most) / 2 : Math.max(least, Math.min(least + most - side, from));
  return {
    x: within(x - high / 2, high, room.x, room.width),
    y: within(y - wide / 2, wide, room.y, room.height),
    width: high,
    height: wide,
  };
}

/** Effect of dragging: from the place at the start and the pointer's positions to the new place. */
type DragEffect = (place: Place, from: Point, to: Point) => Partial<Place>;
const distance = ({ at: [x, y] }: Place, [px, py]: Point) => Math.max(Math.hypot(px - x, py - y), 1);
const angleTo = ({ at: [x, y] }: Place, [px, py]: Point) => (Math.atan2(py - y, px - x) * 180) / Math.PI;
const dragMove: DragEffect = ({ at: [x, y] }, from, to) => ({ at: [x + to[0] - from[0], y + to[1] - from[1]] });
const dragScale: DragEffect = (place, from, to) => ({
  scale: (place.scale * distance(place, to)) / distance(place, from),
});
const dragTurn: DragEffect = (place, from, to) => {
  const free = place.turn + angleTo(place, to) - angleTo(place, from);
  const eighth = Math.round(free / 45) * 45;
  return { turn: Math.abs(free - eighth) < SNAP_ANGLE ? eighth : free };
};

interface Line {
  key: string;
  color: string | null;
  power: number;
  path: string;
}
/** Lines of an object; equal-looking lines are one path. */
function linesOf(report: Report, pen: string | null, isOwn: boolean, usual: string): Line[] {
  const colors = new Map(report.parts.map(({ n, color }) => [n, color]));
  const all = new Map<string, Line>();
  for (const { points, part, power, reachable } of report.preview?.strokes ?? []) {
    const own = pen ?? (part !== null && isOwn ? colors.get(part) : null) ?? usual;
    const color = reachable ? own : null;
    const key = `${color} ${power}`;
    const line = all.get(key) ?? { key, color, power, path: "" };
    line.path += pathOf(points);
    all.set(key, line);
  }
  return [...all.values()];
}

/** Object as it was checked, moved to where it is wanted. */
function SheetItem({ bench, item, width }: { bench: Bench; item: Item; width: number }) {
  const found = bench.checkedObjects.value.get(item.id);
  const [was, now] = [found?.place ?? null, bench.placeOf(item)];
  const usual = bench.isComposed.value ? "#000000" : "var(--planned)";
  const lines = useMemo(
    () => (found === undefined ? [] : linesOf(found.report, item.color, item.shape === undefined, usual)),
    [found, item.color, usual],
  );
  if (was === null || now === null || !drawnItems(bench.doc.now.value.items).includes(item)) return null;
  const burnt = (power: number) => ({
    strokeWidth: Math.max(BURNT_LINE_WIDTH, width / 1000),
    strokeOpacity: power / 100,
    strokeLinecap: "butt",
    vectorEffect: "none",
  });
  return (
    <g
      transform={`translate(${now.at.join(" ")}) rotate(${now.turn - was.turn}) scale(${now.scale / was.scale}) translate(${-was.at[0]} ${-was.at[1]})`}
    >
      {lines.map(({ key, color, power, path }) =>
        color === null ? (
          <g key={key}>
            <path class="casing" d={path} />
            <path class="unreachable" d={path} />
          </g>
        ) : (
          <path key={key} class="drawn" stroke={color} d={path} style={bench.tool === "laser" ? burnt(power) : {}} />
        ),
      )}
    </g>
  );
}

export function Sheet({ bench, hint }: { bench: Bench; hint: string }) {
  const plane = useRef<SVGGElement>(null);
  const isNear = useSignal(true);
  const ghost = useSignal(false);
  const frame = useSignal<Frame>(DEFAULT_AREA);
  useEffect(() => followReach(bench), [bench]);
  useEffect(watchWorld, []);
  useEffect(
    () => effect(() => void (frame.value = isNear.value ? closeFrame(bench, frame.peek()) : wholeFrame())),
    [bench],
  );
  const { x, y, width, height } = frame.value;
  const { items } = bench.doc.now.value;
  const item = bench.item.value;
  const now = bench.place.value;
  const [wide, high] = item === null ? [0, 0] : bench.sizeOf(item);
  const state = store.state.value;
  const report = bench.report.value;
  const isComplete = items.length > 0 && report !== null && !bench.isChecking.value && bench.isChecked.value;
  const sheet = paper.corners();
  // On dark paper an engraving or a photo would look like its negative.
  const isLight = bench.tool === "laser" || items.some(({ format }) => format === "image");
  const reach = outlines.value.map((outline) => `${pathOf(outline)}Z`).join("");
  /** Position on the sheet of a pointer event. */
  const pointOf = (event: PointerEvent): Point => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(plane.current?.getScreenCTM()?.inverse());
    return [at.x, at.y];
  };
  let grips = 0;
  const taken = (hand: DragEffect, id: number | null = item?.id ?? null) => ({
    onPointerDown: (event: PointerEvent) => {
      if (event.button !== 0) return;
      bench.choose(id);
      const [target, before, from] = [event.currentTarget, bench.place.peek(), pointOf(event)];
      if (before === null || !(target instanceof Element)) return;
      target.setPointerCapture(event.pointerId);
      const key = `grip ${++grips} ${Date.now()}`;
      const over = new AbortController();
      target.addEventListener(
        "pointermove",
        (event) => bench.change(hand(before, from, pointOf(event as PointerEvent)), key),
        over,
      );
      target.addEventListener("lostpointercapture", () => over.abort(), over);
    },
  });
  const keys = (event: KeyboardEvent) => {
    if (item === null || now === null || event.target !== event.currentTarget) return;
    if (event.key === "Delete" || event.key === "Backspace") {
      event.preventDefault();
      return bench.remove(item.id);
    }
    const by = event.shiftKey ? 10 : 1;
    const [px, py] = now.at;
    const changes: Record<string, Partial<Place>> = {
      ArrowLeft: { at: [px, py - by] },
      ArrowRight: { at: [px, py + by] },
      ArrowUp: { at: [px - by, py] },
      ArrowDown: { at: [px + by, py] },
      "+": { scale: now.scale * KEY_SCALE },
      "-": { scale: now.scale / KEY_SCALE },
      "[": { turn: now.turn + KEY_ANGLE },
      "]": { turn: now.turn - KEY_ANGLE },
    };
    const wanted = changes[event.key];
    if (wanted === undefined) return;
    event.preventDefault();
    bench.change(wanted, "key");
  };
  /** Position in the picture of a point on the sheet, percent. */
  const spot = ([px, py]: Point) => ({
    left: `${(100 * (py - y)) / height}%`,
    top: `${(100 * (px - x)) / width}%`,
  });
  const outlineOf = (of: Item) => CORNERS.map((one) => bench.cornerOf(of, one).join()).join(" ");
  const isThere = item !== null && now !== null && wide + high > 0;
  return (
    <section class="card sheet-card" aria-label={w("sheet.title")}>
      <div
        class={`plane ${bench.isChecking.value ? "checking" : ""} is-${bench.stage.value} ${isLight ? "light" : ""}`}
        style={{ "--ratio": ratioOf(frame.value) }}
        data-testid="draw-preview"
        data-shown={isThere && isComplete}
        role="group"
        tabIndex={0}
        aria-label={w("sheet.name")}
        aria-describedby="sheet-keys"
        onKeyDown={keys}
      >
        <div class="plane-fit">
          <svg viewBox={viewBox(frame.value)} aria-hidden="true">
            <g ref={plane} transform={READER}>
              <clipPath id="sheet-reach">
                <path clip-rule="evenodd" d={reach} />
              </clipPath>
              <path class={`reach ${sheet === null ? "paper" : ""}`} d={reach} />
              {sheet === null ? null : (
                <>
                  <polygon class="beyond" points={sheet.map((at) => at.join()).join(" ")} />
                  <polygon
                    class="paper"
                    clip-path="url(#sheet-reach)"
                    points={sheet.map((at) => at.join()).join(" ")}
                    data-testid="sheet-paper"
                  />
                </>
              )}
              <pattern id="sheet-grid" width="10" height="10" patternUnits="userSpaceOnUse">
                <path class="grid" d="M0 0H10M0 0V10" />
              </pattern>
              <rect x={x} y={y} width={width} height={height} fill="url(#sheet-grid)" />
              <circle class="base" r="24" />
              {paper.strokes().map(({ points, burnt }, nth) => (
                <path key={nth} class={burnt ? "burnt" : "ink"} d={pathOf(points)} />
              ))}
              {items.map((one) => (
                <SheetItem key={one.id} bench={bench} item={one} width={width} />
              ))}
              {bench.isComposed.value && isComplete
                ? report.preview?.strokes.map(({ reachable, points }, nth) =>
                    reachable ? null : <path key={nth} class="unreachable" d={pathOf(points)} />,
                  )
                : null}
              {items.map((one) =>
                one === item || bench.checkedObjects.value.get(one.id)?.place == null ? null : (
                  <polygon
                    key={one.id}
                    class="other"
                    data-testid={`draw-item-${one.id}`}
                    points={outlineOf(one)}
                    {...taken(dragMove, one.id)}
                  />
                ),
              )}
              {isThere ? (
                <polygon class="hold" data-testid="draw-hold" points={outlineOf(item)} {...taken(dragMove)} />
              ) : null}
              {state === null ? null : <circle class="tip" cx={state.x} cy={state.y} r={height / 110} />}
              {ghost.value && isThere ? (
                <>
                  <path
                    id="sheet-way"
                    d={pathOf((report?.preview?.strokes ?? []).flatMap(({ points }) => points))}
                    visibility="hidden"
                  />
                  <circle class="ghost" r={height / 95}>
                    <animateMotion
                      dur={`${Math.min(MAX_DOT_DURATION, report?.seconds ?? 0)}s`}
                      repeatCount="indefinite"
                    >
                      <mpath href="#sheet-way" />
                    </animateMotion>
                  </circle>
                </>
              ) : null}
            </g>
          </svg>
          {isThere ? (
            <>
              {CORNERS.map((one, nth) => (
                <span
                  key={nth}
                  class={`handle corner ${nth % 2 === 0 ? "" : "other-way"}`}
                  style={spot(bench.cornerOf(item, one))}
                  data-testid={`draw-corner-${nth + 1}`}
                  {...taken(dragScale)}
                />
              ))}
              <span
                class="handle turn"
                style={spot(bench.cornerOf(item, [0, 1], width / 16))}
                data-testid="draw-turn"
                {...taken(dragTurn)}
              />
            </>
          ) : items.length > 0 || !paper.isBlank() ? null : (
            <p class="hint plane-hint">{hint}</p>
          )}
        </div>
      </div>
      <div class="cameras" role="group" aria-label={w("sheet.tools")}>
        <Button
          id="draw-undo"
          class="icon"
          label={w("sheet.undo")}
          title={`${w("sheet.undo")} (Ctrl+Z)`}
          off={!bench.doc.canUndo.value}
          text="↶"
          press={() => bench.undo()}
        />
        <Button
          id="draw-redo"
          class="icon"
          label={w("sheet.redo")}
          title={`${w("sheet.redo")} (Ctrl+Y)`}
          off={!bench.doc.canRedo.value}
          text="↷"
          press={() => bench.redo()}
        />
        <Button
          id="draw-near"
          aria-pressed={isNear.value && items.length > 0}
          off={items.length === 0}
          text={w("sheet.near")}
          press={() => (isNear.value = !isNear.value)}
        />
        <Button
          id="draw-fit"
          aria-pressed={isThere && item.place === null}
          off={!isThere}
          text={w("sheet.fit")}
          press={() => bench.releasePlace()}
        />
        <Button
          id="draw-ghost"
          aria-pressed={ghost.value}
          off={!isThere}
          text={w("sheet.ghost")}
          press={() => (ghost.value = !ghost.value)}
        />
        <NewSheet bench={bench} />
      </div>
      <p id="sheet-keys" class="hint">
        {w("sheet.hand")} <span class="with-keys">{w("sheet.keys")}</span>
      </p>
      <Placing bench={bench} off={!isThere} />
    </section>
  );
}

/** Button for a new sheet of paper. Also shown where the sheet is full. */
export function NewSheet({ bench, id = "sheet-new" }: { bench: Bench; id?: string }) {
  const reason = jobs.whyNoControl.value ?? (jobs.busy.value ? "why.busy.job" : null);
  const isVirtual = store.arm.value?.virtual === true;
  const lay = async () => {
    if (!(await paper.layNewSheet())) return;
    bench.refresh();
    store.notify(w(isVirtual ? "sheet.new.done" : "sheet.new.real"));
  };
  return (
    <Button
      id={id}
      off={paper.isBlank() || (isVirtual ? reason !== null : jobs.busy.value)}
      title={w("sheet.new.text")}
      text={w("sheet.new")}
      press={lay}
    />
  );
}

/** Place and size of the object as numbers to edit. */
function Placing({ bench, off }: { bench: Bench; off: boolean }) {
  const place = bench.place.value;
  const item = bench.item.value;
  const [ax, ay] = place?.at ?? [0, 0];
  const width = item === null ? 0 : bench.sizeOf(item)[0];
  const fields = [
    { name: "x", unit: "mm", value: ax, set: (to: number) => bench.change({ at: [to, ay] }) },
    { name: "y", unit: "mm", value: ay, set: (to: number) => bench.change({ at: [ax, to] }) },
    { name: "width", unit: "mm", least: 0.5, value: width, set: (to: number) => bench.setWidth(to) },
    { name: "rotate", unit: "°", value: place?.turn ?? 0, set: (to: number) => bench.change({ turn: to }) },
  ] as const;
  return (
    <div class="placing">
      {fields.map(({ name, unit, value, set, ...limits }) => (
        <Field key={name} label={w(`sheet.${name}`)} unit={unit}>
          <NumberInput
            id={`draw-place-${name}`}
            label={w(`sheet.${name}`)}
            value={value}
            step={1}
            {...limits}
            off={off}
            set={set}
          />
        </Field>
      ))}
    </div>
  );
}
