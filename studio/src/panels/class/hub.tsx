// Class at a hub: pupils, turns and codes are managed at the pages of the stations.
import { useEffect } from "preact/hooks";
import * as store from "../../store";
import { Card } from "../../ui/parts";
import { roll, watchRoll } from "./roll";
import { w } from "./words";

/** Description of the place where pupils sign in. */
export const signInPlace = (machines: readonly unknown[]): string =>
  machines.length > 0 ? w("hub.machines", { machines: machines.join(", ") }) : w("hub.place");

export function StationsCard() {
  useEffect(watchRoll, []);
  const machines = [...new Set(store.arms.value.flatMap(({ machine }) => machine ?? []))].sort();
  const missing = roll.value?.missing ?? [];
  const differ = (roll.value?.differ ?? []).flatMap(({ arms }) => arms);
  return (
    <Card title={w("pupils.title")} class="arms">
      <p class="hint" data-testid="class-stations">
        {signInPlace(machines)}
      </p>
      {missing.length > 0 ? (
        <p class="hint bad" role="status" data-testid="class-missing">
          {w("hub.missing", { arms: missing.join(", ") })}
        </p>
      ) : null}
      {differ.length > 0 ? (
        <p class="hint bad" role="status" data-testid="class-differ">
          {w("hub.differ", { arms: differ.join(", ") })}
        </p>
      ) : null}
    </Card>
  );
}
