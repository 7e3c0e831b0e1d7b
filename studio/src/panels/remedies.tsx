// What is wrong, and what to do about it: a button for each thing that this page can do.
import * as actions from "../actions";
import { t } from "../i18n";
import * as check from "../run/check";
import { labelOf } from "../run/words";
import * as store from "../store";
import { Do } from "../ui/parts";

/** What a remedy does, and what its button is called. Those without one are done elsewhere. */
const DONE: Record<string, { text: () => string; press: () => Promise<unknown> }> = {
  home: { text: () => t("alarms.home"), press: actions.home },
  "clear-alarms": { text: () => t("alarms.these"), press: actions.clearAlarms },
  "laser-off": { text: () => t("remedy.laser-off"), press: () => actions.laser(false) },
  "suction-off": { text: () => t("remedy.suction-off"), press: () => actions.tool({ suction: false }) },
  "gripper-off": { text: () => t("remedy.gripper-off"), press: () => actions.tool({ gripper: "off" }) },
  stop: { text: () => t("remedy.stop"), press: () => actions.stop(false) },
};

/** What is done by itself, or by an option that this page asks. */
function Remedy({ of }: { of: actions.Remedy }) {
  const known = DONE[of.action ?? ""];
  if (known !== undefined) {
    const press = async () => {
      await known.press();
      if (check.problem.value !== null) await check.check();
    };
    return <Do id={`remedy-${of.action}`} off={store.why.value !== null} text={known.text()} press={press} />;
  }
  const name = of.option ?? of.without;
  const option = check.asked.value.find((option) => option.name === name);
  if (name === undefined || option === undefined) return null;
  const label = labelOf(option);
  if (of.without !== undefined)
    return (
      <Do id={`remedy-${name}`} text={t("remedy.without", { name: label })} press={() => check.setValue(name, "")} />
    );
  if (of.value === undefined) return <span class="hint">{t("remedy.fill", { name: label })}</span>;
  const value = Array.isArray(of.value) ? of.value.join(" ") : String(of.value);
  const text = of.value === true ? label : t("remedy.set", { name: label, value });
  return <Do id={`remedy-${name}`} text={text} press={() => check.setValue(name, value)} />;
}

export function Remedies({ of }: { of: readonly actions.Remedy[] }) {
  if (of.length === 0) return null;
  return (
    <div class="buttons-row remedies" role="group" aria-label={t("alarms.cure")}>
      {of.map((remedy, nth) => (
        <Remedy key={nth} of={remedy} />
      ))}
    </div>
  );
}

export function Problem({ of: { text, remedies } }: { of: actions.Problem }) {
  return (
    <>
      <p class="check bad" role="alert">
        {text}
      </p>
      <Remedies of={remedies} />
    </>
  );
}
