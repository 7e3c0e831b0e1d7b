// The parts of a drawing: its layers or colours, which of them are drawn, and whether the pen is changed between them.
import { useEffect } from "preact/hooks";
import type { Part } from "../api";
import { t } from "../i18n";
import * as check from "../run/check";
import { duration } from "../run/jobs";
import { Card, Heads, Pick } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./partslist.json";

const w = sentencesOf(texts);

/** Whether it is drawn: as a person has ticked it, else as the station says. */
function isWanted({ n, skipped }: Part): boolean {
  const only = check.values.value.only;
  return only ? only.split("\n").includes(String(n)) : !skipped;
}

function tick(part: Part, is: boolean): void {
  const parts = check.report.value?.parts ?? [];
  const only = parts.filter((one) => (one.n === part.n ? is : isWanted(one)));
  if (only.length > 0) check.setValue("only", only.length === parts.length ? "" : only.map(({ n }) => n).join("\n"));
}

export function PartsCard() {
  const option = check.asked.value.find(({ name }) => name === "parts");
  const parts = check.report.value?.parts ?? [];
  // A file whose layers say nothing is seen in its colours, and drawn without a pause.
  useEffect(() => {
    const strokes = check.report.value?.preview?.strokes ?? [];
    if (
      option === undefined ||
      check.values.value.parts !== undefined ||
      strokes.length === 0 ||
      strokes.some(({ part }) => part !== null)
    )
      return;
    check.values.value = { ...check.values.value, parts: "color", no_pause: "true" };
  }, [check.report.value, option]);
  if (option === undefined) return null;
  const options = option.choices.map((value) => ({ value, text: t(`setup.parts.${value}` as "setup.parts.none") }));
  return (
    <Card title={w("parts.title")} class="parts-card">
      <Pick
        title={w("parts.by")}
        id="parts-by"
        value={check.valueOf("parts")}
        options={[{ value: "", text: w("parts.auto") }, ...options]}
        choose={(to) => check.setValue("parts", to)}
      />
      {parts.length === 0 ? null : (
        <table data-testid="parts">
          <Heads
            names={[w("parts.drawn"), w("parts.name"), w("parts.length"), w("parts.time")]}
            unseen={[w("parts.drawn")]}
          />
          <tbody>
            {parts.map((part) => (
              <tr key={part.n} data-testid={`part-${part.n}`}>
                <td>
                  <input
                    type="checkbox"
                    aria-label={w("parts.draw", { name: part.name ?? part.color ?? part.n })}
                    checked={isWanted(part)}
                    disabled={isWanted(part) && parts.filter(isWanted).length === 1}
                    data-testid={`part-only-${part.n}`}
                    onChange={(event) => tick(part, event.currentTarget.checked)}
                  />
                </td>
                <th scope="row">
                  <span class="swatch" style={{ background: part.color ?? "var(--planned)" }} />{" "}
                  {part.name ?? part.color ?? part.n}
                </th>
                <td class="number">{`${Math.round(part.drawn_mm)} mm`}</td>
                <td class="number">{part.seconds === null ? "–" : duration(part.seconds)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <label class="tick">
        <input
          type="checkbox"
          checked={check.valueOf("no_pause") !== "true"}
          data-testid="parts-pause"
          onChange={(event) => check.setValue("no_pause", String(!event.currentTarget.checked))}
        />
        <span>{w("parts.pause")}</span>
      </label>
    </Card>
  );
}
