// Small components shared by the panels.
import { type Signal, useSignal } from "@preact/signals";
import type { ButtonHTMLAttributes, ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { parseNumber } from "../numbers";
import { useFileDrop } from "./filedrop";

interface ChoiceProps<T extends string> {
  name: string;
  label: string;
  value: T;
  options: ReadonlyArray<{ value: T; text: string; disabled?: boolean }>;
  choose: (value: T) => void;
}

/** Choice of one value from a few: radio buttons drawn as a row of buttons. */
export function Choice<T extends string>({ name, label, value, options, choose }: ChoiceProps<T>) {
  return (
    <fieldset class="choice">
      <legend>{label}</legend>
      <div class="choice-row">
        {options.map((option) => (
          <label key={option.value}>
            <input
              type="radio"
              name={name}
              checked={option.value === value}
              disabled={option.disabled ?? false}
              data-testid={`${name}-${option.value}`}
              onChange={() => choose(option.value)}
            />
            <span>{option.text}</span>
          </label>
        ))}
      </div>
    </fieldset>
  );
}

interface CardProps {
  title: string;
  class?: string;
  more?: ComponentChildren;
  group?: boolean;
  children: ComponentChildren;
}

export function Card({ title, more, group, children, ...rest }: CardProps) {
  return (
    <section
      class={`card ${rest.class ?? ""}`}
      role={group ? "group" : undefined}
      aria-label={group ? title : undefined}
    >
      <div class="card-head">
        <h2>{title}</h2>
        {more}
      </div>
      {children}
    </section>
  );
}

/** Disabled state, and the id of the element that states the reason. */
interface Disableable {
  off?: boolean;
  why?: string | null | undefined;
}

const describedBy = (off: boolean, why: Disableable["why"]) => (off && why ? why : undefined);

interface SwitchProps extends Disableable {
  id: string;
  label: string;
  on: boolean | null;
  danger?: boolean;
  flip: (on: boolean) => unknown;
}

export function Switch({ id, label, on, danger, flip, ...rest }: SwitchProps) {
  return (
    <Button
      id={id}
      role="switch"
      class={`switch ${danger ? "danger" : ""}`}
      aria-checked={on === true}
      {...rest}
      press={() => flip(on !== true)}
    >
      <span>{label}</span>
      <span class="switch-track" aria-hidden="true" />
    </Button>
  );
}

interface ButtonProps extends Disableable, Omit<ButtonHTMLAttributes<HTMLButtonElement>, "onClick"> {
  /** Test id. */
  id?: string;
  press: () => unknown;
  label?: string;
  /** Label, if it is plain text. */
  text?: string;
}

/** Does something for as long as what it does lasts once: presses meanwhile, such as the second of a double click, do nothing. */
export function exclusive(): (press: () => unknown) => void {
  let isUnderWay = false;
  return (press) => {
    if (isUnderWay) return;
    const doing = press();
    if (!(doing instanceof Promise)) return;
    isUnderWay = true;
    const over = () => void (isUnderWay = false);
    doing.then(over, over);
  };
}

/** A button that does something, once at a time where it gives a promise. */
export function Button({ id, press, off = false, why, label, text, children = text, ...rest }: ButtonProps) {
  const does = useRef<ReturnType<typeof exclusive> | null>(null);
  does.current ??= exclusive();
  return (
    <button
      type="button"
      aria-describedby={describedBy(off, why)}
      {...rest}
      data-testid={id}
      aria-label={label}
      disabled={off}
      onClick={() => does.current?.(press)}
    >
      {children}
    </button>
  );
}

/** Form field with its label above. */
export function Field({
  label,
  unit,
  ...rest
}: {
  label: ComponentChildren;
  unit?: string;
  class?: string;
  children: ComponentChildren;
}) {
  return (
    <label class={`field ${rest.class ?? ""}`}>
      <span>
        {label} {unit ? <small>{unit}</small> : null}
      </span>
      {rest.children}
    </label>
  );
}

interface TextFieldProps extends Disableable {
  id: string;
  label: string;
  unit?: string;
  value: string;
  /** Text below the field; `bad` marks it as an error. */
  hint?: string;
  bad?: boolean;
  most?: number;
  placeholder?: string;
  inputMode?: "url" | "decimal" | undefined;
  autocomplete?: string;
  class?: string;
  /** Reports every keystroke instead of the completed text. */
  live?: boolean;
  set: (text: string) => void;
}

/** Text field with its label above. */
export function TextField({
  id,
  label,
  unit = "",
  value,
  hint,
  bad = false,
  off = false,
  most,
  autocomplete = "off",
  live = false,
  set,
  ...rest
}: TextFieldProps) {
  const take = (event: { currentTarget: HTMLInputElement }) => set(event.currentTarget.value);
  const { class: name = "", ...more } = rest;
  return (
    <Field label={label} unit={unit} class={name}>
      <input
        type="text"
        autocomplete={autocomplete}
        autoCapitalize="off"
        spellcheck={false}
        aria-label={label}
        aria-invalid={bad}
        aria-describedby={hint === undefined ? undefined : `${id}-hint`}
        data-testid={id}
        disabled={off}
        maxLength={most}
        value={value}
        {...more}
        {...(live ? { onInput: take } : { onChange: take })}
      />
      {hint === undefined ? null : (
        <small id={`${id}-hint`} class={bad ? "bad" : ""} role="status">
          {hint}
        </small>
      )}
    </Field>
  );
}

interface PickProps<T extends string | number> extends Disableable {
  id?: string;
  /** Visible label; `label` is the invisible alternative. */
  title?: string;
  label?: string;
  value: T;
  /** Options: values that serve as their own text, or values with texts. */
  options: ReadonlyArray<T | { value: T; text: string; disabled?: boolean }>;
  choose: (value: T) => void;
}

/** Selection of one value from many. */
export function Pick<T extends string | number>({
  id,
  title,
  label,
  value,
  options,
  off = false,
  why,
  choose,
}: PickProps<T>) {
  const all = options.map((option) =>
    typeof option === "object" ? option : { value: option, text: String(option), disabled: false },
  );
  const select = (
    <select
      aria-label={label}
      aria-describedby={describedBy(off, why)}
      data-testid={id}
      value={value}
      disabled={off}
      onChange={({ currentTarget: { selectedIndex } }) => choose((all[selectedIndex] ?? { value }).value)}
    >
      {all.map(({ value, text, disabled = false }) => (
        <option key={value} value={value} disabled={disabled}>
          {text}
        </option>
      ))}
    </select>
  );
  return title === undefined ? select : <Field label={title}>{select}</Field>;
}

/** Column headers of a table. Those of columns with buttons are visually hidden. */
export function ColumnHeads({ names, unseen = [] }: { names: readonly string[]; unseen?: readonly string[] }) {
  return (
    <thead>
      <tr>
        {names.map((name) => (
          <th key={name} scope="col">
            <span class={unseen.includes(name) ? "unseen" : ""}>{name}</span>
          </th>
        ))}
      </tr>
    </thead>
  );
}

/** Reason for which a control is disabled; renders nothing without one. */
export function Reason({ id, text }: { id: string; text: string | null }) {
  return text === null ? null : (
    <p id={id} class="hint">
      {text}
    </p>
  );
}

interface NumberInputProps extends Disableable {
  id?: string;
  label: string;
  value: number;
  digits?: number;
  /** Step of an arrow key. */
  step?: number;
  least?: number | null | undefined;
  most?: number | null | undefined;
  set: (value: number) => void;
}

/**
 * Number field. Text being typed is kept while the value changes, and text other than a number
 * changes nothing.
 */
export function NumberInput({
  id,
  label,
  value,
  digits = 1,
  step,
  least,
  most,
  off = false,
  why,
  set,
}: NumberInputProps) {
  const typed = useSignal<string | null>(null);
  const take = (text: string) => {
    typed.value = null;
    const read = parseNumber(text);
    if (read !== null) set(Math.min(most ?? read, Math.max(least ?? read, read)));
  };
  // A number of the browser's own takes no comma, or another number for it: `20,5` becomes 205.
  const press = (event: KeyboardEvent & { currentTarget: HTMLInputElement }) => {
    const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const read = parseNumber(event.currentTarget.value);
    if (step === undefined || by === undefined || read === null) return;
    event.preventDefault();
    take(String(Number((read + by * step).toFixed(Math.max(digits, 3)))));
  };
  return (
    <input
      type="text"
      {...(step === undefined
        ? {}
        : {
            role: "spinbutton",
            "aria-valuenow": value,
            "aria-valuemin": least ?? undefined,
            "aria-valuemax": most ?? undefined,
          })}
      inputMode="decimal"
      autocomplete="off"
      aria-label={label}
      aria-describedby={describedBy(off, why)}
      aria-invalid={typed.value !== null && parseNumber(typed.value) === null}
      disabled={off}
      data-testid={id}
      value={typed.value ?? String(Number(value.toFixed(digits)))}
      onInput={(event) => (typed.value = event.currentTarget.value)}
      onChange={(event) => take(event.currentTarget.value)}
      onKeyDown={press}
      onBlur={() => (typed.value = null)}
    />
  );
}

interface RangeProps extends Disableable {
  id: string;
  label?: string;
  least: number;
  most: number;
  step?: number;
  value: number;
  /** Text for the value, if the number alone is not enough. */
  text?: string;
  /** Reports a value only when the slider is released. */
  rests?: boolean;
  set: (value: number) => unknown;
}

export function Range({
  id,
  label,
  least,
  most,
  step = 1,
  value,
  text,
  off = false,
  why,
  rests = false,
  set,
}: RangeProps) {
  const take = (event: { currentTarget: HTMLInputElement }) => void set(event.currentTarget.valueAsNumber);
  const how = {
    min: least,
    max: most,
    step,
    value,
    disabled: off,
    ...(rests ? { onChange: take } : { onInput: take }),
  };
  return (
    <input
      type="range"
      aria-label={label}
      aria-valuetext={text}
      aria-describedby={describedBy(off, why)}
      data-testid={id}
      {...how}
    />
  );
}

/** Drop target for files. */
export function DropZone({
  off,
  open,
  children,
  ...rest
}: {
  off: boolean;
  open: (files: File[]) => unknown;
  class?: string;
  children: ComponentChildren;
}) {
  const over = useSignal(false);
  useFileDrop(off ? null : open);
  return (
    <div
      class={`drop ${rest.class ?? ""} ${over.value ? "over" : ""}`}
      onDragOver={(event) => {
        event.preventDefault();
        over.value = !off;
      }}
      onDragLeave={() => (over.value = false)}
      onDrop={(event) => {
        event.preventDefault();
        over.value = false;
        if (!off) void open([...(event.dataTransfer?.files ?? [])]);
      }}
    >
      {children}
    </div>
  );
}

/** Number of repetitions; 0 means until stopped. */
export function Repetitions({
  id,
  label,
  hint,
  least = 0,
  most = 9999,
  value,
}: {
  id: string;
  label: string;
  hint?: string;
  least?: number;
  most?: number;
  value: Signal<number>;
}) {
  return (
    <label class="times" title={hint}>
      <span>{label}</span>
      <NumberInput
        id={id}
        label={label}
        step={1}
        least={least}
        most={most}
        value={value.value}
        set={(to) => (value.value = Math.min(most, Math.max(least, Math.round(to))))}
      />
    </label>
  );
}

/** Button that opens files of these types in the browser's file dialog. */
export function OpenFile({
  id,
  accept,
  off = false,
  text,
  open,
  ...rest
}: Disableable & { id: string; accept?: string; text: string; class?: string; open: (files: File[]) => unknown }) {
  const input = useRef<HTMLInputElement>(null);
  const chosen = (field: HTMLInputElement) => {
    const files = [...(field.files ?? [])];
    field.value = "";
    void open(files);
  };
  return (
    <>
      <Button id={`${id}-button`} off={off} text={text} press={() => input.current?.click()} {...rest} />
      <input
        ref={input}
        type="file"
        hidden
        accept={accept}
        multiple
        disabled={off}
        data-testid={id}
        onChange={(event) => chosen(event.currentTarget)}
      />
    </>
  );
}
