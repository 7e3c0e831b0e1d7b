// First steps with the virtual arm: three things to try, one press each.
import { useSignal } from "@preact/signals";
import { complain } from "../actions";
import { t } from "../i18n";
import { call, shown } from "../session";
import { hasTried } from "../settings";
import * as store from "../store";
import { Card, Do } from "../ui/parts";

const TRIES = ["wave", "house", "circle"] as const;
type Try = (typeof TRIES)[number];
export function FirstSteps() {
  const isMine = useSignal(false);
  if (store.backend.value !== "sim" || hasTried.value === "yes" || store.socket.value !== "up") return null;
  const why = store.why.value;
  const go = async (what: Try) => {
    isMine.value = true;
    try {
      const plans = (await (await fetch(new URL("assets/first.json", document.baseURI))).json()) as Record<
        Try,
        unknown
      >;
      await call("job.start", { ...shown(), text: JSON.stringify(plans[what]) });
    } catch (error) {
      isMine.value = false;
      complain(error);
    }
  };
  const done = <Do id="first-close" class="quiet small" text={t("close")} press={() => (hasTried.value = "yes")} />;
  return (
    <Card title={t("first.title")} class="first" more={done}>
      <ul class="tries">
        {TRIES.map((what) => (
          <li key={what}>
            <Do
              id={`first-${what}`}
              class="primary"
              off={why !== null}
              aria-describedby="first-why"
              text={t(`first.${what}`)}
              press={() => go(what)}
            />
          </li>
        ))}
        <li>
          <Do id="first-draw" text={t("first.draw")} press={() => (location.hash = "#/draw")} />
        </li>
        <li>
          <Do id="first-more" class="quiet" text={t("first.more")} press={() => (location.hash = "#/gallery")} />
        </li>
      </ul>
      <p id="first-why" class="hint" role="status">
        {why === "why.busy" && isMine.value ? t("first.runs") : why !== null ? t(why) : t("first.text")}
      </p>
    </Card>
  );
}
