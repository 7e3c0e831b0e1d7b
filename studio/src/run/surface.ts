// The height of the work surface: taken from where the tool of the arm touches it.
import { effect, signal } from "@preact/signals";
import { type Problem, problemOf } from "../actions";
import type { Result } from "../client";
import { t } from "../i18n";
import { call, shown } from "../session";
import * as store from "../store";

/** Height that was touched, mm; null if none is known. */
export const height = signal<number | null>(null);
/** Why it was not taken. */
export const problem = signal<Problem | null>(null);

const take = ({ plane }: Result<"surface.touch">): void => void (height.value = plane?.z ?? null);

async function asked(params: { forget?: boolean }, said: () => string): Promise<void> {
  problem.value = null;
  try {
    take(await call("surface.touch", { ...shown(), ...params }));
    store.say(said());
  } catch (error) {
    problem.value = problemOf(error);
  }
}

export const touch = () => asked({}, () => t("touch.done", { z: shownHeight() }));
export const forget = () => asked({ forget: true }, () => t("touch.forgotten"));
export const shownHeight = (): string => (height.value === null ? "–" : `z ${height.value.toFixed(2)} mm`);

/** Knows the height under the shown arm until what this gives back is called. */
export function follow(): () => void {
  // A refusal is of the arm as it was: another one, or one that has been homed since, is asked anew.
  const forgets = effect(() => {
    void store.armName.value;
    void store.isHomed.value;
    problem.value = null;
  });
  const asks = effect(() => {
    const arm = store.armName.value;
    height.value = null;
    if (arm === null || store.socket.value !== "up") return;
    call("surface.get", { arm }).then(
      (known) => store.armName.value === arm && take(known),
      () => {},
    );
  });
  return () => {
    forgets();
    asks();
  };
}
