// The world around a virtual arm: what stands there, what was drawn, and what a hand does.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { complain } from "../actions";
import type { Params } from "../client";
import { t } from "../i18n";
import { save } from "../log";
import { call, shown } from "../session";
import * as store from "../store";
import { Card, Do, NumberInput, Switch } from "../ui/parts";
import { hand } from "../view/layers";
import { drawn, look, world, worldless } from "../view/seen";
import { ArmView } from "../view/view";
import "./world.css";

/** Above everything: what is put there falls onto what is below. */
const ABOVE = 300;
const WHY = "world-why";

/** Why a hand cannot do anything, as a key of the texts. A cable that is out is no reason. */
function why(): "why.closed" | "why.lost" | "why.viewer" | "why.other" | "why.free" | null {
  if (store.socket.value !== "up") return store.socket.value === "closed" ? "why.closed" : "why.lost";
  if (store.role.value === "viewer") return "why.viewer";
  return store.lease.value === "mine" ? null : store.lease.value === "other" ? "why.other" : "why.free";
}

async function done(work: () => Promise<unknown>): Promise<void> {
  try {
    await work();
  } catch (error) {
    complain(error);
  }
  void look();
}
const place = (name: string, x: number, y: number) => done(() => call("world.place", { ...shown(), name, at: [x, y, ABOVE] }));
const begin = (text: string) =>
  done(async () => {
    const { objects } = await call("world.scenario", { ...shown(), text });
    store.say(t("world.begun", { n: objects.length }));
  });

function Scenario({ off }: { off: boolean }) {
  const all = useSignal<Array<{ name: string; title: string | null; text: string }>>([]);
  useEffect(() => {
    call("world.scenarios", shown()).then(({ scenarios }) => (all.value = scenarios), complain);
  }, [store.armName.value]);
  const title = world.value?.title ?? null;
  const current = title === null && world.value?.table == null ? "" : (all.value.find((one) => one.title === title)?.name ?? "own");
  const noTeacher = store.role.value !== "teacher";
  return (
    <Card title={t("world.scenario")}>
      <div class="row">
        <label class="field">
          <span>{t("world.scenario.pick")}</span>
          <select
            data-testid="world-scenario"
            value={current}
            disabled={off || noTeacher}
            aria-describedby={off ? WHY : "world-note"}
            onChange={(event) => {
              const name = event.currentTarget.value;
              const wanted = all.value.find((one) => one.name === name);
              if (name === "" || wanted) void begin(wanted?.text ?? "");
            }}
          >
            <option value="">{t("world.empty")}</option>
            {current === "own" ? <option value="own">{title ?? t("world.own")}</option> : null}
            {all.value.map((one) => (
              <option key={one.name} value={one.name}>
                {one.title}
              </option>
            ))}
          </select>
        </label>
        <label class="pick-file">
          <span>{t("world.open")}</span>
          <input
            type="file"
            accept=".toml"
            data-testid="world-scenario-open"
            disabled={off || noTeacher}
            aria-describedby={off ? WHY : "world-note"}
            onChange={(event) => {
              const input = event.currentTarget;
              const [file] = input.files ?? [];
              if (file) void file.text().then(begin).finally(() => (input.value = ""));
            }}
          />
        </label>
      </div>
      <p class="hint" id="world-note">
        {t(noTeacher ? "world.teacher" : "world.note")}
      </p>
    </Card>
  );
}

function Objects({ off }: { off: boolean }) {
  const objects = world.value?.objects ?? [];
  if (objects.length === 0) return null;
  return (
    <Card title={t("world.objects")}>
      <p class="hint">{t("world.objects.hint")}</p>
      <ul class="objects">
        {objects.map(({ name, color, held, at: [x = 0, y = 0, z = 0] }) => {
          const field = (axis: "x" | "y", value: number) => (
            <label>
              {axis}
              <NumberInput
                label={t("world.object.axis", { name, axis })}
                value={value}
                step={5}
                off={off}
                why={WHY}
                set={(to) => void place(name, axis === "x" ? to : x, axis === "y" ? to : y)}
              />
            </label>
          );
          return (
            <li key={name} data-testid={`world-object-${name}`}>
              <span class="swatch" style={{ background: color }} />
              <b>
                {name}
                {held ? <small>{t("world.held")}</small> : null}
              </b>
              {field("x", x)}
              {field("y", y)}
              <output aria-live="off">{`z ${z.toFixed(1)}`}</output>
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
  const points = strokes.flatMap((stroke) => stroke.points);
  const sides = [0, 1].map((axis) => {
    const all = points.map((point) => point[axis] ?? 0).concat(axis === 0 ? (table?.x ?? []) : (table?.y ?? []));
    const kept = all.filter((value) => Math.abs(value) < 500);
    const [least, most] = kept.reduce(([least, most], value) => [Math.min(least, value), Math.max(most, value)], [Infinity, -Infinity] as [number, number]);
    return kept.length === 0 ? [150, 300] as const : [least - 5, most + 5] as const;
  });
  const [[left = 0, right = 0] = [], [bottom = 0, top = 0] = []] = sides;
  // A stroke that grew is long: its text is made once for each of its states.
  const path = (line: number[][]) => `M${line.map(([x = 0, y = 0]) => `${x} ${-y}`).join("L")}${line.length === 1 ? "h0" : ""}`;
  return (
    <Card
      title={t("world.paper")}
      more={
        <Do id="world-paper-save" class="quiet small" off={strokes.length === 0} press={() => save(`${store.armName.value}-drawing.svg`, svg)}>
          {t("world.paper.save")}
        </Do>
      }
    >
      <svg class={`paper ${strokes.length === 0 ? "blank" : ""}`} data-testid="world-paper" role="img" aria-label={t("world.paper.text", { n: strokes.length })} viewBox={`${left} ${-top} ${right - left} ${top - bottom}`}>
        {table == null ? null : <rect x={left + 5} y={5 - top} width={right - left - 10} height={top - bottom - 10} />}
        {(["ink", "burnt"] as const).map((kind) => (
          <path key={kind} class={kind} d={strokes.filter((stroke) => stroke.burnt === (kind === "burnt")).map((stroke) => path(stroke.points)).join("")} />
        ))}
      </svg>
      {strokes.length === 0 ? <p class="hint" data-testid="world-paper-none">{t(world.value?.draws == null ? "world.draws.none" : "world.paper.none")}</p> : null}
    </Card>
  );
}

const JOINTS = ["j1", "j2", "j3", "j4"] as const;
let guiding = false;
let next: number[] | null = null;
/** One after the other, the newest one last. */
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
    <div class="guide" role="group" aria-label={t("world.guide")}>
      <p class="hint">{t("world.guide.text")}</p>
      {JOINTS.map((joint, at) => (
        <label key={joint}>
          <b>{joint.toUpperCase()}</b>
          <input
            type="range"
            min={limits[joint][0]}
            max={limits[joint][1]}
            step={0.5}
            value={state[joint]}
            data-testid={`world-guide-${joint}`}
            onInput={(event) => {
              const to = event.currentTarget.valueAsNumber;
              const now = next ?? JOINTS.map((joint) => store.state.value?.[joint] ?? 0);
              void guide(now.map((value, nth) => (nth === at ? to : value)));
            }}
          />
          <output aria-live="off">{`${state[joint].toFixed(1)}°`}</output>
        </label>
      ))}
    </div>
  );
}

function Hands({ off }: { off: boolean }) {
  const seen = world.value;
  const reason = off ? WHY : undefined;
  const press = (long: boolean) => done(() => call("world.press", { ...shown(), long }));
  return (
    <Card title={t("world.hands")}>
      <div class="row" role="group" aria-label={t("world.key")}>
        <Do id="world-press" off={off} why={reason} press={() => press(false)}>
          {t("world.press")}
        </Do>
        <Do id="world-press-long" off={off} why={reason} press={() => press(true)}>
          {t("world.press.long")}
        </Do>
      </div>
      <Switch
        label={t("world.unlock")}
        testId="world-unlock"
        on={seen?.unlocked ?? null}
        disabled={off}
        reason={reason}
        flip={(held) => void done(() => call("world.unlock", { ...shown(), held }))}
      />
      {seen?.unlocked && !off ? <Guide /> : null}
      <Switch
        label={t("world.plugged")}
        testId="world-plugged"
        on={seen?.plugged ?? null}
        disabled={off}
        reason={reason}
        flip={(plugged) => void done(() => call("world.unplug", { ...shown(), plugged }))}
      />
    </Card>
  );
}

function Faults({ off }: { off: boolean }) {
  const code = useSignal(64);
  const joint = useSignal(2);
  const degrees = useSignal(5);
  const reason = off ? WHY : undefined;
  const fault = (params: Omit<Params<"world.fault">, "arm">) => done(() => call("world.fault", { ...shown(), ...params }));
  const number = (label: string, value: typeof code, least: number, most: number) => (
    <label class="field">
      <span>{label}</span>
      <input type="number" min={least} max={most} value={value.value} disabled={off} onInput={(event) => (value.value = event.currentTarget.valueAsNumber)} />
    </label>
  );
  return (
    <Card title={t("world.faults")}>
      <p class="hint">{t("world.faults.text")}</p>
      <div class="row">
        {number(t("world.slip.joint"), joint, 1, 4)}
        {number(t("world.slip.by"), degrees, -90, 90)}
        <Do id="world-slip" off={off} why={reason} press={() => fault({ fault: "slip", joint: joint.value, degrees: degrees.value })}>
          {t("world.slip")}
        </Do>
      </div>
      <div class="row">
        {number(t("world.alarm.code"), code, 0, 255)}
        <Do id="world-alarm" off={off} why={reason} press={() => fault({ fault: "alarm", alarm: code.value })}>
          {t("world.alarm")}
        </Do>
        <Do id="world-reset" off={off} why={reason} press={() => fault({ fault: "reset" })}>
          {t("world.reset")}
        </Do>
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
        <p>{t(store.backend.value === "none" ? "why.closed" : "world.none")}</p>
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
