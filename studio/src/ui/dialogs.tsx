// Questions and lists over the page. They are not modal: the stop button must remain usable.
import { useSignal } from "@preact/signals";
import type { ComponentChildren, ComponentProps } from "preact";
import { useEffect, useRef } from "preact/hooks";
import * as actions from "../actions";
import { t } from "../i18n";
import * as store from "../store";
import { Button, TextField } from "./parts";

interface SheetProps {
  role: "alertdialog" | "dialog";
  id: string;
  testId: string;
  title: string;
  children: ComponentChildren;
}

function Sheet({ role, id, testId, title, children }: SheetProps) {
  const ref = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const before = document.activeElement;
    ref.current?.querySelector<HTMLElement>("[data-first]")?.focus();
    return () => {
      if (before instanceof HTMLElement && before.isConnected) before.focus();
    };
  }, []);
  return (
    // biome-ignore lint/a11y/useAriaPropsSupportedByRole: `role` is a dialog or an alert
    <div
      class="sheet"
      ref={ref}
      role={role}
      aria-labelledby={`${id}-title`}
      aria-describedby={`${id}-text`}
      data-testid={testId}
    >
      <h2 id={`${id}-title`}>{title}</h2>
      {children}
    </div>
  );
}

type Answer = ComponentProps<typeof Button>;

/** Question with two answers, of which the first changes nothing. */
function QuestionDialog({ title, no, yes, ...rest }: Omit<SheetProps, "role"> & { no: Answer; yes: Answer }) {
  return (
    <Sheet role="alertdialog" title={title} {...rest}>
      <p id={`${rest.id}-text`}>{rest.children}</p>
      <div class="sheet-buttons">
        <Button data-first {...no} />
        <Button class="primary" {...yes} />
      </div>
    </Sheet>
  );
}

function Question() {
  const question = store.question.value;
  if (question === null) return null;
  const no = { id: "confirm-no", text: t("no"), press: () => question.answer(false) };
  const yes = { id: "confirm-yes", text: question.yes, press: () => question.answer(true) };
  return (
    <QuestionDialog key={question.title} id="confirm" testId="confirm" title={question.title} no={no} yes={yes}>
      {question.text}
    </QuestionDialog>
  );
}

function ControlRequest() {
  const asked = store.controlRequest.value;
  if (asked === null || store.lease.value !== "mine") return null;
  const no = { id: "lease-refuse", text: t("lease.refuse"), press: () => actions.answerControlRequest(false) };
  const yes = { id: "lease-grant", text: t("lease.grant"), press: () => actions.answerControlRequest(true) };
  return (
    <QuestionDialog id="asked" testId="lease-asked" title={t("lease.asked", { name: asked.name })} no={no} yes={yes}>
      {asked.message ? <q>{asked.message}</q> : null} {t("lease.asked.text")}
    </QuestionDialog>
  );
}

/** Asks for the user's name, shown to others while the user has control. */
function NamePrompt() {
  const answer = store.namePrompt.value;
  const name = useSignal("");
  if (answer === null) return null;
  const done = (text: string | null) => {
    store.namePrompt.value = null;
    answer(text);
  };
  return (
    <Sheet role="dialog" id="naming" testId="naming" title={t("naming.title")}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          done(name.value.trim() || null);
        }}
      >
        <p id="naming-text" class="hint">
          {t("settings.name.hint")}
        </p>
        <TextField
          id="naming-name"
          label={t("settings.name")}
          value={name.value}
          most={40}
          autocomplete="nickname"
          live
          set={(text) => (name.value = text)}
        />
        <div class="sheet-buttons">
          <Button text={t("naming.without")} press={() => done(null)} />
          <button type="submit" class="primary" data-testid="naming-take" disabled={name.value.trim() === ""}>
            {t("lease.take")}
          </button>
        </div>
      </form>
    </Sheet>
  );
}

const KEYS = [
  ["↑ ↓ ← →", "keys.move"],
  ["W S", "keys.z"],
  ["A D", "keys.r"],
  ["] [", "keys.rail"],
  ["M", "keys.m"],
  ["F", "keys.f"],
  ["+ −", "keys.size"],
  [". ,", "keys.speed"],
  ["P G L", "keys.tools"],
  ["H C", "keys.home"],
  ["Space Esc", "keys.stop"],
] as const;

function Keys() {
  if (!store.showsKeys.value) return null;
  return (
    <Sheet role="dialog" id="keys" testId="keys" title={t("keys.title")}>
      <dl id="keys-text" class="keys">
        {KEYS.map(([keys, text]) => (
          <div key={text}>
            <dt>
              {keys.split(" ").map((key) => (
                <kbd key={key}>{key}</kbd>
              ))}
            </dt>
            <dd>{t(text)}</dd>
          </div>
        ))}
      </dl>
      <div class="sheet-buttons">
        <Button data-first text={t("close")} press={() => (store.showsKeys.value = false)} />
      </div>
    </Sheet>
  );
}

export function Dialogs() {
  const notice = store.notice.value;
  return (
    <>
      <Question />
      <ControlRequest />
      <NamePrompt />
      <Keys />
      <div class="notice-place" role="status" data-testid="notice">
        {notice ? <p class={`notice ${notice.bad ? "bad" : ""}`}>{notice.text}</p> : null}
      </div>
    </>
  );
}
