// Presets: options under a name, for a pen or a material. One that is chosen is in the fields, where it can be seen and changed.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { tried } from "../actions";
import type { Preset } from "../api";
import { t } from "../i18n";
import { save } from "../log";
import * as check from "../run/check";
import { call } from "../session";
import * as store from "../store";
import { Card, Do, OpenFile, Pick, TextField } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./presets.json";

const w = sentencesOf(texts);

const all = signal<Preset[]>([]);
const chosen = signal("");
const name = signal("");

async function list(): Promise<void> {
  all.value = (await call("preset.list", {})).presets;
}

const choose = (wanted: string) =>
  tried(async () => {
    chosen.value = name.value = wanted;
    if (wanted === "") return;
    const { options = {} } = await call("preset.show", { name: wanted });
    check.values.value = Object.fromEntries(
      Object.entries(options).map(([key, value]) => [key, Array.isArray(value) ? value.join(" ") : String(value)]),
    );
  });

/** What a person has set, without what the route and the sheet say. */
function own(): Record<string, unknown> {
  return Object.fromEntries(
    Object.entries(check.setup.value ?? {}).filter(([key]) => !(key in check.fixed.value) && key !== "only"),
  );
}

const keep = (to: string, content: { setup: Record<string, unknown> } | { text: string }) =>
  tried(async () => {
    // As the library does: another page may have saved one since.
    await list();
    const replaces = all.value.some((one) => one.name === to);
    if (replaces && !(await store.ask(t("replace.title", { name: to }), w("preset.replace.text"), t("replace"))))
      return;
    await call("preset.save", { name: to, ...content });
    await list();
    await choose(to);
    store.say(w("preset.saved", { name: to }));
  });

export function Presets() {
  useEffect(() => {
    if (store.isUp.value) void tried(list);
  }, [store.isUp.value]);
  const off = !store.isUp.value || store.role.value === "viewer";
  const preset = all.value.find((one) => one.name === chosen.value);
  const remove = () =>
    tried(async () => {
      await call("preset.remove", { name: chosen.value });
      await choose("");
      await list();
    });
  const download = () =>
    tried(async () => save(`${chosen.value}.toml`, (await call("preset.show", { name: chosen.value })).text ?? ""));
  const open = ([file]: File[]) =>
    tried(
      async () =>
        file && keep(file.name.replace(/\.toml$/i, "").replace(/[^A-Za-z0-9_-]+/g, "-"), { text: await file.text() }),
    );
  return (
    <Card
      title={w("preset.title")}
      class="preset-card"
      more={<OpenFile id="preset-open" class="small" accept=".toml" off={off} text={t("programs.open")} open={open} />}
    >
      <Pick
        title={w("preset.choose")}
        id="preset-choose"
        value={chosen.value}
        options={[{ value: "", text: w("preset.none") }, ...all.value.map((one) => one.name)]}
        off={!store.isUp.value}
        choose={choose}
      />
      {preset?.note ? (
        <p class="hint" data-testid="preset-note">
          {preset.note}
        </p>
      ) : null}
      <TextField
        id="preset-name"
        label={w("preset.name")}
        value={name.value}
        most={64}
        live
        off={off}
        set={(text) => (name.value = text.trim())}
      />
      <div class="buttons-row">
        <Do
          id="preset-save"
          off={off || name.value === ""}
          text={t("preset.save")}
          press={() => keep(name.value, { setup: own() })}
        />
        <Do id="preset-file" off={preset === undefined} text={w("preset.file")} press={download} />
        <Do
          id="preset-remove"
          off={off || preset === undefined || preset.shipped}
          text={t("preset.remove")}
          press={remove}
        />
      </div>
    </Card>
  );
}
