// Parts shared by the routes of programs: options, results of the check, and updates while they are
// open.
import { effect, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt, type Remedy } from "../actions";
import type { Option, Report } from "../api";
import { sentence, t, translated } from "../i18n";
import * as check from "../run/check";
import * as jobs from "../run/jobs";
import { heightAboveTable } from "../run/paper";
import * as library from "../run/programs";
import * as surface from "../run/surface";
import { labelOf, optionText, plainNoteText } from "../run/words";
import { optionFault } from "../run/workshop";
import * as store from "../store";
import { Button, Pick, TextField } from "../ui/parts";
import { loadBuiltIn, world } from "../view/world";
import { Problem, Remedies } from "./remedies";
import "./run.css";

/** Formats that move the arm, and draw nothing of themselves. */
const MOTION_FORMATS = ["plan", "playback", "blockly"];
function titleOf(group: string): string {
  const format = check.entry.value?.format ?? "";
  const name = group === "pen" && MOTION_FORMATS.includes(format) ? "moves" : group;
  return optionText(`group.${name}`, group);
}

export function OptionField({ option }: { option: Option }) {
  const { name, kind, unit, choices, usual, about } = option;
  const label = labelOf(option);
  const value = check.values.value[name] ?? "";
  const set = (to: string) => check.setValue(name, to);
  if (kind === "switch") {
    return (
      <label class="tick" title={about}>
        <input
          type="checkbox"
          checked={check.valueOf(name) === "true"}
          data-testid={`setup-${name}`}
          onChange={(event) => set(String(event.currentTarget.checked))}
        />
        <span>{label}</span>
      </label>
    );
  }
  if (kind === "choice") {
    const textOf = (choice: string) => optionText(`${name}.${choice}`, translated(`tools.${choice}`, choice));
    const unset = usual || option.default !== null ? [] : [{ value: "", text: t("setup.unset") }];
    const all = [...unset, ...choices.map((choice) => ({ value: choice, text: textOf(choice) }))];
    return <Pick title={label} id={`setup-${name}`} value={check.valueOf(name)} options={all} choose={set} />;
  }
  const of = { point: "x, y ", place: "x, y, z ", area: "x, y, ↔, ↕ " }[kind as "point"] ?? "";
  const fault = optionFault(option, value);
  const placeholder = option.default === null ? optionText(`${name}.hint`, t("setup.unset")) : String(option.default);
  return (
    <TextField
      id={`setup-${name}`}
      label={label}
      unit={of + (unit === "deg" ? "°" : unit)}
      value={value}
      placeholder={placeholder}
      {...(fault === null ? {} : { hint: fault, bad: true })}
      set={set}
    />
  );
}

/** Options that have a place of their own on the page, or that no form can ask for. */
const OPTIONS_ELSEWHERE = ["only", "pens", "parts", "no_pause", "frame", "frame_power"];
const GROUPS = ["fill", "text", "image", "laser", "pen", "place", "parts", "more"] as const;

/** Options of a program: the usual ones, and the others in folded groups. */
export function Options({ first = [], not = [] }: { first?: readonly string[]; not?: readonly string[] }) {
  const asked = check.shownOptions.value.filter(({ name }) => !OPTIONS_ELSEWHERE.includes(name) && !not.includes(name));
  const isFirst = ({ name, usual }: Option) => usual || first.includes(name);
  const fields = (options: Option[]) => (
    <div class="setup">
      {options.map((option) => (
        <OptionField key={option.name} option={option} />
      ))}
    </div>
  );
  const rest = GROUPS.map((group) => ({
    group,
    options: asked.filter((option) => option.group === group && !isFirst(option)),
  }));
  return asked.length === 0 ? null : (
    <div class="options" role="group" aria-label={t("setup.title")}>
      {fields(asked.filter(isFirst))}
      {rest.map(({ group, options }) =>
        options.length === 0 ? null : (
          <details key={group} class="more" data-testid={`setup-group-${group}`}>
            <summary>{titleOf(group)}</summary>
            {fields(options)}
          </details>
        ),
      )}
    </div>
  );
}

/** The file's own picture, if the browser can show it. */
export function Picture({ program }: { program: library.Entry }) {
  const url = useSignal<string | null>(null);
  useEffect(() => {
    let [made, gone] = ["", false];
    const kind = { svg: "image/svg+xml", image: "" }[program.format ?? ""];
    if (kind !== undefined && program.bytes < 4e6 && !program.name.endsWith(".svgz")) {
      library.fetchProgram(program).then(
        (bytes) => {
          if (gone) return;
          url.value = made = URL.createObjectURL(kind === "" ? bytes : new Blob([bytes], { type: kind }));
        },
        () => {},
      );
    }
    return () => {
      gone = true;
      URL.revokeObjectURL(made);
    };
  }, [program.name, program.modified]);
  return url.value === null ? null : (
    <img
      class="file-picture"
      src={url.value}
      alt={t("run.picture", { name: program.name })}
      onError={() => (url.value = null)}
    />
  );
}

function Complaints({ report, program }: { report: Report; program: library.Entry | null }) {
  const lines = useSignal<library.Line[]>([]);
  const at = useSignal<number | null>(null);
  useEffect(() => {
    lines.value = [];
    at.value = null;
  }, [report]);
  const look = (line: number) =>
    attempt(async () => {
      if (program === null) return;
      at.value = line;
      lines.value = await library.linesAt(await library.fetchProgram(program), line);
    });
  return (
    <div class="complaints">
      <ol>
        {report.complaints.map((complaint, nth) => (
          <li key={nth}>
            <button
              type="button"
              class="link"
              data-testid={`run-complaint-${nth + 1}`}
              aria-expanded={complaint.line === undefined ? undefined : at.value === complaint.line}
              onClick={() => complaint.line !== undefined && look(complaint.line)}
            >
              <b>
                {complaint.line === undefined
                  ? t("run.step", { step: complaint.step })
                  : t("run.line", { line: complaint.line })}
              </b>{" "}
              {sentence(complaint)}
            </button>
          </li>
        ))}
      </ol>
      {lines.value.length > 0 ? (
        <pre class="lines" role="region" tabIndex={0} aria-label={t("run.lines")} data-testid="run-lines">
          {lines.value.map((line) => (
            <code key={line.number} class={line.number === at.value ? "at" : ""}>
              <i>{line.number}</i> {line.text}
              {"\n"}
            </code>
          ))}
        </pre>
      ) : null}
    </div>
  );
}

/** Duration and lengths of a program as text. */
export function summaryText(report: Report | null): string {
  if (report === null) return "";
  const facts = [report.seconds === null ? null : t("run.takes", { time: jobs.formatDuration(report.seconds) })];
  if (report.drawn_mm > 0) facts.push(t("run.draws", { mm: Math.round(report.drawn_mm) }));
  const { bounds } = report;
  if (bounds)
    facts.push(t("run.size", { x: Math.round(bounds.y[1] - bounds.y[0]), y: Math.round(bounds.x[1] - bounds.x[0]) }));
  return facts.filter((fact) => fact !== null).join(" · ");
}

/**
 * Code of a note that is hidden: the order of lines matters only to users who look into the file.
 */
const HIDDEN_NOTE = "reordered";

/** Results of the check. */
export function CheckResult() {
  const program = check.entry.value;
  const report = check.report.value;
  if (check.isChecking.value) return <p class="check busy">{t("run.checking")}</p>;
  if (check.problem.value !== null) return <Problem of={check.problem.value} />;
  if (program?.format === null) return <p class="check bad">{t("run.unknown")}</p>;
  if (report === null) return <p class="hint">{t("run.unchecked")}</p>;
  const above = report.ok ? heightAboveTable(report, check.valueOf("tool") || "pen", world.value) : null;
  if (above !== null)
    return (
      <div class="check note" role="status" data-testid="run-air">
        <p>{t("run.air", { mm: Math.round(above) })}</p>
        {surface.isKnown.value ? (
          <Button id="run-air-forget" text={t("run.air.forget")} press={surface.forget} />
        ) : null}
      </div>
    );
  return (
    <>
      <p class={`check ${report.ok ? "good" : "bad"}`} role="status">
        <b>
          {report.ok
            ? t("run.good")
            : report.refused > 0
              ? t("run.refused", { count: report.refused })
              : t("run.unfit")}
        </b>{" "}
        <span class="number">{summaryText(report)}</span>
      </p>
      {report.complaints.length > 0 ? <Complaints report={report} program={program} /> : null}
      {(report.notes ?? [])
        .filter(({ code }) => code !== HIDDEN_NOTE)
        .map((note, nth) => (
          <div key={nth} class="found-note">
            <p class="hint">{plainNoteText(note)}</p>
            <Remedies of={(note.remedies ?? []) as Remedy[]} />
          </div>
        ))}
    </>
  );
}

/** Warning that lines would be invisible, because the virtual arm has no such tool. */
export function NoToolWarning() {
  const around = world.value;
  if (around === null || store.arm.value?.virtual !== true || !((check.report.value?.drawn_mm ?? 0) > 0)) return null;
  const tool = check.valueOf("tool") || (around.draws ?? "pen");
  if (tool === around.draws) return null;
  const wanted = tool === "laser" ? "engraving" : "drawing";
  const off = store.why.value !== null || store.role.value !== "teacher";
  const load = () => attempt(async () => ((await loadBuiltIn(wanted)) ? check.check() : undefined));
  return (
    <div class="check note" role="status" data-testid="run-bare">
      <p>{t("run.draws.none", { tool: translated(`tools.${tool}`, tool).toLowerCase() })}</p>
      <Button
        id="run-scenario"
        off={off}
        why="run-scenario-why"
        text={t("run.draws.load", { name: translated(`scenario.${wanted}`, t(`scenario.${wanted}`)) })}
        press={load}
      />
      <span id="run-scenario-why" class="unseen">
        {off ? t(store.why.value ?? "world.teacher") : ""}
      </span>
    </div>
  );
}

/** Follows jobs and library, and checks changes, while the panel is open. */
export function usePrograms(most?: number): void {
  useEffect(() => {
    const ends = [
      jobs.follow(),
      check.openWorkshop.value.checkOnChange(most),
      effect(() => {
        if (store.socket.value === "up") library.readLibrary().catch(() => {});
      }),
    ];
    return () => ends.forEach((end) => end());
  }, []);
}
