// Presets: named options for a pen or a material. Selecting one fills in the fields, where they can
// be seen and changed.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt } from "../actions";
import type { Preset } from "../api";
import { t } from "../i18n";
import { save } from "../log";
import type { Bench } from "../run/bench";
import { requireValid } from "../run/workshop";
import { call } from "../session";
import * as store from "../store";
import { Button, Card, OpenFile, TextField } from "../ui/parts";
import { sentencesOf } from "../words";
import "./presets.css";
import texts from "./presets.json";
import { Swatch } from "./swatch";

const w = sentencesOf(texts);

const presets = signal<Preset[]>([]);
const selectedName = signal("");
const typedName = signal("");

async function readPresets(): Promise<void> {
  const { presets: listed } = await call("preset.list", {});
  // The tile of a preset shows its values.
  presets.value = await Promise.all(
    listed.map((one) =>
      call("preset.show", { name: one.name }).then(
        (told) => ({ ...one, ...told }),
        () => one,
      ),
    ),
  );
}

const selectPreset = (bench: Bench, wanted: string) =>
  attempt(async () => {
    selectedName.value = typedName.value = wanted;
    if (wanted === "") return;
    const { options = {} } = await call("preset.show", { name: wanted });
    bench.setValues(
      Object.fromEntries(
        Object.entries(options).map(([key, value]) => [key, Array.isArray(value) ? value.join(" ") : String(value)]),
      ),
    );
  });

/** Options that the user has set, without those of the route and the sheet. */
const userOptions = (bench: Bench): Record<string, unknown> =>
  Object.fromEntries(
    Object.entries(bench.setup.value ?? {}).filter(([key]) => !(key in bench.fixed) && !["only", "crop"].includes(key)),
  );

const savePreset = (bench: Bench, to: string, content: { setup: Record<string, unknown> } | { text: string }) =>
  attempt(async () => {
    // Invalid fields prevent saving.
    requireValid(bench.shownOptions.value, bench.values.value);
    // Read again, because another page may have saved one since.
    await readPresets();
    const replaces = presets.value.some((one) => one.name === to);
    if (replaces && !(await store.ask(t("replace.title", { name: to }), w("preset.replace.text"), t("replace"))))
      return;
    await call("preset.save", { name: to, ...content });
    await readPresets();
    await selectPreset(bench, to);
    store.notify(w("preset.saved", { name: to }));
  });

/** Values shown on the tile of a preset. */
function factsOf({ options = {} }: Preset): string {
  const { speed, power } = options as { speed?: number; power?: number | string };
  const facts = [
    speed === undefined ? null : w("preset.speed", { n: speed }),
    power === undefined ? null : w("preset.power", { n: power }),
  ];
  return facts.filter((fact) => fact !== null).join(" · ");
}
/** Title: the purpose of a preset that comes with the program, otherwise its name. */
const titleOf = ({ name, shipped }: Preset): string =>
  shipped && `preset.${name}` in texts.en ? w(`preset.${name}` as "preset.pen") : name;

export function Presets({ bench }: { bench: Bench }) {
  useEffect(() => {
    if (store.isUp.value) void attempt(readPresets);
  }, [store.isUp.value]);
  const off = !store.isUp.value || store.role.value === "viewer";
  const toolOf = ({ options }: Preset) => (options as { tool?: unknown } | undefined)?.tool;
  const fitting = presets.value.filter((one) => (toolOf(one) ?? bench.tool) === bench.tool);
  const preset = fitting.find((one) => one.name === selectedName.value);
  const remove = () =>
    attempt(async () => {
      await call("preset.remove", { name: selectedName.value });
      await selectPreset(bench, "");
      await readPresets();
    });
  const download = () =>
    attempt(async () =>
      save(`${selectedName.value}.toml`, (await call("preset.show", { name: selectedName.value })).text ?? ""),
    );
  const open = ([file]: File[]) =>
    attempt(
      async () =>
        file &&
        savePreset(bench, file.name.replace(/\.toml$/i, "").replace(/[^A-Za-z0-9_-]+/g, "-"), {
          text: await file.text(),
        }),
    );
  return (
    <Card title={w("preset.title")} class="preset-card">
      <div class="presets" role="group" aria-label={w("preset.choose")}>
        {fitting.map((one) => (
          <Button
            key={one.name}
            id={`preset-tile-${one.name}`}
            class="preset"
            aria-pressed={one === preset}
            off={!store.isUp.value}
            press={() => selectPreset(bench, one === preset ? "" : one.name)}
          >
            <Swatch name={one.name} tool={bench.tool} options={one.options ?? {}} />
            <b>{titleOf(one)}</b>
            <small class="number">{factsOf(one)}</small>
          </Button>
        ))}
      </div>
      {preset?.note ? (
        <p class="hint" data-testid="preset-note">
          {preset.shipped ? w("preset.untried") : preset.note}
        </p>
      ) : null}
      <details class="more" data-testid="preset-more">
        <summary>{w("preset.more")}</summary>
        <div class="preset-keep">
          <TextField
            id="preset-name"
            label={w("preset.name")}
            value={typedName.value}
            most={64}
            live
            off={off}
            set={(text) => (typedName.value = text.trim())}
          />
          <div class="buttons-row">
            <Button
              id="preset-save"
              off={off || typedName.value === ""}
              text={t("preset.save")}
              press={() => savePreset(bench, typedName.value, { setup: userOptions(bench) })}
            />
            <OpenFile id="preset-open" accept=".toml" off={off} text={t("programs.open")} open={open} />
            <Button id="preset-file" off={preset === undefined} text={w("preset.file")} press={download} />
            <Button
              id="preset-remove"
              off={off || preset === undefined || preset.shipped}
              text={t("preset.remove")}
              press={remove}
            />
          </div>
        </div>
      </details>
    </Card>
  );
}
