// Pupils of the class: present, with an arm, waiting, absent.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt } from "../../actions";
import { turns } from "../../class";
import { t } from "../../i18n";
import { call } from "../../session";
import * as store from "../../store";
import { Button, Card, ColumnHeads } from "../../ui/parts";
import { whyWaits } from "./reasons";
import { type Roll, readRoll, roll, watchRoll } from "./roll";
import { slips } from "./slips";
import { w } from "./words";

type Pupil = Roll["pupils"][number];

function statusOf({ name, here, place, arm }: Pupil): { text: string; is: "arm" | "waits" | "here" | "missing" } {
  if (arm) return { text: w("pupils.arm", { arm }), is: "arm" };
  const inQueue = turns.value?.queue.find(({ person }) => person === name);
  const why = inQueue === undefined ? null : whyWaits(inQueue);
  if (place != null) return { text: `${t("class.place", { n: place })}${why === null ? "" : `. ${why}`}`, is: "waits" };
  if (here === undefined) return { text: "", is: "missing" };
  return here ? { text: w("pupils.here"), is: "here" } : { text: w("pupils.missing"), is: "missing" };
}

async function renewCode({ name, here }: Pupil): Promise<void> {
  if (here && !(await store.ask(w("pupils.renew.title", { name }), w("pupils.renew.text"), w("pupils.renew")))) return;
  await call("class.codes", { pupils: [name] });
  await readRoll();
}

export function Pupils() {
  useEffect(watchRoll, []);
  // Codes are hidden at first, because the page may be projected.
  const shows = useSignal(false);
  const pupils = roll.value?.pupils ?? [];
  const more = (
    <div class="buttons-row">
      <Button
        id="class-codes"
        class="quiet small"
        aria-pressed={shows.value}
        text={w(shows.value ? "pupils.hide" : "pupils.show")}
        press={() => (shows.value = !shows.value)}
      />
      <Button id="class-slips" class="small" text={w("pupils.slips")} press={() => (slips.value = pupils)} />
    </div>
  );
  return (
    <Card title={w("pupils.title")} class="arms" more={more}>
      <table data-testid="class-pupils" class="pupils">
        <ColumnHeads
          names={[w("pupils.name"), w("pupils.status"), w("door.code"), w("pupils.do")]}
          unseen={[w("pupils.do")]}
        />
        <tbody>
          {pupils.map((pupil) => {
            const { text, is } = statusOf(pupil);
            return (
              <tr key={pupil.name} class={is}>
                <th scope="row">{pupil.name}</th>
                <td data-testid={`pupil-${pupil.name}`}>
                  <span class={`dot ${is}`} aria-hidden="true" />
                  {text}
                </td>
                <td>
                  {shows.value ? (
                    <code>{pupil.code}</code>
                  ) : (
                    <span aria-label={w("pupils.hidden")} role="img">
                      ••••••
                    </span>
                  )}
                </td>
                <td>
                  <div class="buttons-row">
                    {pupil.place != null ? (
                      <Button
                        class="quiet small"
                        label={w("pupils.out.of", { name: pupil.name })}
                        text={w("pupils.out")}
                        press={() => attempt(() => call("turn.leave", { person: pupil.name }))}
                      />
                    ) : null}
                    <Button
                      id={`class-renew-${pupil.name}`}
                      class="quiet small"
                      label={w("pupils.renew.title", { name: pupil.name })}
                      text={w("pupils.renew")}
                      press={() => attempt(() => renewCode(pupil))}
                    />
                  </div>
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
      {shows.value && roll.value?.pin ? <p class="hint">{w("pupils.pin", { pin: roll.value.pin })}</p> : null}
    </Card>
  );
}
