// World of a virtual arm as last read, for its panel and for the picture.
import { effect, signal } from "@preact/signals";
import { attempt, homeShownArm } from "../actions";
import type { Result } from "../client";
import { call, shownArm } from "../session";
import * as store from "../store";
import { until } from "../until";
import { type Lines, show, USUAL_TABLE } from "./layers";

export type World = Result<"world.look">;
export type Stroke = NonNullable<World["strokes"]>[number];

export const world = signal<World | null>(null);
/** Drawing in the world. The object is kept while the drawing does not change. */
export const drawn = signal<{ svg: string; strokes: Stroke[] }>({ svg: "", strokes: [] });
/** True if the arm has no world that can be read. */
export const hasNoWorld = signal(false);

/**
 * Polling interval, ms: for the world panel, for other panels, and while the arm moves in a world
 * with objects.
 */
const POLL_INTERVALS = { own: 250, other: 1000, moving: 100 };
/** Limit of drawn coordinates, mm. */
const MAX_COORDINATE = 420;
let watchers = 0;
let timer: ReturnType<typeof setTimeout> | undefined;
let worldArm: string | null = null;

/** Polls the world until the returned function is called. */
export function watchWorld(): () => void {
  if (watchers++ === 0) void readWorld();
  return () => {
    if (--watchers === 0) clearTimeout(timer);
  };
}

/** Reads the world immediately, after a change. */
export async function readWorld(): Promise<void> {
  clearTimeout(timer);
  const { arm } = shownArm();
  if (worldArm !== arm) forget(arm);
  if (store.socket.value === "up" && store.arm.value?.virtual === true && !hasNoWorld.value && !document.hidden) {
    try {
      const mark = world.value?.mark;
      const latest = await call("world.look", { arm, ...(mark === undefined ? {} : { mark }) });
      if (arm === store.armName.value) applyWorld(latest);
    } catch (error) {
      hasNoWorld.value = (error as { data?: { kind?: string } }).data?.kind === "unsupported";
    }
  }
  clearTimeout(timer);
  const moves = store.state.value?.moving === true && (world.value?.objects.length ?? 0) > 0;
  if (watchers > 0)
    timer = setTimeout(
      () => void readWorld(),
      moves ? POLL_INTERVALS.moving : store.route.value === "world" ? POLL_INTERVALS.own : POLL_INTERVALS.other,
    );
}

/** Time within which an arm reports after power-up that it is not homed, ms. */
const HOMING_REPORT_TIME = 600;

/**
 * Power-cycles the arm in the world of a scenario. Returns the names of its objects. The page's own
 * arm is homed at once; another arm is homed again if it was homed and `homes` is true.
 */
export async function loadScenario(text: string, homes = true): Promise<string[]> {
  const wasHomed = store.isHomed.value === true;
  const { objects } = await call("world.scenario", { ...shownArm(), text });
  // The measured table and paper belong to the former world.
  const { forgetIfMeasured } = await import("../run/surface");
  await forgetIfMeasured();
  void readWorld();
  if (homes && wasHomed && (await until(() => store.isHomed.value === false, HOMING_REPORT_TIME)))
    void attempt(homeShownArm);
  return objects;
}

/** Loads a built-in scenario in the same way. Returns false if the name is unknown. */
export async function loadBuiltIn(name: string, homes = true): Promise<boolean> {
  const { scenarios } = await call("world.scenarios", shownArm());
  const found = scenarios.find((one) => one.name === name);
  if (found === undefined) return false;
  await loadScenario(found.text, homes);
  await readWorld();
  return true;
}

function forget(arm: string): void {
  worldArm = arm;
  world.value = null;
  hasNoWorld.value = false;
  drawn.value = { svg: "", strokes: [] };
}

function applyWorld(latest: World): void {
  if (latest.strokes !== null) drawn.value = { svg: latest.drawing ?? "", strokes: latest.strokes };
  if (JSON.stringify(latest) !== JSON.stringify(world.value)) world.value = latest;
}

/** Darkness of a stroke, in steps of a tenth. A burnt stroke's depends on its power. */
export const darkness = ({ burnt, power }: Stroke): number => (burnt ? Math.max(1, Math.round(power / 10)) / 10 : 1);

const clampRange = ([least = -MAX_COORDINATE, most = MAX_COORDINATE]: number[]): [number, number] => [
  Math.max(-MAX_COORDINATE, least),
  Math.min(MAX_COORDINATE, most),
];

effect(() => {
  const table = world.value?.table ?? null;
  const height = table?.height ?? USUAL_TABLE;
  const [x, y] = [clampRange(table?.x ?? []), clampRange(table?.y ?? [])];
  const sheet = [
    [x[0], y[0]],
    [x[1], y[0]],
    [x[1], y[1]],
    [x[0], y[1]],
  ].map((corner) => [...corner, height]);
  const lines = drawn.value.strokes.map((stroke): Lines => {
    const { burnt, points } = stroke;
    return {
      points: points.map(([px = 0, py = 0]) => [px, py, height + 0.5]),
      color: burnt ? "--burnt" : "--ink",
      dots: points.length === 1,
      opacity: darkness(stroke),
    };
  });
  // A surface to draw on is a sheet. A surface for objects is a mark on the table.
  const isPaper = (world.value?.draws ?? null) !== null;
  const size = [x[1] - x[0], y[1] - y[0], 2];
  const top = {
    at: [(x[0] + x[1]) / 2, (y[0] + y[1]) / 2, height - 2.5],
    size,
    color: "--sheet",
    opacity: isPaper ? 1 : 0.55,
  };
  show(
    "paper",
    table === null ? lines : [...lines, { points: sheet, color: "--grid-strong", closed: true }],
    table === null ? [] : [top],
  );
});

effect(() => {
  const belt = world.value?.belt ?? null;
  if (belt === null) return show("belt", []);
  const [x = 0, y = 0] = belt.start;
  const turn = (belt.direction * Math.PI) / 180;
  const along = (distance: number, offset: number) => [
    x + distance * Math.cos(turn) - offset * Math.sin(turn),
    y + distance * Math.sin(turn) + offset * Math.cos(turn),
    belt.height + 0.5,
  ];
  const marks: Lines[] = [];
  // Marks on the belt make its motion visible.
  for (let at = ((belt.travel % 60) + 60) % 60; at < belt.length; at += 60) {
    marks.push({
      points: [along(at - 10, belt.width / 3), along(at, 0), along(at - 10, -belt.width / 3)],
      color: "--belt-mark",
    });
  }
  const floor = world.value?.table?.height ?? USUAL_TABLE;
  // Box with its length along the belt: for the belt and its two legs.
  const slab = (middle: number, length: number, width: number, low: number, high: number) => {
    const at = [...along(middle, 0).slice(0, 2), low];
    return { at, size: [length, width, high - low], turn: belt.direction, color: "--belt" };
  };
  const { length, width, height } = belt;
  const legs = [40, length - 40].map((at) => slab(at, 14, width * 0.8, Math.min(floor, height - 8), height - 8));
  show("belt", marks, [slab(length / 2, length, width, height - 8, height), ...legs]);
});

effect(() => {
  const objects = world.value?.objects ?? [];
  show(
    "objects",
    [],
    objects.map(({ name, at, size, turn, color, held }) => ({ name, at, size, turn, color, held })),
  );
});
