// The keyboard: Escape stops always, Space where something moves; in the jog pad the keys of `magician jog`.
import { clearAlarms, home, laser, stop, tool } from "./actions";
import * as jog from "./jog";
import * as store from "./store";

type Move = [jog.Axis, 1 | -1];
const CARTESIAN: Record<string, Move> = {
  ArrowUp: ["x", 1],
  ArrowDown: ["x", -1],
  ArrowLeft: ["y", 1],
  ArrowRight: ["y", -1],
  w: ["z", 1],
  PageUp: ["z", 1],
  s: ["z", -1],
  PageDown: ["z", -1],
  a: ["r", 1],
  d: ["r", -1],
  "]": ["l", 1],
  "[": ["l", -1],
};
/** What the same keys move where joints are jogged. */
const JOINT: Partial<Record<jog.Axis, jog.Axis>> = { x: "j2", y: "j1", z: "j3", r: "j4" };

const gripper = { off: "closed", closed: "open", open: "off" } as const;
const OTHERS: Record<string, () => void> = {
  m: () => (jog.mode.value = jog.mode.value === "hold" ? "step" : "hold"),
  f: jog.nextFrame,
  "+": () => jog.longer(1),
  "-": () => jog.longer(-1),
  ".": () => jog.faster(1),
  ",": () => jog.faster(-1),
  p: () => moves() && void tool({ suction: store.state.value?.tool.suction !== true }),
  g: () => {
    const now = store.state.value?.tool.gripper as keyof typeof gripper | null;
    if (moves()) void tool({ gripper: gripper[now ?? "off"] });
  },
  l: () => moves() && void laser(store.state.value?.tool.laser !== true),
  h: () => moves() && void home(),
  c: () => moves() && void clearAlarms(),
  "?": () => (store.showsKeys.value = !store.showsKeys.value),
};

const moves = () => store.why.value === null;
const isText = (target: Element | null) =>
  target instanceof HTMLTextAreaElement ||
  (target instanceof HTMLInputElement && !["radio", "checkbox", "range", "button"].includes(target.type));
const inPad = (target: Element | null) => target?.closest("[data-testid=jog-pad]") ?? null;

/** Whether something is under way that Space stops. */
function isMoving(): boolean {
  const state = store.state.value;
  return (
    jog.phase.value !== "idle" ||
    store.isBusy.value ||
    (store.isUp.value && (state?.moving === true || state?.jog != null))
  );
}

/** The keys that are down and hold a jog, by their code: the key's name changes with Shift. */
const down = new Set<string>();

function keydown(event: KeyboardEvent): void {
  const target = event.target instanceof Element ? event.target : null;
  if (event.key === "Escape") {
    if (store.question.value !== null) store.question.value.answer(false);
    store.showsKeys.value = false;
    store.beside.value = null;
    void stop();
    event.preventDefault();
    return;
  }
  if (event.key === " " && !isText(target)) {
    const free =
      target === null ||
      target === document.body ||
      target.closest("[data-testid=view]") !== null ||
      inPad(target) !== null;
    if (free || isMoving()) {
      event.preventDefault();
      if (!event.repeat) void stop();
      return;
    }
  }
  if (event.key === "Enter" && target instanceof HTMLInputElement && ["radio", "checkbox"].includes(target.type)) {
    target.click();
    event.preventDefault();
    return;
  }
  if (inPad(target) === null || event.ctrlKey || event.metaKey || event.altKey) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const move = CARTESIAN[key];
  if (move !== undefined) {
    event.preventDefault();
    const axis = (jog.frame.value === "joint" && JOINT[move[0]]) || move[0];
    if (event.repeat || (axis === "l" && store.model.value?.limits.l == null)) return;
    down.add(event.code);
    jog.press(axis, move[1], event.code);
  } else if (OTHERS[key] !== undefined) {
    event.preventDefault();
    if (!event.repeat) OTHERS[key]();
  } else if (event.key === "Enter" && target instanceof HTMLButtonElement && target.dataset.axis !== undefined) {
    event.preventDefault();
    if (event.repeat) return;
    down.add(event.code);
    jog.press(target.dataset.axis as jog.Axis, target.dataset.sign === "+" ? 1 : -1, event.code);
  }
}

export function listen(): void {
  document.addEventListener("keydown", keydown, { capture: true });
  document.addEventListener(
    "keyup",
    (event) => {
      // Space operates a button as it goes up: one that has stopped the arm operates nothing.
      const target = event.target instanceof Element ? event.target : null;
      if (event.key === " " && inPad(target) !== null) event.preventDefault();
      if (down.delete(event.code)) jog.lift(event.code);
    },
    { capture: true },
  );
}
