// Jog pad: a button for each direction, to hold or to press.
import { t } from "../i18n";
import * as jog from "../jog";
import * as store from "../store";
import { Card, Choice, Field, Pick, Range } from "../ui/parts";

interface ButtonProps {
  axis: jog.Axis;
  sign: 1 | -1;
  /** Keyboard key with the same effect, if keys control this half of the pad. */
  hint?: string | undefined;
  place?: string;
}

function shownAxis(axis: jog.Axis): string {
  return axis === "l" ? t("jog.rail") : axis.toUpperCase();
}

function JogButton({ axis, sign, hint, place }: ButtonProps) {
  const off = store.why.value !== null;
  const direction = `${axis}${sign > 0 ? "+" : "-"}`;
  const by = `pointer ${direction}`;
  const lift = () => jog.release(by);
  return (
    <button
      type="button"
      class={`jog ${jog.currentDirection.value === direction ? "on" : ""}`}
      style={place === undefined ? undefined : { gridArea: place }}
      data-testid={`jog-${axis}-${sign > 0 ? "plus" : "minus"}`}
      data-axis={axis}
      data-key={hint}
      data-sign={sign > 0 ? "+" : "-"}
      aria-label={t(sign > 0 ? "jog.plus" : "jog.minus", { axis: shownAxis(axis) })}
      disabled={off}
      aria-describedby={off ? "jog-why" : undefined}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        jog.press(axis, sign, by);
      }}
      onPointerUp={lift}
      onPointerCancel={lift}
      onLostPointerCapture={lift}
      onContextMenu={(event) => event.preventDefault()}
      onClick={(event) => {
        // Activated by a screen reader, without pointer or key: a hold would never end.
        if (event.detail === 0 && jog.makesSteps.value) jog.press(axis, sign, by);
      }}
    >
      <span>
        {shownAxis(axis)}
        {sign > 0 ? "+" : "−"}
      </span>
    </button>
  );
}

const BASE = [
  ["x", 1, "↑", "xp"],
  ["y", 1, "←", "yp"],
  ["y", -1, "→", "ym"],
  ["x", -1, "↓", "xm"],
  ["r", 1, "A", "rp"],
  ["r", -1, "D", "rm"],
  ["z", 1, "W", "zp"],
  ["z", -1, "S", "zm"],
] as const;
const JOINTS = [
  ["j1", "←", "→"],
  ["j2", "↑", "↓"],
  ["j3", "W", "S"],
  ["j4", "A", "D"],
] as const;

function Status() {
  const why = store.why.value;
  const { phase, currentDirection: current, endReason: ended } = jog;
  let text = t(jog.makesSteps.value ? "jog.idle.step" : "jog.idle.hold");
  if (current.value !== null && phase.value !== "ending") {
    text = t("jog.running", { axis: current.value.toUpperCase().replace("-", "−") });
  } else if (ended.value !== null) {
    text = t(`jog.end.${ended.value}` as "jog.end.stopped");
  }
  return (
    <p id="jog-why" class={`jog-status ${why !== null ? "off" : ""}`} data-testid="jog-status" role="status">
      {why !== null ? t(why) : text}
    </p>
  );
}

export function JogPad() {
  const joints = jog.frame.value === "joint";
  const hasRail = store.model.value?.limits.l != null;
  const modes = (["hold", "step"] as const).map((value) => ({
    value,
    text: t(`jog.${value}`),
    disabled: value === "hold" && jog.frame.value === "tool",
  }));
  return (
    <Card
      title={t("jog.title")}
      class="jog-card"
      group
      more={
        <button type="button" class="quiet small" onClick={() => (store.showsKeys.value = !store.showsKeys.value)}>
          {t("jog.help")} <kbd aria-hidden="true">?</kbd>
        </button>
      }
    >
      <Status />
      {store.backend.value === "serial" ? (
        <p class="hint" data-testid="jog-note">
          {t("jog.note")}
        </p>
      ) : null}
      <div
        class={`jog-pad ${joints ? "joints" : "base"}`}
        data-testid="jog-pad"
        tabIndex={0}
        role="group"
        aria-label={t("jog.pad")}
        onFocusOut={(event) => {
          const to = event.relatedTarget;
          if (!(to instanceof Node) || !event.currentTarget.contains(to)) jog.endJog("released");
        }}
      >
        <div class="pad-base">
          {BASE.map(([axis, sign, key, place]) => (
            <JogButton key={place} axis={axis} sign={sign} hint={joints ? undefined : key} place={place} />
          ))}
        </div>
        {jog.frame.value === "base" ? <p class="hint">{t("jog.sides")}</p> : null}
        <div class="pad-joints">
          {JOINTS.map(([axis, plus, minus]) => (
            <div class="pair" key={axis}>
              <JogButton axis={axis} sign={1} hint={joints ? plus : undefined} />
              <JogButton axis={axis} sign={-1} hint={joints ? minus : undefined} />
            </div>
          ))}
          {hasRail ? (
            <div class="pair">
              <JogButton axis="l" sign={1} hint="]" />
              <JogButton axis="l" sign={-1} hint="[" />
            </div>
          ) : null}
        </div>
      </div>
      <div class="jog-options">
        <Choice
          name="jog-frame"
          label={t("jog.frame")}
          value={jog.frame.value}
          choose={(frame) => (jog.frame.value = frame)}
          options={jog.FRAMES.map((value) => ({ value, text: t(`jog.${value}`) }))}
        />
        <Choice
          name="jog-mode"
          label={t("jog.mode")}
          value={jog.makesSteps.value ? "step" : "hold"}
          choose={(mode) => (jog.mode.value = mode)}
          options={modes}
        />
        <Pick
          title={t("jog.size")}
          id="jog-step-size"
          value={jog.stepSize.value}
          options={jog.STEPS.map((n) => ({ value: n as number, text: t("jog.unit", { n }) }))}
          choose={(size) => (jog.stepSize.value = size)}
        />
        <Field
          label={
            <>
              {t("jog.speed")} <b class="number">{jog.speed.value} %</b>
            </>
          }
        >
          <Range id="jog-speed" least={1} most={100} value={jog.speed.value} set={(to) => (jog.speed.value = to)} />
        </Field>
      </div>
    </Card>
  );
}
