// The first minutes with the virtual arm: three things to try, each one press.
import { useSignal } from "@preact/signals";
import { complain } from "../actions";
import { t } from "../i18n";
import type { Params } from "../client";
import { call, shown } from "../session";
import { hasTried } from "../settings";
import * as store from "../store";
import { Card, Do, TextField } from "../ui/parts";

const TRIES = ["wave", "house", "circle"] as const;
type Try = (typeof TRIES)[number];
/** A name is written beside the house, from left to right as the arm is seen from behind; smaller where it would not fit. */
const LETTERS = { font: "script", size: 18, at: [230, -95], rotate: -90, fit: true };

type Program = Pick<Params<"job.start">, "text" | "format" | "setup">;

export function FirstSteps() {
  const isMine = useSignal(false);
  const name = useSignal("");
  if (store.backend.value !== "sim" || hasTried.value === "yes" || store.socket.value !== "up") return null;
  const why = store.why.value;
  const start = async (program: () => Promise<Program>) => {
    isMine.value = true;
    try {
      await call("job.start", { ...shown(), ...(await program()) });
    } catch (error) {
      isMine.value = false;
      complain(error);
    }
  };
  const go = (what: Try) =>
    start(async () => {
      const plans = (await (await fetch(new URL("assets/first.json", document.baseURI))).json()) as Record<Try, unknown>;
      return { text: JSON.stringify(plans[what]) };
    });
  const write = (event: Event) => {
    event.preventDefault();
    const text = name.value.trim();
    if (text !== "" && why === null) void start(async () => ({ text, format: "text", setup: LETTERS }));
  };
  const done = (
    <Do id="first-close" class="quiet small" text={t("close")} press={() => (hasTried.value = "yes")} />
  );
  return (
    <Card title={t("first.title")} class="first" more={done}>
      <ul class="tries">
        {TRIES.map((what) => (
          <li key={what}>
            <Do id={`first-${what}`} class="primary" off={why !== null} aria-describedby="first-why" text={t(`first.${what}`)} press={() => go(what)} />
          </li>
        ))}
      </ul>
      <form class="tries first-name" onSubmit={write}>
        <TextField id="first-name" label={t("first.name")} value={name.value} most={30} live set={(text) => (name.value = text)} />
        <button type="submit" data-testid="first-write" disabled={why !== null || name.value.trim() === ""} aria-describedby="first-why">
          {t("first.write")}
        </button>
      </form>
      <p id="first-why" class="hint" role="status">
        {why === "why.busy" && isMine.value ? t("first.runs") : why !== null ? t(why) : t("first.text")}
      </p>
    </Card>
  );
}
