// 3D picture with its buttons, loaded after the page's frame. Connects the store to the scene.
import { computed, effect, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { theme } from "../settings";
import * as store from "../store";
import { colorAt } from "../ui/color";
import { Button } from "../ui/parts";
import { sentencesOf } from "../words";
import { VIEWS, type View } from "./camera";
import { layers, onTablePressed, target } from "./layers";
import { mountedOf } from "./mounted";
import { reach } from "./reach";
import "./scene.css";
import { ArmScene } from "./stage";
import texts from "./words.json";
import { world } from "./world";

const w = sentencesOf(texts);
/** Zoom factor of a button. */
const ZOOM = 1.3;

const ICONS = {
  in: "M12 5v14M5 12h14",
  out: "M5 12h14",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
} as const;

/** Opens the picture in an element. Throws if the browser cannot render it. */
export function open(place: HTMLElement) {
  const scene = new ArmScene(place, (x, y) => onTablePressed.value?.(x, y));
  const view = signal<View | null>("corner");
  const follows = signal(false);
  const letters = (["x", "y"] as const).map((name) => {
    const letter = document.createElement("span");
    letter.className = "axis";
    letter.setAttribute("aria-hidden", "true");
    letter.textContent = name;
    place.append(letter);
    return [name, letter] as const;
  });
  scene.onTurned = (at) => {
    for (const [name, letter] of letters) {
      const [x, y] = at[name];
      const to = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      if (letter.style.transform !== to) letter.style.transform = to;
    }
  };
  const say = (name: string, value: string) => {
    if (place.dataset[name] !== value) place.dataset[name] = value;
  };
  scene.onDrawn = ({ tip, camera }) => {
    say("tip", tip.map((value) => value.toFixed(2)).join(","));
    say("camera", camera.join(","));
  };
  scene.rig.coveredShare = () => {
    const bar = place.parentElement?.querySelector(".cameras")?.getBoundingClientRect();
    return bar === undefined ? 0 : Math.max(0, (place.getBoundingClientRect().bottom - bar.top) / place.clientHeight);
  };
  scene.rig.onUserTurn = () => (view.value = null);
  // Every state contains a tool. The arm is rebuilt only when it differs.
  const tool = computed(() => mountedOf(store.state.value?.tool, world.value?.draws));
  const table = computed(() => world.value?.table?.height ?? null);
  const css = (name: string) => colorAt(place, name);
  const color = (name: string) => (name.startsWith("--") ? css(name) : name);
  const colors = () => {
    scene.setColors(css("--grid"), css("--grid-strong"), css("--card"));
    scene.setLayers(layers.peek(), color, true);
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", colors);
  const ends = [
    effect(() => {
      if (store.model.value !== null) scene.setModel(store.model.value, tool.value, table.value);
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
    effect(() => scene.setTarget(target.value)),
    effect(() => void place.classList.toggle("aims", onTablePressed.value !== null && view.value === "top")),
  ];
  const end = () => {
    dark.removeEventListener("change", colors);
    for (const end of ends) end();
    for (const [, letter] of letters) letter.remove();
    scene.end();
  };
  const look = (name: View) => {
    view.value = name;
    follows.value = false;
    scene.rig.setFollow(false);
    scene.rig.look(name);
  };
  const follow = () => {
    follows.value = !follows.value;
    scene.rig.setFollow(follows.value);
  };
  const Zoom = ({ name, press }: { name: keyof typeof ICONS; press: () => void }) => (
    <Button id={name === "fit" ? "view-fit" : `view-zoom-${name}`} label={w(name)} title={w(name)} press={press}>
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path d={ICONS[name]} />
      </svg>
    </Button>
  );
  const Buttons = () => {
    useEffect(() => scene.rig.reframe(true), []);
    return (
      <>
        <div class="zooms" role="group" aria-label={w("zoom")}>
          <Zoom name="in" press={() => scene.rig.zoom(ZOOM)} />
          <Zoom name="out" press={() => scene.rig.zoom(1 / ZOOM)} />
          <Zoom name="fit" press={() => scene.rig.fit()} />
        </div>
        <div class="cameras" role="group" aria-label={t("view.cameras")}>
          {VIEWS.map((name) => (
            <Button
              key={name}
              id={`view-${name}`}
              aria-pressed={view.value === name}
              text={w(name)}
              press={() => look(name)}
            />
          ))}
          <Button id="view-follow" aria-pressed={follows.value} text={w("follow")} press={follow} />
        </div>
      </>
    );
  };
  return { Buttons, end };
}
