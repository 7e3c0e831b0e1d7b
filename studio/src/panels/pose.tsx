// Eight numbers of a pose, and the panel to go to one.
import { useSignal } from "@preact/signals";
import type { ComponentType } from "preact";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import * as store from "../store";

const TIP = [
  ["x", "mm"],
  ["y", "mm"],
  ["z", "mm"],
  ["r", "°"],
] as const;
const JOINTS = [
  ["j1", "°"],
  ["j2", "°"],
  ["j3", "°"],
  ["j4", "°"],
] as const;
type Name = (typeof TIP)[number][0] | (typeof JOINTS)[number][0];

/** Two decimals, and no minus before a zero. */
const numberFormat = new Intl.NumberFormat("en", {
  minimumFractionDigits: 2,
  maximumFractionDigits: 2,
  useGrouping: false,
  signDisplay: "negative",
});

function Value({ name, unit }: { name: Name; unit: string }) {
  const state = store.state.value;
  const label = name.startsWith("j") ? name.toUpperCase() : name;
  return (
    <div class="value">
      <label for={`pose-${name}`}>{label}</label>
      <output id={`pose-${name}`} data-testid={`pose-${name}`} aria-live="off">
        {state === null || state[name] === undefined ? "" : numberFormat.format(state[name])}
      </output>
      <span class="unit">{unit}</span>
    </div>
  );
}

export function Pose() {
  return (
    <section class="card pose" role="group" aria-label={t("pose.title")}>
      <div class="values">
        {TIP.map(([name, unit]) => (
          <Value key={name} name={name} unit={unit} />
        ))}
      </div>
      <div class="values">
        {JOINTS.map(([name, unit]) => (
          <Value key={name} name={name} unit={unit} />
        ))}
      </div>
    </section>
  );
}

/** Loaded after the page's frame; its place is reserved. */
export function GoToPose() {
  const Panel = useSignal<ComponentType | null>(null);
  useEffect(() => {
    import("./goto").then(
      ({ GoTo }) => (Panel.value = GoTo),
      () => {},
    );
  }, []);
  return <section class="card goto">{Panel.value ? <Panel.value /> : null}</section>;
}
