// The height of the work surface, beside the jog pad that brings the tool down to it.
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import * as check from "../run/check";
import * as surface from "../run/surface";
import * as store from "../store";
import { Card, Do, Why } from "../ui/parts";
import { JogPad } from "./jogpad";
import { Problem } from "./remedies";

/** Takes the height from where the tool is. */
export function TouchOff({ tool = "pen" }: { tool?: "pen" | "laser" }) {
  const why = store.why.value;
  const off = why !== null;
  return (
    <Card
      title={t("touch.title")}
      class="touch-card"
      group
      more={
        <output class="number" data-testid="touch-off-height" aria-live="polite">
          {surface.shownHeight()}
        </output>
      }
    >
      <p class="hint">{t(`touch.text.${tool}`)}</p>
      <div class="buttons-row">
        <Do
          id="touch-off"
          class={surface.height.value === null ? "primary" : ""}
          off={off}
          why="touch-why"
          text={t(`touch.use.${tool}`)}
          press={surface.touch}
        />
        {surface.height.value === null ? null : (
          <Do
            id="touch-off-forget"
            class="quiet"
            off={off}
            why="touch-why"
            text={t("touch.forget")}
            press={surface.forget}
          />
        )}
      </div>
      <Why id="touch-why" text={why === null ? null : t(why)} />
      {surface.problem.value === null ? null : <Problem of={surface.problem.value} />}
    </Card>
  );
}

/** What a person needs where a program does not know how high its surface lies: the button, and the pad. */
export function Height({ tool = "pen" }: { tool?: "pen" | "laser" }) {
  useEffect(surface.follow, []);
  const isUnknown = check.problem.value?.remedies.some((remedy) => remedy.action === "touch-off") === true;
  if (!isUnknown && surface.height.value === null) return null;
  return (
    <>
      <TouchOff tool={tool} />
      {isUnknown ? <JogPad /> : null}
    </>
  );
}
