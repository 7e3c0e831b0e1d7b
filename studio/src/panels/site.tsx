// Arms of a station or site: who has which, what each does, and actions on several.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { reportError, stop } from "../actions";
import { frozen as frozenArms, hasClass, turnOfArm, turnText } from "../class";
import { t } from "../i18n";
import { save } from "../log";
import { printablePage } from "../results";
import { base64 } from "../run/programs";
import { call, showArm } from "../session";
import { withMember } from "../settings";
import {
  activityText,
  chosen,
  deletePictures,
  forEachArm,
  isKnown,
  jobs,
  jobText,
  pictures,
  releaseArm,
  startOnArms,
  states,
  takeArm,
  watchSite,
} from "../site";
import * as store from "../store";
import { Button, Card, OpenFile, Pick } from "../ui/parts";
import { boundsOf, pathOf, READER, toReader, viewBox } from "../view/flat";
import type { FleetScene } from "../view/fleet";
import { isReservedForTeacher, TeacherTile } from "./class/tile";
import { w } from "./class/words";
import "./arms.css";
import { sentencesOf } from "../words";
import texts from "./site.json";

const siteText = sentencesOf(texts);

/** Largest number of arms with large tiles. */
const MAX_LARGE_TILES = 4;

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
    job: jobText(arm) ?? (job?.state === "failed" ? t("job.failed") : null),
  };
}

function Tile({ arm }: { arm: store.ArmEntry }) {
  const { name, holder, port } = arm;
  const { alarms, asks, waits, job, lost } = marksOf(arm);
  const isMine = holder !== null && holder.session === store.session.value;
  // The holder of an arm is unknown while its station is unreachable.
  const turn = store.socket.value === "up" ? turnText(name) : null;
  const frozen = store.socket.value === "up" && frozenArms.value.includes(name);
  const who =
    store.socket.value !== "up"
      ? ""
      : holder === null
        ? lost
          ? t("arms.link.lost")
          : jobText(arm) !== null
            ? t("arms.busy")
            : isReservedForTeacher(turnOfArm(name))
              ? w("tile.teacher")
              : t("arms.free")
        : isMine
          ? t("arms.you")
          : holder.name;
  const doing = activityText(arm);
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
          onClick={() => showArm(name)}
          title={t("arms.show", { name })}
          aria-current={name === store.armName.value ? "true" : undefined}
        >
          {name}
        </a>
        <label hidden={store.arms.value.length < 2}>
          <input
            type="checkbox"
            aria-label={siteText("site.choose", { name })}
            data-testid={`choose-${name}`}
            checked={chosen.value.has(name)}
            onChange={(event) => (chosen.value = withMember(chosen.value, name, event.currentTarget.checked))}
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
          <span class="alarm">{siteText("site.alarm", { code: `0x${(alarms[0] ?? 0).toString(16)}` })}</span>
        ) : null}
        {asks === null ? null : <span data-testid={`hand-${name}`}>{siteText("site.asks", { name: asks })}</span>}
        {waits > 0 ? <span>{siteText("site.waits", { n: waits })}</span> : null}
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
      call("program.list", {}).then(({ programs: all }) => (programs.value = all.map(({ name }) => name)), reportError);
  }, [store.socket.value]);
  const said = (work: Promise<number>) => void work.then((n) => n > 0 && store.notify(t("site.done", { n })));
  const off = none || isViewer || store.socket.value !== "up";
  return (
    <div class="site-bar" role="group" aria-label={siteText("site.bar")}>
      <Button id="stop-all" class="stop-all" text={t("site.stopAll")} press={() => stop(true)} />
      <Button
        id="choose-all"
        press={() => (chosen.value = new Set(mine.length === arms.length ? [] : arms.map(({ name }) => name)))}
      >
        {t(mine.length === arms.length ? "site.none" : "site.all")}
      </Button>
      <Button
        id="site-take"
        off={off}
        why="site-why"
        text={t("lease.take")}
        press={() => said(forEachArm(mine, takeArm))}
      />
      <Button
        id="site-give"
        off={off}
        why="site-why"
        text={t("lease.release")}
        press={() => said(forEachArm(mine, releaseArm))}
      />
      <Pick
        id="site-program"
        label={siteText("site.program")}
        value={program.value}
        options={[{ value: "", text: siteText("site.program") }, ...programs.value]}
        choose={(name) => (program.value = name)}
      />
      <Button
        id="site-send"
        class="primary"
        off={off || program.value === ""}
        why="site-why"
        press={() => said(startOnArms(mine, { program: program.value }, program.value))}
      >
        {siteText("site.send", { n: mine.length })}
      </Button>
      <OpenFile
        id="site-file"
        off={off}
        why="site-why"
        text={siteText("site.file")}
        open={async ([file]) => file && said(startOnArms(mine, { data: base64(await file.arrayBuffer()) }, file.name))}
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
    if (
      await store.ask(siteText("site.pictures.clear.title"), siteText("site.pictures.clear.text"), t("programs.delete"))
    )
      await deletePictures(names);
  };
  const more = (
    <div class="buttons-row">
      <Button
        id="pictures-save"
        class="quiet small"
        press={() => save("results.html", printablePage(t("site.pictures"), pictures.value), "text/html")}
      >
        {siteText("site.pictures.all")}
      </Button>
      <Button id="pictures-clear" class="quiet small" text={siteText("site.pictures.clear")} press={clear} />
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
              <Button
                id={`picture-${name}`}
                label={siteText("site.picture", { name })}
                press={() => save(`${name}.svg`, toReader(svg))}
              >
                <svg viewBox={viewBox(box)} aria-hidden="true">
                  <path transform={READER} d={strokes.map((stroke) => pathOf(stroke.points)).join("")} />
                </svg>
                <span>{name}</span>
              </Button>
              <Button
                id={`picture-delete-${name}`}
                class="quiet small icon"
                label={siteText("site.picture.delete", { name })}
                text="✕"
                press={() => deletePictures([name])}
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
      {siteText("site.count", values)}
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
            <div class={`fleet ${arms.length <= MAX_LARGE_TILES ? "few" : ""}`} ref={place} data-testid="fleet">
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
