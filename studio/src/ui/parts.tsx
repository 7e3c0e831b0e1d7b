// Small parts that panels share.
import type { ComponentChildren } from "preact";

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
