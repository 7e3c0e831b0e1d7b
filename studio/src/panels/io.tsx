// Pins, sensors and steppers. Their commands come from the arm's table, so that this page knows
// none.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { attempt, reportError, withConfirmation } from "../actions";
import { t } from "../i18n";
import { io, levels, type Row, refresh, type Field as TableField, watchKind, watchPins } from "../pins";
import { call, shownArm } from "../session";
import { language } from "../settings";
import * as store from "../store";
import { Button, Card, ColumnHeads, Field, NumberInput, Pick, Range } from "../ui/parts";
import { sentencesOf } from "../words";
import "./io.css";
import texts from "./io.words.json";
import sentences from "./pins.json";

const w = sentencesOf(sentences);

type Pin = NonNullable<typeof io.value>["pins"][number];
const REASON_ID = "io-why";
/** Translations of the table's texts, by language. */
const TABLE_TEXTS: Record<string, Record<string, string>> = texts;
const tableText = (text: string): string => {
  const [said = ""] = text.split(";");
  return TABLE_TEXTS[language.value]?.[said] ?? said;
};

/** Sends a command of the table with values in the order of its fields. */
async function send(row: Row, values: ReadonlyArray<number | boolean>): Promise<void> {
  const fields = Object.fromEntries((row.sets ?? []).map(({ name }, at) => [name, values[at] as number | boolean]));
  await attempt(() =>
    withConfirmation(row.about, (yes) => call("arm.set", { ...shownArm(), command: row.command, fields, ...yes })),
  );
}
const rowOf = (role: string) => io.value?.rows.find((row) => row.role === role);
async function setPin(role: string, values: number[]): Promise<void> {
  const row = rowOf(role);
  if (row) await send(row, values);
  await refresh();
}
const driveInput = (address: number, to: { level: boolean } | { value: number }) =>
  attempt(() => call("world.input", { ...shownArm(), address, ...to }));

/** Reading of a pin as text, and true if it is high; null if unknown. */
function reading({ address, function: own, frequency, duty_cycle }: Pin): { text: string; high: boolean | null } {
  const kind = watchKind(own);
  const value = levels.value.get(address);
  if (frequency !== null) return { text: `${frequency} Hz, ${duty_cycle} %`, high: null };
  if (kind === null || value === undefined) return { text: "–", high: null };
  const { counts = 1, volts = 0 } = io.value?.analog ?? {};
  return kind === "analog"
    ? { text: `${((value / counts) * volts).toFixed(1)} V`, high: null }
    : { text: String(value), high: value !== 0 };
}

/** Control of a pin: sets an output, or drives an input of a virtual arm. */
function Setting({ pin, off }: { pin: Pin; off: boolean }) {
  const frequency = useSignal(pin.frequency || 1000);
  const duty = useSignal(pin.duty_cycle || 50);
  const { address } = pin;
  const kind = watchKind(pin.function);
  const level = levels.value.get(address) ?? 0;
  const driven = {
    id: `pin-${address}-drive`,
    label: w("io.drive", { n: address }),
    off: store.lease.value !== "mine",
    why: REASON_ID,
  };
  if (kind === "output") {
    const is = levels.value.get(address) ?? pin.level ?? 0;
    const turn = () => setPin("output", [address, is === 0 ? 1 : 0]);
    return (
      <Button
        id={`pin-${address}-set`}
        aria-pressed={is !== 0}
        label={w("io.set", { n: address })}
        off={off}
        why={REASON_ID}
        text={w(is === 0 ? "io.high" : "io.low")}
        press={turn}
      />
    );
  }
  if (pin.frequency !== null) {
    const [, hertz, percent] = rowOf("signal")?.sets ?? [];
    const setSignal = () => setPin("signal", [address, frequency.value, duty.value]);
    const number = (field: TableField | undefined, value: typeof duty) => {
      const label = `${tableText(field?.about ?? "")}, ${tableText(field?.unit ?? "")}`;
      return (
        <NumberInput
          label={label}
          step={1}
          least={field?.least}
          most={field?.most}
          value={value.value}
          off={off}
          why={REASON_ID}
          set={(to) => (value.value = to)}
        />
      );
    };
    return (
      <>
        {number(hertz, frequency)}
        {number(percent, duty)}
        <Button
          id={`pin-${address}-set`}
          class="small"
          label={w("io.set", { n: address })}
          off={off}
          why={REASON_ID}
          text={w("io.signal")}
          press={setSignal}
        />
      </>
    );
  }
  if (kind === null || store.arm.value?.virtual !== true) return null;
  if (kind === "analog") {
    const { counts = 1, volts = 0 } = io.value?.analog ?? {};
    return (
      <>
        <Range {...driven} least={0} most={counts} value={level} set={(value) => driveInput(address, { value })} />
        <small>{`0 … ${volts} V`}</small>
      </>
    );
  }
  return (
    <Button
      {...driven}
      class="quiet"
      aria-pressed={level !== 0}
      text={w(level === 0 ? "io.driveHigh" : "io.driveLow")}
      press={() => driveInput(address, { level: level === 0 })}
    />
  );
}

function PinRow({ pin, off }: { pin: Pin; off: boolean }) {
  const { address } = pin;
  const { text, high } = reading(pin);
  return (
    <tr class={text === "–" ? "unused" : ""}>
      <th scope="row">{address}</th>
      <td>
        <Pick
          id={`pin-${address}-function`}
          label={w("io.function.of", { n: address })}
          value={pin.function}
          options={(io.value?.functions ?? []).map(({ value, about }) => ({
            value,
            text: value === 0 ? w("io.none") : tableText(about),
            disabled: pin.can !== null && !pin.can.includes(value),
          }))}
          off={off}
          why={REASON_ID}
          choose={(to) => setPin("function", [address, to])}
        />
      </td>
      <td>
        {high === null ? null : <span class={`lamp ${high ? "high" : ""}`} />}
        <output class={high ? "high" : ""} aria-live="off" data-testid={`pin-${address}-level`}>
          {text}
        </output>
      </td>
      <td>
        <div class="set">
          <Setting key={pin.function} pin={pin} off={off} />
        </div>
      </td>
    </tr>
  );
}

/** Interval of reading a sensor, ms. */
const READ_INTERVAL = 500;

/** Sensor or stepper: the fields of its command, and its answer. */
function Device({ row, off }: { row: Row; off: boolean }) {
  const values = useSignal<Record<string, number>>({});
  const seen = useSignal<Record<string, number> | null>(null);
  const reads = useSignal(false);
  const fields = row.sets ?? [];
  const valueFor = ({ name, kind, choices, least }: TableField) => {
    return (
      values.value[name] ??
      (kind === "number" ? Math.max(0, least ?? 0) : kind === "choice" ? (choices[0]?.value ?? 0) : 1)
    );
  };
  useEffect(() => {
    if (!reads.value || !store.isUp.value) return;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let over = false;
    const read = async () => {
      const query = Object.fromEntries((row.asks ?? []).map((field) => [field.name, valueFor(field)]));
      try {
        seen.value = (await call("arm.get", { ...shownArm(), command: row.command, query })) as Record<string, number>;
      } catch (error) {
        reads.value = false;
        reportError(error);
      }
      if (!over) timer = setTimeout(() => void read(), READ_INTERVAL);
    };
    void read();
    return () => {
      over = true;
      clearTimeout(timer);
    };
  }, [reads.value, store.armName.value, store.isUp.value]);
  const tells = row.tells ?? [];
  const isColor = tells.length === 3 && tells.every(({ most }) => most === 255);
  return (
    <form
      class="device"
      aria-label={tableText(row.about)}
      onSubmit={(event) => {
        event.preventDefault();
        void send(row, fields.map(valueFor)).then(refresh);
      }}
    >
      <b>{tableText(row.about).replace(/\.$/, "")}</b>
      <div class="device-fields">
        {fields.map((field) => {
          const value = valueFor(field);
          const take = (to: number) => (values.value = { ...values.value, [field.name]: to });
          if (field.kind === "switch") {
            return (
              <label key={field.name} class="check">
                <input
                  type="checkbox"
                  checked={value !== 0}
                  disabled={off}
                  onChange={(event) => take(event.currentTarget.checked ? 1 : 0)}
                />
                {tableText(field.about)}
              </label>
            );
          }
          const label =
            field.kind === "number" ? `${tableText(field.about)}, ${tableText(field.unit)}` : tableText(field.about);
          return (
            <Field key={field.name} label={label}>
              {field.kind === "choice" ? (
                <Pick
                  value={value}
                  options={field.choices.map((choice) => ({ value: choice.value, text: tableText(choice.name) }))}
                  off={off}
                  choose={take}
                />
              ) : (
                <NumberInput
                  label={label}
                  step={1}
                  digits={3}
                  least={field.least}
                  most={field.most}
                  value={value}
                  off={off}
                  set={take}
                />
              )}
            </Field>
          );
        })}
      </div>
      <div class="readings">
        <button
          type="submit"
          disabled={off}
          aria-describedby={off ? REASON_ID : undefined}
          data-testid={`device-${row.command}`}
        >
          {w("io.send")}
        </button>
        {tells.length > 0 ? (
          <Button
            id={`read-${row.command}`}
            aria-pressed={reads.value}
            off={!store.isUp.value}
            press={() => (reads.value = !reads.value)}
          >
            {w(reads.value ? "io.reading" : "io.read")}
          </Button>
        ) : null}
        {seen.value === null ? null : (
          <>
            {isColor ? (
              <span
                class="swatch"
                style={{ background: `rgb(${tells.map(({ name }) => seen.value?.[name] ?? 0).join(" ")})` }}
              />
            ) : null}
            {tells.map(({ name, about, unit, kind }) => (
              <span key={name}>
                {tableText(about)}{" "}
                <b>{kind === "switch" ? (seen.value?.[name] ? t("yes") : w("io.no")) : seen.value?.[name]}</b>
                {kind === "number" && unit !== "counts" ? ` ${tableText(unit)}` : ""}
              </span>
            ))}
          </>
        )}
      </div>
    </form>
  );
}

export function Io() {
  useEffect(watchPins, []);
  const off = store.why.value;
  const known = io.value;
  const devices = (role: string) =>
    known?.rows
      .filter((row) => row.role === role)
      .map((row) => <Device key={row.command} row={row} off={off !== null} />);
  return (
    <div class="io">
      <Card title={w("io.pins")} class="pins-card">
        <p class={`jog-status ${off === null ? "" : "off"}`} id={REASON_ID}>
          {off === null ? w("io.hint") : t(off)}
        </p>
        {known === null ? (
          <p class="hint">{t(store.socket.value === "closed" ? "why.closed" : "link.connecting")}</p>
        ) : (
          <table class="pins" aria-label={w("io.pins")}>
            <ColumnHeads names={[w("io.pin"), w("io.function"), w("io.level"), w("io.setting")]} />
            <tbody>
              {known.pins.map((pin) => (
                <PinRow key={pin.address} pin={pin} off={off !== null} />
              ))}
            </tbody>
          </table>
        )}
      </Card>
      <div class="io-side">
        <Card title={w("io.sensors")}>{devices("sensor")}</Card>
        <Card title={w("io.steppers")}>{devices("stepper")}</Card>
      </div>
    </div>
  );
}
