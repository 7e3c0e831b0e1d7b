// The arms of the station, how it is reached, and what happened.
import { t } from "../i18n";
import { clock, lines, save } from "../log";
import { show } from "../session";
import * as store from "../store";
import { Card } from "../ui/parts";
import { Connect } from "./connect";

function List() {
  const arms = store.arms.value;
  const holder = (arm: store.ArmEntry) => {
    if (arm.holder === null) return t("arms.free");
    return arm.holder.session === store.session.value ? t("arms.you") : arm.holder.name;
  };
  return (
    <Card title={t("arms.title")} class="arms">
      {arms.length === 0 ? (
        <p class="hint">{t(store.socket.value === "closed" ? "why.closed" : "link.connecting")}</p>
      ) : (
        <table>
          <thead>
            <tr>
              <th scope="col">{t("arms.name")}</th>
              <th scope="col">{t("arms.kind")}</th>
              <th scope="col">{t("arms.port")}</th>
              <th scope="col">{t("arms.link")}</th>
              <th scope="col">{t("arms.holder")}</th>
            </tr>
          </thead>
          <tbody>
            {arms.map((arm) => {
              const isShown = arm.name === store.armName.value;
              const line = isShown ? (store.state.value?.link ?? arm.link) : arm.link;
              return (
                <tr key={arm.name} data-testid={`arm-${arm.name}`}>
                  <th scope="row">
                    <label class="pick">
                      <input
                        type="radio"
                        name="shown"
                        checked={isShown}
                        aria-label={t("arms.show", { name: arm.name })}
                        onChange={() => show(arm.name)}
                      />
                      {arm.name}
                    </label>
                  </th>
                  <td>
                    <span class={`badge ${arm.virtual ? "virtual" : "real"}`}>{t(arm.virtual ? "arm.virtual" : "arm.real")}</span>
                  </td>
                  <td class="port">{arm.port}</td>
                  <td>
                    <span class={`dot ${line}`} aria-hidden="true" /> {t(line === "up" ? "arms.link.up" : "arms.link.lost")}
                  </td>
                  <td>{holder(arm)}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      )}
    </Card>
  );
}

function Log() {
  const all = lines.value;
  const text = () => all.map((line) => `${line.at.toISOString()}  ${line.text}\n`).join("");
  return (
    <Card
      title={t("log.title")}
      class="log-card"
      more={
        <button type="button" class="quiet small" disabled={all.length === 0} onClick={() => save("magician-log.txt", text())}>
          {t("log.export")}
        </button>
      }
    >
      <div class="log" role="log" aria-label={t("log.title")} tabIndex={0} data-testid="log">
        {all.length === 0 ? <p class="hint">{t("log.empty")}</p> : null}
        {all.map((line, at) => (
          <p key={at}>
            <time dateTime={line.at.toISOString()}>{clock(line.at)}</time> {line.text}
          </p>
        ))}
      </div>
    </Card>
  );
}

export function Arms() {
  return (
    <div class="columns">
      <List />
      <Connect />
      <Log />
    </div>
  );
}
