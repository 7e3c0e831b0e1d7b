// Programs: opened, looked at before anything moves, run, paused, gone on with.
import { effect, signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { tried } from "../actions";
import { t, told } from "../i18n";
import * as check from "../run/check";
import * as jobs from "../run/jobs";
import * as library from "../run/programs";
import * as store from "../store";
import { world } from "../view/seen";
import { ArmView } from "../view/view";
import { Card, Do, Times } from "../ui/parts";
import { JobCard, PastJobs } from "./job";
import { Pose } from "./pose";
import { formatOf, Programs, size } from "./programs";
import "./run.css";

const loops = signal(1);

function Field({ option }: { option: check.Option }) {
  const { name, kind, unit, choices, about } = option;
  const label = told(`setup.${name}`, about);
  const value = check.values.value[name] ?? "";
  const set = (to: string) => (check.values.value = { ...check.values.value, [name]: to });
  if (kind === "switch") {
    return (
      <label class="tick">
        <input type="checkbox" checked={value === "true"} data-testid={`setup-${name}`} onChange={(event) => set(String(event.currentTarget.checked))} />
        <span>{label}</span>
      </label>
    );
  }
  const hint = kind === "point" ? `x, y ${unit}` : unit === "deg" ? "°" : unit;
  return (
    <label class="field">
      <span>
        {label} <small>{kind === "choice" ? "" : hint}</small>
      </span>
      {kind === "choice" ? (
        <select data-testid={`setup-${name}`} value={value || (choices[0] ?? "")} onChange={(event) => set(event.currentTarget.value)}>
          {choices.map((choice) => (
            <option key={choice} value={choice}>
              {told(`setup.${name}.${choice}`, told(`tools.${choice}`, choice))}
            </option>
          ))}
        </select>
      ) : (
        <input
          type="text"
          inputMode={kind === "number" ? "decimal" : undefined}
          autocomplete="off"
          placeholder={t("setup.unset")}
          data-testid={`setup-${name}`}
          value={value}
          onChange={(event) => set(event.currentTarget.value)}
        />
      )}
    </label>
  );
}

/** The file's own picture, where the browser can show it. */
function Picture({ program }: { program: library.Entry }) {
  const url = useSignal<string | null>(null);
  useEffect(() => {
    let made: string | null = null;
    let gone = false;
    const kind = { svg: "image/svg+xml", image: "" }[program.format ?? ""];
    if (kind !== undefined && program.bytes < 4e6 && !program.name.endsWith(".svgz")) {
      library.get(program).then((bytes) => {
        if (gone) return;
        made = URL.createObjectURL(kind === "" ? bytes : new Blob([bytes], { type: kind }));
        url.value = made;
      }, () => {});
    }
    return () => {
      gone = true;
      if (made !== null) URL.revokeObjectURL(made);
    };
  }, [program.name, program.modified]);
  return url.value === null ? null : <img class="file-picture" src={url.value} alt={t("run.picture", { name: program.name })} onError={() => (url.value = null)} />;
}

function Complaints({ report, program }: { report: check.Report; program: library.Entry }) {
  const lines = useSignal<library.Line[]>([]);
  const at = useSignal<number | null>(null);
  useEffect(() => {
    lines.value = [];
    at.value = null;
  }, [report]);
  const look = (line: number) =>
    tried(async () => {
      at.value = line;
      lines.value = await library.linesAt(await library.get(program), line);
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
              <b>{complaint.line === undefined ? t("run.step", { step: complaint.step }) : t("run.line", { line: complaint.line })}</b> {complaint.message}
            </button>
          </li>
        ))}
      </ol>
      {lines.value.length > 0 ? (
        <pre class="lines" tabIndex={0} aria-label={t("run.lines")} data-testid="run-lines">
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

function about(report: check.Report | null): string {
  if (report === null) return "";
  const facts = [report.seconds === null ? null : t("run.takes", { time: jobs.duration(report.seconds) })];
  if (report.drawn_mm > 0) facts.push(t("run.draws", { mm: Math.round(report.drawn_mm) }));
  const { bounds } = report;
  if (bounds) facts.push(t("run.size", { x: Math.round(bounds.x[1] - bounds.x[0]), y: Math.round(bounds.y[1] - bounds.y[0]) }));
  return facts.filter((fact) => fact !== null).join(" · ");
}

function Found({ program }: { program: library.Entry }) {
  const report = check.report.value;
  if (check.isChecking.value) return <p class="check busy">{t("run.checking")}</p>;
  if (check.problem.value !== null) return <p class="check bad" role="alert">{check.problem.value}</p>;
  if (program.format === null) return <p class="check bad">{t("run.unknown")}</p>;
  if (report === null) return <p class="hint">{t("run.unchecked")}</p>;
  return (
    <>
      <p class={`check ${report.ok ? "good" : "bad"}`} role="status">
        <b>{report.ok ? t("run.good") : report.refused > 0 ? t("run.refused", { count: report.refused }) : t("run.unfit")}</b> <span class="number">{about(report)}</span>
      </p>
      {report.complaints.length > 0 ? <Complaints report={report} program={program} /> : null}
      {(report.notes ?? []).map((note, nth) => (
        <p key={nth} class="hint">
          {note.text}
        </p>
      ))}
    </>
  );
}

/** The tool that the virtual arm would need for its lines to be seen, and does not have; else null. */
function leavesNothing(): string | null {
  const around = world.value;
  if (around === null || store.arm.value?.virtual !== true || !((check.report.value?.drawn_mm ?? 0) > 0)) return null;
  const chosen = check.options.value.find(({ name }) => name === "tool");
  const tool = chosen === undefined ? (around.draws ?? "pen") : (check.values.value["tool"] || (chosen.choices[0] ?? "pen"));
  return tool === around.draws ? null : tool;
}

function Selected() {
  const program = check.entry.value;
  if (program === null) return null;
  const why = jobs.why.value;
  const reason = why ?? (jobs.busy.value ? "why.busy.job" : null);
  const start = () =>
    tried(async () => {
      const source = check.source();
      // What is known to be impossible is looked at once more: the arm may stand elsewhere now.
      if (check.report.value?.ok !== true && !(await check.check())) return;
      // Nobody has pressed for what was chosen meanwhile.
      if (JSON.stringify(check.source()) !== JSON.stringify(source)) return;
      try {
        await jobs.start({ ...source, loops: loops.value }, program.name, about(check.report.value));
      } catch (error) {
        check.refuse(error);
      }
    });
  const fields = check.options.value.filter(check.counts);
  const bare = leavesNothing();
  const isShown = check.isShown.value;
  const look = () => {
    if (isShown) check.draw(null);
    else if (check.report.value?.preview) check.draw(check.report.value);
    else void check.check();
  };
  return (
    <Card title={program.name} class="selected">
      <div class="file-facts">
        <p class="hint">
          {formatOf(program.format)} · {size(program.bytes)}
        </p>
        <Picture key={program.name} program={program} />
      </div>
      {fields.length > 0 ? (
        <div class="setup" role="group" aria-label={t("setup.title")}>
          {fields.map((option) => (
            <Field key={option.name} option={option} />
          ))}
        </div>
      ) : null}
      <Found program={program} />
      <div class="buttons-row">
        <Do id="run-start" class="primary" off={reason !== null || program.format === null} why="start-why" press={start}>
          {t("run.start")}
        </Do>
        <Do id="run-check" off={!store.isUp.value || program.format === null} press={check.check}>
          {t("run.check")}
        </Do>
        <button type="button" data-testid="run-preview" data-shown={isShown} aria-pressed={isShown} disabled={!store.isUp.value} onClick={look}>
          {t("run.preview")}
        </button>
        <Times id="run-loops" label={t("run.times")} hint={t("run.times.hint")} value={loops} />
      </div>
      {reason !== null ? (
        <p id="start-why" class="hint">
          {t(reason)}
        </p>
      ) : null}
      {bare === null ? null : (
        <p class="check note" role="status" data-testid="run-bare">
          {t("run.draws.none", { tool: told(`tools.${bare}`, bare).toLowerCase() })}
        </p>
      )}
    </Card>
  );
}

export function Run() {
  useEffect(() => {
    const ends = [
      jobs.follow(),
      check.checkAlong(),
      effect(() => {
        if (store.socket.value === "up") library.list().catch(() => {});
      }),
    ];
    return () => ends.forEach((end) => end());
  }, []);
  return (
    <div class="move run">
      <div class="move-look">
        <ArmView />
        <Pose />
        <JobCard />
      </div>
      <div class="move-do" aria-label={t("nav.run")} role="group">
        <Programs />
        <Selected />
        <PastJobs />
      </div>
    </div>
  );
}
