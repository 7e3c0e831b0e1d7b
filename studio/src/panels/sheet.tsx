// The sheet from above: what the arm reaches of it, and the drawing, which a hand drags, scales and turns. X is to the right, Y up.
import { computed, effect, signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import * as check from "../run/check";
import { change, found, isFound, type Place, type Point, place, setWidth, size, turned, wanted } from "../run/place";
import { call } from "../session";
import * as store from "../store";
import { Do, Field, NumberInput } from "../ui/parts";
import { boundsOf, type Frame, pathOf, UP, viewBox } from "../view/flat";
import { drawn, watchWorld } from "../view/seen";
import { sentencesOf } from "../words";
import "./sheet.css";
import texts from "./sheet.json";

const w = sentencesOf(texts);

/** What is seen before the station has said what the arm reaches, and round it. */
const ROOM = { x: -240, y: -340, width: 580, height: 680 };
const MARGIN = 14;
/** From the middle of a small drawing to the edge of the picture, from near. */
const LEAST = 80;
/** How much wider than high it is. */
const WIDE = 1.3;
/** A turn snaps to its eighths when it is as near as this. */
const SNAP = 3;
/** What the beam leaves is as wide as this, mm: the lines of a photo are seen apart where they are. */
const BEAM = 0.2;
/** The dot goes along the whole path in no more seconds than this. */
const LONGEST = 20;
/** What a key makes of the size and the turn. */
const [GROWS, TURNS] = [1.05, 15];
const CORNERS: readonly Point[] = [
  [-1, -1],
  [1, -1],
  [1, 1],
  [-1, 1],
];

const outlines = signal<number[][][]>([]);

/** The lines of the picture, those that look the same in one path. */
const paths = computed(() => {
  const all = new Map<string, { color: string | null; power: number; path: string }>();
  const colors = new Map(check.report.value?.parts.map(({ n, color }) => [n, color]));
  for (const { points, part, power, reachable } of check.report.value?.preview?.strokes ?? []) {
    const color = reachable ? (part !== null && colors.get(part)) || "var(--planned)" : null;
    const key = `${color} ${power}`;
    all.set(key, { color, power, path: (all.get(key)?.path ?? "") + pathOf(points) });
  }
  return [...all].map(([key, line]) => ({ key, ...line }));
});
/** The whole way of the tip over the sheet, from line to line. */
const way = computed(() => pathOf((check.report.value?.preview?.strokes ?? []).flatMap(({ points }) => points)));

/** What the tip reaches at the height where it draws. */
function followReach(): () => void {
  const height = computed(() => check.report.value?.preview?.strokes[0]?.height ?? null);
  return effect(() => {
    const tool = String(check.fixed.value.tool ?? "pen");
    const z = height.value ?? store.model.value?.links[0]?.at[2];
    if (!store.isUp.value || z === undefined) return;
    call("motion.reach", { z, tool: tool as "pen" }).then(
      (reach) => (outlines.value = reach.outlines),
      () => {},
    );
  });
}

/** All that the arm reaches. */
function whole(): Frame {
  const points = outlines.value.flat();
  return points.length === 0 ? ROOM : boundsOf(points, MARGIN);
}

/** The drawing from near. A frame in which it is seen well stays: the sheet does not move below a hand. */
function near(before: Frame): Frame {
  const placed = found.value;
  if (placed === null) return whole();
  const [x, y] = placed.at;
  const reach = Math.hypot(...size.peek()) / 2;
  const isSeen =
    Math.abs(before.x + before.width / 2 - x) + reach < before.width / 2 &&
    Math.abs(before.y + before.height / 2 - y) + reach < before.height / 2;
  const half = Math.max(reach * 1.9, LEAST);
  if (isSeen && before.height < 3 * half) return before;
  return { x: x - half * WIDE, y: y - half, width: 2 * half * WIDE, height: 2 * half };
}

/** What a hand makes of a place: as it was when it was taken, where it was taken, and where the hand is now. */
type Hand = (place: Place, from: Point, to: Point) => Partial<Place>;
const far = ({ at: [x, y] }: Place, [px, py]: Point) => Math.max(Math.hypot(px - x, py - y), 1);
const angle = ({ at: [x, y] }: Place, [px, py]: Point) => (Math.atan2(py - y, px - x) * 180) / Math.PI;
const moves: Hand = ({ at: [x, y] }, from, to) => ({ at: [x + to[0] - from[0], y + to[1] - from[1]] });
const scales: Hand = (place, from, to) => ({ scale: (place.scale * far(place, to)) / far(place, from) });
const turns: Hand = (place, from, to) => {
  const free = place.turn + angle(place, to) - angle(place, from);
  const eighth = Math.round(free / 45) * 45;
  return { turn: Math.abs(free - eighth) < SNAP ? eighth : free };
};

export function Sheet({ hint }: { hint: string }) {
  const plane = useRef<SVGGElement>(null);
  const isNear = useSignal(true);
  const ghost = useSignal(false);
  const frame = useSignal<Frame>(ROOM);
  useEffect(followReach, []);
  useEffect(watchWorld, []);
  useEffect(() => effect(() => void (frame.value = isNear.value ? near(frame.peek()) : whole())), []);
  const { x, y, width, height } = frame.value;
  const now = place.value;
  const was = found.value;
  const [wide, high] = size.value;
  const state = store.state.value;
  const isBurnt = check.fixed.value.tool === "laser";
  /** A place on the sheet for the pointer. */
  const pointOf = (event: PointerEvent): Point => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(plane.current?.getScreenCTM()?.inverse());
    return [at.x, at.y];
  };
  const taken = (hand: Hand) => ({
    onPointerDown: (event: PointerEvent) => {
      const [target, before, from] = [event.currentTarget, place.peek(), pointOf(event)];
      if (event.button !== 0 || before === null || !(target instanceof Element)) return;
      target.setPointerCapture(event.pointerId);
      const over = new AbortController();
      target.addEventListener(
        "pointermove",
        (event) => change(hand(before, from, pointOf(event as PointerEvent))),
        over,
      );
      target.addEventListener("lostpointercapture", () => over.abort(), over);
    },
  });
  const keys = (event: KeyboardEvent) => {
    if (now === null || event.target !== event.currentTarget) return;
    const by = event.shiftKey ? 10 : 1;
    const [px, py] = now.at;
    const changes: Record<string, Partial<Place>> = {
      ArrowLeft: { at: [px - by, py] },
      ArrowRight: { at: [px + by, py] },
      ArrowUp: { at: [px, py + by] },
      ArrowDown: { at: [px, py - by] },
      "+": { scale: now.scale * GROWS },
      "-": { scale: now.scale / GROWS },
      "[": { turn: now.turn + TURNS },
      "]": { turn: now.turn - TURNS },
    };
    const wanted = changes[event.key];
    if (wanted === undefined) return;
    event.preventDefault();
    change(wanted);
  };
  /** Where a place on the sheet is in the picture, percent. */
  const spot = ([px, py]: Point) => ({
    left: `${(100 * (px - x)) / width}%`,
    top: `${(100 * (y + height - py)) / height}%`,
  });
  const corner = ([sx, sy]: Point, beyond = 0): Point => {
    const [dx, dy] = turned([(sx * wide) / 2, (sy * high) / 2 + beyond], now?.turn ?? 0);
    return [(now?.at[0] ?? 0) + dx, (now?.at[1] ?? 0) + dy];
  };
  const isThere = now !== null && was !== null && wide + high > 0;
  return (
    <section class="card sheet-card" aria-label={w("sheet.title")}>
      <div
        class={`plane ${check.isChecking.value ? "checking" : ""}`}
        style={{ "--ratio": width / height }}
        data-testid="draw-preview"
        data-shown={isThere && !check.isChecking.value && isFound.value}
        role="group"
        tabIndex={0}
        aria-label={w("sheet.name")}
        aria-describedby="sheet-keys"
        onKeyDown={keys}
      >
        <div class="plane-fit">
          <svg viewBox={viewBox(frame.value)} aria-hidden="true">
            <g ref={plane} transform={UP}>
              <path class="reach" d={outlines.value.map((outline) => `${pathOf(outline)}Z`).join("")} />
              <pattern id="sheet-grid" width="10" height="10" patternUnits="userSpaceOnUse">
                <path class="grid" d="M0 0H10M0 0V10" />
              </pattern>
              <rect x={x} y={y} width={width} height={height} fill="url(#sheet-grid)" />
              <path class="axes" d="M0 0H40M0 0V40" />
              <circle class="base" r="24" />
              {drawn.value.strokes.map(({ points, burnt }, nth) => (
                <path key={nth} class={burnt ? "burnt" : "ink"} d={pathOf(points)} />
              ))}
              {isThere ? (
                <g
                  transform={`translate(${now.at.join(" ")}) rotate(${now.turn - was.turn}) scale(${now.scale / was.scale}) translate(${-was.at[0]} ${-was.at[1]})`}
                >
                  {paths.value.map(({ key, color, power, path }) =>
                    color === null ? (
                      <g key={key}>
                        <path class="casing" d={path} />
                        <path class="unreachable" d={path} />
                      </g>
                    ) : (
                      <path
                        key={key}
                        class="drawn"
                        stroke={color}
                        d={path}
                        style={
                          isBurnt
                            ? {
                                strokeWidth: Math.max(BEAM, width / 1000),
                                strokeOpacity: power / 100,
                                strokeLinecap: "butt",
                                vectorEffect: "none",
                              }
                            : {}
                        }
                      />
                    ),
                  )}
                </g>
              ) : null}
              {isThere ? (
                <polygon
                  class="hold"
                  data-testid="draw-hold"
                  points={CORNERS.map((one) => corner(one).join()).join(" ")}
                  {...taken(moves)}
                />
              ) : null}
              {state === null ? null : <circle class="tip" cx={state.x} cy={state.y} r={width / 90} />}
              {ghost.value && isThere ? (
                <>
                  <path id="sheet-way" d={way.value} visibility="hidden" />
                  <circle class="ghost" r={width / 80}>
                    <animateMotion
                      dur={`${Math.min(LONGEST, check.report.value?.seconds ?? 0)}s`}
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
                  class="handle corner"
                  style={spot(corner(one))}
                  data-testid={`draw-corner-${nth + 1}`}
                  {...taken(scales)}
                />
              ))}
              <span
                class="handle turn"
                style={spot(corner([0, 1], height / 16))}
                data-testid="draw-turn"
                {...taken(turns)}
              />
            </>
          ) : (
            <p class="hint plane-hint">{hint}</p>
          )}
        </div>
      </div>
      <div class="cameras" role="group" aria-label={t("view.cameras")}>
        <Do
          id="draw-near"
          aria-pressed={isNear.value}
          text={w("sheet.near")}
          press={() => (isNear.value = !isNear.value)}
        />
        <Do
          id="draw-fit"
          aria-pressed={isThere && wanted.value === null}
          off={!isThere}
          text={w("sheet.fit")}
          press={() => (wanted.value = null)}
        />
        <Do
          id="draw-ghost"
          aria-pressed={ghost.value}
          off={!isThere}
          text={w("sheet.ghost")}
          press={() => (ghost.value = !ghost.value)}
        />
      </div>
      <p id="sheet-keys" class="hint">
        {w("sheet.keys")}
      </p>
      <Placing off={!isThere} />
    </section>
  );
}

/** The place in numbers, which can be typed. */
function Placing({ off }: { off: boolean }) {
  const [ax, ay] = place.value?.at ?? [0, 0];
  const fields = [
    { name: "x", unit: "mm", value: ax, set: (to: number) => change({ at: [to, ay] }) },
    { name: "y", unit: "mm", value: ay, set: (to: number) => change({ at: [ax, to] }) },
    { name: "width", unit: "mm", value: size.value[0], set: setWidth },
    { name: "rotate", unit: "°", value: place.value?.turn ?? 0, set: (to: number) => change({ turn: to }) },
  ] as const;
  return (
    <div class="placing">
      {fields.map(({ name, unit, value, set }) => (
        <Field key={name} label={w(`sheet.${name}`)} unit={unit}>
          <NumberInput
            id={`draw-place-${name}`}
            label={w(`sheet.${name}`)}
            value={value}
            step={1}
            off={off}
            set={set}
          />
        </Field>
      ))}
    </div>
  );
}
