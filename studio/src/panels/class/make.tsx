// A class made in the page: its pupils, arms and the length of a turn; changed and ended there, too.
import { useSignal } from "@preact/signals";
import { tried } from "../../actions";
import { hasClass } from "../../class";
import { isPin } from "../../pairing";
import { call, keepTeaching, keptToken, signOut } from "../../session";
import { toggled } from "../../settings";
import * as store from "../../store";
import { Card, Do, Field, NumberInput } from "../../ui/parts";
import { type Roll, read, roll } from "./roll";
import { w } from "./words";

/** Length of a turn that a new class has, minutes. */
const TURN = 5;

const listed = (text: string): string[] =>
  text
    .split(/[\n,;\t]+/)
    .map((name) => name.trim().replace(/\s+/g, " "))
    .filter((name) => name !== "");
/** Names as people paste them: one a line, or in a row with commas; each once. */
export const namesOf = (text: string): string[] => [...new Set(listed(text))];

/** A name that stands there more than once: the station takes both for one pupil, whichever letters are large. */
export const repeatedIn = (text: string): string | undefined => {
  const names = listed(text).map((name) => name.toLowerCase());
  return listed(text).find((name, nth) => names.indexOf(name.toLowerCase()) < nth);
};

/** The arms that pupils of a class may have; none are named where they may have all. */
const armsOf = (now: Roll | null): string[] =>
  now?.class?.arms.length ? now.class.arms : store.arms.value.map(({ name }) => name);

/** How far the clock of this browser is from UTC, such as `+01:00`. */
function offsetNow(): string {
  const minutes = -new Date().getTimezoneOffset();
  const two = (n: number) => String(Math.trunc(Math.abs(n))).padStart(2, "0");
  return `${minutes < 0 ? "-" : "+"}${two(minutes / 60)}:${two(minutes % 60)}`;
}

function Form({ now, done }: { now: Roll | null; done: () => void }) {
  const names = useSignal((now?.pupils ?? []).map(({ name }) => name).join("\n"));
  const arms = useSignal<ReadonlySet<string>>(new Set(armsOf(now)));
  const minutes = useSignal(now?.class ? now.class.turn_s / 60 : TURN);
  const all = store.arms.value.map(({ name }) => name);
  const given = namesOf(names.value);
  const long = given.find((name) => name.length > 40);
  const twice = repeatedIn(names.value);
  const off = given.length === 0 || long !== undefined || twice !== undefined || arms.value.size === 0;
  const whyNot = () => {
    if (long !== undefined) return w("make.long", { name: long });
    if (twice !== undefined) return w("make.twice", { name: twice });
    return arms.value.size === 0 ? w("make.noArms") : null;
  };
  const why = whyNot();
  const make = () =>
    tried(async () => {
      const loses = now?.pupils.some(({ group }) => group !== null);
      if (loses && !(await store.ask(w("make.change"), w("make.loses"), w("make.change")))) return;
      const some = all.filter((name) => arms.value.has(name));
      const { pin } = await call("class.set", {
        names: given,
        turn_s: Math.round(minutes.value * 60),
        offset: offsetNow(),
        ...(some.length === all.length ? {} : { arms: some }),
      });
      keepTeaching(pin);
      void read();
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
              onChange={(event) => (arms.value = toggled(arms.value, name, event.currentTarget.checked))}
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
        <Do
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

async function end(): Promise<void> {
  if (!(await store.ask(w("make.end"), w("make.end.text"), w("make.end")))) return;
  await call("class.set", { text: "" });
  await read();
  // Without a class this computer's people are teachers again, and there is no PIN that could be tried.
  if (isPin(keptToken())) signOut();
}

export function Make() {
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
      <Do
        id="class-change"
        class="quiet small"
        aria-expanded={isOpen.value}
        text={w("make.change")}
        press={() => (isOpen.value = !isOpen.value)}
      />
      <Do id="class-end" class="quiet small" text={w("make.end")} press={() => tried(end)} />
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
