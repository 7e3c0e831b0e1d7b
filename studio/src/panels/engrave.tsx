// Engraving with the laser: arranged on the sheet, outlined with the laser off, and burnt once it
// is armed.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { parseNumber } from "../numbers";
import { benches } from "../run/bench";
import { whyNotStart } from "../run/jobs";
import { watchArmed } from "../run/laser";
import * as store from "../store";
import { Button, Card, TextField } from "../ui/parts";
import { sentencesOf } from "../words";
import { ArmLaser } from "./armlaser";
import texts from "./engrave.json";
import { WorkshopPanel } from "./workshop";

const w = sentencesOf(texts);

/** Values typed for a test grid; the station supplies the others. */
const grid = signal<Record<string, string>>({});
const GRID_FIELDS = ["power", "speed", "cell"] as const;
const bench = benches.laser;
const isTestGrid = () => bench.item.value?.format === "testgrid";

function setGrid(fields: Record<string, string>, isWanted = true): void {
  grid.value = fields;
  if (!isWanted) return;
  const typed = Object.entries(fields).flatMap(([name, text]) =>
    text.trim() === "" ? [] : [[name, name === "cell" ? (parseNumber(text) ?? text.trim()) : text.trim()]],
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
        {GRID_FIELDS.map((name) => (
          <TextField
            key={name}
            id={`testgrid-${name}`}
            label={t(`laser.grid.${name}`)}
            value={grid.value[name] ?? ""}
            placeholder={t("setup.unset")}
            bad={
              name === "cell" && (grid.value.cell ?? "").trim() !== "" && parseNumber(grid.value.cell ?? "") === null
            }
            off={off}
            set={(text) => setGrid({ ...grid.value, [name]: text }, isTestGrid())}
          />
        ))}
        <Button
          id="laser-testgrid"
          aria-pressed={isTestGrid()}
          off={off}
          text={w("laser.grid.lay")}
          press={() => setGrid(grid.value)}
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
      <Button
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
    <WorkshopPanel
      bench={bench}
      name={t("nav.engrave")}
      hint={w("engrave.empty")}
      first={["power", "speed", "passes"]}
      before={before}
    >
      <TestGrid />
    </WorkshopPanel>
  );
}
