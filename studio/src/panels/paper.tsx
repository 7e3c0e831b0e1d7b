// Measuring three corners of the paper: a sketch as the user in front of the arm sees it, and the
// next corner.
import { attempt, setTool as mount } from "../actions";
import { translated } from "../i18n";
import * as surface from "../run/surface";
import { w } from "../run/surface.words";
import { call, shownArm } from "../session";
import * as store from "../store";
import { Button } from "../ui/parts";

/** Sheet of the sketch with its corners. */
const SHEET = { x: 60, y: 62, width: 140, height: 84 };
const CORNER_POSITIONS: Record<surface.Corner, readonly [number, number]> = {
  "lower-left": [SHEET.x, SHEET.y + SHEET.height],
  "lower-right": [SHEET.x + SHEET.width, SHEET.y + SHEET.height],
  "upper-left": [SHEET.x, SHEET.y],
};
/** Lift of the pen between corners, mm. */
const PEN_LIFT = 10;

const stateOf = (corner: surface.Corner): "now" | "taken" | "open" => {
  if (corner === surface.corner.value) return "now";
  return surface.knownSurface.value?.corners.includes(corner) ? "taken" : "open";
};

function Sketch() {
  return (
    <svg class="paper-sketch" viewBox="0 0 260 196" role="img" aria-label={w("paper.sketch")}>
      <circle class="sketch-arm" cx="130" cy="22" r="18" />
      <path class="sketch-arm" d="M130 40V56" />
      <text x="130" y="26">
        {w("paper.arm")}
      </text>
      <rect class="sketch-sheet" {...SHEET} rx="2" />
      <path class="sketch-axis" d="M222 62V100M216 93l6 8 6-8" />
      <text x="222" y="116">
        X+
      </text>
      <path class="sketch-axis" d="M96 104H142M135 98l8 6-8 6" />
      <text x="156" y="108">
        Y+
      </text>
      {surface.CORNERS.map((corner, nth) => {
        const [x, y] = CORNER_POSITIONS[corner];
        return (
          <g key={corner} class={`sketch-corner is-${stateOf(corner)}`}>
            <circle cx={x} cy={y} r="13" />
            <text x={x} y={y + 5}>
              {stateOf(corner) === "taken" ? "✓" : nth + 1}
            </text>
          </g>
        );
      })}
      <text class="sketch-you" x="130" y="188">
        {w("paper.you")}
      </text>
    </svg>
  );
}

/** True if the pen is so close to the paper that a move could draw. */
export const isLow = (): boolean =>
  surface.height.value !== null && (store.state.value?.z ?? Infinity) - surface.height.value < PEN_LIFT / 2;

export function LiftPen({ off, ...rest }: { off: boolean; class?: string }) {
  const lift = () => attempt(() => call("jog.step", { ...shownArm(), axis: "z", by: PEN_LIFT }));
  return (
    <Button
      id="paper-lift"
      {...rest}
      off={off || store.state.value?.moving === true}
      why="touch-why"
      text={w("paper.lift", { by: PEN_LIFT })}
      press={lift}
    />
  );
}

export function Paper({ off }: { off: boolean }) {
  const n = surface.CORNERS.indexOf(surface.corner.value) + 1;
  const tool = store.state.value?.tool.name;
  return (
    <div class="paper-wizard">
      <div class="paper-look">
        <Sketch />
        <ol class="paper-corners" aria-label={w("paper.corners")}>
          {surface.CORNERS.map((corner, nth) => {
            const state = stateOf(corner);
            return (
              <li key={corner}>
                <button
                  type="button"
                  class="quiet"
                  data-testid={`paper-corner-${nth + 1}`}
                  data-state={state}
                  aria-current={state === "now" ? "step" : undefined}
                  onClick={() => (surface.corner.value = corner)}
                >
                  {`${nth + 1}. ${w(`paper.${corner}`)}`} <small>{w(`paper.state.${state}`)}</small>
                </button>
              </li>
            );
          })}
        </ol>
      </div>
      <p role="status">
        <b data-testid="paper-step">{w("paper.step", { n, corner: w(`paper.${surface.corner.value}`) })}</b>{" "}
        <span class="hint">{w("paper.how")}</span>
      </p>
      {tool === "pen" || tool === "laser" ? null : (
        <div class="check note" role="status">
          <p>{w("paper.tool", { tool: translated(`tools.${tool}`, "–") })}</p>
          <Button
            id="paper-tool"
            off={off}
            why="touch-why"
            text={w("paper.pen")}
            press={() => mount({ tool: "pen" })}
          />
        </div>
      )}
      <div class="buttons-row">
        <Button
          id="paper-take"
          class="primary"
          off={off}
          why="touch-why"
          text={w("paper.take")}
          press={surface.takeCorner}
        />
        <LiftPen off={off} />
        <Button
          id="paper-close"
          class="quiet"
          text={w("paper.close")}
          press={() => (surface.isMeasuring.value = false)}
        />
      </div>
    </div>
  );
}
