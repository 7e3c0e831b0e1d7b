// Teach: positions shown to the arm or by it, in a table that can be played.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { mayBurn } from "../run/burn";
import * as jobs from "../run/jobs";
import * as store from "../store";
import * as actions from "../teach/actions";
import * as program from "../teach/rows";
import { useFileDrop } from "../ui/filedrop";
import { Button, Card, NumberInput, OpenFile, Pick, Reason, Repetitions, Switch, TextField } from "../ui/parts";
import { ArmView } from "../view/view";
import { ArmLaser } from "./armlaser";
import { JogPad } from "./jogpad";
import { Objects } from "./objects";
import { Points } from "./points";
import { Pose } from "./pose";
import { ArmCard } from "./tools";
import "./run.css";
import "./teach.css";
import { w } from "../teach/words";

/** Number of pins that may be outputs. */
const PINS = 20;

const pin = signal(1);

function Add() {
  const off = store.why.value !== null;
  const why = "teach-why";
  const count = program.tickedRows.value.size;
  return (
    <>
      <div class="buttons-row add-bar">
        <Button id="teach-add" class="primary" off={off} why={why} text={w("teach.add")} press={actions.capture} />
        <Button id="teach-undo" off={!program.canUndo.value} text={w("teach.undo")} press={program.undo} />
        <Button id="teach-redo" off={!program.canRedo.value} text={w("teach.redo")} press={program.redo} />
        <Button
          id="teach-delete"
          off={program.rows.value.length === 0}
          text={count > 1 ? w("teach.deleteMany", { count }) : w("teach.delete")}
          press={program.remove}
        />
      </div>
      <Reason id={why} text={off ? t(store.why.value ?? "why.free") : null} />
      <details class="more">
        <summary>{w("teach.more")}</summary>
        <div class="more-body">
          <Switch
            id="teach-guide"
            label={w("teach.guide")}
            on={actions.addsByKey.value}
            off={off}
            why={why}
            flip={actions.setGuiding}
          />
          <div class="buttons-row">
            <Button id="teach-wait" text={w("teach.addWait")} press={actions.addWait} />
            <Repetitions id="teach-pin" label={w("teach.pin")} least={1} most={PINS} value={pin} />
            <Button id="teach-output-high" text={w("teach.high")} press={() => actions.addOutput(pin.value, true)} />
            <Button id="teach-output-low" text={w("teach.low")} press={() => actions.addOutput(pin.value, false)} />
          </div>
        </div>
      </details>
    </>
  );
}

function Play() {
  const why = jobs.whyNotStart();
  const off = why !== null || program.rows.value.length === 0;
  const nth = program.selected.value;
  const n = nth + 1;
  const leads = program.rows.value[nth]?.motion !== null;
  return (
    <div class="buttons-row play">
      <Button
        id="teach-play"
        class="primary"
        off={off}
        why="play-why"
        text={w("teach.play")}
        press={() => actions.play("all")}
      />
      <label class="times" title={w("teach.toolWait.hint")}>
        <span>{w("teach.toolWait")}</span>
        <NumberInput
          id="tool-wait"
          label={w("teach.toolWait")}
          step={0.1}
          least={0}
          most={10}
          digits={2}
          value={actions.toolWait.value}
          set={(seconds) => (actions.toolWait.value = Math.min(10, Math.max(0, seconds)))}
        />
        <span>s</span>
      </label>
      <Repetitions id="teach-loops" label={t("run.times")} hint={t("run.times.hint")} value={actions.loops} />
      <Button
        id="teach-from"
        off={off}
        why="play-why"
        text={w("teach.from", { n })}
        press={() => actions.play("from")}
      />
      <Button id="teach-step" off={off} why="play-why" text={w("teach.one", { n })} press={() => actions.play("one")} />
      <Button
        id="teach-again"
        off={store.why.value !== null || off || !leads}
        why="play-why"
        text={w("teach.again", { n })}
        press={() => actions.reteach(nth)}
      />
      <ArmLaser id="teach-laser-arm" burns={mayBurn(undefined)} why="play-why" />
      <span id="play-why" class={why === "laser.unarmed" ? "hint" : "unseen"}>
        {why === null ? w("teach.empty") : t(why)}
      </span>
    </div>
  );
}

function Files() {
  const off = !store.isUp.value;
  return (
    <div class="buttons-row files">
      <TextField
        id="teach-title"
        class="title"
        label={w("teach.title")}
        value={program.taught.value.title}
        most={60}
        placeholder={w("teach.untitled")}
        set={(text) => program.change({ title: text.trim() })}
      />
      <Pick
        title={t("programs.format")}
        id="teach-save-format"
        value={actions.format.value}
        options={(["plan", "playback"] as const).map((value) => ({ value, text: t(`format.${value}`) }))}
        choose={(format) => (actions.format.value = format)}
      />
      <Button
        id="teach-save"
        off={off || program.rows.value.length === 0}
        text={w("teach.save")}
        press={actions.save}
      />
      <OpenFile
        id="teach-open"
        accept=".playback,.json,.plan,.csv,.xyz,.blockly,.xml"
        off={off}
        text={t("programs.open")}
        open={([file]) => file && actions.open(file)}
      />
    </div>
  );
}

export function Teach() {
  useEffect(() => actions.follow(), []);
  useFileDrop(store.isUp.value ? ([file]) => file && actions.open(file) : null);
  const isSaved = program.isSaved.value;
  const isEmpty = program.rows.value.length === 0;
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
        <section class="card points-add">
          <Add />
        </section>
        <Card
          title={w("teach.points")}
          class="points-card"
          more={isEmpty ? null : <span class="hint">{w(isSaved ? "teach.isSaved" : "teach.unsaved")}</span>}
        >
          <Points />
          <Play />
          <Files />
        </Card>
      </div>
      <div class="move-do" aria-label={t("nav.teach")} role="group">
        <Objects />
        <JogPad />
        <ArmCard />
      </div>
    </div>
  );
}
