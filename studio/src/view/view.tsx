// Picture of the arm: in 3D if the browser supports it, otherwise from above.
import { useSignal } from "@preact/signals";
import type { ComponentType, RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import * as store from "../store";
import "./fence";
import { watchWorld } from "./world";

export function ArmView() {
  const place = useRef<HTMLDivElement>(null);
  const Buttons = useSignal<ComponentType | null>(null);
  const Plan = useSignal<ComponentType<{ place: RefObject<HTMLElement | null> }> | null>(null);
  useEffect(watchWorld, []);
  useEffect(() => {
    let end: (() => void) | undefined;
    let gone = false;
    const draw = async () => {
      try {
        if (document.createElement("canvas").getContext("webgl2") === null) throw new Error("no WebGL");
        // The stop button and the pose must not wait for the picture.
        const { open } = await import("./scene");
        if (gone || place.current === null) return;
        const scene = open(place.current);
        ({ end, Buttons: Buttons.value } = scene);
      } catch {
        const plan = await import("./plan");
        if (!gone) Plan.value = plan.Plan;
      }
    };
    void draw();
    return () => {
      gone = true;
      end?.();
    };
  }, []);
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
        {Plan.value ? <Plan.value place={place} /> : null}
      </div>
      <p id="view-text" class="unseen">
        {state === null ? t("view.none") : t("view.text", values)}
      </p>
      {isOld ? <p class="view-note">{t("view.stale")}</p> : null}
      {Plan.value ? <p class="view-note">{t("view.plan")}</p> : Buttons.value ? <Buttons.value /> : null}
    </section>
  );
}
