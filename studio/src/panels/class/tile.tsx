// Tile of one arm in a lesson, for the teacher.
import { attempt } from "../../actions";
import { type ArmTurn, formatTime, turnOfArm, turns } from "../../class";
import { t } from "../../i18n";
import { call } from "../../session";
import { isKnown } from "../../site";
import * as store from "../../store";
import { Button } from "../../ui/parts";
import { commandArm } from "./conduct";
import { reasonOf } from "./reasons";
import { w } from "./words";

/** True if the schedule reserves the arm for the teacher. */
export const isReservedForTeacher = (turn: ArmTurn | null): boolean => turn?.slot != null && turn.slot.until === null;

export function TeacherTile({ arm }: { arm: store.ArmEntry }) {
  const { name } = arm;
  const turn = turnOfArm(name);
  const off = !isKnown(arm);
  const slot = turn?.slot ?? null;
  const waits = turns.value?.queue.some(({ arms }) => arms.includes(name)) === true;
  return (
    <div class="tile-teacher">
      {slot === null || slot.until === null ? null : (
        <p class="tile-line" data-testid={`slot-${name}`}>
          {w("tile.slot", { who: slot.who.join(", "), time: formatTime(slot.until) })}
        </p>
      )}
      {slot === null && turn?.free_at != null ? (
        <p class="tile-line" data-testid={`slot-${name}`}>
          {w("tile.closed", { time: formatTime(turn.free_at) })}
        </p>
      ) : null}
      {(turn?.jobs ?? []).map(({ job, title, person, reason }) => (
        <p key={job} class="tile-line" data-testid={`queued-${name}`}>
          {[person, title || w("class.untitled")].filter(Boolean).join(": ")} <small>{reasonOf(reason)}</small>
        </p>
      ))}
      <div class="tile-buttons">
        <Button
          id={`tile-home-${name}`}
          off={off}
          label={w("tile.home", { name })}
          text={t("home")}
          press={() => attempt(() => commandArm(name, "arm.home", w("tile.home", { name })))}
        />
        <Button
          id={`tile-clear-${name}`}
          off={off}
          label={w("tile.clear", { name })}
          text={w("tile.clear.short")}
          press={() => attempt(() => commandArm(name, "arm.clear_alarms", w("tile.clear", { name })))}
        />
        {store.hub.value ? null : (
          <>
            <Button
              id={`tile-end-${name}`}
              off={!turn?.person}
              label={w("tile.end", { name })}
              text={w("tile.end.short")}
              press={() => attempt(() => call("turn.end", { arm: name }))}
            />
            <Button
              id={`tile-next-${name}`}
              off={!turn?.person || !waits}
              label={w("tile.next", { name })}
              text={w("tile.next.short")}
              press={() => attempt(() => call("turn.next", { arm: name }))}
            />
          </>
        )}
      </div>
    </div>
  );
}
