// Arms of a station or site: who has which, what each does, and actions on several.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { complain, stop } from "../actions";
import { frozen as frozenArms, hasClass, turnAt, turnOf } from "../class";
import { t } from "../i18n";
import { save } from "../log";
import { page } from "../results";
import { base64 } from "../run/programs";
import { call, show } from "../session";
import { toggled } from "../settings";
import {
  chosen,
  doingOf,
  drop,
  each,
  give,
  isKnown,
  jobOf,
  jobs,
  pictures,
  send,
  states,
  take,
  watchSite,
} from "../site";
import * as store from "../store";
import { Card, Do, OpenFile, Pick } from "../ui/parts";
import { boundsOf, pathOf, READER, toReader, viewBox } from "../view/flat";
import type { FleetScene } from "../view/fleet";
import { isTeachers, TeacherTile } from "./class/tile";
import { w } from "./class/words";
import "./arms.css";
import { sentencesOf } from "../words";
import texts from "./site.json";

const own = sentencesOf(texts);

/** Largest number of arms with large tiles. */
const FEW = 4;

/** Marks of an arm's state. */
function marksOf(arm: store.ArmEntry) {
  const state = states.get(arm.name);
  const job = jobs.get(arm.name);
  const asks = arm.waiting.find((waiter) => waiter.asks);
  return {
    lost: !isKnown(arm),
    alarms: (isKnown(arm) ? state?.alarms : null)?.filter((code) => code !== 0) ?? [],
    asks: asks?.name ?? null,
    waits: arm.waiting.filter((waiter) => !waiter.asks).length,
    job: jobOf(arm) ?? (job?.state === "failed" ? t("job.failed") : null),
  };
}

function Tile({ arm }: { arm: store.ArmEntry }) {
  const { name, holder, port } = arm;
  const { alarms, asks, waits, job, lost } = marksOf(arm);
  const isMine = holder !== null && holder.session === store.session.value;
  // The holder of an arm is unknown while its station is unreachable.
  const turn = store.socket.value === "up" ? turnOf(name) : null;
  const frozen = store.socket.value === "up" && frozenArms.value.includes(name);
  const who =
    store.socket.value !== "up"
      ? ""
      : holder === null
        ? lost
          ? t("arms.link.lost")
          : jobOf(arm) !== null
            ? t("arms.busy")
            : isTeachers(turnAt(name))
              ? w("tile.teacher")
              : t("arms.free")
        : isMine
          ? t("arms.you")
          : holder.name;
  const doing = doingOf(arm);
  return (
    <li
      class={`tile ${isMine ? "mine" : ""} ${alarms.length > 0 ? "alarmed" : ""} ${lost ? "lost" : "up"} ${frozen ? "frozen" : ""}`}
      data-testid={`arm-${name}`}
      data-holder={holder?.name ?? ""}
      data-t={states.get(name)?.t}
    >
      <div class="tile-head">
        <a
          href="#/move"
          onClick={() => show(name)}
          title={t("arms.show", { name })}
          aria-current={name === store.armName.value ? "true" : undefined}
        >
          {name}
        </a>
        <label hidden={store.arms.value.length < 2}>
          <input
            type="checkbox"
            aria-label={own("site.choose", { name })}
            data-testid={`choose-${name}`}
            checked={chosen.value.has(name)}
            onChange={(event) => (chosen.value = toggled(chosen.value, name, event.currentTarget.checked))}
          />
        </label>
      </div>
      <div class="tile-view" data-place>
        {lost ? (
          <span class="tile-lost" aria-hidden="true">
            ?
          </span>
        ) : null}
      </div>
      <div class="tile-foot">
        {turn === null ? (
          <p class="who" title={who}>
            {who}
          </p>
        ) : (
          <p class="who turn" title={turn} data-testid={`turn-${name}`}>
            {turn}
          </p>
        )}
        <p title={doing}>{doing}</p>
        {arm.virtual ? null : (
          <p class="port" title={port}>
            {port}
          </p>
        )}
        {arm.machine ? (
          <p class="port" title={w("tile.machine.text", { machine: arm.machine })} data-testid={`machine-${name}`}>
            {w("tile.machine", { machine: arm.machine })}
          </p>
        ) : null}
      </div>
      {store.role.value === "teacher" && hasClass.value ? <TeacherTile arm={arm} /> : null}
      <div class="tile-marks">
        {frozen ? (
          <span class="frozen" data-testid={`frozen-${name}`}>
            {t("class.frozen")}
          </span>
        ) : null}
        {alarms.length > 0 ? (
          <span class="alarm">{own("site.alarm", { code: `0x${(alarms[0] ?? 0).toString(16)}` })}</span>
        ) : null}
        {asks === null ? null : <span data-testid={`hand-${name}`}>{own("site.asks", { name: asks })}</span>}
        {waits > 0 ? <span>{own("site.waits", { n: waits })}</span> : null}
        {job === null ? null : <span class="job">{job}</span>}
      </div>
    </li>
  );
}

/** 3D pictures of the arms in their tiles, drawn on one canvas. */
function useFleet(place: { current: HTMLDivElement | null }): void {
  const arms = store.arms.value;
  const model = store.model.value;
  const names = arms.map(({ name }) => name).join();
  useEffect(() => {
    const element = place.current;
    if (element === null || model === null || names === "") return;
    let scene: FleetScene | null = null;
    let gone = false;
    const order = names.split(",");
    const layOut = () => {
      const from = element.getBoundingClientRect();
      const places = [...element.querySelectorAll("[data-place]")].map((tile) => {
        const { left, top, width, height } = tile.getBoundingClientRect();
        return { x: left - from.left, y: top - from.top, width, height };
      });
      if (from.width > 0) scene?.setPlaces(places, from.width, from.height);
    };
    const sizes = new ResizeObserver(layOut);
    let end = () => {};
    import("../view/fleet").then(
      ({ FleetScene }) => {
        if (gone) return;
        try {
          scene = new FleetScene(element, model, order.length);
        } catch {
          // Without WebGL the tiles have text only.
          return;
        }
        let most = 0;
        scene.onDrawn = (ms) => {
          most = Math.max(most * 0.98, ms);
          element.dataset.ms = ms.toFixed(2);
          element.dataset.most = most.toFixed(2);
        };
        layOut();
        sizes.observe(element);
        end = effect(() => {
          const arms = new Map(store.arms.value.map((arm) => [arm.name, arm]));
          scene?.setJoints(
            order.map((name) => {
              const state = states.get(name);
              const arm = arms.get(name);
              return state && arm && isKnown(arm) ? [state.j1, state.j2, state.j3, state.j4, state.rail ?? 0] : null;
            }),
          );
        });
      },
      () => {},
    );
    return () => {
      gone = true;
      end();
      sizes.disconnect();
      scene?.end();
    };
  }, [names, model]);
}

/** Arms whose tiles are visible or close to that. */
function useInView(place: { current: HTMLDivElement | null }): Set<string> {
  const inView = useRef(new Set<string>()).current;
  const names = store.arms.value.map(({ name }) => name).join();
  useEffect(() => {
    const element = place.current;
    if (element === null) return;
    const order = names.split(",");
    const arms = new Map([...element.querySelectorAll(".tile")].map((tile, nth) => [tile, order[nth] ?? ""]));
    const watcher = new IntersectionObserver(
      (entries) => {
        for (const { target, isIntersecting } of entries)
          inView[isIntersecting ? "add" : "delete"](arms.get(target) ?? "");
      },
      { rootMargin: "25%" },
    );
    inView.clear();
    for (const tile of arms.keys()) watcher.observe(tile);
    return () => watcher.disconnect();
  }, [names]);
  return inView;
}

function Bar() {
  const programs = useSignal<string[]>([]);
  const program = useSignal("");
  const arms = store.arms.value;
  const mine = arms.filter(({ name }) => chosen.value.has(name)).map(({ name }) => name);
  const none = mine.length === 0;
  const isViewer = store.role.value === "viewer";
  useEffect(() => {
    if (store.socket.value === "up")
      call("program.list", {}).then(({ programs: all }) => (programs.value = all.map(({ name }) => name)), complain);
  }, [store.socket.value]);
  const said = (work: Promise<number>) => void work.then((n) => n > 0 && store.say(t("site.done", { n })));
  const off = none || isViewer || store.socket.value !== "up";
  return (
    <div class="site-bar" role="group" aria-label={own("site.bar")}>
      <Do id="stop-all" class="stop-all" text={t("site.stopAll")} press={() => stop(true)} />
      <Do
        id="choose-all"
        press={() => (chosen.value = new Set(mine.length === arms.length ? [] : arms.map(({ name }) => name)))}
      >
        {t(mine.length === arms.length ? "site.none" : "site.all")}
      </Do>
      <Do id="site-take" off={off} why="site-why" text={t("lease.take")} press={() => said(each(mine, take))} />
      <Do id="site-give" off={off} why="site-why" text={t("lease.release")} press={() => said(each(mine, give))} />
      <Pick
        id="site-program"
        label={own("site.program")}
        value={program.value}
        options={[{ value: "", text: own("site.program") }, ...programs.value]}
        choose={(name) => (program.value = name)}
      />
      <Do
        id="site-send"
        class="primary"
        off={off || program.value === ""}
        why="site-why"
        press={() => said(send(mine, { program: program.value }, program.value))}
      >
        {own("site.send", { n: mine.length })}
      </Do>
      <OpenFile
        id="site-file"
        off={off}
        why="site-why"
        text={own("site.file")}
        open={async ([file]) => file && said(send(mine, { data: base64(await file.arrayBuffer()) }, file.name))}
      />
      <span id="site-why" class="unseen">
        {t(isViewer ? "why.viewer" : "site.why")}
      </span>
    </div>
  );
}

function Pictures() {
  if (pictures.value.length === 0) return null;
  const clear = async () => {
    const names = pictures.value.map(({ name }) => name);
    if (await store.ask(own("site.pictures.clear.title"), own("site.pictures.clear.text"), t("programs.delete")))
      await drop(names);
  };
  const more = (
    <div class="buttons-row">
      <Do
        id="pictures-save"
        class="quiet small"
        press={() => save("results.html", page(t("site.pictures"), pictures.value), "text/html")}
      >
        {own("site.pictures.all")}
      </Do>
      <Do id="pictures-clear" class="quiet small" text={own("site.pictures.clear")} press={clear} />
    </div>
  );
  return (
    <Card title={t("site.pictures")} class="arms" more={more}>
      <div class="pictures">
        {pictures.value.map(({ name, svg, strokes }) => {
          const box = boundsOf(
            strokes.flatMap((stroke) => stroke.points),
            4,
          );
          return (
            <div key={name} class="picture">
              <Do
                id={`picture-${name}`}
                label={own("site.picture", { name })}
                press={() => save(`${name}.svg`, toReader(svg))}
              >
                <svg viewBox={viewBox(box)} aria-hidden="true">
                  <path transform={READER} d={strokes.map((stroke) => pathOf(stroke.points)).join("")} />
                </svg>
                <span>{name}</span>
              </Do>
              <Do
                id={`picture-delete-${name}`}
                class="quiet small icon"
                label={own("site.picture.delete", { name })}
                text="✕"
                press={() => drop([name])}
              />
            </div>
          );
        })}
      </div>
    </Card>
  );
}

function Count() {
  const marks = store.arms.value.map(marksOf);
  const count = (is: (one: ReturnType<typeof marksOf>) => boolean) => marks.filter(is).length;
  const values = {
    n: marks.length,
    lost: count(({ lost }) => lost),
    alarms: count(({ alarms }) => alarms.length > 0),
    jobs: count(({ job }) => job !== null),
    hands: count(({ asks }) => asks !== null),
  };
  return (
    <p class="hint" data-testid="site-count" role="status">
      {own("site.count", values)}
    </p>
  );
}

/**
 * All arms; with the pictures stored in this browser, unless the station's results are shown beside
 * them.
 */
export function Site({ pictures: withPictures = true }: { pictures?: boolean }) {
  const place = useRef<HTMLDivElement>(null);
  const inView = useInView(place);
  useEffect(() => watchSite(inView), []);
  useFleet(place);
  const arms = store.arms.value;
  return (
    <>
      <Card title={t("arms.title")} class="arms site" more={arms.length > 1 ? <Count /> : null}>
        {arms.length === 0 ? (
          <p class="hint">{t(store.socket.value === "closed" ? "why.closed" : "link.connecting")}</p>
        ) : (
          <>
            {arms.length > 1 ? <Bar /> : null}
            <div class={`fleet ${arms.length <= FEW ? "few" : ""}`} ref={place} data-testid="fleet">
              <ul class="tiles" aria-label={t("arms.title")}>
                {arms.map((arm) => (
                  <Tile key={arm.name} arm={arm} />
                ))}
              </ul>
            </div>
          </>
        )}
      </Card>
      {withPictures ? <Pictures /> : null}
    </>
  );
}
