// Sign-in page of a class: name and code; other ways in are folded.
import { useSignal } from "@preact/signals";
import { fromSlip, hasClass } from "../../class";
import { t } from "../../i18n";
import { tokenFor } from "../../pairing";
import { apiUrl, connect, keptPupil } from "../../session";
import * as store from "../../store";
import { Card, TextField } from "../../ui/parts";
import { Connect } from "../connect";
import { StationsCard, signInPlace } from "./hub";
import { w } from "./words";

/** Reason for a refused sign-in, in the page's language. */
function faultText(of: "pupil" | "pin"): string | undefined {
  const fault = store.signInFault.value;
  if (fault?.of !== of) return undefined;
  if (Array.isArray(fault.machines)) return signInPlace(fault.machines);
  if (typeof fault.wait === "number") return w("door.wait", { seconds: Math.ceil(fault.wait) });
  return w(of === "pin" ? "door.pin.wrong" : "door.wrong");
}

export function SignIn() {
  const slip = fromSlip.value;
  const name = useSignal(slip?.name ?? keptPupil());
  const code = useSignal(slip?.code ?? "");
  const pin = useSignal("");
  const refused = useSignal(false);
  const url = apiUrl(location.origin);
  const faults = { pupil: faultText("pupil"), pin: faultText("pin") };
  const signIn = (event: Event) => {
    event.preventDefault();
    if (url !== null && name.value.trim() !== "") connect(url, code.value.trim(), name.value.trim());
  };
  const teach = async (event: Event) => {
    event.preventDefault();
    if (url === null) return;
    const token = await tokenFor(url, pin.value.trim());
    refused.value = token === null;
    if (token) connect(url, token);
  };
  // Without a known class the station may only want a token.
  const isSure = !store.hub.value && (hasClass.value || slip !== null);
  return (
    <>
      {store.hub.value ? <StationsCard /> : null}
      <Card title={w("door.title")} class="arms door">
        <form class="door-form" onSubmit={signIn} hidden={store.hub.value}>
          <TextField
            id="class-name"
            label={w("door.name")}
            value={name.value}
            most={40}
            autocomplete="off"
            live
            set={(text) => (name.value = text)}
          />
          <TextField
            id="class-code"
            label={w("door.code")}
            value={code.value}
            most={12}
            live
            set={(text) => (code.value = text)}
            bad={faults.pupil !== undefined}
            hint={faults.pupil ?? w("door.code.hint")}
          />
          <button
            type="submit"
            class="primary"
            data-testid="class-signin"
            disabled={name.value.trim() === "" || code.value.trim() === ""}
          >
            {w("door.signin")}
          </button>
        </form>
        <details open={faults.pin !== undefined || !isSure}>
          <summary data-testid="class-teacher">{w(isSure ? "door.teacher" : "door.token")}</summary>
          <form class="door-form" onSubmit={teach}>
            <TextField
              id="class-pin"
              label={w("door.pin")}
              value={pin.value}
              inputMode="decimal"
              live
              set={(text) => (pin.value = text)}
              bad={refused.value || faults.pin !== undefined}
              hint={faults.pin ?? (refused.value ? t("connect.code.refused") : w("door.pin.hint"))}
            />
            <button type="submit" data-testid="class-pin-signin" disabled={pin.value.trim() === ""}>
              {w("door.signin")}
            </button>
          </form>
        </details>
        <details>
          <summary data-testid="class-other">{w("door.other")}</summary>
          {store.socket.value === "up" ? (
            <p>
              <a href="#/move">{w("door.look")}</a>
            </p>
          ) : null}
          <Connect />
        </details>
      </Card>
    </>
  );
}
