// Going to a pose that is typed, pasted, or pressed on the table. Nothing moves before Go.
import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { problemOf, reportError } from "../actions";
import { parseNumber } from "../numbers";
import { call, shownArm } from "../session";
import * as store from "../store";
import { Button, TextField } from "../ui/parts";
import { onTablePressed, target } from "../view/layers";
import { sentencesOf } from "../words";
import { AXES, formatPose, parsePose } from "./goto.pose";
import "./goto.css";
import texts from "./goto.json";

const w = sentencesOf(texts);
/** Delay after the last key before the fields are checked, ms. */
const CHECK_DELAY = 200;
const UNITS = { x: "mm", y: "mm", z: "mm", r: "°" } as const;

/** Copies text to the clipboard. Over plain HTTP browsers only support the old way. */
async function copy(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = Object.assign(document.createElement("textarea"), { value: text });
    area.className = "unseen";
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

async function copyPose(): Promise<void> {
  const state = store.state.value;
  if (state === null) return;
  const pose = formatPose(state);
  const done = await copy(pose);
  store.notify(done ? w("copied", { pose }) : w("uncopied"), !done);
}

/** The pose that is typed, or null. */
function parseGoal(typed: readonly string[]) {
  const [x, y, z, r] = typed.map(parseNumber);
  return x != null && y != null && z != null && r != null ? { x, y, z, r } : null;
}

function Fields() {
  const present = () => AXES.map((axis) => String(Number((store.state.peek()?.[axis] ?? 0).toFixed(2))));
  const typed = useSignal(present());
  const why = useSignal<string | null>(null);
  const isGoing = useSignal(false);
  const put = (values: readonly number[]) => {
    typed.value = typed.value.map((old, nth) => (values[nth] === undefined ? old : String(values[nth])));
  };
  useSignalEffect(() => {
    const goal = parseGoal(typed.value);
    target.value = goal;
    if (goal === null) {
      why.value = w("number");
      return;
    }
    const { x, y, z, r } = goal;
    // The earlier result stays visible until the station has answered.
    let isOld = false;
    const look = async () => {
      const tool = store.model.peek()?.tool.bias;
      const refusal = await call("motion.inverse", { pose: [x, y, z, r], ...(tool ? { tool } : {}) }).then(
        () => null,
        (error: unknown) => problemOf(error).text,
      );
      if (!isOld) why.value = refusal;
    };
    const timer = setTimeout(() => void look(), CHECK_DELAY);
    return () => {
      isOld = true;
      clearTimeout(timer);
    };
  });
  useEffect(() => {
    onTablePressed.value = (x, y) => put([Math.round(x), Math.round(y)]);
    return () => {
      onTablePressed.value = null;
      target.value = null;
    };
  }, []);
  const go = async () => {
    // Reads the fields themselves: the drawn target follows a moment later.
    const goal = parseGoal(typed.peek());
    if (goal === null || isGoing.peek()) return;
    isGoing.value = true;
    const rail = store.state.value?.rail ?? null;
    try {
      await call("arm.move", { ...shownArm(), to: [goal.x, goal.y, goal.z, goal.r, ...(rail === null ? [] : [rail])] });
    } catch (error) {
      why.value = problemOf(error).text;
      reportError(error);
    }
    isGoing.value = false;
  };
  const paste = (event: ClipboardEvent) => {
    const pose = parsePose(event.clipboardData?.getData("text") ?? "");
    if (pose === null) return;
    event.preventDefault();
    put(pose);
  };
  const off = store.why.value !== null;
  const isOff = off || why.value !== null || isGoing.value;
  return (
    <>
      <div class="goto-fields" onPaste={paste}>
        {AXES.map((axis, nth) => (
          <TextField
            key={axis}
            id={`goto-${axis}`}
            label={axis}
            unit={UNITS[axis]}
            inputMode="decimal"
            bad={parseNumber(typed.value[nth] ?? "") === null}
            value={typed.value[nth] ?? ""}
            live
            set={(text) => (typed.value = typed.value.with(nth, text))}
          />
        ))}
      </div>
      <div class="goto-do">
        <Button
          id="goto-start"
          class="primary"
          off={isOff}
          why={off ? "jog-why" : "goto-said"}
          text={w(isGoing.value ? "going" : "go")}
          press={go}
        />
        <Button id="goto-here" text={w("here")} press={() => (typed.value = present())} />
        <p id="goto-said" class={`goto-said ${why.value === null ? "" : "bad"}`} role="status" data-testid="goto-said">
          {why.value ?? w("ready")}
        </p>
      </div>
      <p class="hint">{w("press")}</p>
    </>
  );
}

export function GoTo() {
  const isOpen = useSignal(false);
  return (
    <>
      <div class="goto-bar">
        <Button
          id="goto"
          aria-expanded={isOpen.value}
          text={isOpen.value ? w("close") : w("open")}
          press={() => (isOpen.value = !isOpen.value)}
        />
        <Button id="pose-copy" off={store.state.value === null} text={w("copy")} press={copyPose} />
      </div>
      {isOpen.value ? <Fields /> : null}
    </>
  );
}
