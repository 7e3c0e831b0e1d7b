// What the arm does at a press: home, tools, speed.
import * as actions from "../actions";
import { t } from "../i18n";
import * as store from "../store";
import { Card, Do, Switch } from "../ui/parts";

const TOOLS = ["none", "suction", "gripper", "pen", "laser"] as const;
const GRIPPER = ["open", "closed", "off"] as const;

export function ArmCard() {
  const state = store.state.value;
  const off = store.why.value !== null;
  const reason = off ? "jog-why" : undefined;
  const tool = state?.tool;
  const mounted = tool?.name ?? (tool?.bias ? "custom" : "unknown");
  const speed = state?.speed ?? null;
  return (
    <Card title={t("arm.title")} class="arm-card">
      <div class="buttons">
        <Do id="home" off={off} why={reason} press={actions.home}>
          {t("home")}
        </Do>
        <Do id="clear-alarms" class={store.alarms.value.length > 0 ? "primary" : ""} off={off} why={reason} press={actions.clearAlarms}>
          {t("alarms.clear")}
        </Do>
      </div>
      {state?.homed === false ? <p class="hint">{t("home.unknown")}</p> : null}
      <label class="field">
        <span>
          {t("arm.speed")} <b class="number">{speed === null ? "–" : `${Math.round(speed)} %`}</b>
        </span>
        <input
          type="range"
          min={1}
          max={100}
          value={speed ?? 50}
          disabled={off}
          aria-describedby={reason}
          data-testid="arm-speed"
          onChange={(event) => actions.speed(Number(event.currentTarget.value))}
        />
      </label>
      <label class="field">
        <span>{t("tools.select")}</span>
        <select
          data-testid="tool-select"
          value={mounted}
          disabled={off}
          aria-describedby={reason}
          onChange={(event) => actions.tool({ tool: event.currentTarget.value as (typeof TOOLS)[number] })}
        >
          {mounted === "custom" || mounted === "unknown" ? (
            <option value={mounted} disabled>
              {t(`tools.${mounted}`)}
            </option>
          ) : null}
          {TOOLS.map((name) => (
            <option key={name} value={name}>
              {t(`tools.${name}`)}
            </option>
          ))}
        </select>
      </label>
      <div class="tool-row">
        <Switch
          label={t("tool.suction")}
          testId="tool-suction"
          on={tool?.suction ?? null}
          disabled={off}
          reason={reason}
          flip={(suction) => actions.tool({ suction })}
        />
        <Switch label={t("tool.laser")} testId="tool-laser" on={tool?.laser ?? null} disabled={off} reason={reason} danger flip={actions.laser} />
      </div>
      <div class="gripper" role="group" aria-label={t("tool.gripper")}>
        <span aria-hidden="true">{t("tool.gripper")}</span>
        <div class="segments">
          {GRIPPER.map((gripper) => (
            <Do id={`tool-gripper-${gripper}`} key={gripper} aria-pressed={tool?.gripper === gripper} off={off} why={reason} press={() => actions.tool({ gripper })}>
              {t(`tool.${gripper}`)}
            </Do>
          ))}
        </div>
      </div>
    </Card>
  );
}
