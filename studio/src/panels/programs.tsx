// Library of programs: open, select, delete.
import { attempt } from "../actions";
import { t, translated } from "../i18n";
import * as check from "../run/check";
import * as library from "../run/programs";
import * as store from "../store";
import { Button, Card, ColumnHeads, DropZone, OpenFile } from "../ui/parts";
import { sentencesOf } from "../words";
import texts from "./programs.json";

const w = sentencesOf(texts);

export const ACCEPTED_FILES =
  ".gcode,.nc,.ngc,.gc,.g,.tap,.svg,.svgz,.dxf,.plt,.hpgl,.png,.jpg,.jpeg,.bmp,.webp,.gif,.tif,.tiff,.playback,.blockly,.csv,.xyz,.json,.plan,.xml,.txt";

export const formatOf = (format: string | null) =>
  format === null ? t("format.none") : translated(`format.${format}`, format);
export function formatSize(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  return bytes < 1e6 ? `${(bytes / 1000).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

export function Programs() {
  const all = library.programs.value;
  const off = !store.isUp.value || store.role.value === "viewer";
  return (
    <Card
      title={w("programs.title")}
      class="programs"
      more={
        <OpenFile
          id="program-open"
          class="primary small"
          accept={ACCEPTED_FILES}
          off={off}
          text={t(library.isLoading.value ? "programs.loading" : "programs.open")}
          open={check.openFiles}
        />
      }
    >
      <DropZone off={off} open={check.openFiles}>
        {all.length === 0 ? (
          <p class="hint">{w("programs.empty")}</p>
        ) : (
          <div class="scroll" tabIndex={0} role="group" aria-label={w("programs.title")}>
            <table>
              <ColumnHeads
                names={[w("programs.name"), t("programs.format"), w("programs.size"), t("programs.delete")]}
                unseen={[t("programs.delete")]}
              />
              <tbody>
                {all.map((program) => (
                  <Program key={program.name} program={program} />
                ))}
              </tbody>
            </table>
          </div>
        )}
      </DropZone>
    </Card>
  );
}

function Program({ program }: { program: library.Entry }) {
  const { name, bytes, format } = program;
  const isSelected = check.selected.value === name;
  const pick = () => void check.runWorkshop.select(name);
  const remove = () =>
    attempt(async () => {
      await library.deleteProgram(name);
      if (isSelected && check.entry.value === null) await check.runWorkshop.select(null);
    });
  return (
    <tr data-testid={`program-${name}`} aria-selected={isSelected}>
      <th scope="row">
        <button type="button" class="link" aria-pressed={isSelected} onClick={pick}>
          {name}
        </button>
      </th>
      <td onClick={pick}>{formatOf(format)}</td>
      <td class="number" onClick={pick}>
        {formatSize(bytes)}
      </td>
      <td>
        <Button
          id={`delete-${name}`}
          class="quiet small icon"
          label={w("programs.deleteOne", { name })}
          off={store.role.value === "viewer"}
          text="✕"
          press={remove}
        />
      </td>
    </tr>
  );
}
