// Keyboard: Escape always stops, Space while something moves; in the jog pad the keys of `magician
// jog`.
import { clearAlarms, home, setLaser, setTool, stop } from "./actions";
import * as jog from "./jog";
import * as store from "./store";

type Direction = [jog.Axis, 1 | -1];
const CARTESIAN: Record<string, Direction> = {
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
/** Joint that each key moves in the joint frame. */
const JOINT: Partial<Record<jog.Axis, jog.Axis>> = { x: "j2", y: "j1", z: "j3", r: "j4" };

const gripper = { off: "closed", closed: "open", open: "off" } as const;
const KEY_ACTIONS: Record<string, () => void> = {
  m: () => (jog.mode.value = jog.mode.value === "hold" ? "step" : "hold"),
  f: jog.nextFrame,
  "+": () => jog.changeStepSize(1),
  "-": () => jog.changeStepSize(-1),
  ".": () => jog.changeSpeed(1),
  ",": () => jog.changeSpeed(-1),
  p: () => canMove() && void setTool({ suction: store.state.value?.tool.suction !== true }),
  g: () => {
    const now = store.state.value?.tool.gripper as keyof typeof gripper | null;
    if (canMove()) void setTool({ gripper: gripper[now ?? "off"] });
  },
  l: () => canMove() && void setLaser(store.state.value?.tool.laser !== true),
  h: () => canMove() && void home(),
  c: () => canMove() && void clearAlarms(),
  "?": () => (store.showsKeys.value = !store.showsKeys.value),
};

const canMove = () => store.why.value === null;
const isText = (target: Element | null) =>
  target instanceof HTMLTextAreaElement ||
  (target instanceof HTMLInputElement && !["radio", "checkbox", "range", "button"].includes(target.type));
const jogPadOf = (target: Element | null) => target?.closest("[data-testid=jog-pad]") ?? null;

/** True if Space would stop something. */
function isMoving(): boolean {
  const state = store.state.value;
  return (
    jog.phase.value !== "idle" ||
    store.isBusy.value ||
    (store.isUp.value && (state?.moving === true || state?.jog != null))
  );
}

/** Pressed keys that hold a jog, by code, since the name of a key changes with Shift. */
const heldKeys = new Set<string>();

function keydown(event: KeyboardEvent): void {
  const target = event.target instanceof Element ? event.target : null;
  if (event.key === "Escape") {
    if (store.question.value !== null) store.question.value.answer(false);
    store.showsKeys.value = false;
    store.sidePanel.value = null;
    void stop();
    event.preventDefault();
    return;
  }
  if (event.key === " " && !isText(target)) {
    const free =
      target === null ||
      target === document.body ||
      target.closest("[data-testid=view]") !== null ||
      jogPadOf(target) !== null;
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
  if (jogPadOf(target) === null || event.ctrlKey || event.metaKey || event.altKey) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const move = CARTESIAN[key];
  if (move !== undefined) {
    event.preventDefault();
    const axis = (jog.frame.value === "joint" && JOINT[move[0]]) || move[0];
    if (event.repeat || (axis === "l" && store.model.value?.limits.l == null)) return;
    heldKeys.add(event.code);
    jog.press(axis, move[1], event.code);
  } else if (KEY_ACTIONS[key] !== undefined) {
    event.preventDefault();
    if (!event.repeat) KEY_ACTIONS[key]();
  } else if (event.key === "Enter" && target instanceof HTMLButtonElement && target.dataset.axis !== undefined) {
    event.preventDefault();
    if (event.repeat) return;
    heldKeys.add(event.code);
    jog.press(target.dataset.axis as jog.Axis, target.dataset.sign === "+" ? 1 : -1, event.code);
  }
}

export function listen(): void {
  document.addEventListener("keydown", keydown, { capture: true });
  document.addEventListener(
    "keyup",
    (event) => {
      // Space activates a button on release; after it has stopped the arm it must not.
      const target = event.target instanceof Element ? event.target : null;
      if (event.key === " " && jogPadOf(target) !== null) event.preventDefault();
      if (heldKeys.delete(event.code)) jog.release(event.code);
    },
    { capture: true },
  );
}
