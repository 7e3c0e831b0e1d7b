// Objects on the sheet: shapes to add, and actions on the selected object.
import { useEffect } from "preact/hooks";
import type { Bench } from "../run/bench";
import type { Item } from "../run/items";
import { PATHS, SHAPES } from "../run/shapes";
import * as store from "../store";
import { Button, Card } from "../ui/parts";
import { sentencesOf } from "../words";
import "./items.css";
import texts from "./workshop.json";

const w = sentencesOf(texts);

/** Pens for an object; the first keeps the object's own. */
const PENS = [
  { name: "own", color: null },
  { name: "black", color: "#000000" },
  { name: "blue", color: "#1d4ed8" },
  { name: "red", color: "#c81e1e" },
  { name: "green", color: "#15803d" },
  { name: "orange", color: "#d97706" },
] as const;

export const nameOf = (item: Item): string => (item.shape ? w(`shape.${item.shape}`) : item.name);

/** Keyboard shortcuts of the page while the workshop is open. */
export function useUndoKeys(bench: Bench): void {
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
      // In an input field these keys undo typing.
      if (event.target instanceof Element && event.target.closest("input, textarea, select, dialog") !== null) return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      if (key === "y" || event.shiftKey) bench.redo();
      else bench.undo();
    };
    addEventListener("keydown", press);
    return () => removeEventListener("keydown", press);
  }, [bench]);
}

export function Palette({ bench, write }: { bench: Bench; write: () => void }) {
  const off = !store.isUp.value;
  const addText = () => {
    bench.addText(w("objects.newText"));
    write();
  };
  return (
    <div class="palette" role="group" aria-label={w("objects.add")}>
      <Button
        id="add-text"
        class="quiet"
        off={off}
        label={w("objects.addText")}
        title={w("objects.addText")}
        press={addText}
      >
        <svg viewBox="-4 -4 58 58" aria-hidden="true">
          <path d="M5 12V4H45V12M25 4V46M17 46H33" />
        </svg>
      </Button>
      {SHAPES.map((shape) => (
        <Button
          key={shape}
          id={`shape-${shape}`}
          class="quiet"
          off={off}
          label={w(`shape.${shape}`)}
          title={w(`shape.${shape}`)}
          press={() => bench.addShape(shape, w(`shape.${shape}`))}
        >
          <svg viewBox="-4 -4 58 58" aria-hidden="true">
            <path d={PATHS[shape]} />
          </svg>
        </Button>
      ))}
    </div>
  );
}

function Row({ bench, item, isChosen }: { bench: Bench; item: Item; isChosen: boolean }) {
  const own = item.shape
    ? null
    : bench.parts.value.find(({ isDrawn, targets }) => isDrawn && targets.some(({ id }) => id === item.id))?.color;
  const color = item.color ?? own ?? (bench.isComposed.value ? "#000000" : "var(--planned)");
  const [wide, high] = bench.sizeOf(item);
  return (
    <li>
      <button
        type="button"
        class="item-row"
        aria-pressed={isChosen}
        data-testid={`object-${item.id}`}
        onClick={() => bench.choose(item.id)}
      >
        <span class="swatch" style={{ background: color }} />
        <b>{nameOf(item)}</b>
        <small class="number">{wide + high > 0 ? `${Math.round(wide)} × ${Math.round(high)} mm` : ""}</small>
      </button>
    </li>
  );
}

/** List of objects if there are several, and actions on the selected one. */
export function Objects({ bench }: { bench: Bench }) {
  const { items } = bench.doc.now.value;
  const item = bench.item.value;
  if (items.length === 0) return null;
  const at = items.indexOf(item as (typeof items)[number]);
  return (
    <Card title={w("objects.title")} class="items-card">
      <ul class="item-list" aria-label={w("objects.list")}>
        {items.map((one) => (
          <Row key={one.id} bench={bench} item={one} isChosen={one === item} />
        ))}
      </ul>
      {item === null ? null : (
        <div class="item-do" role="group" aria-label={`${w("objects.of")}: ${nameOf(item)}`}>
          <div class="buttons-row">
            <Button
              id="object-duplicate"
              class="small"
              text={w("objects.duplicate")}
              press={() => bench.duplicate(item.id)}
            />
            <Button id="object-delete" class="small" text={w("objects.delete")} press={() => bench.remove(item.id)} />
            {items.length < 2 ? null : (
              <>
                <Button
                  id="object-earlier"
                  class="small"
                  off={at === 0}
                  text={w("objects.earlier")}
                  press={() => bench.order(item.id, -1)}
                />
                <Button
                  id="object-later"
                  class="small"
                  off={at === items.length - 1}
                  text={w("objects.later")}
                  press={() => bench.order(item.id, 1)}
                />
              </>
            )}
          </div>
          {bench.tool === "laser" || ["image", "gcode", "testgrid"].includes(item.format) ? null : (
            <fieldset class="pens">
              <legend>{w("pen")}</legend>
              {PENS.map(({ name, color }) => (
                <label key={name} title={w(`pen.${name}`)}>
                  <input
                    type="radio"
                    name="object-pen"
                    aria-label={w(`pen.${name}`)}
                    checked={item.color === color}
                    data-testid={`object-pen-${name}`}
                    onChange={() => bench.color(item.id, color)}
                  />
                  <span class={color === null ? "own" : ""} style={color === null ? {} : { background: color }} />
                </label>
              ))}
            </fieldset>
          )}
        </div>
      )}
    </Card>
  );
}
