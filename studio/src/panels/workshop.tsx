// What drawing and engraving share: what is put on the sheet, how long it takes, and its start.
import { effect, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { type Key, t } from "../i18n";
import * as check from "../run/check";
import * as jobs from "../run/jobs";
import { setup } from "../run/place";
import * as library from "../run/programs";
import * as store from "../store";
import { Card, Do, Drop, Field, OpenFile, Pick } from "../ui/parts";
import { PartsCard } from "./partslist";
import { Presets } from "./presets";
import { ACCEPT, formatOf } from "./programs";
import { about, Found, Options, Unseen, usePrograms } from "./setup";
import { Sheet } from "./sheet";
import { Height } from "./touch";

/** What has lines of its own that can lie anywhere. */
const FORMATS = ["svg", "dxf", "hpgl", "image", "text", "gcode"];
/** Larger files are checked when they are asked for. */
const AT_ONCE = 8 * 1024 * 1024;

const typed = signal("");

function write(text: string): void {
  typed.value = text;
  void check.choose(text.trim() === "" ? null : { text, format: "text" });
}

/** Draws with a tool, where the sheet has it, as long as the panel is open. */
function useWorkshop(tool: "pen" | "laser"): void {
  usePrograms(AT_ONCE);
  useEffect(() => {
    const end = effect(
      () => void (check.fixed.value = { tool, work: tool === "pen" ? "draw" : "engrave", ...setup.value }),
    );
    if (check.chosen.value === null && store.isUp.value) write(typed.value);
    return () => {
      end();
      check.fixed.value = {};
      if (check.selected.value === null) void check.choose(null);
    };
  }, []);
}

function What() {
  const off = !store.isUp.value;
  const noFile = off || store.role.value === "viewer";
  const drawings = library.programs.value.filter(({ format }) => FORMATS.includes(format ?? ""));
  return (
    <Card
      title={t("draw.what")}
      class="what-card"
      more={
        <OpenFile
          id="draw-open"
          class="small"
          accept={ACCEPT}
          off={noFile}
          text={t(library.isLoading.value ? "programs.loading" : "programs.open")}
          open={check.openFiles}
        />
      }
    >
      <Drop off={noFile} open={check.openFiles} class="what-drop">
        <Field label={t("draw.text")}>
          <textarea
            rows={2}
            maxLength={2000}
            disabled={off}
            placeholder={t("draw.text.hint")}
            data-testid="draw-text"
            value={check.chosen.value?.format === "text" ? typed.value : ""}
            onInput={(event) => write(event.currentTarget.value)}
          />
        </Field>
        <Pick
          title={t("draw.program")}
          id="draw-program"
          value={check.selected.value ?? ""}
          options={[
            { value: "", text: t("draw.program.none") },
            ...drawings.map(({ name, format }) => ({ value: name, text: `${name} (${formatOf(format)})` })),
          ]}
          off={off || drawings.length === 0}
          choose={(name) => void check.select(name || null)}
        />
      </Drop>
    </Card>
  );
}

export function title(): string {
  return (
    check.selected.value ??
    (check.chosen.value?.format === "testgrid" ? t("laser.grid") : typed.value.trim().slice(0, 40))
  );
}
/** Why nothing can be started now. */
export const why = (): Key | null => jobs.why.value ?? (jobs.busy.value ? "why.busy.job" : null);

interface WorkshopProps {
  tool: "pen" | "laser";
  name: string;
  hint: string;
  /** Options that are not folded. */
  first: readonly string[];
  /** Why nothing can be started, beyond what holds for every job. */
  because?: Key | null;
  /** What stands before the start, and below all. */
  before?: ComponentChildren;
  children?: ComponentChildren;
}

export function Workshop({ tool, name, hint, first, because = null, before, children }: WorkshopProps) {
  useWorkshop(tool);
  const reason = why() ?? because;
  const isThere = check.chosen.value !== null;
  const seconds = check.report.value?.seconds ?? null;
  const time = (
    <p class="draw-time">
      <b class="number" data-testid="draw-time">
        {seconds === null ? "–" : jobs.duration(seconds)}
      </b>{" "}
      <span class="hint">{t("draw.time")}</span>
    </p>
  );
  const start = () => check.start(title(), about(check.report.value));
  return (
    <div class="workshop">
      <Sheet hint={hint} />
      <div class="workshop-do" role="group" aria-label={name}>
        <What />
        <Card title={t("draw.go")} class="start-card" more={time}>
          {isThere ? <Found /> : null}
          <Unseen />
          {before}
          <div class="buttons-row">
            <Do
              id="draw-start"
              class="primary"
              off={reason !== null || !isThere}
              why="draw-why"
              text={t("run.start")}
              press={start}
            />
            <Do id="draw-check" off={!store.isUp.value || !isThere} text={t("run.check")} press={check.check} />
          </div>
          <p id="draw-why" class="hint" role="status">
            {reason === null ? "" : t(reason)}
          </p>
        </Card>
        <Height tool={tool} />
        {check.asked.value.length === 0 ? null : (
          <Card title={t("setup.title")} class="options-card">
            <Options first={first} />
          </Card>
        )}
        <PartsCard />
        <Presets />
        {children}
      </div>
    </div>
  );
}
