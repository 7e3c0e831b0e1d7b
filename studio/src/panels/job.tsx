// Finished jobs.

import type { Job } from "../api";
import { wallTime } from "../clock";
import { t } from "../i18n";
import { clock } from "../log";
import * as jobs from "../run/jobs";
import * as strip from "../run/strip";
import { Card, Do, Heads } from "../ui/parts";

const stateOf = (job: Job) => t(`job.${job.state}` as "job.running");

/** Earlier jobs, newest first. */
export function PastJobs() {
  const past = jobs.jobs.value.filter((job) => !jobs.isUnderWay(job) && job !== strip.told.value).toReversed();
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
              <td class="number">{job.ended === null ? "–" : clock(wallTime(job.ended))}</td>
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
