// What stands above every route: Stop, what is connected, who has control, where to go.
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import * as actions from "../actions";
import { t, told } from "../i18n";
import { clock } from "../log";
import * as store from "../store";
import { Do } from "./parts";

const ICONS: Record<store.Route, ComponentChildren> = {
  move: <path d="M12 3v18M3 12h18M12 3l-3 3M12 3l3 3M12 21l-3-3M12 21l3-3M3 12l3-3M3 12l3 3M21 12l-3-3M21 12l-3 3" />,
  teach: <path d="M5 6h.01M5 12h.01M5 18h.01M9.500 6H20M9.500 12H16M9.500 18H13M18 15v6M15 18h6" />,
  draw: <path d="M4 20l1-4.500L16.500 4l3.500 3.500L8.500 19zM14 6.500l3.500 3.500M12 20h8" />,
  engrave: <path d="M12 3v9M9.500 3h5M12 15v.01M12 18v3M6.500 12.500l2 1.500M17.500 12.500l-2 1.500M4 20h4M16 20h4" />,
  run: <path d="M7 4.500v15l12-7.500z" />,
  io: <path d="M4 8h4v8H4zM8 10h3m-3 4h3M20 8h-4v8h4zM16 12h-5" />,
  plots: <path d="M4 4v16h16M7 15l4-5 3 3 5-7" />,
  world: <path d="M12 3.500 19.500 8v8L12 20.500 4.500 16V8zM4.500 8 12 12.300 19.500 8M12 12.300v8.200" />,
  arms: <path d="M5 20h9M9.500 20V10l8-3v5M9.500 10l3-4" />,
  settings: <path d="M4 7h9m4 0h3M4 17h3m4 0h9M15 4.800v4.400M9 14.800v4.400" />,
};

function Nav() {
  const nav = useRef<HTMLElement>(null);
  const route = store.route.value;
  // On a phone the bar is longer than the screen.
  useEffect(() => nav.current?.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest", inline: "center" }), [route]);
  return (
    <nav ref={nav} aria-label={t("skip.nav")}>
      {store.ROUTES.map((route) => (
        <a key={route} href={`#/${route}`} aria-current={store.route.value === route ? "page" : undefined}>
          <svg viewBox="0 0 24 24" aria-hidden="true">{ICONS[route]}</svg>
          <span>{t(`nav.${route}`)}</span>
        </a>
      ))}
    </nav>
  );
}

function What() {
  const arm = store.arm.value;
  const kind = arm === null ? "none" : arm.virtual ? "virtual" : "real";
  return (
    <div class="what">
      <span class={`badge ${kind}`} data-testid="header-arm">
        {t(`arm.${kind}`)}
        {store.backend.value === "sim" && store.simSpeed !== 1 ? <b data-testid="header-speed"> ×{store.simSpeed}</b> : null}
        {store.arms.value.length > 1 && arm !== null ? <b> {arm.name}</b> : null}
      </span>
      {store.isLaserOn.value ? <span class="badge laser" data-testid="header-laser">{t("arm.laser")}</span> : null}
    </div>
  );
}

function Lease() {
  if (store.socket.value !== "up" || store.armName.value === null) return null;
  const lease = store.lease.value;
  const isViewer = store.role.value === "viewer";
  const name = store.holder.value?.name ?? "";
  const text = t(`lease.${lease}`, { name });
  const noTake = isViewer || (lease === "other" && store.role.value !== "teacher");
  return (
    <div class={`lease ${lease}`}>
      <span data-testid="lease-holder" class="holder" title={text}>{text}</span>
      <div class="lease-buttons">
      {lease === "mine" ? <Do id="lease-release" class="quiet" text={t("lease.release")} press={actions.release} /> : null}
      {lease === "other" ? (
        <Do id="lease-ask" class="primary" off={isViewer || store.asking.value} text={store.asking.value ? t("lease.asking") : t("lease.ask")} press={actions.askFor} />
      ) : null}
      {lease !== "mine" ? (
        <Do id="lease-take" class={lease === "free" ? "primary" : "quiet"} off={noTake} why="no-take" text={t("lease.take")} press={actions.take} />
      ) : null}
      </div>
      {noTake ? <span id="no-take" class="unseen">{t(isViewer ? "why.viewer" : "lease.teacher")}</span> : null}
    </div>
  );
}

export function Header() {
  return (
    <header>
      <Do id="stop" class="stop" title={t("stop.hint")} text={t("stop")} press={actions.stop} />
      <What />
      <Lease />
      <Nav />
    </header>
  );
}

/** That the connection is lost, and since when. */
export function LinkLost() {
  const since = store.since.value;
  if (store.link.value !== "lost" || since === null) return null;
  return (
    <div class="banner lost" role="status">
      <p><b>{t("link.lost")} <time data-testid="link-since" dateTime={since.toISOString()}>{clock(since)}</time></b> {t("link.again")}</p>
    </div>
  );
}

/** A newer build of the page: it waits until it is taken. */
export function Update() {
  const take = store.update.value;
  if (take === null) return null;
  return (
    <div class="banner update" role="status">
      <p>{t("update.text")}</p>
      <Do id="update-offer" class="small" text={t("update")} press={take} />
    </div>
  );
}

/** The alarms that stand, each with cause and cure. */
export function Alarms() {
  const alarms = store.alarms.value;
  const holds = store.holds.value;
  return (
    <div role="alert" data-testid="alarm-banner" class={alarms.length > 0 ? `banner alarm ${holds ? "holds" : "notes"}` : "unseen"}>
      {alarms.length > 0 ? (
        <>
          <ul>
            {alarms.map((alarm) => (
              <li key={alarm.code} data-testid={`alarm-${alarm.code}`}>
                <b>{alarm.name}</b> <span>{told(`alarm.${alarm.code}.cause`, alarm.cause)}.</span>{" "}
                <span class="cure">{t("alarms.cure")}: {told(`alarm.${alarm.code}.cure`, alarm.cure)}.</span>
              </li>
            ))}
          </ul>
          {holds ? <p>{t("alarms.hold")}</p> : null}
        </>
      ) : null}
    </div>
  );
}
