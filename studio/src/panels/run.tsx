// Programs: open, preview before anything moves, run, pause, resume.
import { signal } from "@preact/signals";
import { attempt } from "../actions";
import { t } from "../i18n";
import { mayBurn } from "../run/burn";
import * as check from "../run/check";
import * as jobs from "../run/jobs";
import * as library from "../run/programs";
import * as store from "../store";
import { Button, Card, Reason, Repetitions } from "../ui/parts";
import { ArmView } from "../view/view";
import { sentencesOf } from "../words";
import { ArmLaser } from "./armlaser";
import { PastJobs } from "./job";
import { Pose } from "./pose";
import { formatOf, formatSize, Programs } from "./programs";
import texts from "./programs.json";
import { CheckResult, NoToolWarning, Options, Picture, summaryText, usePrograms } from "./setup";
import { Height } from "./touch";

const w = sentencesOf(texts);

const loops = signal(1);
/** Formats whose points can be changed where points are taught. */
const TEACHABLE_FORMATS = ["plan", "playback"];

const openInTeach = (program: library.Entry) =>
  attempt(async () => {
    const content = await library.fetchProgram(program);
    const { open } = await import("../teach/actions");
    location.hash = "#/teach";
    await open(new File([content], program.name));
  });

function Selected() {
  const program = check.entry.value;
  if (program === null) return null;
  const setup = check.setup.value;
  const reason = jobs.whyNotStart(setup);
  const start = () =>
    check.runWorkshop.start(program.name, () => summaryText(check.report.value), { loops: loops.value });
  const isShown = check.isPreviewed.value;
  const look = () => {
    if (isShown) check.runWorkshop.showPreview(null);
    else if (check.report.value?.preview) check.runWorkshop.showPreview(check.report.value);
    else void check.check();
  };
  return (
    <Card title={program.name} class="selected">
      <div class="file-facts">
        <p class="hint">
          {formatOf(program.format)} · {formatSize(program.bytes)}
        </p>
        <Picture key={program.name} program={program} />
      </div>
      <Options />
      <CheckResult />
      <div class="buttons-row">
        <Button
          id="run-start"
          class="primary"
          off={reason !== null || program.format === null}
          why="start-why"
          text={t("run.start")}
          press={start}
        />
        <Button
          id="run-check"
          off={!store.isUp.value || program.format === null}
          text={t("run.check")}
          press={check.check}
        />
        <button
          type="button"
          data-testid="run-preview"
          data-shown={isShown}
          aria-pressed={isShown}
          disabled={!store.isUp.value}
          onClick={look}
        >
          {t("run.preview")}
        </button>
        {TEACHABLE_FORMATS.includes(program.format ?? "") ? (
          <Button
            id="run-teach"
            off={!store.isUp.value}
            text={w("programs.teach")}
            press={() => openInTeach(program)}
          />
        ) : null}
        <Repetitions id="run-loops" label={t("run.times")} hint={t("run.times.hint")} value={loops} />
      </div>
      <ArmLaser id="run-laser-arm" burns={mayBurn(setup)} why="start-why" />
      <Reason id="start-why" text={reason === null ? null : t(reason)} />
      <NoToolWarning />
    </Card>
  );
}

export function Run() {
  usePrograms();
  return (
    <div class="move run">
      <div class="move-look">
        <ArmView />
        <Pose />
      </div>
      <div class="move-do" aria-label={t("nav.run")} role="group">
        <Programs />
        <Selected />
        <Height />
        <PastJobs />
      </div>
    </div>
  );
}
