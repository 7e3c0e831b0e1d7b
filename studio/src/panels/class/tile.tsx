// Tile of one arm in a lesson, for the teacher.
import { tried } from "../../actions";
import { type ArmTurn, clockOf, turnAt, turns } from "../../class";
import { t } from "../../i18n";
import { call } from "../../session";
import { isKnown } from "../../site";
import * as store from "../../store";
import { Do } from "../../ui/parts";
import { forPupil } from "./conduct";
import { reasonOf } from "./reasons";
import { w } from "./words";

/** True if the schedule reserves the arm for the teacher. */
export const isTeachers = (turn: ArmTurn | null): boolean => turn?.slot != null && turn.slot.until === null;

export function TeacherTile({ arm }: { arm: store.ArmEntry }) {
  const { name } = arm;
  const turn = turnAt(name);
  const off = !isKnown(arm);
  const slot = turn?.slot ?? null;
  const waits = turns.value?.queue.some(({ arms }) => arms.includes(name)) === true;
  return (
    <div class="tile-teacher">
      {slot === null || slot.until === null ? null : (
        <p class="tile-line" data-testid={`slot-${name}`}>
          {w("tile.slot", { who: slot.who.join(", "), time: clockOf(slot.until) })}
        </p>
      )}
      {slot === null && turn?.free_at != null ? (
        <p class="tile-line" data-testid={`slot-${name}`}>
          {w("tile.closed", { time: clockOf(turn.free_at) })}
        </p>
      ) : null}
      {(turn?.jobs ?? []).map(({ job, title, person, reason }) => (
        <p key={job} class="tile-line" data-testid={`queued-${name}`}>
          {[person, title || w("class.untitled")].filter(Boolean).join(": ")} <small>{reasonOf(reason)}</small>
        </p>
      ))}
      <div class="tile-buttons">
        <Do
          id={`tile-home-${name}`}
          off={off}
          label={w("tile.home", { name })}
          text={t("home")}
          press={() => tried(() => forPupil(name, "arm.home", w("tile.home", { name })))}
        />
        <Do
          id={`tile-clear-${name}`}
          off={off}
          label={w("tile.clear", { name })}
          text={w("tile.clear.short")}
          press={() => tried(() => forPupil(name, "arm.clear_alarms", w("tile.clear", { name })))}
        />
        {store.hub.value ? null : (
          <>
            <Do
              id={`tile-end-${name}`}
              off={!turn?.person}
              label={w("tile.end", { name })}
              text={w("tile.end.short")}
              press={() => tried(() => call("turn.end", { arm: name }))}
            />
            <Do
              id={`tile-next-${name}`}
              off={!turn?.person || !waits}
              label={w("tile.next", { name })}
              text={w("tile.next.short")}
              press={() => tried(() => call("turn.next", { arm: name }))}
            />
          </>
        )}
      </div>
    </div>
  );
}
