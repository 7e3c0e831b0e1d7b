// Teach: points shown to the arm or by it, in a table that can be played.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import * as jobs from "../run/jobs";
import * as store from "../store";
import * as actions from "../teach/actions";
import * as program from "../teach/rows";
import { ArmView } from "../view/view";
import { Card, Do, OpenFile, Switch, Times } from "../ui/parts";
import { JobCard } from "./job";
import { JogPad } from "./jogpad";
import { Points } from "./points";
import { Pose } from "./pose";
import { ArmCard } from "./tools";
import "./run.css";
import "./teach.css";

/** Pins that may be outputs, by their addresses. */
const PINS = 20;

const pin = signal(1);

function Add() {
  const off = store.why.value !== null;
  const why = "teach-why";
  const count = program.picked.value.size;
  return (
    <>
      <div class="buttons-row add-bar">
        <Do id="teach-add" class="primary" off={off} why={why} press={actions.capture}>
          {t("teach.add")}
        </Do>
        <Do id="teach-undo" off={!program.canUndo.value} press={program.undo}>
          {t("teach.undo")}
        </Do>
        <Do id="teach-redo" off={!program.canRedo.value} press={program.redo}>
          {t("teach.redo")}
        </Do>
        <Do id="teach-delete" off={program.rows.value.length === 0} press={program.remove}>
          {count > 1 ? t("teach.deleteMany", { count }) : t("teach.delete")}
        </Do>
      </div>
      {off ? (
        <p id={why} class="hint">
          {t(store.why.value ?? "why.free")}
        </p>
      ) : null}
      <details class="more">
        <summary>{t("teach.more")}</summary>
        <div class="more-body">
          <Switch label={t("teach.guide")} testId="teach-guide" on={actions.guides.value} disabled={off} reason={off ? why : undefined} flip={(on) => void actions.guide(on)} />
          <div class="buttons-row">
            <Do id="teach-wait" press={actions.addWait}>
              {t("teach.addWait")}
            </Do>
            <Times id="teach-pin" label={t("teach.pin")} least={1} most={PINS} value={pin} />
            <Do id="teach-output-high" press={() => actions.addOutput(pin.value, true)}>
              {t("teach.high")}
            </Do>
            <Do id="teach-output-low" press={() => actions.addOutput(pin.value, false)}>
              {t("teach.low")}
            </Do>
          </div>
        </div>
      </details>
    </>
  );
}

function Play() {
  const why = jobs.why.value ?? (jobs.busy.value ? "why.busy.job" : null);
  const off = why !== null || program.rows.value.length === 0;
  const nth = program.selected.value;
  const n = nth + 1;
  const leads = program.rows.value[nth]?.motion !== null;
  return (
    <div class="buttons-row play">
      <Do id="teach-play" class="primary" off={off} why="play-why" press={() => actions.play("all")}>
        {t("teach.play")}
      </Do>
      <Times id="teach-loops" label={t("run.times")} hint={t("run.times.hint")} value={actions.loops} />
      <Do id="teach-from" off={off} why="play-why" press={() => actions.play("from")}>
        {t("teach.from", { n })}
      </Do>
      <Do id="teach-step" off={off} why="play-why" press={() => actions.play("one")}>
        {t("teach.one", { n })}
      </Do>
      <Do id="teach-again" off={store.why.value !== null || off || !leads} why="play-why" press={() => actions.reteach(nth)}>
        {t("teach.again", { n })}
      </Do>
      <span id="play-why" class="unseen">
        {why === null ? t("teach.empty") : t(why)}
      </span>
    </div>
  );
}

function Files() {
  const off = !store.isUp.value;
  return (
    <div class="buttons-row files">
      <label class="field title">
        <span>{t("teach.title")}</span>
        <input
          type="text"
          autocomplete="off"
          maxLength={60}
          placeholder={t("teach.untitled")}
          data-testid="teach-title"
          value={program.taught.value.title}
          onChange={(event) => program.change({ title: event.currentTarget.value.trim() })}
        />
      </label>
      <label class="field">
        <span>{t("programs.format")}</span>
        <select data-testid="teach-save-format" value={actions.format.value} onChange={(event) => (actions.format.value = event.currentTarget.value as "plan")}>
          <option value="plan">{t("format.plan")}</option>
          <option value="playback">{t("format.playback")}</option>
        </select>
      </label>
      <Do id="teach-save" off={off || program.rows.value.length === 0} press={actions.save}>
        {t("teach.save")}
      </Do>
      <OpenFile id="teach-open" accept=".playback,.json,.plan,.csv,.xyz,.blockly,.xml" off={off} text={t("programs.open")} open={([file]) => file && actions.open(file)} />
    </div>
  );
}

export function Teach() {
  useEffect(() => actions.follow(), []);
  const isSaved = program.isSaved.value;
  // What has ended well is no news here.
  const shows = jobs.busy.value || jobs.job.value?.state === "failed" || jobs.job.value?.state === "interrupted";
  return (
    <div
      class="move teach"
      onKeyDown={(event) => {
        const isText = event.target instanceof HTMLInputElement && event.target.type === "text";
        if (!(event.ctrlKey || event.metaKey) || isText) return;
        const key = event.key.toLowerCase();
        if (key !== "z" && key !== "y") return;
        event.preventDefault();
        if (key === "y" || event.shiftKey) program.redo();
        else program.undo();
      }}
    >
      <div class="move-look">
        <ArmView />
        <Pose />
        <Card title={t("teach.points")} class="points-card" more={<span class="hint">{t(isSaved ? "teach.isSaved" : "teach.unsaved")}</span>}>
          <Add />
          <Points />
          <Play />
          {shows ? <JobCard /> : null}
          <Files />
        </Card>
      </div>
      <div class="move-do" aria-label={t("nav.teach")} role="group">
        <JogPad />
        <ArmCard />
      </div>
    </div>
  );
}
