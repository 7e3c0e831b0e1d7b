// The height of the work surface and the place of the paper, beside the jog pad that brings the tool down to them.
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import * as check from "../run/check";
import * as surface from "../run/surface";
import { w } from "../run/surface.words";
import * as store from "../store";
import { Card, Do, Why } from "../ui/parts";
import { JogPad } from "./jogpad";
import { isLow, LiftPen, Paper } from "./paper";
import { Problem } from "./remedies";
import "./touch.css";

type Tool = "pen" | "laser";

/** What the touches come to, and what another one would tell. */
function Touches() {
  const known = surface.known.value;
  if (known?.plane == null) return null;
  const { touches, plane, residual } = known;
  if (touches < 2) return <p class="hint">{w("touch.add.text")}</p>;
  if (touches === 2) return <p class="hint">{w("touch.more")}</p>;
  const tilt = surface.tiltOf(plane).toFixed(1);
  return (
    <p class="hint" data-testid="touch-off-tilt">
      {w("touch.tilt", { n: touches, tilt, off: (residual ?? 0).toFixed(2) })}
    </p>
  );
}

/** Takes the height from where the tool is; or the corners of the paper. */
export function TouchOff({ tool = "pen" }: { tool?: Tool }) {
  const why = store.why.value;
  const off = why !== null;
  const isKnown = surface.isKnown.value;
  const isMeasuring = surface.isMeasuring.value;
  const problem = surface.problem.value;
  const isSheet = surface.sheet.value !== null;
  const may = { off, why: "touch-why" };
  return (
    <Card
      title={w(isMeasuring ? "paper.title" : "touch.title")}
      class="touch-card"
      group
      more={
        <output class="number" data-testid="touch-off-height" aria-live="polite">
          {surface.shownHeight()}
        </output>
      }
    >
      {isMeasuring ? (
        <Paper off={off} />
      ) : (
        <>
          <p class="hint" data-testid={isSheet ? "paper-size" : undefined}>
            {isSheet ? w("paper.is", { size: surface.shownSize() }) : w(`touch.text.${tool}`)}
          </p>
          <div class="buttons-row">
            {isSheet ? null : (
              <Do
                id="touch-off"
                class={isKnown ? "" : "primary"}
                {...may}
                text={w(`touch.use.${tool}`)}
                press={() => surface.touch()}
              />
            )}
            {isKnown && !isSheet ? (
              <Do id="touch-off-add" {...may} text={w("touch.add")} press={() => surface.touch(true)} />
            ) : null}
            {isSheet ? <LiftPen off={off} class={isLow() ? "primary" : ""} /> : null}
            {isSheet ? <Do id="paper-wizard" {...may} text={w("paper.again")} press={surface.measure} /> : null}
            {isKnown ? (
              <Do id="touch-off-forget" class="quiet" {...may} text={w("touch.forget")} press={surface.forget} />
            ) : null}
          </div>
          {isSheet ? null : (
            <>
              <Touches />
              <p class="hint">{w("paper.text")}</p>
              <div class="buttons-row">
                <Do id="paper-wizard" {...may} text={w("paper.measure")} press={surface.measure} />
              </div>
            </>
          )}
        </>
      )}
      <Why id="touch-why" text={why === null ? null : t(why)} />
      {problem === null ? null : <Problem of={problem} />}
    </Card>
  );
}

/** What a person needs where a program does not know how high its surface lies: the button, and the pad. */
export function Height({ tool = "pen" }: { tool?: Tool }) {
  useEffect(surface.follow, []);
  const isUnknown = check.problem.value?.remedies.some((remedy) => remedy.action === "touch-off") === true;
  if (!isUnknown && !surface.isKnown.value && !surface.isMeasuring.value) return null;
  return (
    <>
      <TouchOff tool={tool} />
      {isUnknown || surface.isMeasuring.value ? <JogPad /> : null}
    </>
  );
}
