// Image on the sheet: crop, brightness, and original beside result.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Bench } from "../run/bench";
import { type Item, rotated } from "../run/items";
import * as paper from "../run/paper";
import * as library from "../run/programs";
import { entryOf } from "../run/workshop";
import * as store from "../store";
import { Button, Card, Field, Range, TextField } from "../ui/parts";
import { boundsOf, pathOf } from "../view/flat";
import { sentencesOf } from "../words";
import { OptionField } from "./setup";
import "./photo.css";
import texts from "./workshop.json";

const w = sentencesOf(texts);
/** Smallest crop, px; a smaller one is a tap. */
const MIN_CROP = 8;
const SLIDERS = [
  { name: "brightness", least: -100, most: 100, usual: 0 },
  { name: "contrast", least: -100, most: 100, usual: 0 },
  { name: "threshold", least: 1, most: 255, usual: 128 },
] as const;

/** Options that this panel asks for. */
export const PHOTO_OPTIONS = ["image", "mode", "crop", "invert", ...SLIDERS.map(({ name }) => name)];

type Area = [x: number, y: number, width: number, height: number];
const parseArea = (text: string): Area | null => {
  const numbers = text.split(/[\s,]+/).map(Number);
  return numbers.length === 4 && numbers.every(Number.isFinite) ? (numbers as Area) : null;
};

/** Picture of the file, in which the user drags the crop frame. */
function Crop({ bench, item, url }: { bench: Bench; item: Item; url: string }) {
  const image = useRef<HTMLImageElement>(null);
  const size = useSignal<[number, number] | null>(null);
  const dragged = useSignal<Area | null>(null);
  const isShown = useSignal(true);
  const kept = dragged.value ?? parseArea(item.values.crop ?? "");
  const pixel = (event: PointerEvent): [number, number] => {
    const box = image.current?.getBoundingClientRect();
    const [wide, high] = size.value ?? [1, 1];
    if (box === undefined) return [0, 0];
    const within = (value: number, most: number) => Math.max(0, Math.min(most, Math.round(value)));
    return [
      within(((event.clientX - box.left) / box.width) * wide, wide),
      within(((event.clientY - box.top) / box.height) * high, high),
    ];
  };
  const press = (event: PointerEvent) => {
    const target = event.currentTarget;
    if (event.button !== 0 || size.value === null || !(target instanceof Element)) return;
    event.preventDefault();
    target.setPointerCapture(event.pointerId);
    const from = pixel(event);
    const over = new AbortController();
    target.addEventListener(
      "pointermove",
      (moved) => {
        const to = pixel(moved as PointerEvent);
        dragged.value = [
          Math.min(from[0], to[0]),
          Math.min(from[1], to[1]),
          Math.abs(to[0] - from[0]),
          Math.abs(to[1] - from[1]),
        ];
      },
      over,
    );
    target.addEventListener(
      "lostpointercapture",
      () => {
        over.abort();
        const area = dragged.value;
        dragged.value = null;
        if (area !== null && area[2] >= MIN_CROP && area[3] >= MIN_CROP) bench.setValue("crop", area.join(" "));
      },
      over,
    );
  };
  const [wide, high] = size.value ?? [1, 1];
  const share = (value: number, of: number) => `${(100 * value) / of}%`;
  if (!isShown.value) return <CropField bench={bench} item={item} />;
  return (
    <div class="photo-crop" data-testid="photo-crop" onPointerDown={press}>
      <img
        ref={image}
        src={url}
        alt=""
        draggable={false}
        onLoad={(event) => (size.value = [event.currentTarget.naturalWidth, event.currentTarget.naturalHeight])}
        onError={() => (isShown.value = false)}
      />
      {kept === null ? null : (
        <span
          class="photo-frame"
          style={{
            left: share(kept[0], wide),
            top: share(kept[1], high),
            width: share(kept[2], wide),
            height: share(kept[3], high),
          }}
        />
      )}
    </div>
  );
}

function CropField({ bench, item }: { bench: Bench; item: Item }) {
  return (
    <TextField
      id="setup-crop"
      label={w("photo.crop")}
      unit="x, y, ↔, ↕ px"
      value={item.values.crop ?? ""}
      set={(to) => bench.setValue("crop", to)}
    />
  );
}

/** Result as the core computes it, turned towards the reader. */
function Result({ bench, item }: { bench: Bench; item: Item }) {
  const found = bench.checkedObjects.value.get(item.id);
  const strokes = found?.report.preview?.strokes ?? [];
  const angle = paper.uprightRotation() + (found?.place?.turn ?? 0);
  const lines = strokes.map(({ points, power }) => ({ power, points: points.map((point) => rotated(point, -angle)) }));
  const { x, y, width, height } = boundsOf(lines.flatMap(({ points }) => points));
  const paths = new Map<number, string>();
  for (const { power, points } of lines) paths.set(power, (paths.get(power) ?? "") + pathOf(points));
  const isBurnt = bench.tool === "laser";
  const pen = Number(item.values.pen_width || 0.5);
  return (
    <div class={`photo-result ${bench.isChecking.value ? "busy" : ""}`} data-testid="photo-result">
      {strokes.length === 0 ? (
        <p class="hint">{w("photo.making")}</p>
      ) : (
        <svg viewBox={`${x} ${-y - height} ${width} ${height}`} aria-hidden="true">
          <g transform="scale(1 -1)">
            {[...paths].map(([power, path]) => (
              <path
                key={power}
                d={path}
                stroke-width={isBurnt ? 0.22 : Math.max(pen, width / 300)}
                stroke-opacity={isBurnt ? power / 100 : 1}
              />
            ))}
          </g>
        </svg>
      )}
    </div>
  );
}

export function Photo({ bench }: { bench: Bench }) {
  const item = bench.item.value;
  const name = item?.source.program;
  if (item === null || item.format !== "image" || name === undefined) return null;
  return <Controls key={`${item.id}`} bench={bench} item={item} name={name} />;
}

function Controls({ bench, item, name }: { bench: Bench; item: Item; name: string }) {
  const url = useSignal<string | null>(null);
  useEffect(() => {
    let [made, gone] = ["", false];
    const end = effect(() => {
      const entry = entryOf(name);
      if (entry === null || made !== "") return;
      library.fetchProgram(entry).then(
        (bytes) => {
          if (!gone && made === "") url.value = made = URL.createObjectURL(bytes);
        },
        () => {},
      );
    });
    return () => {
      gone = true;
      end();
      URL.revokeObjectURL(made);
    };
  }, [name]);
  const isBlack =
    bench.tool === "pen"
      ? ["outline", "centerline"].includes(bench.valueOf("image") || "outline")
      : bench.valueOf("mode") === "threshold";
  const style = bench.shownOptions.value.find((option) => option.name === (bench.tool === "pen" ? "image" : "mode"));
  const isChanged = [...SLIDERS.map(({ name }) => name), "crop", "invert"].some((one) => item.values[one]);
  const reset = () => {
    for (const one of [...SLIDERS.map(({ name }) => name), "crop", "invert"])
      if (item.values[one]) bench.setValue(one, "");
  };
  return (
    <Card
      title={w("photo.title")}
      class="photo-card"
      more={<Button id="photo-reset" class="quiet small" off={!isChanged} text={w("photo.reset")} press={reset} />}
    >
      <div class="photo-both">
        <figure>
          {url.value === null ? null : <Crop bench={bench} item={item} url={url.value} />}
          <figcaption class="hint">{w("photo.crop")}</figcaption>
        </figure>
        <figure>
          <Result bench={bench} item={item} />
          <figcaption class="hint">{w(`photo.result.${bench.tool}`)}</figcaption>
        </figure>
      </div>
      {style === undefined ? null : <OptionField option={style} />}
      {SLIDERS.map(({ name, least, most, usual }) => {
        const off = !store.isUp.value || (name === "threshold" && !isBlack);
        const value = Number(item.values[name] || usual);
        return (
          <Field
            key={name}
            class="photo-slider"
            label={
              <>
                {w(`photo.${name}`)} <output>{value}</output>
              </>
            }
          >
            <Range
              id={`photo-${name}`}
              label={w(`photo.${name}`)}
              least={least}
              most={most}
              value={value}
              off={off}
              why="photo-why"
              set={(to) => bench.setValue(name, to === usual ? "" : String(to))}
            />
          </Field>
        );
      })}
      <label class="tick">
        <input
          type="checkbox"
          checked={item.values.invert === "true"}
          data-testid="photo-invert"
          onChange={(event) => bench.setValue("invert", event.currentTarget.checked ? "true" : "")}
        />
        <span>{w("photo.invert")}</span>
      </label>
      <p id="photo-why" class="hint">
        {isBlack ? "" : w("photo.threshold.off")}
      </p>
    </Card>
  );
}
