// Appearance of the arm: solids for each link of the model, and for the rods beside them. Distances
// between axes come from the model. The thickness of the parts is not measured.
import type { Model } from "../store";
import { box, type Circle, corners, lathe, moved, type Point, plate, tube } from "./solid";

/** Link of the model: its parent, position, and the joint that turns it. */
export type Link = Pick<Model["links"][number], "name" | "parent" | "joint" | "axis" | "at">;

/** Solid of one colour on a link. */
export interface Part {
  link: string;
  color: string;
  solid: number[];
}

export type ToolName = "none" | "suction" | "gripper" | "pen" | "laser";

const SHELL = "#eceef1";
const INLAY = "#cfd5dc";
const DARK = "#2d323a";
const METAL = "#8d96a3";
/** Anodised metal of the laser, light enough to be visible on a dark sheet. */
const ANODISED = "#3c434e";
const RUBBER = "#23262c";
const HOSE = "#a9c4dd";
export const ACCENT = "#2f8fff";

/**
 * Pins of the elbow plate, from its axis, in the vertical plane of the arm, mm: of the rear arm's
 * rod, and of the forearm's.
 */
const BEHIND = [-26, 9] as const;
const ABOVE = [9, 33] as const;
/** Length of the crank that drives the forearm from its rear end, mm. */
const CRANK = 30;

/** Dimensions of the arm from its links, mm. */
export interface Measures {
  rear: number;
  fore: number;
  /** Half the width of the base, its height, and the distance from its top to the shoulder. */
  half: number;
  base: number;
  turret: number;
  /** Offset of the tool's axis from the wrist's. */
  tool: Point;
}

export function measuresOf(model: Model): Measures {
  const link = (name: string) => model.links.find((one) => one.name === name);
  const at = (name: string) => link(name)?.at ?? [];
  const [width = 0, , base = 0] = link("base")?.size ?? [];
  const [bx = 0, by = 0, bz = 0] = at("tool");
  const [rear, fore] = [at("elbow")[2] ?? 0, at("wrist")[0] ?? 0];
  return { rear, fore, half: width / 2, base, turret: at("turret")[2] ?? 0, tool: [bx, by, bz] };
}

const Y = [0, 1, 0];
/**
 * Rods of the parallelograms, as links that the model does not name. They turn with the joints of
 * the model, so that both ends of each rod coincide with their pins in every pose.
 */
export const RODS: readonly Link[] = [
  // Keeps the elbow plate level in all positions of the rear arm.
  { name: "level_rod", parent: "turret", joint: "j2", axis: Y, at: [BEHIND[0], 0, BEHIND[1]] },
  // Keeps the head level in all positions of the forearm.
  { name: "head_rod", parent: "elbow", joint: "j3", axis: Y, at: [ABOVE[0], 0, ABOVE[1]] },
  // The third motor's crank is parallel to the forearm, and its rod to the rear arm.
  { name: "crank", parent: "turret", joint: "j3", axis: Y, at: [0, 0, 0] },
  { name: "crank_pin", parent: "crank", joint: "-j3", axis: Y, at: [-CRANK, 0, 0] },
  { name: "drive_rod", parent: "crank_pin", joint: "j2", axis: Y, at: [0, 0, 0] },
];

const disc = (radius: number, from: number, to: number, bevel = 1.2): number[] =>
  lathe([
    [radius - bevel, from],
    [radius, from + bevel],
    [radius, to - bevel],
    [radius - bevel, to],
  ]);
/** Pin across the arm, at a point of its plane. */
const pin = ([x, z]: readonly [number, number], radius: number, half: number): number[] =>
  plate("xz", [[x, z, radius]], -half, half, 0.8);
const bothSides = (circles: readonly Circle[], from: number, to: number, bevel = 1): number[] => [
  ...plate("xz", circles, from, to, bevel),
  ...plate("xz", circles, -to, -from, bevel),
];

/** Arm without its tool. `hang` is the distance of the tip below the wrist's axis. */
export function bodyOf({ rear, fore, half, base, turret, tool }: Measures, hang: number, hasHose: boolean): Part[] {
  const [bx, by] = tool;
  const parts: Part[] = [];
  const on = (link: string, color: string, ...solids: number[][]) => {
    for (const solid of solids) parts.push({ link, color, solid });
  };
  // The base's origin is at its top, where the turret begins.
  const [low, edge] = [-base, half - 5];
  on("base", DARK, plate("xy", corners(-edge, edge, -edge, edge, 20), low, low + 8, 1));
  on("base", SHELL, plate("xy", corners(-half, half, -half, half, 22), low + 5, -20, 5));
  on("base", INLAY, plate("yz", corners(-46, 46, low + 16, -32, 6), half - 0.8, half + 0.8, 0.6));
  on("base", ACCENT, plate("yz", [[34, low + 29, 3]], half, half + 1.6, 0.5));
  on("base", DARK, disc(57.5, -21, -18));

  on("turret", ACCENT, disc(56, -turret - 18, -turret - 15.6, 0.3));
  on("turret", DARK, disc(56.5, -turret - 15.8, -turret - 12, 0.8));
  on("turret", SHELL, plate("xy", corners(-50, 50, -48, 48, 26), -turret - 13, -30, 4));
  const cheek: Circle[] = [
    [0, 0, 32],
    [-24, -34, 20],
    [26, -34, 20],
  ];
  on("turret", SHELL, bothSides(cheek, 24, 41, 3));
  on("turret", DARK, bothSides([[0, 0, 23]], 40, 46, 2), pin([0, 0], 13, 25));
  on("turret", METAL, bothSides([[0, 0, 8]], 45, 48, 1), pin(BEHIND, 4, 26));

  const links: Circle[] = [
    [0, 0, 20],
    [0, rear, 15],
  ];
  on("rear_arm", SHELL, plate("xz", links, -13, 13, 3));
  on(
    "rear_arm",
    INLAY,
    bothSides(
      [
        [0, 34, 8],
        [0, rear - 30, 7],
      ],
      12.4,
      13.6,
      0.5,
    ),
  );
  const rod = (length: number, along: "up" | "out"): Circle[] => [
    [0, 0, 5],
    along === "up" ? [0, length, 5] : [length, 0, 5],
  ];
  on("level_rod", METAL, plate("xz", rod(rear, "up"), 17.5, 22, 1));
  on("drive_rod", METAL, plate("xz", rod(rear, "up"), -22, -17.5, 1));
  on(
    "crank",
    DARK,
    plate(
      "xz",
      [
        [0, 0, 13],
        [-CRANK, 0, 7],
      ],
      -17,
      -13.4,
      0.8,
    ),
  );
  on("crank", METAL, moved(plate("xz", [[0, 0, 3.5]], -23, -14, 0.6), [-CRANK, 0, 0]));

  const triangle: Circle[] = [
    [0, 0, 12],
    [...BEHIND, 8],
    [...ABOVE, 8],
  ];
  on("elbow", SHELL, bothSides(triangle, 13.4, 17, 1));
  on("elbow", DARK, pin([0, 0], 8, 19.5), pin(BEHIND, 3.5, 23), pin(ABOVE, 3.5, 18));
  on("elbow", ACCENT, pin([0, 0], 4.5, 20.3));

  const beam: Circle[] = [
    [-CRANK, 0, 8],
    [0, 0, 14],
    [fore, 0, 10.5],
  ];
  on("forearm", SHELL, plate("xz", beam, -11, 11, 3));
  on(
    "forearm",
    INLAY,
    bothSides(
      [
        [30, 0, 6],
        [fore - 26, 0, 5],
      ],
      10.4,
      11.6,
      0.5,
    ),
  );
  on("forearm", METAL, moved(plate("xz", [[0, 0, 3.5]], -23, 13, 0.6), [-CRANK, 0, 0]));
  on("head_rod", METAL, plate("xz", rod(fore, "out"), -4, 4, 1.2));

  // The head: a plate on the wrist's two pins, with the servo above the tool's axis.
  const reach = Math.max(10, Math.abs(bx) - 14) * (bx < 0 ? -1 : 1);
  on(
    "wrist",
    SHELL,
    bothSides(
      [
        [0, 0, 11],
        [...ABOVE, 8],
        [reach, 2, 9],
        [reach, 18, 9],
      ],
      11.6,
      15,
      1,
    ),
  );
  on("wrist", DARK, pin([0, 0], 6.5, 17.5), pin(ABOVE, 3.5, 16));
  on("wrist", SHELL, moved(box([-19, -19, -12], [19, 19, 27], 7, 2.5), [bx, by, 0]));
  on("wrist", DARK, moved(plate("xy", corners(-15, 15, -15, 15, 6), 26, 31, 1.5), [bx, by, 0]));
  on("tool", DARK, disc(15, hang - 19, hang - 11.5));
  if (hasHose) {
    on(
      "wrist",
      HOSE,
      tube(
        [
          [bx + 7, by + 6, -34],
          [bx + 10, by + 26, -26],
          [bx - 4, by + 30, 14],
          [bx - 26, 24, 22],
          [0, 20, 6],
          [0, 19, 0],
        ],
        2.6,
      ),
    );
    on(
      "forearm",
      HOSE,
      tube(
        [
          [fore, 19, 0],
          [fore - 24, 15, 6],
          [60, 15, 6],
          [24, 17, 16],
          [4, 12, 20],
        ],
        2.6,
      ),
    );
  }
  return parts;
}

/** Tool from the flange down to its tip, which is the origin. Its jaws are separate links. */
export function toolOf(name: ToolName | null, hang: number): Part[] {
  const parts: Part[] = [];
  const on = (link: string, color: string, ...solids: number[][]) => {
    for (const solid of solids) parts.push({ link, color, solid });
  };
  // Parts below the flange, even with a very short tool.
  const top = Math.max(34, hang - 18);
  if (name === "suction") {
    on("tool", METAL, disc(5, 16, top));
    on("tool", DARK, disc(9, top - 18, top - 2), moved(disc(4, -5, 5), [7, 4, top - 12]));
    const bellows = [
      [4.5, 21],
      [8.5, 19],
      [8.5, 17.5],
      [5.5, 15],
      [9.5, 12.5],
      [9.5, 11.5],
      [6, 9],
      [10, 6.5],
      [7, 4.5],
      [11.5, 0.6],
      [11, 0],
    ] as const;
    on("tool", RUBBER, lathe(bellows));
  } else if (name === "gripper") {
    on("tool", DARK, box([-13, -25, top - 26], [13, 25, top], 5, 2));
    on("tool", METAL, box([-9, -33, top - 30], [9, 33, top - 25], 2, 0.8));
    on("tool", ACCENT, plate("yz", corners(-12, 12, top - 15, top - 11, 1.5), 12.4, 13.6, 0.4));
    for (const [link, sign] of [
      ["jaw_left", 1],
      ["jaw_right", -1],
    ] as const) {
      const side = (from: number, to: number) => [Math.min(sign * from, sign * to), Math.max(sign * from, sign * to)];
      const [a = 0, b = 0] = side(0, 5);
      const [c = 0, d = 0] = side(4, 9);
      on(link, METAL, box([-7, c, 4], [7, d, top - 27], 2, 0.8));
      on(link, RUBBER, box([-7, a, -4], [7, b, 16], 2, 0.8));
    }
  } else if (name === "laser") {
    on("tool", ANODISED, box([-15, -15, 30], [15, 15, top], 3, 1.2));
    const fins = Math.max(2, Math.floor((top - 38) / 5));
    for (let nth = 0; nth < fins; nth++)
      on("tool", ANODISED, box([-19, -19, 35 + nth * 5], [19, 19, 37.2 + nth * 5], 3, 0.6));
    on("tool", METAL, disc(8, 22, 31));
    on("tool", ACCENT, disc(4.5, 20, 23, 0.6));
  } else if (name === "pen") {
    on("tool", INLAY, box([-12, -11, top - 15], [12, 11, top], 4, 1.6));
    on("tool", DARK, plate("yz", [[0, top - 7.5, 4]], 11, 17, 1));
    const pen = [
      [5, top],
      [5, 15],
      [3.8, 10],
      [1.3, 3],
    ] as const;
    on("tool", ACCENT, lathe(pen));
    on(
      "tool",
      RUBBER,
      lathe([
        [1.3, 3],
        [0.5, 0],
      ]),
    );
  } else {
    on(
      "tool",
      METAL,
      lathe([
        [4, top],
        [4, 14],
        [0.6, 0],
      ]),
    );
  }
  return parts;
}

/** Distance of each jaw from the middle, mm. */
export const JAWS = { open: 21, closed: 0.5, off: 13 } as const;
