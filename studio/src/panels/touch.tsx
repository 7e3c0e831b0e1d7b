// Measuring the work surface and the paper, beside the jog pad that moves the tool there.
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import * as check from "../run/check";
import * as surface from "../run/surface";
import { w } from "../run/surface.words";
import * as store from "../store";
import { Button, Card, Reason } from "../ui/parts";
import { JogPad } from "./jogpad";
import { isLow, LiftPen, Paper } from "./paper";
import { Problem } from "./remedies";
import "./touch.css";

type Tool = "pen" | "laser";

/** Result of the touches so far, and what another one would add. */
function Touches() {
  const known = surface.knownSurface.value;
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

/** Takes the height at the tool's position, or the corners of the paper. */
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
          {surface.heightText()}
        </output>
      }
    >
      {isMeasuring ? (
        <Paper off={off} />
      ) : (
        <>
          <p class="hint" data-testid={isSheet ? "paper-size" : undefined}>
            {isSheet ? w("paper.is", { size: surface.sizeText() }) : w(`touch.text.${tool}`)}
          </p>
          <div class="buttons-row">
            {isSheet ? null : (
              <Button
                id="touch-off"
                class={isKnown ? "" : "primary"}
                {...may}
                text={w(`touch.use.${tool}`)}
                press={() => surface.touch()}
              />
            )}
            {isKnown && !isSheet ? (
              <Button id="touch-off-add" {...may} text={w("touch.add")} press={() => surface.touch(true)} />
            ) : null}
            {isSheet ? <LiftPen off={off} class={isLow() ? "primary" : ""} /> : null}
            {isSheet ? <Button id="paper-wizard" {...may} text={w("paper.again")} press={surface.measure} /> : null}
            {isKnown ? (
              <Button id="touch-off-forget" class="quiet" {...may} text={w("touch.forget")} press={surface.forget} />
            ) : null}
          </div>
          {isSheet ? null : (
            <>
              <Touches />
              <p class="hint">{w("paper.text")}</p>
              <div class="buttons-row">
                <Button id="paper-wizard" {...may} text={w("paper.measure")} press={surface.measure} />
              </div>
            </>
          )}
        </>
      )}
      <Reason id="touch-why" text={why === null ? null : t(why)} />
      {problem === null ? null : <Problem of={problem} />}
    </Card>
  );
}

/** Button and jog pad for a program whose surface height is unknown. */
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
