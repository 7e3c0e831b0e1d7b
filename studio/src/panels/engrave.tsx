// Engraving with the laser: arranged on the sheet, outlined with the laser off, and burnt once it
// is armed.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { benches } from "../run/bench";
import { isArmed, watchArmed } from "../run/laser";
import * as store from "../store";
import { Card, Do, Switch, TextField } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./engrave.json";
import { Workshop, why } from "./workshop";

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
    text.trim() === "" ? [] : [[name, name === "cell" ? Number(text) : text.trim()]],
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
  const off = why() !== null;
  const frame = () =>
    bench.start(w("laser.frame.of", { title: bench.title.value }), () => w("laser.frame.text"), {
      setup: { frame: "box" },
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
      <Switch
        id="laser-arm"
        label={w("laser.arm")}
        on={isArmed.value}
        off={off}
        why="draw-why"
        danger
        flip={(on) => (isArmed.value = on)}
      />
    </div>
  );
  const because = isArmed.value ? null : "laser.unarmed";
  return (
    <Workshop
      bench={bench}
      name={t("nav.engrave")}
      hint={w("engrave.empty")}
      first={["power", "speed", "passes"]}
      because={because}
      before={before}
    >
      <TestGrid />
    </Workshop>
  );
}
