// World around a virtual arm: its objects, its drawing, and actions by hand.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt, reportError } from "../actions";
import type { Params } from "../client";
import { t, translated } from "../i18n";
import { save } from "../log";
import { call, shownArm } from "../session";
import * as store from "../store";
import { Button, Card, Field, NumberInput, OpenFile, Pick, Range, Switch } from "../ui/parts";
import { boundsOf, pathOf, READER, toReader, viewBox } from "../view/flat";
import { onObjectDragged } from "../view/layers";
import { mutedColor } from "../view/tint";
import { ArmView } from "../view/view";
import { darkness, drawn, hasNoWorld, loadScenario, readWorld, type Stroke, world } from "../view/world";
import { sentencesOf } from "../words";
import { GoTo } from "./objects";
import "./world.css";
import texts from "./world.json";

const w = sentencesOf(texts);

/** Height at which objects are dropped, above everything: they fall onto what is below. */
const DROP_HEIGHT = 300;
const REASON_ID = "world-why";

/** Reason why nothing can be done by hand, as a key of the texts. An unplugged cable does not count. */
const whyNotByHand = () => store.whyBarred(store.socket.value === "up");

async function changeWorld(work: () => Promise<unknown>): Promise<void> {
  await attempt(work);
  void readWorld();
}
const placeObject = (name: string, x: number, y: number) =>
  changeWorld(() => call("world.place", { ...shownArm(), name, at: [x, y, DROP_HEIGHT] }));
const load = (text: string) =>
  changeWorld(async () => {
    const objects = await loadScenario(text);
    store.notify(w("world.begun", { n: objects.length }));
  });

function Scenario({ off }: { off: boolean }) {
  const all = useSignal<Array<{ name: string; title: string | null; text: string }>>([]);
  const isUp = store.socket.value === "up";
  useEffect(() => {
    if (isUp) call("world.scenarios", shownArm()).then(({ scenarios }) => (all.value = scenarios), reportError);
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
            ...all.value.map((one) => ({
              value: one.name,
              text: translated(`scenario.${one.name}`, one.title ?? one.name),
            })),
          ]}
          off={off || noTeacher}
          why={off ? REASON_ID : "world-note"}
          choose={(name) => {
            const wanted = all.value.find((one) => one.name === name);
            if (name === "" || wanted) void load(wanted?.text ?? "");
          }}
        />
        <OpenFile
          id="world-scenario-open"
          accept=".toml"
          off={off || noTeacher}
          why={off ? REASON_ID : "world-note"}
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
const MAX_OBJECT_DISTANCE = 1000;

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
                least={-MAX_OBJECT_DISTANCE}
                most={MAX_OBJECT_DISTANCE}
                off={off}
                why={REASON_ID}
                set={(to) => void placeObject(name, axis === "x" ? to : x, axis === "y" ? to : y)}
              />
            </label>
          );
          return (
            <li key={name} data-testid={`world-object-${name}`}>
              <span class="swatch" style={{ background: mutedColor(color) }} />
              <b>
                {name}
                {held ? <small>{w("world.held")}</small> : null}
              </b>
              {field("x", x)}
              {field("y", y)}
              <output aria-live="off">{`z ${z.toFixed(1)}`}</output>
              <span class="object-do">
                <GoTo thing={thing} off={off || store.why.value !== null} why={REASON_ID} />
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
        <Button
          id="world-paper-save"
          class="quiet small"
          off={strokes.length === 0}
          press={() => save(`${store.armName.value}-drawing.svg`, toReader(svg))}
        >
          {w("world.paper.save")}
        </Button>
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
let isGuiding = false;
let nextJoints: number[] | null = null;
/** Sends joint angles one after the other, always the newest. */
async function guideTo(joints: number[]): Promise<void> {
  nextJoints = joints;
  if (isGuiding) return;
  isGuiding = true;
  while (nextJoints !== null) {
    const to: number[] = nextJoints;
    nextJoints = null;
    await changeWorld(() => call("world.guide", { ...shownArm(), joints: to }));
  }
  isGuiding = false;
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
            set={(to) => guideTo((nextJoints ?? JOINTS.map((one) => store.state.value?.[one] ?? 0)).with(at, to))}
          />
          <output aria-live="off">{`${state[joint].toFixed(1)}°`}</output>
        </label>
      ))}
    </div>
  );
}

function ManualActions({ off }: { off: boolean }) {
  const seen = world.value;
  const press = (long: boolean) => changeWorld(() => call("world.press", { ...shownArm(), long }));
  return (
    <Card title={w("world.hands")}>
      <div class="row" role="group" aria-label={w("world.key")}>
        <Button id="world-press" off={off} why={REASON_ID} text={w("world.press")} press={() => press(false)} />
        <Button
          id="world-press-long"
          off={off}
          why={REASON_ID}
          text={w("world.press.long")}
          press={() => press(true)}
        />
      </div>
      <Switch
        id="world-unlock"
        label={w("world.unlock")}
        on={seen?.unlocked ?? null}
        off={off}
        why={REASON_ID}
        flip={(held) => changeWorld(() => call("world.unlock", { ...shownArm(), held }))}
      />
      {seen?.unlocked && !off ? <Guide /> : null}
      <Switch
        id="world-plugged"
        label={w("world.plugged")}
        on={seen?.plugged ?? null}
        off={off}
        why={REASON_ID}
        flip={(plugged) => changeWorld(() => call("world.unplug", { ...shownArm(), plugged }))}
      />
    </Card>
  );
}

function Faults({ off }: { off: boolean }) {
  const code = useSignal(64);
  const joint = useSignal(2);
  const degrees = useSignal(5);
  const fault = (params: Omit<Params<"world.fault">, "arm">) =>
    changeWorld(() => call("world.fault", { ...shownArm(), ...params }));
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
        <Button
          id="world-slip"
          off={off}
          why={REASON_ID}
          text={w("world.slip")}
          press={() => fault({ fault: "slip", joint: joint.value, degrees: degrees.value })}
        />
      </div>
      <div class="row">
        {number(w("world.alarm.code"), code, 0, 255)}
        <Button
          id="world-alarm"
          off={off}
          why={REASON_ID}
          text={w("world.alarm")}
          press={() => fault({ fault: "alarm", alarm: code.value })}
        />
        <Button
          id="world-reset"
          off={off}
          why={REASON_ID}
          text={w("world.reset")}
          press={() => fault({ fault: "reset" })}
        />
      </div>
    </Card>
  );
}

export function World() {
  const off = whyNotByHand();
  useEffect(() => {
    void readWorld();
    onObjectDragged.value = (name, [x, y]) => {
      if (whyNotByHand() === null) return void placeObject(name, x, y);
      store.notify(t(whyNotByHand() ?? "why.free"), true);
      world.value = world.value === null ? null : { ...world.value };
    };
    return () => {
      onObjectDragged.value = null;
    };
  }, []);
  if (hasNoWorld.value || store.arm.value?.virtual === false || store.backend.value === "none") {
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
          <p class="jog-status off" id={REASON_ID}>
            {t(off)}
          </p>
        )}
        <Scenario off={off !== null} />
        <Objects off={off !== null} />
        <Paper />
        <ManualActions off={off !== null} />
        <Faults off={off !== null} />
      </div>
    </div>
  );
}
