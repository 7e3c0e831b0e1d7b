// Small parts that panels share.
import { type Signal, useSignal } from "@preact/signals";
import type { ButtonHTMLAttributes, ComponentChildren } from "preact";
import { useRef } from "preact/hooks";

interface ChoiceProps<T extends string> {
  name: string;
  label: string;
  value: T;
  options: ReadonlyArray<{ value: T; text: string; testId?: string; disabled?: boolean }>;
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
              data-testid={option.testId}
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
    <section class={`card ${rest.class ?? ""}`} role={group ? "group" : undefined} aria-label={group ? title : undefined}>
      <div class="card-head">
        <h2>{title}</h2>
        {more}
      </div>
      {children}
    </section>
  );
}

interface SwitchProps {
  label: string;
  testId: string;
  on: boolean | null;
  disabled: boolean;
  reason?: string | undefined;
  danger?: boolean;
  flip: (on: boolean) => void;
}

export function Switch({ label, testId, on, disabled, reason, danger, flip }: SwitchProps) {
  return (
    <button
      type="button"
      role="switch"
      class={`switch ${danger ? "danger" : ""}`}
      aria-checked={on === true}
      aria-describedby={disabled ? reason : undefined}
      disabled={disabled}
      data-testid={testId}
      onClick={() => flip(on !== true)}
    >
      <span>{label}</span>
      <span class="switch-track" aria-hidden="true" />
    </button>
  );
}

interface DoProps extends Omit<ButtonHTMLAttributes<HTMLButtonElement>, "onClick"> {
  /** The name that tests know it by. */
  id?: string;
  press: () => unknown;
  off?: boolean;
  /** The id of the element that says why it is off. */
  why?: string | null | undefined;
  label?: string;
}

/** A button that does something. */
export function Do({ id, press, off = false, why, label, ...rest }: DoProps) {
  const because = off && why ? why : undefined;
  return <button type="button" aria-describedby={because} {...rest} data-testid={id} aria-label={label} disabled={off} onClick={() => void press()} />;
}

interface NumberInputProps {
  id?: string;
  label: string;
  value: number;
  digits?: number;
  /** By how much an arrow key changes it. */
  step?: number;
  off?: boolean;
  why?: string | undefined;
  set: (value: number) => void;
}

/** A number: what is being typed stays while the value goes on, and what is no number changes nothing. */
export function NumberInput({ id, label, value, digits = 1, step, off = false, why, set }: NumberInputProps) {
  const typed = useSignal<string | null>(null);
  const take = (text: string) => {
    typed.value = null;
    const read = Number(text.replace(",", "."));
    if (text.trim() !== "" && Number.isFinite(read)) set(read);
  };
  return (
    <input
      {...(step === undefined ? { type: "text", list: undefined } : { type: "number", step })}
      inputMode="decimal"
      autocomplete="off"
      aria-label={label}
      aria-describedby={off ? why : undefined}
      disabled={off}
      data-testid={id}
      value={typed.value ?? String(Number(value.toFixed(digits)))}
      onInput={(event) => (typed.value = event.currentTarget.value)}
      onChange={(event) => take(event.currentTarget.value)}
      onBlur={() => (typed.value = null)}
    />
  );
}

/** A place where files may be dropped. */
export function Drop({ off, open, children, ...rest }: { off: boolean; open: (files: File[]) => unknown; class?: string; children: ComponentChildren }) {
  const over = useSignal(false);
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
export function Times({ id, label, hint, least = 0, most = 9999, value }: { id: string; label: string; hint?: string; least?: number; most?: number; value: Signal<number> }) {
  const set = (text: string) => (value.value = Math.min(most, Math.max(least, Math.round(Number(text) || least))));
  return (
    <label class="times">
      <span>{label}</span>
      <input type="number" min={least} max={most} value={value.value} aria-description={hint} title={hint} data-testid={id} onChange={(event) => set(event.currentTarget.value)} />
    </label>
  );
}

/** A button that opens files of these kinds; the browser asks which. */
export function OpenFile({ id, accept, off, text, open, ...rest }: { id: string; accept: string; off: boolean; text: string; class?: string; open: (files: File[]) => unknown }) {
  const input = useRef<HTMLInputElement>(null);
  const chosen = (field: HTMLInputElement) => {
    const files = [...(field.files ?? [])];
    field.value = "";
    void open(files);
  };
  return (
    <>
      <Do id={`${id}-button`} off={off} press={() => input.current?.click()} {...rest}>
        {text}
      </Do>
      <input ref={input} type="file" hidden accept={accept} multiple disabled={off} data-testid={id} onChange={(event) => chosen(event.currentTarget)} />
    </>
  );
}
