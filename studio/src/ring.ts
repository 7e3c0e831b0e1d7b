// Readings of the last two minutes in a ring buffer, filled on every route and drawn only by the
// plots.
import { batch, effect, signal } from "@preact/signals";
import { levels } from "./pins";
import { notificationListeners } from "./session";
import * as store from "./store";

/** Capacity: two minutes at 20 readings a second. */
const CAPACITY = 2400;
export const POSE = ["x", "y", "z", "r", "j1", "j2", "j3", "j4"] as const;
const PIN_COUNT = 20;
/** Columns of a row: t, the pose, speed of the tip, index, left space, rail, pins by address. */
const COLUMNS = 1 + POSE.length + 3 + PIN_COUNT;
export const COLUMN = {
  t: 0,
  x: 1,
  y: 2,
  z: 3,
  r: 4,
  j1: 5,
  j2: 6,
  j3: 7,
  j4: 8,
  speed: 9,
  index: 10,
  left: 11,
  pin: 11,
} as const;
/** Gap between readings above which they are not joined, s. */
const MAX_GAP = 1.5;

/** Rows in order, with their alarms. */
export interface Readings {
  count: number;
  value(row: number, column: number): number;
  alarms(row: number): readonly number[];
}

let table = new Float64Array(CAPACITY * COLUMNS);
let codes: Array<readonly number[]> = new Array(CAPACITY);
let written = 0;
/** Counter of readings; whatever shows them updates when it changes. */
export const readingCounter = signal(0);

const ring: Readings = {
  get count() {
    return Math.min(written, CAPACITY);
  },
  value(row, column) {
    return table[((written - this.count + row) % CAPACITY) * COLUMNS + column] ?? Number.NaN;
  },
  alarms(row) {
    return codes[(written - this.count + row) % CAPACITY] ?? [];
  },
};
export const readings = (): Readings => ring;

/** Copy of the current readings, for a view that stays still while more arrive. */
export function snapshot(): Readings {
  const [kept, alarms, count, first] = [table.slice(), codes.slice(), ring.count, written - ring.count];
  return {
    count,
    value: (row, column) => kept[((first + row) % CAPACITY) * COLUMNS + column] ?? Number.NaN,
    alarms: (row) => alarms[(first + row) % CAPACITY] ?? [],
  };
}

function clear(): void {
  table = new Float64Array(CAPACITY * COLUMNS);
  codes = new Array(CAPACITY);
  written = 0;
  readingCounter.value++;
}

function write(t: number): void {
  const state = store.state.value;
  if (state === null || state.x === undefined) return;
  const last = written - 1;
  const before = (column: number) => table[(last % CAPACITY) * COLUMNS + column] ?? 0;
  const since = written === 0 ? Infinity : t - before(COLUMN.t);
  // A full state repeats an earlier reading.
  if (since <= 0) return;
  const row = (written % CAPACITY) * COLUMNS;
  const moved = Math.hypot(state.x - before(COLUMN.x), state.y - before(COLUMN.y), state.z - before(COLUMN.z));
  const values = [
    t,
    ...POSE.map((name) => state[name]),
    since > MAX_GAP ? Number.NaN : moved / since,
    state.current_index,
    state.left_space,
  ];
  table.set(values, row);
  for (let pin = 1; pin <= PIN_COUNT; pin++) table[row + COLUMN.pin + pin] = levels.peek().get(pin) ?? Number.NaN;
  codes[written % CAPACITY] = state.alarms ?? [];
  written++;
  readingCounter.value++;
}

let recordedArm: string | null = null;
effect(() => {
  const arm = store.armName.value;
  if (arm !== recordedArm) batch(clear);
  recordedArm = arm;
});
notificationListeners.add((method, params) => {
  if (method !== "arm.state" || params.subscription !== store.subscription.peek()) return;
  write(params.state.t);
});
