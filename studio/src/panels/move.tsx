import { t } from "../i18n";
import * as store from "../store";
import { lazy } from "../ui/lazy";
import { ArmView } from "../view/view";
import { Connect } from "./connect";
import { FirstSteps } from "./first";
import { JogPad } from "./jogpad";
import { GoToPose, Pose } from "./pose";
import { ArmCard } from "./tools";

const Surface = lazy(() => import("./surface").then(({ Surface }) => Surface));

export function Move() {
  // A pupil whose class has ended connects to nothing.
  const isOver = store.refused.value === "revoked" && store.pupil.value !== null;
  const isEmpty = store.backend.value === "none" || (store.refused.value !== null && !isOver);
  return (
    <div class="move">
      <div class="move-look">
        {isEmpty ? <Connect /> : null}
        <FirstSteps />
        <ArmView />
        <Pose />
        <GoToPose />
      </div>
      <div class="move-do" aria-label={t("nav.move")} role="group">
        <JogPad />
        <ArmCard />
        <Surface />
      </div>
    </div>
  );
}
