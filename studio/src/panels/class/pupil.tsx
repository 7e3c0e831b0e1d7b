// A pupil's page: the arm, the place in the queue, and the workshops. Nothing of the teacher's.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt } from "../../actions";
import { isMyName, myArms, myPlace, myTurn, remainingSeconds, turns } from "../../class";
import { LANGUAGES, t } from "../../i18n";
import { formatDuration } from "../../run/jobs";
import { call, signOut } from "../../session";
import { language } from "../../settings";
import { activityText, jobs, watchSite } from "../../site";
import * as store from "../../store";
import ICONS from "../../ui/icons.json";
import { Button, Card, Pick } from "../../ui/parts";
import { reasonOf, whyWaits } from "./reasons";
import { w } from "./words";

/** Explains how a drawing continues that the end of a turn or a freeze has paused. */
function Paused() {
  const own = store.arms.value
    .flatMap(({ name }) => jobs.get(name) ?? [])
    .filter(({ state, holder }) => state === "paused" && isMyName(holder?.name ?? null));
  return (
    <div data-testid="mine-paused" role="status">
      {own.map(({ job, title, arm }) => (
        <p key={job} class="why">
          {w("pupil.paused", { title: title || w("class.untitled"), arm })}
        </p>
      ))}
    </div>
  );
}

function MyArm() {
  const turn = myTurn.value;
  const arm = store.arms.value.find(({ name }) => name === turn?.arm);
  const left = turn === null ? null : remainingSeconds(turn);
  const allFrozen = turns.value?.arms.every(({ frozen }) => frozen) === true;
  return (
    <Card title={w("pupil.arm")} class="pupil-card">
      <div data-testid="mine-arm" role="status">
        {turn === null || arm === undefined ? (
          <p class={allFrozen ? "why" : "hint"}>{w(allFrozen ? "class.wait.frozen" : "pupil.noArm")}</p>
        ) : (
          <>
            <p class="big">{turn.arm}</p>
            <p class={turn.frozen ? "why" : ""}>{turn.frozen ? w("class.wait.frozen") : activityText(arm)}</p>
            {left === null ? null : (
              <p class={`left ${left <= 60 ? "soon" : ""}`}>{w("pupil.left", { left: formatDuration(left) })}</p>
            )}
          </>
        )}
      </div>
      <Paused />
      {turn === null ? null : (
        <Button id="turn" text={w("pupil.done")} press={() => attempt(() => call("turn.leave", {}))} />
      )}
    </Card>
  );
}

function MyPlace() {
  const any = "";
  const wish = useSignal(any);
  const place = myPlace.value;
  const jobs = (turns.value?.arms ?? []).flatMap(({ arm, jobs = [] }) =>
    jobs.filter(({ person }) => isMyName(person)).map((job) => ({ ...job, arm })),
  );
  const join = () => attempt(() => call("turn.join", wish.value === any ? {} : { arm: wish.value }));
  const arms = myArms.value;
  const why = place === null ? null : whyWaits(place);
  return (
    <Card title={w("pupil.place")} class={`pupil-card ${myTurn.value === null ? "" : "later"}`}>
      <div data-testid="mine-place" role="status">
        {place === null ? (
          <p class="hint">{w(myTurn.value === null ? "pupil.noPlace" : "pupil.isTurn")}</p>
        ) : (
          <>
            <p class="big">{t("class.place", { n: place.place })}</p>
            <p>{place.arms.length === arms.length ? w("pupil.anyArm") : place.arms.join(", ")}</p>
            {why === null ? null : <p class="why">{why}</p>}
          </>
        )}
      </div>
      {place !== null ? (
        <Button id="turn" text={t("class.leave")} press={() => attempt(() => call("turn.leave", {}))} />
      ) : myTurn.value !== null ? null : (
        <div class="join">
          {arms.length > 1 ? (
            <Pick
              id="join-arm"
              label={w("pupil.which")}
              value={wish.value}
              options={[{ value: any, text: w("pupil.anyArm") }, ...arms]}
              choose={(arm) => (wish.value = arm)}
            />
          ) : null}
          <Button id="turn" class="primary" text={t("class.join")} press={join} />
        </div>
      )}
      {jobs.map(({ job, title, arm, reason }) => (
        <p key={job} class="hint">
          {w("class.job", { title: title || w("class.untitled"), arm })} {reasonOf(reason)}
        </p>
      ))}
    </Card>
  );
}

export function PupilPage() {
  useEffect(watchSite, []);
  // The banner says that the page was closed; arm and place would be outdated.
  if (store.socket.value === "closed") return null;
  const workshops = store.routes.value.filter((route) => ["draw", "teach", "run", "move"].includes(route));
  return (
    <>
      <Card
        title={store.ownerName.value}
        class="arms pupil"
        more={
          store.pupil.value === null ? null : (
            <Button id="class-signout" class="quiet small" text={w("pupil.signout")} press={leaveClass} />
          )
        }
      >
        {null}
      </Card>
      <MyArm />
      <MyPlace />
      <section class="arms">
        <nav class="workshops" aria-label={w("pupil.workshops")}>
          {workshops.map((route) => (
            <a key={route} href={`#/${route}`}>
              <svg viewBox="0 0 24 24" aria-hidden="true">
                <path d={ICONS[route]} />
              </svg>
              <span>{t(`nav.${route}`)}</span>
            </a>
          ))}
        </nav>
      </section>
      <p class="arms pupil-language">
        <Pick
          id="pupil-language"
          label={t("settings.language")}
          value={language.value}
          options={LANGUAGES}
          choose={(value) => (language.value = value)}
        />
      </p>
    </>
  );
}

/** Signs out and ends the turn at once, without the grace time for absent pupils. */
async function leaveClass(): Promise<void> {
  if (myTurn.value !== null || myPlace.value !== null) await call("turn.leave", {}).catch(() => {});
  signOut();
}
