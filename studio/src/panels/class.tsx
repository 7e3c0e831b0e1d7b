// The class at the arms of the station: the queue for turns, and what a teacher does for all.
import { tried } from "../actions";
import { mine, turns } from "../class";
import { t } from "../i18n";
import { save } from "../log";
import { call, files } from "../session";
import { chosen } from "../site";
import * as store from "../store";
import { Card, Do } from "../ui/parts";

/** The arms that are chosen, or all. */
const arms = () => (chosen.value.size > 0 ? { arms: [...chosen.value] } : {});

async function results(): Promise<void> {
  const { url, headers } = files() ?? { url: "programs/", headers: {} };
  const answer = await fetch(url.replace("programs/", "class/results.html"), { headers });
  if (!answer.ok) throw new Error(await answer.text());
  save("results.html", await answer.text(), "text/html");
}

export function Class() {
  if (turns.value === null) return null;
  const { queue } = turns.value;
  const buttons = store.pupil.value !== null ? (
    <Do id="turn" class="primary" text={t(mine.value === null ? "class.join" : "class.leave")} press={() => tried(() => call(mine.value === null ? "turn.join" : "turn.leave", {}))} />
  ) : store.role.value === "teacher" ? (
    <>
      <Do id="class-freeze" class="stop-all" text={t("class.freeze")} press={() => tried(() => call("class.freeze", arms()))} />
      <Do id="class-free" text={t("class.free")} press={() => tried(() => call("class.free", arms()))} />
      <Do id="class-results" class="quiet" text={t("class.results")} press={() => tried(results)} />
    </>
  ) : null;
  return (
    <Card title={t("class.title")} class="arms" more={<div class="buttons-row">{buttons}</div>}>
      <p class="hint" role="status" data-testid="class-mine">{mine.value ?? t(queue.length === 0 ? "class.nobody" : "class.waits", { n: queue.length })}</p>
      <ol class="class-queue" aria-label={t("class.queue")}>
        {queue.map(({ place, person, arms, missed }) => (
          <li key={place} class={missed ? "missed" : ""}>{person} <small>{arms.join(", ")}</small></li>
        ))}
      </ol>
    </Card>
  );
}
