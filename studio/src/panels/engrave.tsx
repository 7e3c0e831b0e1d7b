// Engraving with the laser: arranged on the sheet, outlined with the laser off, and burnt once it
// is armed.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { numberOf } from "../numbers";
import { benches } from "../run/bench";
import { whyNotStart } from "../run/jobs";
import { watchArmed } from "../run/laser";
import * as store from "../store";
import { Card, Do, TextField } from "../ui/parts";
import { sentencesOf } from "../words";
import { ArmLaser } from "./armlaser";
import texts from "./engrave.json";
import { Workshop } from "./workshop";

const w = sentencesOf(texts);

/** Values typed for a test grid; the station supplies the others. */
const grid = signal<Record<string, string>>({});
const GRID = ["power", "speed", "cell"] as const;
const bench = benches.laser;
const isGrid = () => bench.item.value?.format === "testgrid";

function lay(fields: Record<string, string>, isWanted = true): void {
  grid.value = fields;
  if (!isWanted) return;
  const typed = Object.entries(fields).flatMap(([name, text]) =>
    text.trim() === "" ? [] : [[name, name === "cell" ? (numberOf(text) ?? text.trim()) : text.trim()]],
  );
  const text = JSON.stringify({ format: "magician-testgrid", ...Object.fromEntries(typed) });
  bench.replace({ source: { text, format: "testgrid" }, format: "testgrid", name: t("laser.grid") });
}

function TestGrid() {
  const off = !store.isUp.value;
  return (
    <Card title={t("laser.grid")} class="grid-card">
      <p class="hint">{w("laser.grid.text")}</p>
      <div class="setup">
        {GRID.map((name) => (
          <TextField
            key={name}
            id={`testgrid-${name}`}
            label={t(`laser.grid.${name}`)}
            value={grid.value[name] ?? ""}
            placeholder={t("setup.unset")}
            bad={name === "cell" && (grid.value.cell ?? "").trim() !== "" && numberOf(grid.value.cell ?? "") === null}
            off={off}
            set={(text) => lay({ ...grid.value, [name]: text }, isGrid())}
          />
        ))}
        <Do
          id="laser-testgrid"
          aria-pressed={isGrid()}
          off={off}
          text={w("laser.grid.lay")}
          press={() => lay(grid.value)}
        />
      </div>
    </Card>
  );
}

export function Engrave() {
  useEffect(watchArmed, []);
  const frames = { frame: "box" } as const;
  const off = whyNotStart(frames) !== null;
  const frame = () =>
    bench.start(w("laser.frame.of", { title: bench.title.value }), () => w("laser.frame.text"), {
      setup: frames,
    });
  const before = (
    <div class="laser-do">
      <Do
        id="laser-frame"
        off={off || bench.chosen.value === null}
        why="draw-why"
        text={w("laser.frame")}
        press={frame}
        title={w("laser.frame.text")}
      />
      <ArmLaser id="laser-arm" burns why="draw-why" />
    </div>
  );
  return (
    <Workshop
      bench={bench}
      name={t("nav.engrave")}
      hint={w("engrave.empty")}
      first={["power", "speed", "passes"]}
      before={before}
    >
      <TestGrid />
    </Workshop>
  );
}
