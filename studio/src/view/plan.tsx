// View from above, for browsers without WebGL. The reader stands in front of the arm: y points
// right and x down.
import { useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useRef } from "preact/hooks";
import * as store from "../store";
import { pathOf } from "./flat";
import { type Box, type Lines, layers, onTablePressed, target } from "./layers";
import "./plan.css";
import { reach } from "./reach";
import { mutedColor } from "./tint";

/** Extent of the picture, mm: to both sides, and from behind the arm to the front. */
const HALF = 360;
const [HIGH, LOW] = [-140, 360];
/** Transform with y to the right and x down. */
const FRONT = "matrix(0 1 1 0 0 0)";
const MAX_TRAIL = 200;

/** Margin inside the picture, px. */
const MARGIN = 12;

export function Plan({ place }: { place: RefObject<HTMLElement | null> }) {
  const svg = useRef<SVGSVGElement>(null);
  const trail = useRef<string[]>([]);
  const state = store.state.value;
  /** Position of the shoulder in the page, and the scale in pixels per millimetre. */
  const measured = () => {
    const box = svg.current?.getBoundingClientRect();
    if (box === undefined) return null;
    const scale = Math.min((box.width - 2 * MARGIN) / (2 * HALF), (box.height - 2 * MARGIN) / (LOW - HIGH));
    return { x: box.left + box.width / 2, y: box.top + box.height / 2 - ((LOW + HIGH) / 2) * scale, scale };
  };
  useSignalEffect(() => {
    const now = store.state.value;
    const [at, outer] = [measured(), place.current?.getBoundingClientRect()];
    if (now === null || at === null || outer === undefined) return;
    const tip = [at.x - outer.left + now.y * at.scale, at.y - outer.top + now.x * at.scale];
    place.current?.setAttribute("data-tip", tip.map((value) => value.toFixed(2)).join(","));
  });
  const here = state === null ? null : `${state.y.toFixed(1)},${state.x.toFixed(1)}`;
  if (here !== null && trail.current[trail.current.length - 1] !== here)
    trail.current = [...trail.current.slice(1 - MAX_TRAIL), here];
  const outlines = reach.value?.outlines ?? [];
  const turned = state === null ? 0 : -state.r;
  const goal = target.value;
  const press = (event: { clientX: number; clientY: number }) => {
    const at = measured();
    if (at !== null) onTablePressed.value?.((event.clientY - at.y) / at.scale, (event.clientX - at.x) / at.scale);
  };
  return (
    <svg
      ref={svg}
      class={`plan ${onTablePressed.value === null ? "" : "aims"}`}
      viewBox={`${-HALF} ${HIGH} ${2 * HALF} ${LOW - HIGH}`}
      aria-hidden="true"
      onClick={press}
    >
      <path class="reach" transform={FRONT} d={outlines.map((outline) => `${pathOf(outline)}Z`).join("")} />
      <path class="axes" d={`M0 ${LOW}V${HIGH}M${-HALF} 0H${HALF}`} />
      <text x="8" y={LOW - 8}>
        x
      </text>
      <text x={HALF - 18} y="-8">
        y
      </text>
      <g transform={FRONT}>
        {[...layers.value.values()].map(({ lines, boxes }) => [...boxes.map(Rect), ...lines.map(Path)])}
      </g>
      <rect class="base" x="-79" y="-79" width="158" height="158" rx="14" />
      {state !== null && here !== null ? (
        <>
          <path class="arm" d={`M0 0L${here}`} />
          <polyline class="trail" points={trail.current.join(" ")} />
          <g transform={`translate(${here}) rotate(${turned})`}>
            <circle class="tip" r="12" />
            <path class="heading" d="M0 12V30" />
          </g>
        </>
      ) : null}
      {goal === null ? null : (
        <g class="goal" transform={`translate(${goal.y} ${goal.x}) rotate(${-goal.r})`}>
          <circle r="16" />
          <path d="M0 16V30" />
        </g>
      )}
    </svg>
  );
}

const colorOf = (color: string) => (color.startsWith("--") ? `var(${color})` : color);

function Path({ points, color, closed, dots, opacity }: Lines) {
  const d = dots ? points.map((point) => pathOf([point])).join("") : `${pathOf(points)}${closed ? "Z" : ""}`;
  return points.length === 0 ? null : (
    <path
      d={d}
      fill="none"
      stroke={colorOf(color)}
      stroke-width={dots ? 9 : 3}
      stroke-linecap="round"
      opacity={opacity ?? 1}
    />
  );
}

function Rect({ at: [x = 0, y = 0], size: [length = 0, width = 0], turn = 0, color, opacity, name }: Box) {
  const place = `translate(${x} ${y}) rotate(${turn})`;
  return (
    <rect
      transform={place}
      x={-length / 2}
      y={-width / 2}
      width={length}
      height={width}
      fill={colorOf(name === undefined ? color : mutedColor(color))}
      opacity={opacity ?? 1}
    />
  );
}
