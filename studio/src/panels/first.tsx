// First steps with the virtual arm: three things to try, one press each.
import { useSignal } from "@preact/signals";
import { reportError } from "../actions";
import { t } from "../i18n";
import { call, shownArm } from "../session";
import { hasTried } from "../settings";
import * as store from "../store";
import { Button, Card } from "../ui/parts";

const EXERCISES = ["wave", "house", "circle"] as const;
type Exercise = (typeof EXERCISES)[number];
export function FirstSteps() {
  const isMine = useSignal(false);
  if (store.backend.value !== "sim" || hasTried.value === "yes" || store.socket.value !== "up") return null;
  const why = store.why.value;
  const go = async (what: Exercise) => {
    isMine.value = true;
    try {
      const plans = (await (await fetch(new URL("assets/first.json", document.baseURI))).json()) as Record<
        Exercise,
        unknown
      >;
      await call("job.start", { ...shownArm(), text: JSON.stringify(plans[what]) });
    } catch (error) {
      isMine.value = false;
      reportError(error);
    }
  };
  const done = <Button id="first-close" class="quiet small" text={t("close")} press={() => (hasTried.value = "yes")} />;
  return (
    <Card title={t("first.title")} class="first" more={done}>
      <ul class="tries">
        {EXERCISES.map((what) => (
          <li key={what}>
            <Button
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
          <Button id="first-draw" text={t("first.draw")} press={() => (location.hash = "#/draw")} />
        </li>
        <li>
          <Button id="first-more" class="quiet" text={t("first.more")} press={() => (location.hash = "#/gallery")} />
        </li>
      </ul>
      <p id="first-why" class="hint" role="status">
        {why === "why.busy" && isMine.value ? t("first.runs") : why !== null ? t(why) : t("first.text")}
      </p>
    </Card>
  );
}
