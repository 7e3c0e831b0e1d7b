// The first minutes with the virtual arm: three things to try, each one press.
import { useSignal } from "@preact/signals";
import { complain } from "../actions";
import { t } from "../i18n";
import { call, shown } from "../session";
import { hasTried } from "../settings";
import * as store from "../store";
import { Card } from "../ui/parts";

const TRIES = ["wave", "house", "circle"] as const;
type Try = (typeof TRIES)[number];

export function FirstSteps() {
  const under = useSignal<Try | null>(null);
  if (store.backend.value !== "sim" || hasTried.value === "yes" || store.socket.value !== "up") return null;
  const why = store.why.value;
  const go = async (what: Try) => {
    under.value = what;
    try {
      const plans = (await (await fetch(new URL("assets/first.json", document.baseURI))).json()) as Record<Try, unknown>;
      await call("job.start", { ...shown(), text: JSON.stringify(plans[what]) });
    } catch (error) {
      under.value = null;
      complain(error);
    }
  };
  const done = (
    <button type="button" class="quiet small" data-testid="first-close" onClick={() => (hasTried.value = "yes")}>
      {t("close")}
    </button>
  );
  return (
    <Card title={t("first.title")} class="first" more={done}>
      <ul class="tries">
        {TRIES.map((what) => (
          <li key={what}>
            <button type="button" class="primary" data-testid={`first-${what}`} disabled={why !== null} aria-describedby="first-why" onClick={() => void go(what)}>
              {t(`first.${what}`)}
            </button>
          </li>
        ))}
      </ul>
      <p id="first-why" class="hint" role="status">
        {why === "why.busy" && under.value !== null ? t("first.runs") : why !== null ? t(why) : t("first.text")}
      </p>
    </Card>
  );
}
