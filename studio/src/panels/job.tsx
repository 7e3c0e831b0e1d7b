// The job of the arm: how far it is, and what can be done to it.

import type { Remedy } from "../actions";
import type { Job } from "../api";
import { sentence, t } from "../i18n";
import { clock } from "../log";
import * as jobs from "../run/jobs";
import { noteOf } from "../run/words";
import * as store from "../store";
import { Card, Do, Heads, Why } from "../ui/parts";
import { Remedies } from "./remedies";

const stateOf = (job: Job) => t(`job.${job.state}` as "job.running");

/** What it is at, in numbers. */
function facts(job: Job): string {
  const others = jobs.startedBy(job);
  const loops = job.loops !== 1 ? t("job.loop", { loop: job.loop, loops: job.loops || "∞" }) : null;
  const steps = job.steps === null ? null : t("job.step", { step: job.step, steps: job.steps });
  return [steps, loops, others === null ? null : t("job.by", { name: others })]
    .filter((fact) => fact !== null)
    .join(" · ");
}

export function JobCard() {
  const job = jobs.job.value;
  const why = jobs.why.value;
  const off = why !== null;
  if (job === null) return null;
  const pauses = ["checking", "running", "pausing"].includes(job.state);
  const percent = jobs.percent(job);
  const badge = (
    <span class={`badge job-${job.state}`} role="status">
      {stateOf(job)}
    </span>
  );
  return (
    <Card title={job.title || t("job.untitled")} class="job-card" more={badge}>
      <div
        class="progress"
        role="progressbar"
        aria-label={t("run.progress")}
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuenow={percent === null ? undefined : Math.floor(percent)}
        data-testid="run-progress"
      >
        <span style={{ width: `${percent ?? 0}%` }} />
      </div>
      <div class="job-do">
        <p class="job-facts number">
          <span>{facts(job)}</span>{" "}
          <span data-testid="run-left">
            {jobs.isUnderWay(job) && job.seconds_left !== null
              ? t("run.left", { time: jobs.duration(job.seconds_left) })
              : ""}
          </span>
        </p>
        <div class="buttons-row">
          {pauses ? (
            <Do
              id="run-pause"
              off={off || job.state === "pausing"}
              why="job-why"
              text={t("run.pause")}
              press={() => jobs.pause(job)}
            />
          ) : null}
          {jobs.canResume(job) ? (
            <Do
              id="run-resume"
              class={job.state === "paused" ? "primary" : ""}
              off={off}
              why="job-why"
              text={t("run.resume")}
              press={() => jobs.resume(job)}
            />
          ) : null}
          {jobs.isUnderWay(job) ? (
            <Do id="run-stop" off={!store.isUp.value} text={t("run.stop")} press={() => jobs.end(job)} />
          ) : null}
        </div>
      </div>
      {job.reason === "part" || job.reason === "program" ? (
        <p class="hint">{job.text ?? t(`job.reason.${job.reason}`)}</p>
      ) : null}
      {job.error !== null ? (
        <p class="hint bad">{job.error.template ? sentence(job.error) : job.error.message}</p>
      ) : null}
      {job.error !== null ? <Remedies of={(job.error as { remedies?: Remedy[] }).remedies ?? []} /> : null}
      {(job.notes ?? []).map((note) => (
        <p class="hint" key={note.text}>
          {noteOf(note)}
        </p>
      ))}
      <Why id="job-why" text={off && (pauses || jobs.canResume(job)) ? t(why) : null} />
    </Card>
  );
}

/** What ran before, the newest first. */
export function PastJobs() {
  const past = jobs.jobs.value.filter((job) => !jobs.isUnderWay(job) && job !== jobs.job.value).toReversed();
  const off = jobs.why.value !== null || jobs.busy.value;
  if (past.length === 0) return null;
  return (
    <Card title={t("jobs.title")} class="past-jobs">
      <table>
        <Heads names={[t("jobs.name"), t("jobs.state"), t("jobs.ended"), t("run.resume")]} unseen={[t("run.resume")]} />
        <tbody>
          {past.slice(0, 10).map((job) => (
            <tr key={job.job}>
              <th scope="row">{job.title || t("job.untitled")}</th>
              <td>{stateOf(job)}</td>
              <td class="number">{job.ended === null ? "–" : clock(new Date(job.ended * 1000))}</td>
              <td>
                {jobs.canResume(job) ? (
                  <Do
                    id={`resume-${job.job}`}
                    class="small"
                    off={off}
                    label={`${t("run.resume")}: ${job.title ?? ""}`}
                    press={() => jobs.resume(job)}
                  >
                    {t("run.resume")}
                  </Do>
                ) : null}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </Card>
  );
}
