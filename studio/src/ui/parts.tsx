// Small parts that panels share.
import { type Signal, useSignal } from "@preact/signals";
import type { ButtonHTMLAttributes, ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { numberOf } from "../numbers";
import { useDropped } from "./dropped";

interface ChoiceProps<T extends string> {
  name: string;
  label: string;
  value: T;
  options: ReadonlyArray<{ value: T; text: string; disabled?: boolean }>;
  choose: (value: T) => void;
}

/** One of a few: radios that look like a row of buttons. */
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

/** Whether it does nothing now, and the id of the element that says why. */
interface MayBeOff {
  off?: boolean;
  why?: string | null | undefined;
}

const because = (off: boolean, why: MayBeOff["why"]) => (off && why ? why : undefined);

interface SwitchProps extends MayBeOff {
  id: string;
  label: string;
  on: boolean | null;
  danger?: boolean;
  flip: (on: boolean) => unknown;
}

export function Switch({ id, label, on, danger, flip, ...rest }: SwitchProps) {
  return (
    <Do
      id={id}
      role="switch"
      class={`switch ${danger ? "danger" : ""}`}
      aria-checked={on === true}
      {...rest}
      press={() => flip(on !== true)}
    >
      <span>{label}</span>
      <span class="switch-track" aria-hidden="true" />
    </Do>
  );
}

interface DoProps extends MayBeOff, Omit<ButtonHTMLAttributes<HTMLButtonElement>, "onClick"> {
  /** The name that tests know it by. */
  id?: string;
  press: () => unknown;
  label?: string;
  /** What stands on it, if that is a text alone. */
  text?: string;
}

/** Does something for as long as what it does lasts once: presses meanwhile, such as the second of a double click, do nothing. */
export function once(): (press: () => unknown) => void {
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
export function Do({ id, press, off = false, why, label, text, children = text, ...rest }: DoProps) {
  const does = useRef<ReturnType<typeof once> | null>(null);
  does.current ??= once();
  return (
    <button
      type="button"
      aria-describedby={because(off, why)}
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

/** A control with its name above it. */
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

interface TextFieldProps extends MayBeOff {
  id: string;
  label: string;
  unit?: string;
  value: string;
  /** What stands below it, and whether that is a complaint. */
  hint?: string;
  bad?: boolean;
  most?: number;
  placeholder?: string;
  inputMode?: "url" | "decimal" | undefined;
  autocomplete?: string;
  class?: string;
  /** Letter by letter, and not when it is done. */
  live?: boolean;
  set: (text: string) => void;
}

/** A line of text with its name above it. */
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

interface PickProps<T extends string | number> extends MayBeOff {
  id?: string;
  /** Its name above it; or one that is not seen. */
  title?: string;
  label?: string;
  value: T;
  /** What may be chosen: values that are their own names, or values with texts. */
  options: ReadonlyArray<T | { value: T; text: string; disabled?: boolean }>;
  choose: (value: T) => void;
}

/** One of many. */
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
      aria-describedby={because(off, why)}
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

/** The names of a table's columns; those of columns with buttons are not seen. */
export function Heads({ names, unseen = [] }: { names: readonly string[]; unseen?: readonly string[] }) {
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

/** Why something is off, or nothing. */
export function Why({ id, text }: { id: string; text: string | null }) {
  return text === null ? null : (
    <p id={id} class="hint">
      {text}
    </p>
  );
}

interface NumberInputProps extends MayBeOff {
  id?: string;
  label: string;
  value: number;
  digits?: number;
  /** By how much an arrow key changes it. */
  step?: number;
  least?: number | null | undefined;
  most?: number | null | undefined;
  set: (value: number) => void;
}

/** A number: what is being typed stays while the value goes on, and what is no number changes nothing. */
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
    const read = numberOf(text);
    if (read !== null) set(Math.min(most ?? read, Math.max(least ?? read, read)));
  };
  // A number of the browser's own takes no comma, or another number for it: `20,5` becomes 205.
  const press = (event: KeyboardEvent & { currentTarget: HTMLInputElement }) => {
    const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const read = numberOf(event.currentTarget.value);
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
      aria-describedby={because(off, why)}
      aria-invalid={typed.value !== null && numberOf(typed.value) === null}
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

interface RangeProps extends MayBeOff {
  id: string;
  label?: string;
  least: number;
  most: number;
  step?: number;
  value: number;
  /** The value in words, where it is more than a number. */
  text?: string;
  /** Takes a value only when the hand lets go. */
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
      aria-describedby={because(off, why)}
      data-testid={id}
      {...how}
    />
  );
}

/** A place where files may be dropped. */
export function Drop({
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
  useDropped(off ? null : open);
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

/** How often something is done; 0 is until it is stopped. */
export function Times({
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

/** A button that opens files of these kinds; the browser asks which. */
export function OpenFile({
  id,
  accept,
  off = false,
  text,
  open,
  ...rest
}: MayBeOff & { id: string; accept?: string; text: string; class?: string; open: (files: File[]) => unknown }) {
  const input = useRef<HTMLInputElement>(null);
  const chosen = (field: HTMLInputElement) => {
    const files = [...(field.files ?? [])];
    field.value = "";
    void open(files);
  };
  return (
    <>
      <Do id={`${id}-button`} off={off} text={text} press={() => input.current?.click()} {...rest} />
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
