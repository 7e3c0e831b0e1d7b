// Settings of the user, and the fence of the arm.
import { LANGUAGES, t } from "../i18n";
import { applyName } from "../session";
import { language, ownName, THEMES, type Theme, theme } from "../settings";
import * as store from "../store";
import { Card, Choice, TextField } from "../ui/parts";
import type { Sides as Bounds } from "../view/fence";
import { ArmView } from "../view/view";
import { sentencesOf } from "../words";
import texts from "./settings.json";

const w = sentencesOf(texts);

function Sides({ name, sides }: { name: string; sides: Bounds }) {
  const text = Object.entries(sides).map(([axis, [least, most]]) => `${axis} ${least} … ${most}`);
  return <Row name={name} value={`${text.join(", ")} mm`} />;
}

function Row({ name, value }: { name: string; value: string }) {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{value}</dd>
    </div>
  );
}

function Fence() {
  const name = store.armName.value;
  const fence = store.fence.value;
  return (
    <Card title={w("fence.title", { arm: name ?? "–" })}>
      <div data-testid="fence">
        {name === null ? (
          <p class="hint">{w("fence.off")}</p>
        ) : fence === null ? (
          <p>{w("fence.none")}</p>
        ) : (
          <>
            <dl class="facts">
              {fence.floor === null ? null : <Row name={w("fence.floor")} value={`z ≥ ${fence.floor} mm`} />}
              {fence.box === null ? null : <Sides name={w("fence.box")} sides={fence.box} />}
              {fence.keep_out.map((sides, at) => (
                <Sides key={at} name={`${w("fence.out")} ${at + 1}`} sides={sides} />
              ))}
              {fence.speed === null ? null : <Row name={w("fence.speed")} value={`${fence.speed} mm/s`} />}
              {fence.power === null ? null : <Row name={w("fence.power")} value={`${fence.power} %`} />}
            </dl>
            <p class="hint">{w("fence.text")}</p>
          </>
        )}
      </div>
    </Card>
  );
}

export function Settings() {
  return (
    <div class="columns">
      <Card title={t("settings.you")}>
        <TextField
          id="settings-name"
          label={t("settings.name")}
          value={ownName.value}
          most={40}
          autocomplete="nickname"
          placeholder={t("settings.usualName")}
          hint={t("settings.name.hint")}
          set={(text) => {
            ownName.value = text.trim();
            applyName();
          }}
        />
        <Choice<string>
          name="settings-language"
          label={t("settings.language")}
          value={language.value}
          choose={(value) => (language.value = value)}
          options={LANGUAGES}
        />
        {t("language.note") ? <p class="hint">{t("language.note")}</p> : null}
        <Choice<Theme>
          name="settings-theme"
          label={t("settings.theme")}
          value={theme.value}
          choose={(value) => (theme.value = value)}
          options={THEMES.map((value) => ({ value, text: t(`settings.${value}`) }))}
        />
        <p class="hint">
          <a href="licences.txt">{t("settings.licences")}</a>
        </p>
      </Card>
      <div class="fence-side">
        <Fence />
        {store.fence.value === null ? null : <ArmView />}
      </div>
    </div>
  );
}
