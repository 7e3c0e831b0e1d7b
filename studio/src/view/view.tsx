// The place of the picture: in 3D where the browser can, else from above.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { theme } from "../settings";
import * as store from "../store";
import { colorAt } from "../ui/color";
import { Do } from "../ui/parts";
import "./fence";
import { layers } from "./layers";
import { Plan } from "./plan";
import { reach } from "./reach";
import type { ArmScene, View } from "./scene";
import { watchWorld } from "./seen";

const VIEWS: readonly View[] = ["corner", "front", "side", "top"];

function hasWebGl(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

/** Brings the store into the scene; what it gives back ends that. */
function bind(scene: ArmScene, place: HTMLElement, letters: Record<"x" | "y", HTMLElement | null>): () => void {
  scene.onDrawn = ({ tip, camera, fps, axes }) => {
    place.dataset.tip = tip.map((value) => value.toFixed(2)).join(",");
    place.dataset.camera = camera.join(",");
    if (fps !== null) place.dataset.fps = fps.toFixed(0);
    for (const name of ["x", "y"] as const) {
      const [x, y] = axes[name];
      const letter = letters[name];
      if (letter) letter.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  };
  const css = (name: string) => colorAt(place, name);
  const color = (name: string) => (name.startsWith("--") ? css(name) : name);
  const colors = () => {
    scene.setColors(css("--grid"), css("--grid-strong"));
    scene.setLayers(layers.peek(), color, true);
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", colors);
  const ends = [
    effect(() => {
      const model = store.model.value;
      if (model === null) return;
      scene.setModel(model);
      colors();
    }),
    effect(() => {
      void theme.value;
      colors();
    }),
    effect(() => {
      const state = store.state.value;
      if (state !== null && state.j1 !== undefined) scene.setState(state);
    }),
    effect(() => {
      const now = reach.value;
      scene.setReach(now?.outlines ?? [], now?.z ?? 0, css("--accent"));
    }),
    effect(() => scene.setLayers(layers.value, color)),
  ];
  return () => {
    dark.removeEventListener("change", colors);
    for (const end of ends) end();
    scene.end();
  };
}

export function ArmView() {
  const place = useRef<HTMLDivElement>(null);
  const letters = { x: useRef<HTMLSpanElement>(null), y: useRef<HTMLSpanElement>(null) };
  const scene = useRef<ArmScene | null>(null);
  const isPlan = useSignal(false);
  const view = useSignal<View>("corner");
  const follows = useSignal(false);
  useEffect(watchWorld, []);
  useEffect(() => {
    let unbind: (() => void) | null = null;
    let gone = false;
    if (!hasWebGl()) {
      isPlan.value = true;
      return;
    }
    // Stop and the pose are there first: the picture comes when it comes.
    import("./scene").then(
      ({ ArmScene }) => {
        if (gone || place.current === null) return;
        try {
          scene.current = new ArmScene(place.current);
        } catch {
          isPlan.value = true;
          return;
        }
        unbind = bind(scene.current, place.current, { x: letters.x.current, y: letters.y.current });
      },
      () => (isPlan.value = true),
    );
    return () => {
      gone = true;
      unbind?.();
      scene.current = null;
    };
  }, []);
  const look = (name: View) => {
    view.value = name;
    scene.current?.look(name);
  };
  const follow = () => {
    follows.value = !follows.value;
    scene.current?.setFollow(follows.value);
  };
  const state = store.state.value;
  const number = (value: number | undefined) => (value ?? 0).toFixed(0);
  const values = { x: number(state?.x), y: number(state?.y), z: number(state?.z), r: number(state?.r) };
  const isOld = store.backend.value !== "none" && store.stale.value && state !== null;
  return (
    <section class={`card view-card ${isOld ? "old" : ""}`}>
      <div
        class="view"
        ref={place}
        role="img"
        aria-label={t("view.name")}
        aria-describedby="view-text"
        tabIndex={0}
        data-testid="view"
      >
        {isPlan.value ? <Plan place={place} /> : null}
        {(["x", "y"] as const).map((name) => (
          <span key={name} class="axis" ref={letters[name]} aria-hidden="true" hidden={isPlan.value}>
            {name}
          </span>
        ))}
      </div>
      <p id="view-text" class="unseen">
        {state === null ? t("view.none") : t("view.text", values)}
      </p>
      {isOld ? <p class="view-note">{t("view.stale")}</p> : null}
      {isPlan.value ? (
        <p class="view-note">{t("view.plan")}</p>
      ) : (
        <div class="cameras" role="group" aria-label={t("view.cameras")}>
          {VIEWS.map((name) => (
            <Do
              key={name}
              id={`view-${name}`}
              aria-pressed={view.value === name}
              text={t(`view.${name}`)}
              press={() => look(name)}
            />
          ))}
          <Do id="view-follow" aria-pressed={follows.value} text={t("view.follow")} press={follow} />
        </div>
      )}
    </section>
  );
}
