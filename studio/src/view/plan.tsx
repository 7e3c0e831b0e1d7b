// The arm from above, for browsers without WebGL: x up, y to the left, as keys move it.
import { useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import * as store from "../store";
import { pathOf } from "./flat";
import { type Box, type Lines, layers } from "./layers";
import { reach } from "./reach";

const HALF = 360;
/** X up, Y to the left. */
const BEHIND = "matrix(0 -1 -1 0 0 0)";
const MOST = 200;

export function Plan({ place }: { place: { current: HTMLElement | null } }) {
  const svg = useRef<SVGSVGElement>(null);
  const trail = useRef<string[]>([]);
  const state = store.state.value;
  useSignalEffect(() => {
    const now = store.state.value;
    const box = svg.current?.getBoundingClientRect();
    const outer = place.current?.getBoundingClientRect();
    if (now === null || box === undefined || outer === undefined) return;
    const scale = Math.min(box.width, box.height) / (2 * HALF);
    const at = [
      box.left - outer.left + box.width / 2 - now.y * scale,
      box.top - outer.top + box.height / 2 - now.x * scale,
    ];
    place.current?.setAttribute("data-tip", at.map((value) => value.toFixed(2)).join(","));
  });
  const here = state === null ? null : `${(-state.y).toFixed(1)},${(-state.x).toFixed(1)}`;
  if (here !== null && trail.current[trail.current.length - 1] !== here)
    trail.current = [...trail.current.slice(1 - MOST), here];
  const outlines = reach.value?.outlines ?? [];
  const turned = state === null ? 0 : -state.r;
  return (
    <svg ref={svg} class="plan" viewBox={`${-HALF} ${-HALF} ${2 * HALF} ${2 * HALF}`} aria-hidden="true">
      <path class="reach" transform={BEHIND} d={outlines.map((outline) => `${pathOf(outline)}Z`).join("")} />
      <path class="axes" d={`M0 ${HALF}V${-HALF}M${-HALF} 0H${HALF}`} />
      <text x="8" y={-HALF + 22}>
        x
      </text>
      <text x={-HALF + 6} y="-8">
        y
      </text>
      <g transform={BEHIND}>
        {[...layers.value.values()].map(({ lines, boxes }) => [...boxes.map(Rect), ...lines.map(Path)])}
      </g>
      <rect class="base" x="-79" y="-79" width="158" height="158" rx="14" />
      {state !== null && here !== null ? (
        <>
          <path class="arm" d={`M0 0L${here}`} />
          <polyline class="trail" points={trail.current.join(" ")} />
          <g transform={`translate(${here}) rotate(${turned})`}>
            <circle class="tip" r="12" />
            <path class="heading" d="M0 -12V-30" />
          </g>
        </>
      ) : null}
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

function Rect({ at: [x = 0, y = 0], size: [length = 0, width = 0], turn = 0, color, opacity }: Box) {
  const place = `translate(${x} ${y}) rotate(${turn})`;
  return (
    <rect
      transform={place}
      x={-length / 2}
      y={-width / 2}
      width={length}
      height={width}
      fill={colorOf(color)}
      opacity={opacity ?? 1}
    />
  );
}
