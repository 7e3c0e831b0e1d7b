// Examples of the gallery: each with its scenario and the panel that it opens in.

import playback from "../../../crates/magician-program/samples/jump_suction_named_v170.playback?raw";
import landscape from "../../../crates/magician-program/samples/landscape.png";
import rabbit from "../../../crates/magician-program/samples/rabbit.svg?raw";
import star from "../../../crates/magician-program/samples/star.plt?raw";
import type { Route } from "../store";
import belt from "./belt.plan.json?raw";
import faults from "./faults.plan.json?raw";
import pick from "./pick.plan.json?raw";
import stack from "./stack.plan.json?raw";
import teach from "./teach.plan.json?raw";

export interface Example {
  name: "draw" | "write" | "stamp" | "engrave" | "pick" | "stack" | "belt" | "teach" | "playback" | "faults";
  panel: Route;
  /** Scenario of the virtual arm. */
  world: "drawing" | "engraving" | "cubes" | "pick_and_sort" | "faults";
  /** Input for the panel: a file with its content or URL, or a text to write. */
  file?: { name: string; text?: string; url?: string };
  text?: string;
  /** Options that differ from the panel's initial ones. */
  setup?: Record<string, string>;
}

export const EXAMPLES: readonly Example[] = [
  { name: "draw", panel: "draw", world: "drawing", file: { name: "rabbit.svg", text: rabbit } },
  { name: "write", panel: "draw", world: "drawing", text: "Hello" },
  {
    name: "stamp",
    panel: "draw",
    world: "drawing",
    file: { name: "star.plt", text: star },
    setup: { grid: "2x3:40x40" },
  },
  { name: "engrave", panel: "engrave", world: "engraving", file: { name: "landscape.png", url: landscape } },
  { name: "pick", panel: "teach", world: "cubes", file: { name: "pick.plan.json", text: pick } },
  { name: "stack", panel: "teach", world: "cubes", file: { name: "stack.plan.json", text: stack } },
  { name: "belt", panel: "run", world: "pick_and_sort", file: { name: "belt.plan.json", text: belt } },
  { name: "teach", panel: "teach", world: "cubes", file: { name: "points.plan.json", text: teach } },
  { name: "playback", panel: "run", world: "cubes", file: { name: "boxes.playback", text: playback } },
  { name: "faults", panel: "run", world: "faults", file: { name: "faults.plan.json", text: faults } },
];
