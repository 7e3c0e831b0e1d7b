// Table of points: one row per move, edited in place.
import { useSignal } from "@preact/signals";
import { playedRow, toolWait } from "../teach/actions";
import * as program from "../teach/rows";
import { type Word, w } from "../teach/words";
import { ColumnHeads, NumberInput, Pick } from "../ui/parts";

const WAYS = ["joints", "line", "jump"] as const;
const AXES = { move: ["x", "y", "z", "r"], joints: ["J1", "J2", "J3", "J4"] } as const;
/** Members of a row that describe a tool's action. */
const TOOLS: Record<string, Partial<program.Row>> = {
  none: { gripper: null, suction: null },
  suction: { gripper: null, suction: true },
  release: { gripper: null, suction: false },
  close: { gripper: "close", suction: null },
  open: { gripper: "open", suction: null },
  off: { gripper: "off", suction: null },
};

/**
 * Wait of a row. A tool needs time to grip or release, so a row with an action waits unless the
 * user has set a time.
 */
const waitOf = ({ wait }: program.Row, tool: string): number | null => {
  if (tool === "none") return wait === toolWait.value ? null : wait;
  return wait ?? (toolWait.value > 0 ? toolWait.value : null);
};

const toolOf = ({ gripper, suction }: program.Row) => {
  const found = Object.entries(TOOLS).find(([, row]) => row.gripper === gripper && row.suction === suction);
  return found?.[0] ?? "both";
};

/** Text of a row other than a plain move, in the terms of the plan. */
function motionText(motion: program.Motion): string {
  const { command, values, ...rest } = motion;
  const shown = typeof command === "string" ? { [command]: values } : rest;
  return JSON.stringify(shown)
    .replace(/[{}"]/g, "")
    .replace(/([:,])/g, "$1 ");
}

function Motion({ row, nth }: { row: program.Row; nth: number }) {
  const motion = row.motion as program.Motion | null;
  const kind = motion?.move ? "move" : motion?.joints ? "joints" : null;
  if (motion === null || kind === null) {
    return (
      <td class="plain" colSpan={5} data-label={w("teach.way")}>
        {motion === null ? "–" : motionText(motion)}
      </td>
    );
  }
  const values = motion[kind] ?? [];
  const ways = kind === "move" ? WAYS : WAYS.slice(0, 2);
  return (
    <>
      <td class="way-cell" data-label={w("teach.way")}>
        <Pick
          label={w("teach.wayOf", { n: nth + 1 })}
          value={motion.by ?? "joints"}
          options={ways.map((way) => ({ value: way as string, text: w(`teach.${way}`) }))}
          choose={(by) => program.edit(nth, { motion: { ...motion, by } })}
        />
      </td>
      {AXES[kind].map((axis, at) => (
        <td key={axis} class="number" data-label={axis}>
          <NumberInput
            label={w("teach.valueOf", { axis, n: nth + 1 })}
            digits={2}
            value={values[at] ?? 0}
            set={(value) => program.edit(nth, { motion: { ...motion, [kind]: values.with(at, value) } })}
          />
        </td>
      ))}
    </>
  );
}

/** Row of the table at a position of the page; null elsewhere. */
function rowAt(x: number, y: number): number | null {
  const found = document.elementFromPoint(x, y)?.closest<HTMLElement>("[data-nth]")?.dataset.nth;
  return found === undefined ? null : Number(found);
}

function Row({ row, nth, over }: { row: program.Row; nth: number; over: { value: number | null } }) {
  const n = nth + 1;
  const tool = toolOf(row);
  const runs = playedRow.value === nth;
  const isSelected = program.selected.value === nth;
  const drop = (event: PointerEvent) => {
    const to = over.value;
    over.value = null;
    if (event.type === "pointerup" && to !== null) program.move(nth, to);
  };
  return (
    <tr
      data-testid={`teach-row-${n}`}
      data-nth={nth}
      class={`${isSelected ? "selected" : ""} ${over.value === nth ? "over" : ""}`}
      aria-selected={isSelected}
      aria-current={runs ? "step" : undefined}
      onFocusIn={() => (program.selected.value = nth)}
      onClick={() => (program.selected.value = nth)}
      onKeyDown={(event) => {
        const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
        if (by === undefined || !event.altKey) return;
        event.preventDefault();
        const pick = event.currentTarget.parentElement?.querySelector<HTMLElement>(
          `[data-testid=teach-pick-${n + by}]`,
        );
        program.move(nth, nth + by);
        pick?.focus();
      }}
    >
      <td class="pick-cell">
        <input
          type="checkbox"
          aria-label={w("teach.pick", { n })}
          checked={program.tickedRows.value.has(row)}
          data-testid={`teach-pick-${n}`}
          onChange={(event) => program.tickRow(row, event.currentTarget.checked)}
        />
      </td>
      <th
        scope="row"
        class="row-grip"
        title={w("teach.drag")}
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          over.value = nth;
        }}
        onPointerMove={(event) => {
          if (over.value !== null) over.value = rowAt(event.clientX, event.clientY) ?? over.value;
        }}
        onPointerUp={drop}
        onPointerCancel={drop}
      >
        <span aria-hidden="true">⠿</span>
        {n}
      </th>
      <td class="name" data-label={w("teach.name")}>
        <input
          type="text"
          autocomplete="off"
          maxLength={80}
          aria-label={w("teach.nameOf", { n })}
          value={row.name}
          onChange={(event) => program.edit(nth, { name: event.currentTarget.value.trim() })}
        />
      </td>
      <Motion row={row} nth={nth} />
      <td class="tool-cell" data-label={w("teach.tool")}>
        <Pick
          label={w("teach.toolOf", { n })}
          value={tool}
          options={[...(tool === "both" ? ["both"] : []), ...Object.keys(TOOLS)].map((value) => ({
            value,
            text: w(`teach.tool.${value}` as Word),
          }))}
          choose={(name) => program.edit(nth, { ...TOOLS[name], wait: waitOf(row, name) })}
        />
      </td>
      <td class="number wait-cell" data-label={w("teach.wait")}>
        <NumberInput
          label={w("teach.waitOf", { n })}
          digits={2}
          least={0}
          value={row.wait ?? 0}
          set={(wait) => program.edit(nth, { wait: wait > 0 ? wait : null })}
        />
      </td>
    </tr>
  );
}

export function Points() {
  const over = useSignal<number | null>(null);
  const all = program.rows.value;
  if (all.length === 0) return <p class="hint empty">{w("teach.empty")}</p>;
  const heads = [
    w("teach.picked"),
    w("teach.n"),
    w("teach.name"),
    w("teach.way"),
    ...AXES.move,
    w("teach.tool"),
    w("teach.wait"),
  ];
  return (
    <div class="points-scroll" tabIndex={0} role="group" aria-label={w("teach.points")}>
      <table class="points" aria-label={w("teach.points")}>
        <ColumnHeads names={heads} unseen={heads.slice(0, 1)} />
        <tbody>
          {all.map((row, nth) => (
            <Row key={nth} row={row} nth={nth} over={over} />
          ))}
        </tbody>
      </table>
    </div>
  );
}
