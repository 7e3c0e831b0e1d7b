// Parts of a drawing: its layers or colours, which of them are drawn, and whether the pen is
// changed in between.
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import type { Bench } from "../run/bench";
import type { PartRow } from "../run/items";
import { formatDuration } from "../run/jobs";
import { Card, Choice, ColumnHeads, Pick } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./partslist.json";

const w = sentencesOf(texts);

const labelOf = (part: PartRow): string => part.name ?? part.color ?? String(part.targets[0]?.n ?? "");
const Swatch = ({ of }: { of: PartRow }) => (
  <span class="swatch" style={{ background: of.color ?? "var(--planned)" }} />
);

export function PartsCard({ bench }: { bench: Bench }) {
  const option = bench.shownOptions.value.find(({ name }) => name === "parts");
  const parts = bench.parts.value;
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
    bench.divideByColors();
  }, [bench.report.value, option]);
  const item = bench.item.value;
  const isPlain = bench.isComposed.value || item?.shape !== undefined || item?.format === "text";
  if (bench.report.value === null || ((option === undefined || isPlain) && parts.length < 2)) return null;
  const options = (option?.choices ?? []).map((value) => ({
    value,
    text: t(`setup.parts.${value}` as "setup.parts.none"),
  }));
  const wanted = parts.filter(({ isDrawn }) => isDrawn);
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
              <span key={nth}>
                {nth === 0 ? null : pauses ? <i aria-hidden="true"> ⏸ </i> : " "}
                <Swatch of={part} />
              </span>
            ))}{" "}
            <span class="hint">
              {wanted.length < 2
                ? w("pens.single")
                : pauses
                  ? w("pens.once", { n: wanted.length - 1 })
                  : w("pens.never", { n: wanted.length })}
            </span>
          </p>
        </>
      )}
      {parts.length < 2 ? null : (
        <table data-testid="parts">
          <ColumnHeads
            names={[w("parts.drawn"), w("parts.name"), w("parts.length"), w("parts.time")]}
            unseen={[w("parts.drawn")]}
          />
          <tbody>
            {parts.map((part, nth) => (
              <tr key={nth} data-testid={`part-${nth + 1}`}>
                <td>
                  <input
                    type="checkbox"
                    aria-label={w("parts.draw", { name: labelOf(part) })}
                    checked={part.isDrawn}
                    disabled={part.isDrawn && wanted.length === 1}
                    data-testid={`part-only-${nth + 1}`}
                    onChange={(event) => bench.setPartDrawn(part, event.currentTarget.checked)}
                  />
                </td>
                <th scope="row">
                  <Swatch of={part} /> {labelOf(part)}
                </th>
                <td class="number">{`${Math.round(part.drawn_mm)} mm`}</td>
                <td class="number">{part.seconds === null ? "–" : formatDuration(part.seconds)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {bench.isComposed.value || option === undefined ? null : (
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
