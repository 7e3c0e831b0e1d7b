// Actions of a teacher on all or on selected arms.
import { attempt, withConfirmation } from "../../actions";
import { frozen as frozenArms, turns } from "../../class";
import { t } from "../../i18n";
import { call } from "../../session";
import { chosen, forEachArm } from "../../site";
import * as store from "../../store";
import { Button, Card } from "../../ui/parts";
import { roll } from "./roll";
import { type Word, w } from "./words";

type Method = "arm.home" | "arm.clear_alarms";

/**
 * Moves an arm during a lesson. The teacher takes it for that time without asking; afterwards its
 * pupil has it again with the rest of the turn.
 */
export async function commandArm(arm: string, method: Method, what: string, isSure = false): Promise<void> {
  const entry = store.arms.value.find(({ name }) => name === arm);
  if (!isSure && method === "arm.home" && entry?.virtual === false && !(await store.ask(what, t("home.text"), what)))
    return;
  const isMine = entry?.holder != null && entry.holder.session === store.session.value;
  const lease = isMine ? null : (await call("lease.take", { arm })).lease;
  try {
    if (isSure) await call(method, { arm, yes: true });
    else await withConfirmation(what, (yes) => call(method, { arm, ...yes }));
  } finally {
    if (lease !== null) await call("lease.release", { lease });
  }
}

async function commandAll(key: "home" | "clear", method: Method): Promise<void> {
  const arms = store.arms.value.filter(({ link }) => link === "up").map(({ name }) => name);
  const text = w(`class.${key}.text`, { n: arms.length });
  if (!(await store.ask(w(`class.${key}All`), text, w(`class.${key}All`)))) return;
  const n = await forEachArm(arms, (arm) => commandArm(arm, method, w(`class.${key}All`), true));
  if (n > 0) store.notify(t("site.done", { n }));
}

async function changeTurns(key: "end" | "next"): Promise<void> {
  const running = (turns.value?.arms ?? []).filter(({ person }) => person !== null).map(({ arm }) => arm);
  if (!(await store.ask(w(`class.${key}All`), w(`class.${key}.text`, { n: running.length }), w(`class.${key}All`))))
    return;
  await attempt(async () => {
    const { arms } = await call(`turn.${key}`, {});
    store.notify(arms.length > 0 ? t("site.done", { n: arms.length }) : w(`class.${key}.nobody`));
  });
}

/**
 * Like Stop, this button is never disabled. If nothing could be sent, the user is told how to stop
 * the arms.
 */
async function freeze(which: { arms?: string[] }): Promise<void> {
  if (store.socket.value !== "up") return store.notify(w("class.freeze.unsent"), true);
  await attempt(() => call("class.freeze", which));
}

export function Conduct() {
  const some = [...chosen.value];
  const pupils = roll.value?.pupils ?? [];
  const count = (is: (one: (typeof pupils)[number]) => boolean) => pupils.filter(is).length;
  const values = {
    n: pupils.length,
    here: count(({ here }) => here === true),
    waits: count(({ place }) => place != null),
    missing: count(({ here }) => here === false),
  };
  const frozen = frozenArms.value.length;
  const off = store.socket.value !== "up";
  const button = (id: string, key: Word, press: () => unknown) => (
    <Button id={id} off={off} text={w(key)} press={press} />
  );
  return (
    <Card
      title={t("class.title")}
      class="arms conduct"
      more={
        store.hub.value ? null : (
          <p class="hint" role="status" data-testid="class-count">
            {w("class.count", values)}
          </p>
        )
      }
    >
      <div class="site-bar" role="group" aria-label={w("class.all")}>
        <Button id="class-freeze-all" class="stop-all" text={w("class.freezeAll")} press={() => freeze({})} />
        {some.length > 0 ? (
          <Button id="class-freeze-chosen" press={() => freeze({ arms: some })}>
            {w("class.freezeSome", { n: some.length })}
          </Button>
        ) : null}
        <Button
          id="class-free"
          off={frozen === 0}
          text={w("class.freeAll")}
          press={() => attempt(() => call("class.free", {}))}
        />
        {some.length > 0 ? (
          <Button
            id="class-free-chosen"
            off={frozen === 0}
            press={() => attempt(() => call("class.free", { arms: some }))}
          >
            {w("class.freeSome", { n: some.length })}
          </Button>
        ) : null}
        <span class="bar-gap" />
        {button("class-home-all", "class.homeAll", () => commandAll("home", "arm.home"))}
        {button("class-clear-all", "class.clearAll", () => commandAll("clear", "arm.clear_alarms"))}
        {store.hub.value ? null : button("class-end-all", "class.endAll", () => changeTurns("end"))}
        {store.hub.value ? null : button("class-next-all", "class.nextAll", () => changeTurns("next"))}
      </div>
      {frozen > 0 ? (
        <p class="banner holds" role="status" data-testid="class-frozen">
          {w("class.frozenText", { n: frozen, all: turns.value?.arms.length ?? store.arms.value.length })}
        </p>
      ) : null}
    </Card>
  );
}
