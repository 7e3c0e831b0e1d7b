// Sample picture of a pen or material with these options.

interface Look {
  /** Colour of the ground, and its grain. */
  ground: string;
  grain?: string;
  line: string;
  width: number;
  /** True if the line cuts through the sheet. */
  cut?: boolean;
}
const LOOKS: Record<string, Look> = {
  pen: { ground: "#ffffff", line: "#1b2a6b", width: 1.1 },
  marker: { ground: "#ffffff", line: "#1f2328", width: 4.2 },
  wood: { ground: "#dcb98a", grain: "#c79f6c", line: "#4b2a12", width: 2.2 },
  leather: { ground: "#a8683c", grain: "#96592f", line: "#3c1d0c", width: 2.2 },
  card: { ground: "#c9a67a", grain: "#bd986a", line: "#5a3416", width: 2 },
  paper: { ground: "#fdfcf8", line: "#2b2f36", width: 1.6, cut: true },
  burnt: { ground: "#e9e2d2", line: "#4a2c16", width: 2.2 },
};

function lookOf(name: string, tool: "pen" | "laser"): Look {
  const known = Object.keys(LOOKS).find((one) => name.toLowerCase().includes(one));
  return LOOKS[known ?? (tool === "laser" ? "burnt" : "pen")] ?? (LOOKS.pen as Look);
}

/** Darkness of a burn: grows with power, falls with speed. */
function darkness({ power, speed }: { power?: unknown; speed?: unknown }): number {
  const most = Number(
    String(power ?? 60)
      .split("..")
      .at(-1),
  );
  return Math.max(0.35, Math.min(1, (0.5 * most) / 50 + 0.25 - Number(speed ?? 20) / 200));
}

export function Swatch({ name, tool, options }: { name: string; tool: "pen" | "laser"; options: object }) {
  const { ground, grain, line, width, cut = false } = lookOf(name, tool);
  const opacity = tool === "laser" && !cut ? darkness(options) : 1;
  return (
    <svg class="material" viewBox="0 0 64 40" aria-hidden="true">
      <rect width="64" height="40" fill={ground} />
      {grain === undefined ? null : (
        <path
          d="M0 6C16 3 30 10 64 5M0 14C20 18 40 9 64 14M0 23C18 20 36 28 64 22M0 32C22 36 44 27 64 33"
          fill="none"
          stroke={grain}
          stroke-width="1.6"
        />
      )}
      {cut ? (
        <>
          <path d="M20 8H44V32H20Z" fill="#8b919b" />
          <path d="M17 5H41V29H17Z" fill={ground} stroke={line} stroke-width="0.6" />
        </>
      ) : (
        <g fill="none" stroke={line} stroke-opacity={opacity} stroke-width={width} stroke-linecap="round">
          <path d="M9 27C11 12 17 10 19 18C21 26 16 31 14 26C13 20 24 14 28 20C31 25 25 30 25 24" />
          {tool === "laser" ? (
            <path d="M38 12H56M38 16H56M38 20H56M38 24H56M38 28H56" stroke-width="2.4" stroke-linecap="butt" />
          ) : (
            <path d="M38 29L56 11M38 21L48 11M46 29L56 19" />
          )}
        </g>
      )}
    </svg>
  );
}
