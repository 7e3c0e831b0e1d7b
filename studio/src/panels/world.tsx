// World around a virtual arm: its objects, its drawing, and actions by hand.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { complain, tried } from "../actions";
import type { Params } from "../client";
import { t, told } from "../i18n";
import { save } from "../log";
import { call, shown } from "../session";
import * as store from "../store";
import { Card, Do, Field, NumberInput, OpenFile, Pick, Range, Switch } from "../ui/parts";
import { boundsOf, pathOf, READER, toReader, viewBox } from "../view/flat";
import { hand } from "../view/layers";
import { begin, darkness, drawn, look, type Stroke, world, worldless } from "../view/seen";
import { tinted } from "../view/tint";
import { ArmView } from "../view/view";
import { sentencesOf } from "../words";
import { GoTo } from "./objects";
import "./world.css";
import texts from "./world.json";

const w = sentencesOf(texts);

/** Height at which objects are dropped, above everything: they fall onto what is below. */
const ABOVE = 300;
const WHY = "world-why";

/** Reason why nothing can be done by hand, as a key of the texts. An unplugged cable does not count. */
const why = () => store.barred(store.socket.value === "up");

async function done(work: () => Promise<unknown>): Promise<void> {
  await tried(work);
  void look();
}
const place = (name: string, x: number, y: number) =>
  done(() => call("world.place", { ...shown(), name, at: [x, y, ABOVE] }));
const load = (text: string) =>
  done(async () => {
    const objects = await begin(text);
    store.say(w("world.begun", { n: objects.length }));
  });

function Scenario({ off }: { off: boolean }) {
  const all = useSignal<Array<{ name: string; title: string | null; text: string }>>([]);
  const isUp = store.socket.value === "up";
  useEffect(() => {
    if (isUp) call("world.scenarios", shown()).then(({ scenarios }) => (all.value = scenarios), complain);
  }, [store.armName.value, isUp]);
  const title = world.value?.title ?? null;
  const current =
    title === null && world.value?.table == null ? "" : (all.value.find((one) => one.title === title)?.name ?? "own");
  const noTeacher = store.role.value !== "teacher";
  return (
    <Card title={w("world.scenario")}>
      <div class="row">
        <Pick
          title={w("world.scenario.pick")}
          id="world-scenario"
          value={current}
          options={[
            { value: "", text: w("world.empty") },
            ...(current === "own" ? [{ value: "own", text: title ?? w("world.own") }] : []),
            ...all.value.map((one) => ({ value: one.name, text: told(`scenario.${one.name}`, one.title ?? one.name) })),
          ]}
          off={off || noTeacher}
          why={off ? WHY : "world-note"}
          choose={(name) => {
            const wanted = all.value.find((one) => one.name === name);
            if (name === "" || wanted) void load(wanted?.text ?? "");
          }}
        />
        <OpenFile
          id="world-scenario-open"
          accept=".toml"
          off={off || noTeacher}
          why={off ? WHY : "world-note"}
          text={w("world.open")}
          open={async ([file]) => file && load(await file.text())}
        />
      </div>
      <p class="hint" id="world-note">
        {noTeacher ? t("world.teacher") : w("world.note")}
      </p>
    </Card>
  );
}

/** An object farther from the arm than this is not to be found again, mm. */
const FARTHEST = 1000;

function Objects({ off }: { off: boolean }) {
  const objects = world.value?.objects ?? [];
  if (objects.length === 0) return null;
  return (
    <Card title={w("world.objects")}>
      <p class="hint">{w("world.objects.hint")}</p>
      <ul class="objects">
        {objects.map((thing) => {
          const { name, color, held } = thing;
          const [x = 0, y = 0, z = 0] = thing.at;
          const field = (axis: "x" | "y", value: number) => (
            <label>
              {axis}
              <NumberInput
                label={w("world.object.axis", { name, axis })}
                value={value}
                step={5}
                least={-FARTHEST}
                most={FARTHEST}
                off={off}
                why={WHY}
                set={(to) => void place(name, axis === "x" ? to : x, axis === "y" ? to : y)}
              />
            </label>
          );
          return (
            <li key={name} data-testid={`world-object-${name}`}>
              <span class="swatch" style={{ background: tinted(color) }} />
              <b>
                {name}
                {held ? <small>{w("world.held")}</small> : null}
              </b>
              {field("x", x)}
              {field("y", y)}
              <output aria-live="off">{`z ${z.toFixed(1)}`}</output>
              <span class="object-do">
                <GoTo thing={thing} off={off || store.why.value !== null} why={WHY} />
              </span>
            </li>
          );
        })}
      </ul>
    </Card>
  );
}

function Paper() {
  const { svg, strokes } = drawn.value;
  const table = world.value?.table;
  const corners =
    table == null
      ? []
      : [
          [table.x[0] ?? 0, table.y[0] ?? 0],
          [table.x[1] ?? 0, table.y[1] ?? 0],
        ];
  const kept = [...corners, ...strokes.flatMap((stroke) => stroke.points)].filter((point) =>
    point.every((value) => Math.abs(value) < 500),
  );
  const lines = new Map<string, { of: Stroke; data: string[] }>();
  for (const stroke of strokes) {
    const look = `${stroke.burnt} ${darkness(stroke)} ${stroke.points.length === 1}`;
    const line = lines.get(look) ?? { of: stroke, data: [] };
    line.data.push(pathOf(stroke.points));
    lines.set(look, line);
  }
  const frame = kept.length === 0 ? { x: 150, y: -150, width: 150, height: 300 } : boundsOf(kept, 5);
  return (
    <Card
      title={w("world.paper")}
      more={
        <Do
          id="world-paper-save"
          class="quiet small"
          off={strokes.length === 0}
          press={() => save(`${store.armName.value}-drawing.svg`, toReader(svg))}
        >
          {w("world.paper.save")}
        </Do>
      }
    >
      <svg
        class={`paper ${strokes.length === 0 ? "blank" : ""}`}
        data-testid="world-paper"
        role="img"
        aria-label={w("world.paper.text", { n: strokes.length })}
        viewBox={viewBox(frame)}
      >
        <g transform={READER}>
          {table == null ? null : <rect {...boundsOf(kept)} />}
          {[...lines].map(
            ([
              look,
              {
                of: { burnt, points },
                data,
              },
            ]) => (
              <path
                key={look}
                class={`${burnt ? "burnt" : "ink"} ${points.length === 1 ? "dot" : ""}`}
                stroke-opacity={look.split(" ")[1]}
                d={data.join("")}
              />
            ),
          )}
        </g>
      </svg>
      {strokes.length === 0 ? (
        <p class="hint" data-testid="world-paper-none">
          {w(world.value?.draws == null ? "world.draws.none" : "world.paper.none")}
        </p>
      ) : null}
    </Card>
  );
}

const JOINTS = ["j1", "j2", "j3", "j4"] as const;
let guiding = false;
let next: number[] | null = null;
/** Sends joint angles one after the other, always the newest. */
async function guide(joints: number[]): Promise<void> {
  next = joints;
  if (guiding) return;
  guiding = true;
  while (next !== null) {
    const to: number[] = next;
    next = null;
    await done(() => call("world.guide", { ...shown(), joints: to }));
  }
  guiding = false;
}

function Guide() {
  const state = store.state.value;
  const limits = store.model.value?.limits;
  if (state === null || limits === undefined) return null;
  return (
    <div class="guide" role="group" aria-label={w("world.guide")}>
      <p class="hint">{w("world.guide.text")}</p>
      {JOINTS.map((joint, at) => (
        <label key={joint}>
          <b>{joint.toUpperCase()}</b>
          <Range
            id={`world-guide-${joint}`}
            least={limits[joint][0] ?? 0}
            most={limits[joint][1] ?? 0}
            step={0.5}
            value={state[joint]}
            set={(to) => guide((next ?? JOINTS.map((one) => store.state.value?.[one] ?? 0)).with(at, to))}
          />
          <output aria-live="off">{`${state[joint].toFixed(1)}°`}</output>
        </label>
      ))}
    </div>
  );
}

function Hands({ off }: { off: boolean }) {
  const seen = world.value;
  const press = (long: boolean) => done(() => call("world.press", { ...shown(), long }));
  return (
    <Card title={w("world.hands")}>
      <div class="row" role="group" aria-label={w("world.key")}>
        <Do id="world-press" off={off} why={WHY} text={w("world.press")} press={() => press(false)} />
        <Do id="world-press-long" off={off} why={WHY} text={w("world.press.long")} press={() => press(true)} />
      </div>
      <Switch
        id="world-unlock"
        label={w("world.unlock")}
        on={seen?.unlocked ?? null}
        off={off}
        why={WHY}
        flip={(held) => done(() => call("world.unlock", { ...shown(), held }))}
      />
      {seen?.unlocked && !off ? <Guide /> : null}
      <Switch
        id="world-plugged"
        label={w("world.plugged")}
        on={seen?.plugged ?? null}
        off={off}
        why={WHY}
        flip={(plugged) => done(() => call("world.unplug", { ...shown(), plugged }))}
      />
    </Card>
  );
}

function Faults({ off }: { off: boolean }) {
  const code = useSignal(64);
  const joint = useSignal(2);
  const degrees = useSignal(5);
  const fault = (params: Omit<Params<"world.fault">, "arm">) =>
    done(() => call("world.fault", { ...shown(), ...params }));
  const number = (label: string, value: typeof code, least: number, most: number) => (
    <Field label={label}>
      <NumberInput
        label={label}
        step={1}
        least={least}
        most={most}
        value={value.value}
        off={off}
        set={(to) => (value.value = to)}
      />
    </Field>
  );
  return (
    <Card title={w("world.faults")}>
      <p class="hint">{w("world.faults.text")}</p>
      <div class="row">
        {number(w("world.slip.joint"), joint, 1, 4)}
        {number(w("world.slip.by"), degrees, -90, 90)}
        <Do
          id="world-slip"
          off={off}
          why={WHY}
          text={w("world.slip")}
          press={() => fault({ fault: "slip", joint: joint.value, degrees: degrees.value })}
        />
      </div>
      <div class="row">
        {number(w("world.alarm.code"), code, 0, 255)}
        <Do
          id="world-alarm"
          off={off}
          why={WHY}
          text={w("world.alarm")}
          press={() => fault({ fault: "alarm", alarm: code.value })}
        />
        <Do id="world-reset" off={off} why={WHY} text={w("world.reset")} press={() => fault({ fault: "reset" })} />
      </div>
    </Card>
  );
}

export function World() {
  const off = why();
  useEffect(() => {
    void look();
    hand.value = (name, [x, y]) => {
      if (why() === null) return void place(name, x, y);
      store.say(t(why() ?? "why.free"), true);
      world.value = world.value === null ? null : { ...world.value };
    };
    return () => {
      hand.value = null;
    };
  }, []);
  if (worldless.value || store.arm.value?.virtual === false || store.backend.value === "none") {
    return (
      <Card title={t("nav.world")}>
        <p>{store.backend.value === "none" ? t("why.closed") : w("world.none")}</p>
      </Card>
    );
  }
  return (
    <div class="move world">
      <div class="move-look">
        <ArmView />
      </div>
      <div class="move-do" role="group" aria-label={t("nav.world")}>
        {off === null ? null : (
          <p class="jog-status off" id={WHY}>
            {t(off)}
          </p>
        )}
        <Scenario off={off !== null} />
        <Objects off={off !== null} />
        <Paper />
        <Hands off={off !== null} />
        <Faults off={off !== null} />
      </div>
    </div>
  );
}
