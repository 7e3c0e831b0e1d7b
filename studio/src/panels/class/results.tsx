// Results of the class, as pictures from the station.
import { effect, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt } from "../../actions";
import type { Result, StationNotification } from "../../client";
import { t } from "../../i18n";
import { save } from "../../log";
import { call, fileEndpoint, notificationListeners } from "../../session";
import * as store from "../../store";
import { Button, Card } from "../../ui/parts";
import { w } from "./words";

/** Largest number of retries for a result without a picture, and the pause between them, ms. */
const MAX_RETRIES = 5;
const RETRY_DELAY = 1000;

async function saveResults(): Promise<void> {
  const { url, headers } = fileEndpoint() ?? { url: "programs/", headers: {} };
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
          if (looks > 1 && told.results.at(-1)?.svg === "") timer = setTimeout(() => read(looks - 1), RETRY_DELAY);
        },
        () => {},
      );
    };
    const hear = (...[method, params]: StationNotification) => {
      if (method === "job.changed" && params.job.state === "done") read(MAX_RETRIES);
    };
    const end = effect(() => void (store.socket.value === "up" && read(MAX_RETRIES)));
    notificationListeners.add(hear);
    return () => {
      notificationListeners.delete(hear);
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
      more={
        <Button id="class-results" class="quiet small" text={t("class.results")} press={() => attempt(saveResults)} />
      }
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
