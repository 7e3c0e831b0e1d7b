// The parts of a drawing: its layers or colours, which of them are drawn, and whether the pen is changed between them.
import type { Part } from "../api";
import { t } from "../i18n";
import * as check from "../run/check";
import { duration } from "../run/jobs";
import { Card, Heads, Pick } from "../ui/parts";

function tick({ n }: Part, isWanted: boolean): void {
  const parts = check.report.value?.parts ?? [];
  const only = parts.filter((part) => (part.n === n ? isWanted : !part.skipped));
  check.setValue("only", only.length === parts.length || only.length === 0 ? "" : only.map((part) => part.n).join("\n"));
}

export function PartsCard() {
  const option = check.asked.value.find(({ name }) => name === "parts");
  if (option === undefined) return null;
  const parts = check.report.value?.parts ?? [];
  const options = option.choices.map((value) => ({ value, text: t(`setup.parts.${value}` as "setup.parts.none") }));
  return (
    <Card title={t("parts.title")} class="parts-card">
      <Pick title={t("parts.by")} id="parts-by" value={check.valueOf("parts")} options={[{ value: "", text: t("parts.auto") }, ...options]} choose={(to) => check.setValue("parts", to)} />
      {parts.length === 0 ? null : (
        <table data-testid="parts">
          <Heads names={[t("parts.drawn"), t("parts.name"), t("parts.length"), t("parts.time")]} unseen={[t("parts.drawn")]} />
          <tbody>
            {parts.map((part) => (
              <tr key={part.n} data-testid={`part-${part.n}`}>
                <td>
                  <input
                    type="checkbox"
                    aria-label={t("parts.draw", { name: part.name ?? part.color ?? part.n })}
                    checked={!part.skipped}
                    data-testid={`part-only-${part.n}`}
                    onChange={(event) => tick(part, event.currentTarget.checked)}
                  />
                </td>
                <th scope="row">
                  <span class="swatch" style={{ background: part.color ?? "var(--planned)" }} /> {part.name ?? part.color ?? part.n}
                </th>
                <td class="number">{`${Math.round(part.drawn_mm)} mm`}</td>
                <td class="number">{part.seconds === null ? "–" : duration(part.seconds)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <label class="tick">
        <input type="checkbox" checked={check.valueOf("no_pause") !== "true"} data-testid="parts-pause" onChange={(event) => check.setValue("no_pause", String(!event.currentTarget.checked))} />
        <span>{t("parts.pause")}</span>
      </label>
    </Card>
  );
}
