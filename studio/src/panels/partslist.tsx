// Parts of a drawing: its layers or colours, which of them are drawn, and whether the pen is
// changed in between.
import { useEffect } from "preact/hooks";
import type { Part } from "../api";
import { t } from "../i18n";
import type { Bench } from "../run/bench";
import * as check from "../run/check";
import { duration } from "../run/jobs";
import { Card, Choice, Heads, Pick } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./partslist.json";

const w = sentencesOf(texts);

/** True if the part is drawn: as ticked by the user, otherwise as the station says. */
function isWanted({ n, skipped }: Part): boolean {
  const only = check.values.value.only;
  return only ? only.split("\n").includes(String(n)) : !skipped;
}

function tick(part: Part, is: boolean): void {
  const parts = check.report.value?.parts ?? [];
  const only = parts.filter((one) => (one.n === part.n ? is : isWanted(one)));
  if (only.length > 0) check.setValue("only", only.length === parts.length ? "" : only.map(({ n }) => n).join("\n"));
}

const labelOf = (part: Part): string => part.name ?? part.color ?? String(part.n);
const Swatch = ({ of }: { of: Part }) => <span class="swatch" style={{ background: of.color ?? "var(--planned)" }} />;

export function PartsCard({ bench }: { bench: Bench }) {
  const option = bench.asked.value.find(({ name }) => name === "parts");
  const parts = bench.report.value?.parts ?? [];
  // A file without useful layers is split by colour, and drawn without a pause.
  useEffect(() => {
    const strokes = bench.report.value?.preview?.strokes ?? [];
    if (
      option === undefined ||
      bench.isComposed.value ||
      bench.values.value.parts !== undefined ||
      strokes.length === 0 ||
      strokes.some(({ part }) => part !== null)
    )
      return;
    bench.setValue("parts", "color");
    bench.setValue("no_pause", "true");
  }, [bench.report.value, option]);
  const item = bench.item.value;
  const isPlain = bench.isComposed.value || item?.shape !== undefined || item?.format === "text";
  if (option === undefined || bench.report.value === null || (isPlain && parts.length < 2)) return null;
  const options = option.choices.map((value) => ({ value, text: t(`setup.parts.${value}` as "setup.parts.none") }));
  const wanted = parts.filter(isWanted);
  const asked = bench.values.value.no_pause;
  const pauses = bench.isComposed.value ? asked === "false" : bench.valueOf("no_pause") !== "true";
  return (
    <Card title={w("parts.title")} class="parts-card">
      {parts.length < 2 ? null : (
        <>
          <Choice
            name="parts-pens"
            label={w("pens.how")}
            value={pauses ? "change" : "one"}
            options={[
              { value: "one", text: w("pens.one") },
              { value: "change", text: w("pens.change") },
            ]}
            choose={(to) => bench.setValue("no_pause", String(to === "one"))}
          />
          <p class="pen-order" data-testid="parts-order">
            {wanted.map((part, nth) => (
              <span key={part.n}>
                {nth === 0 ? null : pauses ? <i aria-hidden="true"> ⏸ </i> : " "}
                <Swatch of={part} />
              </span>
            ))}{" "}
            <span class="hint">
              {pauses ? w("pens.once", { n: Math.max(0, wanted.length - 1) }) : w("pens.never", { n: wanted.length })}
            </span>
          </p>
        </>
      )}
      {parts.length < 2 ? null : (
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
                    aria-label={w("parts.draw", { name: labelOf(part) })}
                    checked={isWanted(part)}
                    disabled={isWanted(part) && wanted.length === 1}
                    data-testid={`part-only-${part.n}`}
                    onChange={(event) => tick(part, event.currentTarget.checked)}
                  />
                </td>
                <th scope="row">
                  <Swatch of={part} /> {labelOf(part)}
                </th>
                <td class="number">{`${Math.round(part.drawn_mm)} mm`}</td>
                <td class="number">{part.seconds === null ? "–" : duration(part.seconds)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {bench.isComposed.value ? null : (
        <details class="more">
          <summary>{w("pens.more")}</summary>
          <Pick
            title={w("parts.by")}
            id="parts-by"
            value={bench.valueOf("parts")}
            options={[{ value: "", text: w("parts.auto") }, ...options]}
            choose={(to) => bench.setValue("parts", to)}
          />
        </details>
      )}
    </Card>
  );
}
