// Finished jobs.

import type { Job } from "../api";
import { wallTime } from "../clock";
import { t } from "../i18n";
import { clock } from "../log";
import { jobBurns } from "../run/burn";
import * as jobs from "../run/jobs";
import * as strip from "../run/strip";
import { Button, Card, ColumnHeads, Reason } from "../ui/parts";
import { ArmLaser } from "./armlaser";

const stateText = (job: Job) => t(`job.${job.state}` as "job.running");

/** Earlier jobs, newest first. */
export function PastJobs() {
  const past = jobs.jobs.value.filter((job) => !jobs.isActive(job) && job !== strip.shownJob.value).toReversed();
  const whyNot = (job: Job) => (jobs.busy.value ? "why.busy.job" : jobs.whyNotResume(job));
  if (past.length === 0) return null;
  const listed = past.slice(0, 10);
  const resumed = listed.filter(jobs.canResume);
  const reason = resumed.map(whyNot).find((one) => one !== null);
  return (
    <Card title={t("jobs.title")} class="past-jobs">
      <table>
        <ColumnHeads
          names={[t("jobs.name"), t("jobs.state"), t("jobs.ended"), t("run.resume")]}
          unseen={[t("run.resume")]}
        />
        <tbody>
          {listed.map((job) => (
            <tr key={job.job}>
              <th scope="row">{job.title || t("job.untitled")}</th>
              <td>{stateText(job)}</td>
              <td class="number">{job.ended === null ? "–" : clock(wallTime(job.ended))}</td>
              <td>
                {jobs.canResume(job) ? (
                  <Button
                    id={`resume-${job.job}`}
                    class="small"
                    off={whyNot(job) !== null}
                    why="resume-why"
                    label={`${t(jobs.continuation(job).key)}: ${job.title ?? ""}`}
                    press={() => jobs.continuation(job).press()}
                  >
                    {t(jobs.continuation(job).key)}
                  </Button>
                ) : null}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      <ArmLaser id="resume-laser-arm" burns={resumed.some(jobBurns)} why="resume-why" />
      <Reason id="resume-why" text={reason === undefined ? null : t(reason)} />
    </Card>
  );
}
