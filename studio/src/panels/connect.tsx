// Choice of an arm: station, virtual arm, or serial port.
import { useSignal } from "@preact/signals";
import { t } from "../i18n";
import { tokenFor } from "../pairing";
import { serial } from "../serial";
import { apiUrl, connect, connectSerial, connectSim, disconnect, keptPupil, keptToken } from "../session";
import * as store from "../store";
import { Button, Card, TextField } from "../ui/parts";

/** Text beside the button: its effect, or why it is disabled here. */
function serialHint() {
  const fault = store.portFault.value;
  if (fault !== null) return t(`serial.${fault}`);
  if (serial !== undefined) return t("connect.serial.why");
  return t(isSecureContext ? "connect.serial.none" : "connect.serial.http");
}

export function Connect() {
  const url = useSignal(location.protocol.startsWith("http") ? location.host : "127.0.0.1:8910");
  const token = useSignal(keptToken());
  const pupil = useSignal(keptPupil());
  const bad = useSignal(false);
  const refused = store.refused.value;
  const [backend, fault] = [store.backend.value, store.portFault.value];
  const isOn = backend !== "none" && refused === null;
  const isFirst = store.isStatic.value && !isOn;
  const noSerial = serial === undefined || (backend === "serial" && store.link.value !== "lost");
  const hint = bad.value
    ? t("connect.bad")
    : refused !== null
      ? t(`connect.${refused}.refused`)
      : t("connect.station.text");
  const go = async (event: Event) => {
    event.preventDefault();
    const address = apiUrl(url.value.trim());
    bad.value = address === null;
    if (address === null) return;
    const name = pupil.value.trim();
    const found = name === "" ? await tokenFor(address, token.value.trim()) : token.value.trim();
    if (found === null) return store.notify(t("connect.code.refused"), true);
    token.value = found;
    connect(address, found, name);
  };
  return (
    <Card title={t("connect.title")} class="connect">
      <div class="ways">
        <div class="way">
          <Button
            id="connect-sim"
            class={isFirst ? "primary" : ""}
            off={backend === "sim"}
            aria-describedby="sim-why"
            text={t("connect.sim")}
            press={connectSim}
          />
          <p id="sim-why" class="hint">
            {t("connect.sim.why")}
          </p>
        </div>
        <div class="way">
          <Button
            id="connect-serial"
            off={noSerial}
            aria-describedby="serial-why"
            text={t("connect.serial")}
            press={connectSerial}
          />
          <p id="serial-why" class={`hint ${fault === null ? "" : "bad"}`} role="status" data-testid="serial-why">
            {serialHint()}
          </p>
        </div>
      </div>
      <form class="server" onSubmit={go}>
        <TextField
          id="station-url"
          label={t("connect.url")}
          value={url.value}
          inputMode="url"
          live
          set={(text) => (url.value = text)}
          bad={bad.value || refused !== null}
          hint={hint}
        />
        <TextField
          id="station-token"
          label={t("connect.token")}
          value={token.value}
          live
          set={(text) => (token.value = text)}
          hint={t("connect.token.hint")}
        />
        <TextField
          id="station-pupil"
          label={t("connect.pupil")}
          value={pupil.value}
          live
          set={(text) => (pupil.value = text)}
          hint={t("connect.pupil.hint")}
        />
        <div class="server-buttons">
          <button type="submit" class={isOn || store.isStatic.value ? "" : "primary"} data-testid="connect-station">
            {t("connect.station")}
          </button>
          {isOn ? <Button class="quiet" text={t("connect.end")} press={disconnect} /> : null}
        </div>
      </form>
      {location.protocol === "https:" ? <p class="hint">{t("connect.mixed")}</p> : null}
    </Card>
  );
}
