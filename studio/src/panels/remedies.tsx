// Problem with its remedies: a button for each that this page can carry out.
import * as actions from "../actions";
import { t } from "../i18n";
import * as check from "../run/check";
import * as surface from "../run/surface";
import { w } from "../run/surface.words";
import { labelOf } from "../run/words";
import * as store from "../store";
import { Button } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./remedies.json";

const r = sentencesOf(texts);

interface RemedyAction {
  id?: string;
  text: () => string;
  press: () => unknown;
  /** True if it needs no control of the arm. */
  free?: boolean;
}
const goToRoute = (route: store.Route) => () => void (location.hash = `#/${route}`);

/** Opens the measurement of the paper on this page if it is there, otherwise at its usual place. */
async function measure(): Promise<void> {
  surface.measure();
  await new Promise(requestAnimationFrame);
  const card = document.querySelector(".touch-card");
  if (card === null) goToRoute("move")();
  else card.scrollIntoView({ block: "center" });
}

/**
 * Actions of the core that this page can carry out, with their buttons. Actions for other programs
 * have none: `list-commands` is the command line's.
 */
const REMEDY_ACTIONS: Record<string, RemedyAction> = {
  home: { text: () => t("alarms.home"), press: actions.home },
  "clear-alarms": { text: () => t("alarms.these"), press: actions.clearAlarms },
  "laser-off": { text: () => t("remedy.laser-off"), press: () => actions.setLaser(false) },
  "suction-off": { text: () => t("remedy.suction-off"), press: () => actions.setTool({ suction: false }) },
  "gripper-off": { text: () => t("remedy.gripper-off"), press: () => actions.setTool({ gripper: "off" }) },
  stop: { text: () => t("remedy.stop"), press: () => actions.stop(false), free: true },
  "stop-jog": { text: () => t("remedy.stop"), press: () => actions.stop(false), free: true },
  "start-queue": { text: () => t("remedy.stop"), press: () => actions.stop(false), free: true },
  jog: { text: () => r("remedy.jog"), press: goToRoute("move"), free: true },
  "list-alarms": { text: () => r("remedy.alarms"), press: () => scrollTo(0, 0), free: true },
  "list-ports": { text: () => r("remedy.arms"), press: goToRoute("arms"), free: true },
  engrave: { text: () => r("remedy.engrave"), press: goToRoute("engrave"), free: true },
  "touch-off": {
    id: "height-here",
    text: () => w(`touch.use.${usesLaser() ? "laser" : "pen"}`),
    press: () => surface.touch(),
  },
  "calibrate-surface": { text: () => w("paper.measure"), press: measure },
};
const usesLaser = () => check.valueOf("tool") === "laser";
/** Options that are set by hand on the sheet of a workshop. */
const SHEET_OPTIONS = ["at", "fit", "scale", "rotate", "width", "place", "turn"];

/** Button for an action, or for an option that this page asks for. */
function Remedy({ of }: { of: actions.Remedy }) {
  const known = REMEDY_ACTIONS[of.action ?? ""];
  if (known !== undefined) {
    const press = async () => {
      await known.press();
      if (check.problem.value !== null) await check.check();
    };
    const off = known.free !== true && store.why.value !== null;
    const id = known.id ?? `remedy-${of.action}`;
    return <Button id={id} off={off} text={known.text()} press={press} />;
  }
  if (of.system !== undefined) return <span class="hint">{r("remedy.system", { line: of.system })}</span>;
  if (of.action === "use-rail") return <span class="hint">{r("remedy.rail", { line: "magician rail on" })}</span>;
  const name = of.option ?? of.without;
  const option = check.shownOptions.value.find((option) => option.name === name);
  if (name !== undefined && !check.openWorkshop.value.isSettable(name) && SHEET_OPTIONS.includes(name))
    return <span class="hint">{r("remedy.sheet")}</span>;
  if (name === "unhomed") return <span class="hint">{r("remedy.unhomed")}</span>;
  if (name === undefined || option === undefined) return null;
  const label = labelOf(option);
  if (of.without !== undefined)
    return (
      <Button
        id={`remedy-${name}`}
        text={t("remedy.without", { name: label })}
        press={() => check.setValue(name, "")}
      />
    );
  if (of.value === undefined) return <span class="hint">{t("remedy.fill", { name: label })}</span>;
  const value = Array.isArray(of.value) ? of.value.join(" ") : String(of.value);
  const text = of.value === true ? label : t("remedy.set", { name: label, value });
  return <Button id={`remedy-${name}`} text={text} press={() => check.setValue(name, value)} />;
}

/**
 * Key that is equal for remedies with the same effect, which are offered once: everything that is
 * set on the sheet, and stopping a job.
 */
const effectKey = ({ action, option, without, value }: actions.Remedy): string => {
  const name = option ?? without ?? "";
  if (name !== "" && !check.openWorkshop.value.isSettable(name) && SHEET_OPTIONS.includes(name)) return "sheet";
  return action === undefined ? `${name} ${JSON.stringify(value)}` : (REMEDY_ACTIONS[action]?.text() ?? action);
};
const isFirst = (one: actions.Remedy, nth: number, all: readonly actions.Remedy[]): boolean =>
  all.findIndex((other) => effectKey(other) === effectKey(one)) === nth;

/**
 * Order of remedies: one press first, then remedies that take a while, then remedies that need
 * typing.
 */
const rank = ({ action, value, without }: actions.Remedy): number =>
  action === undefined
    ? value === undefined && without === undefined
      ? 2
      : 0
    : Number(action === "calibrate-surface");
const inRankOrder = (of: readonly actions.Remedy[]) => of.toSorted((one, other) => rank(one) - rank(other));

export function Remedies({ of }: { of: readonly actions.Remedy[] }) {
  if (of.length === 0) return null;
  return (
    <div class="buttons-row remedies" role="group" aria-label={t("alarms.cure")}>
      {inRankOrder(of)
        .filter(isFirst)
        .map((remedy) => (
          <Remedy key={effectKey(remedy)} of={remedy} />
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
