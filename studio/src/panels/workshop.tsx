// Parts shared by drawing and engraving: objects on the sheet, duration, start.
import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n";
import type { Bench } from "../run/bench";
import * as check from "../run/check";
import { hasFills } from "../run/fills";
import * as jobs from "../run/jobs";
import * as paper from "../run/paper";
import * as library from "../run/programs";
import { entryOf } from "../run/workshop";
import * as store from "../store";
import { Button, Card, DropZone, Field, OpenFile, Pick } from "../ui/parts";
import { sentencesOf } from "../words";
import { nameOf, Objects, Palette, useUndoKeys } from "./items";
import { PartsCard } from "./partslist";
import { PHOTO_OPTIONS, Photo } from "./photo";
import { Presets } from "./presets";
import { ACCEPTED_FILES, formatOf } from "./programs";
import { CheckResult, NoToolWarning, Options, summaryText, usePrograms } from "./setup";
import { NewSheet, Sheet } from "./sheet";
import sheetTexts from "./sheet.json";
import { Height } from "./touch";
import texts from "./workshop.json";

const w = sentencesOf(texts);
const onSheet = sentencesOf(sheetTexts);

/** Formats whose lines can be placed anywhere. */
const PLACEABLE_FORMATS = ["svg", "dxf", "hpgl", "image", "text", "gcode"];
/** Largest file that is checked automatically, bytes. */
const AUTO_CHECK_LIMIT = 8 * 1024 * 1024;

/** True once the route's program belongs to this workshop. */
function useBench(bench: Bench): boolean {
  const [isOpen, open] = useState(false);
  useEffect(() => {
    check.openWorkshop.value = bench;
    open(true);
    return () => {
      if (check.openWorkshop.value === bench) check.openWorkshop.value = check.runWorkshop;
    };
  }, [bench]);
  return isOpen;
}

function SourcePicker({ bench }: { bench: Bench }) {
  const off = !store.isUp.value;
  const noFile = off || store.role.value === "viewer";
  const drawings = library.programs.value.filter(({ format }) => PLACEABLE_FORMATS.includes(format ?? ""));
  const item = bench.item.value;
  const field = useRef<HTMLTextAreaElement>(null);
  // The next typed text replaces the selected word.
  const write = () =>
    requestAnimationFrame(() => {
      field.current?.focus();
      field.current?.select();
    });
  return (
    <Card
      title={t("draw.what")}
      class="what-card"
      more={
        <OpenFile
          id="draw-open"
          class="small"
          accept={ACCEPTED_FILES}
          off={noFile}
          text={t(library.isLoading.value ? "programs.loading" : "programs.open")}
          open={(files) => bench.openFiles(files)}
        />
      }
    >
      <DropZone off={noFile} open={(files) => bench.openFiles(files)} class="what-drop">
        <Field label={t("draw.text")}>
          <textarea
            ref={field}
            rows={2}
            maxLength={2000}
            disabled={off}
            placeholder={t("draw.text.hint")}
            data-testid="draw-text"
            value={item?.format === "text" ? (item.source.text ?? "") : ""}
            onInput={(event) => bench.write(event.currentTarget.value)}
            onBlur={() => bench.doc.seal()}
          />
        </Field>
        <Palette bench={bench} write={write} />
        {drawings.length === 0 ? null : (
          <Pick
            title={t("draw.program")}
            id="draw-program"
            value={item?.source.program ?? ""}
            options={[
              { value: "", text: t("draw.program.none") },
              ...drawings.map(({ name, format }) => ({ value: name, text: `${name} (${formatOf(format)})` })),
            ]}
            off={off}
            choose={(name) => {
              if (name !== "") bench.take(name);
              else if (item !== null) bench.remove(item.id);
            }}
          />
        )}
      </DropZone>
    </Card>
  );
}

/** Note that filled shapes are only outlined, which their file does not show. */
function FillNote({ bench }: { bench: Bench }) {
  const isFilled = useSignal(false);
  const item = bench.item.value;
  const isDrawing = item?.format === "svg" && item.shape === undefined;
  const [name, text] = [item?.source.program, item?.source.text];
  useEffect(() => {
    let gone = false;
    isFilled.value = false;
    const entry = entryOf(name);
    const content =
      text ??
      (entry !== null && entry.bytes < AUTO_CHECK_LIMIT ? library.fetchProgram(entry).then((file) => file.text()) : "");
    if (isDrawing)
      Promise.resolve(content).then(
        (svg) => {
          if (!gone) isFilled.value = hasFills(svg);
        },
        () => {},
      );
    return () => {
      gone = true;
    };
  }, [name, text, isDrawing, entryOf(name)?.modified]);
  if (!isDrawing || !isFilled.value || (bench.valueOf("fill") || "none") !== "none") return null;
  return (
    <div class="check note" role="status" data-testid="draw-filled">
      <p>{w("fill.note")}</p>
      <Button id="draw-fill" class="small" text={w("fill.do")} press={() => bench.setValue("fill", "hatch")} />
    </div>
  );
}

/** Note that an object was shrunk below the size of its file. */
function ShrinkNote({ bench }: { bench: Bench }) {
  const shrunk = bench.shrunk.value;
  const item = bench.doc.now.value.items.find(({ id }) => id === shrunk?.id);
  if (shrunk === null || item === undefined || item.place !== null || bench.isFull.value) return null;
  const [from, to] = [shrunk.from, shrunk.to].map(Math.round) as [number, number];
  return (
    <p class="hint" role="status" data-testid="sheet-shrunk">
      {onSheet("sheet.shrunk", { name: nameOf(item), from, to })}
    </p>
  );
}

interface WorkshopProps {
  bench: Bench;
  name: string;
  hint: string;
  /** Options outside the folded part. */
  first: readonly string[];
  /** Content before the start button, and below everything. */
  before?: ComponentChildren;
  children?: ComponentChildren;
}

export function WorkshopPanel(props: WorkshopProps) {
  return useBench(props.bench) ? <OpenWorkshop {...props} /> : null;
}

function OpenWorkshop({ bench, name, hint, first, before, children }: WorkshopProps) {
  usePrograms(AUTO_CHECK_LIMIT);
  useUndoKeys(bench);
  const reason = jobs.whyNotStart(bench.fixed);
  const isThere = bench.chosen.value !== null;
  const seconds = bench.report.value?.seconds ?? null;
  const time = (
    <p class="draw-time">
      <b class="number" data-testid="draw-time">
        {seconds === null ? "–" : jobs.formatDuration(seconds)}
      </b>{" "}
      <span class="hint">{t("draw.time")}</span>
    </p>
  );
  const start = () => {
    const started = bench.start(bench.title.value, () => summaryText(bench.report.value));
    void paper.recordWhenDone(bench, started);
    return started;
  };
  return (
    <div class="workshop">
      <Sheet bench={bench} hint={hint} />
      <div class="workshop-do" role="group" aria-label={name}>
        <SourcePicker bench={bench} />
        <Card title={t("draw.go")} class="start-card" more={time}>
          {isThere ? <CheckResult /> : null}
          <FillNote bench={bench} />
          {isThere && bench.isFull.value && !paper.isBlank() ? (
            <div class="check note" role="status" data-testid="sheet-full">
              <p>{onSheet("sheet.full")}</p>
              <NewSheet bench={bench} id="sheet-new-here" />
            </div>
          ) : null}
          <ShrinkNote bench={bench} />
          <NoToolWarning />
          {before}
          <div class="buttons-row">
            <Button
              id="draw-start"
              class="primary"
              off={reason !== null || !isThere}
              why="draw-why"
              text={t("run.start")}
              press={start}
            />
            <Button
              id="draw-check"
              off={!store.isUp.value || !isThere}
              text={t("run.check")}
              press={() => bench.check()}
            />
          </div>
          <p id="draw-why" class="hint" role="status">
            {reason === null ? "" : t(reason)}
          </p>
        </Card>
        <Height tool={bench.tool} />
        <Photo bench={bench} />
        <PartsCard bench={bench} />
        <Objects bench={bench} />
        {check.shownOptions.value.length === 0 || !isThere ? null : (
          <Card title={t("setup.title")} class="options-card">
            <Options first={first} not={PHOTO_OPTIONS} />
          </Card>
        )}
        <Presets bench={bench} />
        {children}
      </div>
    </div>
  );
}
