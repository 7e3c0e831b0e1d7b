// Immediate actions: homing, tools, speed.
import * as actions from "../actions";
import { t, translated } from "../i18n";
import * as store from "../store";
import { Button, Card, Field, Pick, Range, Switch } from "../ui/parts";

const TOOLS = ["none", "suction", "gripper", "pen", "laser"] as const;
const GRIPPER = ["open", "closed", "off"] as const;

export function ArmCard() {
  const state = store.state.value;
  const off = store.why.value !== null;
  const tool = state?.tool;
  const mounted = tool?.name ?? (tool?.bias ? "custom" : "unknown");
  const isOther = mounted === "custom" || mounted === "unknown";
  const speed = state?.speed ?? null;
  const isOn = store.alarms.value.some(({ code }) => code === store.SWITCHED_ON);
  return (
    <Card title={t("arm.title")} class="arm-card">
      <div class="buttons">
        <Button
          id="home"
          class={isOn ? "primary" : ""}
          off={off}
          why="jog-why"
          text={t(store.why.value === "why.homing" ? "home.now" : "home")}
          press={actions.home}
        />
        <Button
          id="clear-alarms"
          class={store.alarms.value.some(({ code }) => code !== store.SWITCHED_ON) ? "primary" : ""}
          off={off}
          why="jog-why"
          text={t("alarms.clear")}
          press={actions.clearAlarms}
        />
      </div>
      {state?.homed === false ? <p class="hint">{t("home.unknown")}</p> : null}
      <Field
        label={
          <>
            {t("arm.speed")} <b class="number">{speed === null ? "–" : `${Math.round(speed)} %`}</b>
          </>
        }
      >
        <Range
          id="arm-speed"
          least={1}
          most={100}
          value={speed ?? 50}
          off={off}
          why="jog-why"
          rests
          set={actions.setSpeed}
        />
      </Field>
      <Pick
        title={t("tools.select")}
        id="tool-select"
        value={mounted}
        options={[
          ...(isOther ? [{ value: mounted, text: translated(`tools.${mounted}`, mounted), disabled: true }] : []),
          ...TOOLS.map((value) => ({ value: value as string, text: t(`tools.${value}`) })),
        ]}
        off={off}
        why="jog-why"
        choose={(name) => actions.setTool({ tool: name as (typeof TOOLS)[number] })}
      />
      <div class="tool-row">
        <Switch
          id="tool-suction"
          label={t("tool.suction")}
          on={tool?.suction ?? null}
          off={off}
          why="jog-why"
          flip={(suction) => actions.setTool({ suction })}
        />
        <Switch
          id="tool-laser"
          label={t("tool.laser")}
          on={tool?.laser ?? null}
          off={off}
          why="jog-why"
          danger
          flip={actions.setLaser}
        />
      </div>
      <div class="gripper" role="group" aria-label={t("tool.gripper")}>
        <span aria-hidden="true">{t("tool.gripper")}</span>
        <div class="segments">
          {GRIPPER.map((gripper) => (
            <Button
              id={`tool-gripper-${gripper}`}
              key={gripper}
              aria-pressed={tool?.gripper === gripper}
              off={off}
              why="jog-why"
              press={() => actions.setTool({ gripper })}
            >
              {t(`tool.${gripper}`)}
            </Button>
          ))}
        </div>
      </div>
    </Card>
  );
}
