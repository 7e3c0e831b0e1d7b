// Form for a class: its pupils, arms and the length of a turn. Also changes and ends it.
import { useSignal } from "@preact/signals";
import { attempt } from "../../actions";
import { hasClass } from "../../class";
import { isPin } from "../../pairing";
import { call, keepTeaching, keptToken, signOut } from "../../session";
import { withMember } from "../../settings";
import * as store from "../../store";
import { Button, Card, Field, NumberInput } from "../../ui/parts";
import { type Roll, readRoll, roll } from "./roll";
import { w } from "./words";

/** Default length of a turn, minutes. */
const DEFAULT_TURN_MINUTES = 5;

const splitNames = (text: string): string[] =>
  text
    .split(/[\n,;\t]+/)
    .map((name) => name.trim().replace(/\s+/g, " "))
    .filter((name) => name !== "");
/** Names from pasted text, one per line or separated by commas, without duplicates. */
export const parseNames = (text: string): string[] => [...new Set(splitNames(text))];

/** A name that stands there more than once: the station takes both for one pupil, whichever letters are large. */
export const duplicateName = (text: string): string | undefined => {
  const names = splitNames(text).map((name) => name.toLowerCase());
  return splitNames(text).find((name, nth) => names.indexOf(name.toLowerCase()) < nth);
};

/** Arms that pupils of the class may use; if the class names none, all of the station. */
const armsOfClass = (now: Roll | null): string[] =>
  now?.class?.arms.length ? now.class.arms : store.arms.value.map(({ name }) => name);

/** Offset of this browser's clock from UTC, such as `+01:00`. */
function utcOffset(): string {
  const minutes = -new Date().getTimezoneOffset();
  const two = (n: number) => String(Math.trunc(Math.abs(n))).padStart(2, "0");
  return `${minutes < 0 ? "-" : "+"}${two(minutes / 60)}:${two(minutes % 60)}`;
}

function Form({ now, done }: { now: Roll | null; done: () => void }) {
  const names = useSignal((now?.pupils ?? []).map(({ name }) => name).join("\n"));
  const arms = useSignal<ReadonlySet<string>>(new Set(armsOfClass(now)));
  const minutes = useSignal(now?.class ? now.class.turn_s / 60 : DEFAULT_TURN_MINUTES);
  const all = store.arms.value.map(({ name }) => name);
  const given = parseNames(names.value);
  const long = given.find((name) => name.length > 40);
  const twice = duplicateName(names.value);
  const off = given.length === 0 || long !== undefined || twice !== undefined || arms.value.size === 0;
  const whyNot = () => {
    if (long !== undefined) return w("make.long", { name: long });
    if (twice !== undefined) return w("make.twice", { name: twice });
    return arms.value.size === 0 ? w("make.noArms") : null;
  };
  const why = whyNot();
  const make = () =>
    attempt(async () => {
      const loses = now?.pupils.some(({ group }) => group !== null);
      if (loses && !(await store.ask(w("make.change"), w("make.loses"), w("make.change")))) return;
      const some = all.filter((name) => arms.value.has(name));
      const { pin } = await call("class.set", {
        names: given,
        turn_s: Math.round(minutes.value * 60),
        offset: utcOffset(),
        ...(some.length === all.length ? {} : { arms: some }),
      });
      keepTeaching(pin);
      void readRoll();
      done();
    });
  return (
    <div class="make">
      <Field label={w("make.names", { n: given.length })}>
        <textarea
          rows={now ? 6 : 8}
          data-testid="class-names"
          value={names.value}
          spellcheck={false}
          placeholder={"Ada\nBen\nChen Li"}
          onInput={(event) => (names.value = event.currentTarget.value)}
        />
        <small>{w(now ? "make.names.change" : "make.names.hint")}</small>
      </Field>
      <fieldset class="make-arms">
        <legend>{w("make.arms")}</legend>
        {all.map((name) => (
          <label key={name}>
            <input
              type="checkbox"
              data-testid={`class-arm-${name}`}
              checked={arms.value.has(name)}
              onChange={(event) => (arms.value = withMember(arms.value, name, event.currentTarget.checked))}
            />{" "}
            {name}
          </label>
        ))}
      </fieldset>
      <Field label={w("make.turn")} unit="min" class="make-turn">
        <NumberInput
          id="class-turn"
          label={w("make.turn")}
          value={minutes.value}
          step={1}
          least={0}
          most={240}
          set={(to) => (minutes.value = Math.min(240, Math.max(0, to)))}
        />
        <small>{w("make.turn.hint")}</small>
      </Field>
      <div class="buttons-row">
        <Button
          id="class-make"
          class="primary"
          off={off}
          why="make-why"
          text={w(now ? "make.change" : "make.make")}
          press={make}
        />
        {why === null ? null : (
          <p id="make-why" class="hint bad">
            {why}
          </p>
        )}
      </div>
    </div>
  );
}

async function endClass(): Promise<void> {
  if (!(await store.ask(w("make.end"), w("make.end.text"), w("make.end")))) return;
  await call("class.set", { text: "" });
  await readRoll();
  // Without a class, users of this computer are teachers again, and the PIN is no longer valid.
  if (isPin(keptToken())) signOut();
}

export function ClassEditor() {
  const isOpen = useSignal(false);
  const now = roll.value;
  if (!hasClass.value) {
    return (
      <Card title={w("make.title")} class="arms">
        <p class="hint">{w("make.text")}</p>
        <Form now={null} done={() => {}} />
      </Card>
    );
  }
  if (now === null) return null;
  const more = (
    <div class="buttons-row">
      <Button
        id="class-change"
        class="quiet small"
        aria-expanded={isOpen.value}
        text={w("make.change")}
        press={() => (isOpen.value = !isOpen.value)}
      />
      <Button id="class-end" class="quiet small" text={w("make.end")} press={() => attempt(endClass)} />
    </div>
  );
  return (
    <Card title={w("make.now")} class="arms" more={more}>
      {isOpen.value ? (
        <Form now={now} done={() => (isOpen.value = false)} />
      ) : (
        <p class="hint">{w("make.is", { n: now.pupils.length, minutes: (now.class?.turn_s ?? 0) / 60 })}</p>
      )}
    </Card>
  );
}
