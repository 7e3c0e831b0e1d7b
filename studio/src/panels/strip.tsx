// Strip below the header on every route: the arm's job, whoever started it.
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import type { Remedy } from "../actions";
import type { Job } from "../api";
import { sentence, t } from "../i18n";
import { jobBurns, jobFrames } from "../run/burn";
import * as jobs from "../run/jobs";
import { watchArmed } from "../run/laser";
import * as strip from "../run/strip";
import { w } from "../run/strip.words";
import { plainNoteText } from "../run/words";
import * as store from "../store";
import { Button } from "../ui/parts";
import { ArmLaser } from "./armlaser";
import { Remedies } from "./remedies";
import "./strip.css";

/** True if the job was last known to be running and the arm is not heard now. */
const isOutOfContact = (job: Job): boolean => !store.isUp.value && jobs.isActive(job);

/** Describes what an unreachable arm may still be doing. */
function lastActivityText(): string {
  const left = store.lastActivity.value;
  return left === null ? t("why.lost") : `${t(left.laser ? "left.laser" : "left.moves")} ${t("left.switch")}`;
}

/** Progress of the job, or how it ended. */
function progressText(job: Job): string {
  if (isOutOfContact(job)) return w("strip.unheard", { state: factsText(job) });
  return factsText(job);
}
function factsText(job: Job): string {
  const percent = jobs.percentDone(job);
  const shown = percent === null ? null : `${Math.floor(percent)} %`;
  if (!jobs.isActive(job)) {
    const seconds = strip.durationOf(job);
    if (job.state === "done" && seconds !== null) return w("strip.done", { time: jobs.formatDuration(seconds) });
    const state = t(`job.${job.state}` as "job.stopped");
    return shown === null || job.state === "done" ? state : w("strip.ended", { state, percent: shown });
  }
  const all = [
    job.state === "running" && shown !== null && !isOutOfContact(job) ? null : t(`job.${job.state}` as "job.paused"),
    shown,
    job.loops === 1 ? null : t("job.loop", { loop: job.loop, loops: job.loops || "∞" }),
  ].filter((fact) => fact !== null);
  return all.join(" · ");
}

function remainingText(job: Job): string {
  const left = jobs.isActive(job) && !isOutOfContact(job) ? jobs.secondsLeft(job) : null;
  return left === null ? "" : t("run.left", { time: jobs.formatDuration(left) });
}

/** Text below: why buttons are disabled, what the job waits for, how it failed, its notes. */
function StripText({ job, why, burns }: { job: Job; why: string | null; burns: boolean }) {
  const waits = job.reason === "part" || job.reason === "program" ? (job.text ?? t(`job.reason.${job.reason}`)) : null;
  const error = job.error;
  const isEmpty = !burns && waits === null && error === null && why === null && (job.notes ?? []).length === 0;
  return isEmpty ? null : (
    <div class="strip-more">
      {waits === null ? null : <p class="strip-words">{waits}</p>}
      {error === null ? null : (
        <div class="strip-words bad">
          <p role="alert">{error.template ? sentence(error) : error.message}</p>
          <Remedies of={(error as { remedies?: Remedy[] }).remedies ?? []} />
        </div>
      )}
      {(job.notes ?? []).map((note) => (
        <div class="strip-words" key={note.text}>
          <p data-testid={`job-note-${note.code}`}>{plainNoteText(note)}</p>
          <Remedies of={(note.remedies ?? []) as Remedy[]} />
        </div>
      ))}
      {why === null && !burns ? null : (
        <div class="strip-why">
          <p class="strip-words" id="strip-why">
            {why}
          </p>
          <ArmLaser id="strip-laser-arm" burns={burns} why="strip-why" />
        </div>
      )}
    </div>
  );
}

/** Scroll position up to which the page counts as at its top and moves with the strip, px. */
const TOP_SCROLL = 40;

/**
 * Keeps the page still when the strip appears or disappears, so that the user does not press
 * something else. Returns the function to call after layout.
 */
function holdScroll(): () => void {
  const cards = [0.6, 0.65, 0.7, 0.5].map((share) =>
    document.elementFromPoint(innerWidth * 0.7, innerHeight * share)?.closest(".card"),
  );
  const at = cards.find((card) => card && !card.matches(".view-card, .sheet-card"));
  const before = at?.getBoundingClientRect().top ?? 0;
  if (!at || scrollY < TOP_SCROLL) return () => {};
  // The browser's scroll anchoring would add the same correction again.
  const { style } = document.documentElement;
  style.overflowAnchor = "none";
  requestAnimationFrame(() => requestAnimationFrame(() => (style.overflowAnchor = "")));
  return () => {
    const by = at.getBoundingClientRect().top - before;
    if (Math.abs(by) > 1) scrollBy(0, by);
  };
}

/** Publishes the heights of header and strip for elements that stick below them. */
function publishHeights(strip: HTMLElement | null): () => void {
  const header = document.querySelector("header");
  const root = document.documentElement;
  if (!header || !strip) return () => {};
  const measure = () => {
    root.style.setProperty("--bar", `${header.offsetHeight}px`);
    root.style.setProperty("--strip", `${strip.offsetHeight}px`);
  };
  const look = new ResizeObserver(measure);
  look.observe(header);
  look.observe(strip);
  measure();
  root.dataset.strip = "true";
  return () => {
    look.disconnect();
    delete root.dataset.strip;
    for (const name of ["--bar", "--strip"]) root.style.removeProperty(name);
  };
}

function ShownJob({ job, stays }: { job: Job; stays: () => void }) {
  const place = useRef<HTMLElement>(null);
  useLayoutEffect(() => {
    const ends = publishHeights(place.current);
    stays();
    return ends;
  }, []);
  const isUnderWay = jobs.isActive(job);
  const pauses = ["checking", "running", "pausing"].includes(job.state);
  const resumes = jobs.canResume(job);
  const burns = resumes && jobBurns(job);
  const reason = resumes ? jobs.whyNotResume(job) : jobs.whyNoControl.value;
  const off = reason !== null;
  const percent = jobs.percentDone(job);
  const others = jobs.startedBy(job);
  const title = job.title || t("job.untitled");
  const name = jobFrames(job) ? w("strip.frame", { title }) : title;
  const arm = store.arms.value.length > 1 ? `${job.arm} · ` : "";
  return (
    <section
      ref={place}
      class={`job-strip is-${job.state}`}
      data-testid="job-strip"
      data-state={job.state}
      data-known={!isOutOfContact(job)}
      aria-label={w("strip")}
    >
      <div class="strip-what">
        <b class="strip-name" title={name}>
          {arm}
          {name}
        </b>
        <span class="strip-facts number" data-testid="job-strip-facts">
          {progressText(job)}
          {remainingText(job) === "" ? null : " · "}
          <span data-testid="run-left">{remainingText(job)}</span>
        </span>
        <span class="unseen" role="status">
          {`${name}: ${isOutOfContact(job) ? progressText(job) : t(`job.${job.state}` as "job.running")}`}
        </span>
        {others === null ? null : <span class="strip-facts">{t("job.by", { name: others })}</span>}
      </div>
      <div class="strip-do">
        {pauses || resumes ? (
          <Button
            id="job-strip-pause"
            class={job.state === "paused" && !jobs.isOfOthers(job) ? "primary" : ""}
            off={off || job.state === "pausing"}
            why="strip-why"
            press={() => (pauses ? jobs.pause(job) : jobs.continuation(job).press())}
          >
            <span data-testid={pauses ? "run-pause" : "run-resume"}>
              {t(pauses ? "run.pause" : jobs.continuation(job).key)}
            </span>
          </Button>
        ) : null}
        {isUnderWay && store.socket.value !== "closed" ? (
          <Button
            id="job-strip-stop"
            off={!store.isUp.value || job.state === "stopping"}
            press={() => void jobs.end(job)}
          >
            <span data-testid="run-stop">{w("strip.stop")}</span>
          </Button>
        ) : (
          <Button id="job-strip-close" class="quiet" label={w("strip.close")} press={() => strip.dismiss(job)}>
            <svg viewBox="0 0 24 24" aria-hidden="true">
              <path d="M6 6l12 12M18 6L6 18" />
            </svg>
          </Button>
        )}
      </div>
      <StripText
        job={job}
        burns={burns}
        why={isOutOfContact(job) ? lastActivityText() : off && (pauses || resumes) ? t(reason) : null}
      />
      <div
        class="strip-bar"
        role="progressbar"
        aria-label={t("run.progress")}
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuenow={percent === null ? undefined : Math.floor(percent)}
        data-testid="run-progress"
      >
        <span style={{ width: `${percent ?? 0}%` }} />
      </div>
    </section>
  );
}

export function JobStrip() {
  useEffect(strip.follow, []);
  useEffect(watchArmed, []);
  const job = strip.shownJob.value;
  const isThere = useRef(false);
  const isNew = isThere.current !== (job !== null);
  // Before and after the page is laid out.
  const stays = isNew ? holdScroll() : () => {};
  isThere.current = job !== null;
  useLayoutEffect(() => {
    if (isNew && job === null) stays();
  });
  return job === null ? null : <ShownJob job={job} stays={stays} />;
}
