// Header above every route: the stop button, the connection, the holder of control, and the
// navigation.
import { useEffect, useRef } from "preact/hooks";
import * as actions from "../actions";
import { myStatusText, stopsAll } from "../class";
import { t, translated } from "../i18n";
import { clock } from "../log";
import { signOut, takeBackSession } from "../session";
import * as store from "../store";
import ICONS from "./icons.json";
import { Button } from "./parts";

function Nav() {
  const nav = useRef<HTMLElement>(null);
  const [route, routes] = [store.route.value, store.routes.value];
  // On a phone the bar is wider than the screen.
  useEffect(
    () => nav.current?.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest", inline: "center" }),
    [route],
  );
  return (
    <nav ref={nav} aria-label={t("skip.nav")}>
      {routes.map((one) => (
        <a key={one} href={`#/${one}`} aria-current={route === one ? "page" : undefined}>
          <svg viewBox="0 0 24 24" aria-hidden="true">
            <path d={ICONS[one]} />
          </svg>
          <span>{t(`nav.${one}`)}</span>
        </a>
      ))}
      <button
        type="button"
        class="nav-help"
        data-testid="help"
        aria-expanded={store.sidePanel.value === "help"}
        onClick={() => {
          store.sidePanel.value = store.sidePanel.value === "help" ? null : "help";
        }}
      >
        <svg viewBox="0 0 24 24" aria-hidden="true">
          <path d={ICONS.help} />
        </svg>
        <span>{t("help")}</span>
      </button>
    </nav>
  );
}

/**
 * Identity of this page at the station, so that users of a shared computer see whose session it is.
 */
function Owner() {
  if (store.backend.value !== "station" || store.socket.value !== "up") return null;
  const text = t("owner", { name: store.ownerName.value, role: t(`role.${store.role.value}`) });
  return (
    <span class="badge owner" data-testid="owner" title={text}>
      {text}
    </span>
  );
}

function Identity() {
  const arm = store.arm.value;
  const kind = arm === null ? "none" : arm.virtual ? "virtual" : "real";
  const isPupil = store.audience.value === "pupil";
  return (
    <div class="what">
      {store.route.value === "class" ? null : (
        <span class={`badge ${kind}`} data-testid="header-arm">
          {t(`arm.${kind}`)}
          {store.backend.value === "sim" && store.simSpeed !== 1 ? (
            <b data-testid="header-speed"> ×{store.simSpeed}</b>
          ) : null}
          {store.arms.value.length > 1 && arm !== null ? <b> {arm.name}</b> : null}
        </span>
      )}
      {isPupil && myStatusText.value !== null ? null : <Owner />}
      {myStatusText.value === null ? null : (
        <span class="badge" data-testid="header-turn">
          {myStatusText.value}
        </span>
      )}
      {store.laser.value === "off" ? null : (
        <span class="badge laser" data-testid="header-laser" data-known={store.laser.value === "on"}>
          {t(store.laser.value === "on" ? "arm.laser" : "arm.laserWas")}
        </span>
      )}
    </div>
  );
}

function Lease() {
  // A pupil's arm is assigned by the turn, and the class's page is about all arms: neither requests
  // control here.
  if (
    store.socket.value !== "up" ||
    store.armName.value === null ||
    store.audience.value !== "all" ||
    store.route.value === "class"
  )
    return null;
  const lease = store.lease.value;
  const isViewer = store.role.value === "viewer";
  const name = store.holder.value?.name ?? "";
  const text = t(`lease.${lease}`, { name });
  const noTake = isViewer || (lease === "other" && store.role.value !== "teacher");
  return (
    <div class={`lease ${lease}`}>
      <span data-testid="lease-holder" class="holder" title={text}>
        {text}
      </span>
      <div class="lease-buttons">
        {lease === "mine" ? (
          <Button id="lease-release" class="quiet" text={t("lease.release")} press={actions.releaseControl} />
        ) : null}
        {lease === "other" ? (
          <Button
            id="lease-ask"
            class="primary"
            off={isViewer || store.isRequestingControl.value}
            text={store.isRequestingControl.value ? t("lease.asking") : t("lease.ask")}
            press={actions.askForControl}
          />
        ) : null}
        {lease !== "mine" ? (
          <Button
            id="lease-take"
            class={lease === "free" ? "primary" : "quiet"}
            off={noTake}
            why="no-take"
            text={t("lease.take")}
            press={actions.takeControl}
          />
        ) : null}
      </div>
      {noTake ? (
        <span id="no-take" class="unseen">
          {t(isViewer ? "why.viewer" : "lease.teacher")}
        </span>
      ) : null}
    </div>
  );
}

export function Header() {
  return (
    <header>
      <Button
        id="stop"
        class="stop"
        title={t("stop.hint")}
        text={t(stopsAll.value ? "site.stopAll" : "stop")}
        press={() => void actions.stop()}
      />
      <Identity />
      <Lease />
      <Nav />
    </header>
  );
}

/**
 * Banner for a page that the station has closed or refused because it is full: the page shows old
 * data.
 */
function Closed({ why, since }: { why: "token" | "revoked" | "taken" | "full"; since: Date | null }) {
  return (
    <div class="banner lost" role="alert" data-testid="closed">
      <p>
        <b>{t(why === "revoked" && store.pupil.value !== null ? "closed.class" : `closed.${why}`)}</b>{" "}
        {since === null ? null : t("closed.since", { time: clock(since) })} {why === "full" ? t("closed.again") : null}
      </p>
      {why === "full" ? null : (
        <div class="banner-do">
          <Button
            id="closed-signin"
            text={t(why === "taken" ? "closed.back" : "closed.signin")}
            press={why === "taken" ? takeBackSession : signOut}
          />
        </div>
      )}
    </div>
  );
}

/** Banner for a lost connection, with the time of the loss. */
export function LinkLost() {
  const since = store.lostSince.value;
  const refused = store.refused.value;
  // The sign-in page asks for a code or token itself, as does the form for another station.
  if (refused !== null && refused !== "unreachable" && !(refused === "token" && since === null))
    return <Closed why={refused} since={since} />;
  if (store.link.value !== "lost" || since === null) return null;
  return (
    <div class="banner lost" role="status">
      <p>
        <b>
          {t("link.lost")}{" "}
          <time data-testid="link-since" dateTime={since.toISOString()}>
            {clock(since)}
          </time>
        </b>{" "}
        {t("link.again")}
      </p>
    </div>
  );
}

/** Banner: what an unreachable arm may still be doing. During a job the strip says it instead. */
export function LastActivity() {
  const left = store.lastActivity.value;
  return left === null || store.isBusy.value ? null : (
    <div class="banner lost" role="alert" data-testid="left-doing">
      <p>
        <b>{t(left.laser ? "left.laser" : "left.moves")}</b> {t("left.switch")}
      </p>
    </div>
  );
}

/** Offer of a newer build of the page. */
export function UpdateOffer() {
  const take = store.update.value;
  if (take === null) return null;
  return (
    <div class="banner update" role="status">
      <p>{t("update.text")}</p>
      <Button id="update-offer" class="small" text={t("update")} press={take} />
    </div>
  );
}

/** Active alarms with cause and remedy. */
export function Alarms() {
  // The class's page is about all arms, and a pupil without an arm cannot do anything about an
  // alarm.
  const alarms = store.route.value === "class" && store.lease.value !== "mine" ? [] : store.alarms.value;
  const holds = store.isQueueHeld.value;
  const off = store.why.value !== null;
  return (
    <div
      role="alert"
      data-testid="alarm-banner"
      class={alarms.length > 0 ? `banner alarm ${holds ? "holds" : "notes"}` : "unseen"}
    >
      {alarms.length > 0 ? (
        <>
          <ul>
            {alarms.map((alarm) =>
              alarm.code === store.SWITCHED_ON ? (
                <li key={alarm.code} data-testid={`alarm-${alarm.code}`}>
                  <b>{t("alarms.on")}</b>{" "}
                  <span>{t(store.arm.value?.virtual ? "alarms.on.virtual" : "alarms.on.text")}</span>
                </li>
              ) : (
                <li key={alarm.code} data-testid={`alarm-${alarm.code}`}>
                  <b>{alarm.name}</b> <span>{translated(`alarm.${alarm.code}.cause`, alarm.cause)}.</span>{" "}
                  <span class="cure">
                    {t("alarms.cure")}: {translated(`alarm.${alarm.code}.cure`, alarm.cure)}.
                  </span>
                </li>
              ),
            )}
          </ul>
          {holds ? <p>{t("alarms.hold")}</p> : null}
          <div class="banner-do">
            {alarms.some(({ code }) => code === store.SWITCHED_ON) ? (
              <Button id="alarm-home" off={off} why="alarm-why" text={t("alarms.home")} press={actions.home} />
            ) : null}
            {alarms.some(({ code }) => code !== store.SWITCHED_ON) ? (
              <Button id="alarm-clear" off={off} why="alarm-why" text={t("alarms.these")} press={actions.clearAlarms} />
            ) : null}
            <span id="alarm-why" class="unseen">
              {off && store.why.value !== null ? t(store.why.value) : ""}
            </span>
          </div>
        </>
      ) : null}
    </div>
  );
}
