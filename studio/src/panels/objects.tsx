// Objects around a virtual arm: go to one, pick it up, put it on another, without typing numbers.
import { useEffect } from "preact/hooks";
import { attempt } from "../actions";
import { t } from "../i18n";
import { call, shownArm } from "../session";
import * as store from "../store";
import { toolWait } from "../teach/actions";
import { CLEARANCE, gripOf, gripPosition, heldAfter, pickRows, placeRows, type WorldObject } from "../teach/objects";
import * as program from "../teach/rows";
import { w } from "../teach/words";
import { Button, Card } from "../ui/parts";
import "./objects.css";
import { watchWorld, world } from "../view/world";

const ROW_NAMES = {
  above: (name: string) => w("objects.above", { name }),
  on: (name: string) => w("objects.on", { name }),
};
const toolRotation = () => store.state.value?.r ?? 0;

/** Moves the arm above an object or onto it, clear of everything in between. */
export function goTo(thing: WorldObject, above: boolean): Promise<void> {
  const [x, y, z] = gripPosition(thing, gripOf(store.state.value?.tool.name) ?? "suction");
  const to = (z: number) => [x, y, z, toolRotation()];
  return attempt(async () => {
    await call("arm.move", { ...shownArm(), to: to(z + CLEARANCE), by: "joint" });
    if (!above) await call("arm.move", { ...shownArm(), to: to(z), by: "linear" });
  });
}

/** Buttons for both. */
export function GoTo({ thing, off, why }: { thing: WorldObject; off: boolean; why: string }) {
  const { name } = thing;
  return (
    <>
      <Button
        id={`goto-above-${name}`}
        class="small"
        off={off}
        why={why}
        label={w("objects.goAboveOf", { name })}
        text={w("objects.goAbove")}
        press={() => goTo(thing, true)}
      />
      <Button
        id={`goto-on-${name}`}
        class="small"
        off={off}
        why={why}
        label={w("objects.goOnOf", { name })}
        text={w("objects.goOn")}
        press={() => goTo(thing, false)}
      />
    </>
  );
}

function ObjectRow({ thing, held, off }: { thing: WorldObject; held: WorldObject | null; off: boolean }) {
  const { name, color } = thing;
  const grip = gripOf(store.state.value?.tool.name);
  const tool = () => ({ tool: store.state.value?.tool.name ?? null });
  const add = (rows: program.Row[]) =>
    program.insert(rows, program.rows.value.length === 0 && program.taught.value.tool === null ? tool() : {});
  return (
    <li data-testid={`object-${name}`}>
      <span class="swatch" style={{ background: color }} />
      <b>{name}</b>
      <span class="object-do">
        <Button
          id={`pick-${name}`}
          class={held === null ? "primary small" : "small"}
          off={grip === null || held !== null}
          why={grip === null ? "objects-tool" : "objects-held"}
          label={w("objects.pickOf", { name })}
          text={w("objects.pick")}
          press={() => grip && add(pickRows(thing, grip, toolWait.value, toolRotation(), ROW_NAMES))}
        />
        <Button
          id={`put-${name}`}
          class={held === null || held.name === name ? "small" : "primary small"}
          off={grip === null || held === null || held.name === name}
          why={grip === null ? "objects-tool" : "objects-empty"}
          label={w("objects.putOf", { name })}
          text={w("objects.put")}
          press={() => grip && held && add(placeRows(thing, held, grip, toolWait.value, toolRotation(), ROW_NAMES))}
        />
        <GoTo thing={thing} off={off} why="teach-why" />
      </span>
    </li>
  );
}

export function Objects() {
  useEffect(watchWorld, []);
  const things = world.value?.objects ?? [];
  if (things.length === 0 || store.arm.value?.virtual !== true) return null;
  const held = heldAfter(program.rows.value, program.selected.value, things);
  const grip = gripOf(store.state.value?.tool.name);
  return (
    <Card title={w("objects.title")} class="objects-card" group>
      <p
        class="hint"
        id={grip === null ? "objects-tool" : held === null ? "objects-empty" : "objects-held"}
        role="status"
      >
        {grip === null
          ? w("objects.tool")
          : held === null
            ? w("objects.empty")
            : w("objects.held", { name: held.name })}
      </p>
      <ul class="things">
        {things.map((thing) => (
          <ObjectRow key={thing.name} thing={thing} held={held} off={store.why.value !== null} />
        ))}
      </ul>
      <span class="unseen">{store.why.value === null ? "" : t(store.why.value)}</span>
    </Card>
  );
}
