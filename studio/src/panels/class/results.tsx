// Results of the class, as pictures from the station.
import { effect, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { tried } from "../../actions";
import type { Result, Told } from "../../client";
import { t } from "../../i18n";
import { save } from "../../log";
import { call, files, notified } from "../../session";
import * as store from "../../store";
import { Card, Do } from "../../ui/parts";
import { w } from "./words";

/** Largest number of retries for a result without a picture, and the pause between them, ms. */
const LOOKS = 5;
const AGAIN = 1000;

async function page(): Promise<void> {
  const { url, headers } = files() ?? { url: "programs/", headers: {} };
  const answer = await fetch(url.replace("programs/", "class/results.html"), { headers });
  if (!answer.ok) throw new Error(await answer.text());
  save("results.html", await answer.text(), "text/html");
}

export function Results() {
  const results = useSignal<Result<"class.results">["results"]>([]);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    // Pictures are made after the job is done, without a notification.
    const read = (looks: number) => {
      clearTimeout(timer);
      call("class.results", {}).then(
        (told) => {
          results.value = told.results;
          if (looks > 1 && told.results.at(-1)?.svg === "") timer = setTimeout(() => read(looks - 1), AGAIN);
        },
        () => {},
      );
    };
    const hear = (...[method, params]: Told) => {
      if (method === "job.changed" && params.job.state === "done") read(LOOKS);
    };
    const end = effect(() => void (store.socket.value === "up" && read(LOOKS)));
    notified.add(hear);
    return () => {
      notified.delete(hear);
      clearTimeout(timer);
      end();
    };
  }, []);
  // Newest first.
  const all = results.value.toReversed();
  return (
    <Card
      title={t("site.pictures")}
      class="arms"
      more={<Do id="class-results" class="quiet small" text={t("class.results")} press={() => tried(page)} />}
    >
      {all.length === 0 ? <p class="hint">{w("results.none")}</p> : null}
      <ul class="results" data-testid="results">
        {all.map(({ job, pupil, title, arm, svg, time_local }) => (
          <li key={job}>
            {svg === "" ? (
              <p class="hint">{w("results.noPicture")}</p>
            ) : (
              <img alt={title || w("class.untitled")} src={`data:image/svg+xml,${encodeURIComponent(svg)}`} />
            )}
            <p>
              <b>{pupil}</b> {title || w("class.untitled")}
            </p>
            <p class="hint">
              {arm} · {time_local}
            </p>
          </li>
        ))}
      </ul>
    </Card>
  );
}
