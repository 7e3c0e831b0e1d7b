// Workshop of drawings and engravings: objects on a sheet that become one job.
import { computed, effect, signal } from "@preact/signals";
import { reportError } from "../actions";
import type { Option, Report } from "../api";
import { RpcError } from "../client";
import { t } from "../i18n";
import texts from "../panels/workshop.json";
import { call, shownArm } from "../session";
import * as store from "../store";
import { boundsOf, type Points } from "../view/flat";
import { readWorld, world } from "../view/world";
import { sentencesOf } from "../words";
import { History } from "./history";
import {
  boxOf,
  clampedPlace,
  compose,
  type Doc,
  drawnItems,
  type Item,
  isObjectOption,
  isSame,
  linesByColor,
  normalizedTurn,
  type PartRow,
  type Place,
  type Point,
  partRows,
  partsOf,
  rotated,
  roundedPlace,
  selectedItem,
  styleOf,
  withChange,
  withMovedItem,
  withoutItem,
  withPartDrawn,
} from "./items";
import * as jobs from "./jobs";
import { corners, occupiedFrames, rotateOf, turnOf, uprightRotation } from "./paper";
import { freeSpot, overlaps, type Room } from "./room";
import { type Shape, svgOf } from "./shapes";
import { storedWorkshop } from "./stored";
import { sheet } from "./surface";
import { entryOf, isRelevant, optionsOf, requireValid, type Source, setupOf, type Values, Workshop } from "./workshop";

const w = sentencesOf(texts);

/** Result of an object's last check. */
interface CheckedObject {
  key: string;
  report: Report;
  place: Place | null;
  /** Width and height of the object at `place`, as the reader sees them, mm. */
  sides: Point;
  /** Middle of this area relative to `place`; not zero if the drawing is repeated or filled. */
  middle: Point;
}

/** Formats without a size of their own, which fill the free space. */
const FILLING_FORMATS = ["text", "image"];
/**
 * Largest side that is chosen automatically by tool and format, mm: large images take long, burnt
 * ones even longer.
 */
const MAX_SIDE: Record<string, Record<string, number>> = { pen: { image: 130 }, laser: { image: 50, text: 120 } };
/** Share of the size on a blank sheet below which the sheet counts as full. */
const FULL_SHEET_SHARE = 0.45;
/** An object shrunk below this share of its size gets a note. */
const SHRINK_NOTE_SHARE = 0.97;
/** Smallest size, mm; below it an object has no room. */
const MIN_SIZE = 12;
/** Formats that are burnt as they are and cannot be combined with others. */
const UNCOMBINABLE_FORMATS = ["image", "gcode", "testgrid"];
/** Width of an image at scale 1, mm. */
const IMAGE_WIDTH = 30;
/** Largest number of preview points. A preview with more has been thinned and cannot be drawn. */
const MAX_PREVIEW_POINTS = 19_000;
/** Longest text of a composed drawing that fits into a message. */
const MAX_TEXT_LENGTH = 900_000;
/** Placement options, which the sheet determines. */
const PLACEMENT_OPTIONS = ["at", "scale", "rotate", "fit", "width", "height", "place", "turn"];
/** Options of a job that do not apply while a single object is checked. */
const JOB_ONLY_OPTIONS = ["parts", "no_pause"];

export class Bench extends Workshop {
  readonly tool: "pen" | "laser";
  readonly doc = new History<Doc>({ items: [], chosen: null });
  readonly checkedObjects = signal<ReadonlyMap<number, CheckedObject>>(new Map());
  readonly item = computed(() => selectedItem(this.doc.now.value));
  /** Options of the job, for all of its objects. */
  private readonly common = signal<Values>({});
  /** Source and setup of the last check. */
  private readonly job = signal<{ source: Source; setup: Record<string, unknown> } | null>(null);
  /**
   * Automatic places of objects, valid while `key` is unchanged; a null place means the station's.
   */
  private readonly spots = new Map<number, { key: string; place: Place | null }>();
  /** True if an object had little or no free room. */
  readonly isFull = signal(false);
  /** Object shrunk to fit beside the others: widths before and after, mm. */
  readonly shrunk = signal<{ id: number; from: number; to: number } | null>(null);
  /** Job started here, and the selection and options at its start. */
  private readonly startedJob = signal<{ job: string; appearance: string } | null>(null);
  /** Stage of the shown objects: `drawing` while their job runs, `drawn` once it is done. */
  readonly stage = computed<"planned" | "drawing" | "drawn">(() => {
    const begun = this.startedJob.value;
    const job = begun === null ? undefined : jobs.jobs.value.find((one) => one.job === begun.job);
    if (begun === null || job === undefined || begun.appearance !== this.appearance()) return "planned";
    if (job.state === "done") return "drawn";
    return jobs.isActive(job) ? "drawing" : "planned";
  });
  protected override onJobStarted(job: string): void {
    this.startedJob.value = { job, appearance: this.appearance() };
  }
  /** Identifies the appearance of the objects. The division into parts and pen changes do not affect it. */
  private appearance(): string {
    const { no_pause: _, ...common } = this.common.value;
    const items = this.doc.now.value.items.map(({ name: _name, values: { parts: _parts, ...values }, ...item }) => ({
      ...item,
      values,
    }));
    return JSON.stringify([items, common]);
  }
  private nextId = 1;

  constructor(tool: "pen" | "laser") {
    const work = tool === "pen" ? "draw" : "engrave";
    super({ tool, work });
    this.tool = tool;
    const storage = storedWorkshop(work);
    const restored = storage.read();
    if (restored !== null) {
      this.doc.amend(restored.doc);
      this.common.value = restored.common;
      this.nextId = Math.max(0, ...restored.doc.items.map(({ id }) => id)) + 1;
    }
    effect(() => storage.write({ doc: this.doc.now.value, common: this.common.value }));
  }

  /** True if the objects become one drawing. A single object is passed on as it is. */
  readonly isComposed = computed(() => {
    const { items } = this.doc.now.value;
    return items.length > 1 || items[0]?.color != null;
  });
  /**
   * Source to run: the only object, or the composition of all. A composition has no file lines to
   * show.
   */
  readonly chosen = computed<Source | null>(() => {
    const [first] = this.doc.now.value.items;
    if (first === undefined) return null;
    return this.isComposed.value ? { format: "svg" } : first.source;
  });
  readonly values = computed<Values>(() => ({ ...this.common.value, ...this.item.value?.values }));

  override isSettable(name: string): boolean {
    return super.isSettable(name) && !PLACEMENT_OPTIONS.includes(name);
  }

  private isOwn(name: string): boolean {
    const option = this.options.value.find((one) => one.name === name);
    return option !== undefined && isObjectOption(option);
  }

  setValue(name: string, to: string): void {
    const item = this.item.value;
    if (item !== null && this.isOwn(name)) {
      // `only` lists numbers of parts, which a new division makes invalid.
      const { only, ...rest } = item.values;
      const values = { ...rest, ...(only && name !== "parts" ? { only } : {}), [name]: to };
      this.doc.commit(withChange(this.doc.now.value, item.id, { values }), `${name} ${item.id}`);
    } else this.common.value = { ...this.common.value, [name]: to };
  }

  setValues(values: Values): void {
    const all = Object.entries(values);
    this.common.value = Object.fromEntries(all.filter(([name]) => !this.isOwn(name)));
    const item = this.item.value;
    const own = Object.fromEntries(all.filter(([name]) => this.isOwn(name)));
    if (item !== null)
      this.doc.commit(withChange(this.doc.now.value, item.id, { values: { ...partsOf(item.values), ...own } }));
  }

  /**
   * Divides a file without layers by its colours. Pauses for pen changes are off, because the user
   * has not asked for them.
   */
  divideByColors(): void {
    const item = this.item.value;
    if (item === null) return;
    this.doc.amend(withChange(this.doc.now.value, item.id, { values: { ...item.values, parts: "color" } }));
    this.common.value = { ...this.common.value, no_pause: "true" };
  }

  /** Parts of all objects on the sheet, drawn or not. */
  readonly parts = computed<PartRow[]>(() =>
    partRows(this.doc.now.value.items, this.checkedObjects.value, this.isComposed.value ? this.report.value : null),
  );
  /** Switches a part on or off. All objects keep their places. */
  setPartDrawn(row: PartRow, isOn: boolean): void {
    const now = this.doc.now.value;
    const items = now.items.map((item) => ({ ...item, place: this.placeOf(item) }));
    this.doc.commit(withPartDrawn({ ...now, items }, this.checkedObjects.value, row, isOn, this.isComposed.value));
  }

  /** Objects restored from storage get their options once the station is connected. */
  override checkOnChange(most?: number): () => void {
    const ends = [
      super.checkOnChange(most),
      effect(() => {
        if (store.isUp.value && this.options.peek().length === 0 && this.doc.now.peek().items.length > 0)
          this.loadSelectedOptions();
      }),
    ];
    return () => ends.forEach((end) => end());
  }

  // User actions.

  /** Resolves once the options of the selected object are known. */
  ready: Promise<void> = Promise.resolve();

  private async fetchOptions(format: string): Promise<void> {
    try {
      const options = await optionsOf(format);
      if ((this.item.peek()?.format ?? format) === format) this.options.value = options;
    } catch (error) {
      reportError(error);
    }
  }

  private loadOptions(format: string): void {
    this.ready = this.fetchOptions(format);
  }

  /** Removes everything from the sheet. */
  clear(): void {
    this.forgetParts();
    this.doc.commit({ items: [], chosen: null });
    this.loadSelectedOptions();
  }

  /** Adds an object to the sheet. Objects already there keep their places. */
  add(of: Omit<Item, "id" | "color" | "values" | "place">): void {
    const before = this.doc.now.value;
    const id = this.nextId++;
    // A new text takes over the style of the last one.
    const like = before.items.findLast(({ format }) => format === of.format);
    const values = styleOf(like?.values ?? {});
    const items = before.items.map((item) => ({
      ...item,
      place: item.place ?? this.checkedObjects.value.get(item.id)?.place ?? null,
    }));
    if (items.length === 0) this.forgetParts();
    this.doc.commit({ items: [...items, { ...of, id, color: null, values, place: null }], chosen: id }, `new ${id}`);
    this.report.value = items.length === 0 ? null : this.report.value;
    this.loadOptions(of.format);
  }

  /** Resets the option for pen changes, which belongs to the former drawing. */
  private forgetParts(): void {
    const { no_pause: _, ...kept } = this.common.value;
    this.common.value = kept;
  }

  addShape(shape: Shape, name: string): void {
    this.add({ source: { text: svgOf(shape), format: "svg" }, format: "svg", name, shape });
  }

  /** Replaces all objects by one. */
  replace(of: Omit<Item, "id" | "color" | "values" | "place">): void {
    const now = this.doc.now.value;
    const [only] = now.items;
    if (now.items.length === 1 && only?.format === of.format) {
      this.doc.commit(withChange(now, only.id, { ...of, place: null }), `${of.format} ${only.id}`);
      return;
    }
    const id = this.nextId++;
    this.forgetParts();
    this.doc.commit({ items: [{ ...of, id, color: null, values: {}, place: null }], chosen: id });
    this.loadOptions(of.format);
  }

  /** Writes into the selected text, or into a new one. */
  write(text: string): void {
    const item = this.item.value;
    const name = text.trim().slice(0, 40);
    const source = { text, format: "text" };
    if (item?.format !== "text") {
      if (name !== "") this.add({ source, format: "text", name });
      return;
    }
    if (name === "") return this.remove(item.id, `new ${item.id}`);
    this.doc.commit(withChange(this.doc.now.value, item.id, { source, name }), `new ${item.id}`);
  }

  /** Adds another text. */
  addText(text: string): void {
    this.add({ source: { text, format: "text" }, format: "text", name: text });
  }

  choose(id: number | null): void {
    const now = this.doc.now.value;
    if (now.chosen === id) return;
    this.doc.seal();
    this.doc.amend({ ...now, chosen: id });
    this.loadSelectedOptions();
  }

  remove(id: number, key: string | null = null): void {
    this.doc.commit(withoutItem(this.doc.now.value, id), key);
    this.loadSelectedOptions();
  }

  duplicate(id: number): void {
    const item = this.doc.now.value.items.find((one) => one.id === id);
    if (item === undefined) return;
    const found = this.checkedObjects.value.get(id);
    this.add({
      source: item.source,
      format: item.format,
      name: item.name,
      ...(item.shape ? { shape: item.shape } : {}),
      ...(item.isOff ? { isOff: true } : {}),
    });
    const now = this.doc.now.value;
    const added = now.items.at(-1);
    if (added === undefined) return;
    const place = item.place ?? found?.place ?? null;
    const beside: Place | null = place === null ? null : { ...place, at: [place.at[0] + 10, place.at[1] + 10] };
    this.doc.amend(withChange(now, added.id, { place: beside, color: item.color, values: item.values }));
  }

  order(id: number, by: number): void {
    this.doc.commit(withMovedItem(this.doc.now.value, id, by));
  }

  color(id: number, color: string | null): void {
    this.doc.commit(withChange(this.doc.now.value, id, { color }));
  }

  /**
   * Moves, scales or turns the selected object about the centre of its drawn colours. Consecutive
   * changes with the same key are undone together.
   */
  change(by: Partial<Place>, key: string | null = null): void {
    const [item, now] = [this.item.value, this.place.value];
    if (item === null || now === null) return;
    const next = clampedPlace({ ...now, ...by }, Math.max(...this.sizeOf(item)) / now.scale);
    const [dx, dy] = this.middleOf(item, next);
    const place = roundedPlace({ ...next, at: [next.at[0] - dx, next.at[1] - dy] });
    this.doc.commit(withChange(this.doc.now.value, item.id, { place }), key === null ? null : `${key} ${item.id}`);
  }

  /** Leaves the place of the selected object to the page. */
  releasePlace(): void {
    const item = this.item.value;
    if (item === null) return;
    this.spots.delete(item.id);
    this.doc.commit(withChange(this.doc.now.value, item.id, { place: null }));
  }

  /**
   * Handles a new sheet: objects without a chosen place are placed again, with the whole sheet
   * free.
   */
  refresh(): void {
    this.spots.clear();
    this.isFull.value = false;
    const stays = ({ id, place }: Item) => place !== null && this.checkedObjects.value.has(id);
    const items = this.doc.now.value.items.filter(stays);
    this.checkedObjects.value = new Map(
      [...this.checkedObjects.value].filter(([id]) => items.some((item) => item.id === id)),
    );
    if (this.doc.now.value.items.some(({ place }) => place === null)) void this.check();
  }

  undo(): void {
    this.doc.undo();
    this.loadSelectedOptions();
  }

  redo(): void {
    this.doc.redo();
    this.loadSelectedOptions();
  }

  /** Loads the options of the selected object. */
  private loadSelectedOptions(): void {
    const { items } = this.doc.now.value;
    const format = this.item.value?.format ?? (items.length > 0 ? "svg" : null);
    if (format !== null) this.loadOptions(format);
    if (items.length === 0) this.forget();
  }

  async openFiles(files: Iterable<File>): Promise<void> {
    for (const { name, label } of await this.storeFiles(files)) this.take(name, label);
  }

  /** Adds a program of the library. `label` is its name for the user. */
  take(name: string, label = name): void {
    const format = entryOf(name)?.format ?? null;
    if (format === null) this.problem.value = { text: t("run.unknown"), remedies: [] };
    else this.add({ source: { program: name }, format, name: label });
  }

  // Places of objects.

  /**
   * Centre, scale and turn of the drawn colours of the selected object: as chosen by the user,
   * otherwise as placed by the last check.
   */
  readonly place = computed<Place | null>(() => {
    const item = this.item.value;
    const place = item === null ? null : this.placeOf(item);
    if (item === null || place === null) return null;
    const [dx, dy] = this.middleOf(item, place);
    return { ...place, at: [place.at[0] + dx, place.at[1] + dy] };
  });
  /**
   * Offset from the place of an object to the centre of its drawn colours. The station places the
   * centre of the whole file, after turning it, so the offset is zero if all colours are drawn.
   */
  private middleOf(item: Item, { scale, turn }: Place): Point {
    if (!item.values.only) return [0, 0];
    const found = this.checkedObjects.value.get(item.id);
    const [mx, my] = found?.middle ?? [0, 0];
    const by = scale / (found?.place?.scale ?? 1);
    return rotated([mx * by, my * by], uprightRotation() + turn);
  }
  placeOf(item: Item): Place | null {
    return item.place ?? this.checkedObjects.value.get(item.id)?.place ?? null;
  }
  /** Width and height of an object at its place. */
  sizeOf(item: Item): Point {
    const found = this.checkedObjects.value.get(item.id);
    const by = (this.placeOf(item)?.scale ?? 1) / (found?.place?.scale ?? 1);
    return [(found?.sides[0] ?? 0) * by, (found?.sides[1] ?? 0) * by];
  }
  /** Position of a corner of an object, or of a point `beyond` it. */
  cornerOf(item: Item, [sx, sy]: Point, beyond = 0): Point {
    const [found, place, [width, height]] = [
      this.checkedObjects.value.get(item.id),
      this.placeOf(item),
      this.sizeOf(item),
    ];
    const by = (place?.scale ?? 1) / (found?.place?.scale ?? 1);
    const [mx, my] = found?.middle ?? [0, 0];
    const corner = [mx * by + (sx * width) / 2, my * by + (sy * height) / 2 + beyond];
    const [dx, dy] = rotated(corner, uprightRotation() + (place?.turn ?? 0));
    return [(place?.at[0] ?? 0) + dx, (place?.at[1] ?? 0) + dy];
  }
  setWidth(width: number): void {
    const item = this.item.value;
    const [is] = item === null ? [0] : this.sizeOf(item);
    if (is > 0) this.change({ scale: ((this.place.value?.scale ?? 1) * width) / is });
  }

  /** True if everything has been checked at its wanted place. */
  readonly isChecked = computed(() =>
    this.doc.now.value.items.every((item) => {
      const found = this.checkedObjects.value.get(item.id);
      if (found === undefined) return false;
      return item.place === null || (found.place !== null && isSame(item.place, found.place));
    }),
  );

  protected override isSettled(): boolean {
    return this.isChecked.value && !this.isChecking.value && this.checkedKey === this.selectionKey();
  }
  override selectionKey(): string {
    const { items } = this.doc.now.value;
    const versions = items.map(({ source }) => entryOf(source.program)?.modified);
    return JSON.stringify([items.map(({ name: _, ...item }) => item), versions, this.common.value]);
  }
  protected override trackDependencies(): void {
    void this.doc.now.value.items;
    void this.common.value;
    void sheet.value;
  }
  protected override largestFile(): number | null {
    const sizes = this.doc.now.value.items.map(({ source }) => entryOf(source.program)?.bytes ?? 0);
    return Math.max(0, ...sizes);
  }

  override source(): Source & { setup?: Record<string, unknown> } {
    const job = this.job.value;
    return job === null ? {} : { ...job.source, setup: job.setup };
  }

  // Requests to the station.

  /** Room for automatic placement. Existing drawings and the other objects are occupied areas. */
  private async freeRoom(height: number, others: readonly CheckedObject[]): Promise<Room> {
    const { outlines } = await call("motion.reach", { z: height, tool: this.tool });
    const boxes = others.map(({ report }) => boundsOf((report.preview?.strokes ?? []).flatMap(({ points }) => points)));
    return { outlines, paper: corners(), taken: [...occupiedFrames(), ...boxes] };
  }

  private requestReport(source: Source, setup: Record<string, unknown>): Promise<Report> {
    return call("job.check", { ...shownArm(), ...source, setup, preview: true });
  }

  private placementOptions(place: Place | null, isHeld: boolean): Record<string, unknown> {
    if (place === null) return { rotate: rotateOf(0), fit: true };
    const { at, scale, turn } = place;
    return { at, scale, rotate: rotateOf(turn), turn: false, ...(isHeld ? {} : { fit: true }) };
  }

  /** Options of an object: its own, and those of the whole job if it is alone. */
  private async optionsFor(item: Item): Promise<Record<string, unknown>> {
    const all = (await optionsOf(item.format)).filter(({ name }) => this.isSettable(name));
    const values = { ...this.common.value, ...item.values };
    const said = (name: string): string =>
      String(this.fixed[name] ?? (values[name] || (all.find((one) => one.name === name)?.default ?? "")));
    const isAsked = (option: Option) =>
      isRelevant(option, all, said) &&
      (!this.isComposed.value || isObjectOption(option) || ["surface", "speed"].includes(option.name)) &&
      !(this.isComposed.value && JOB_ONLY_OPTIONS.includes(option.name));
    requireValid(all.filter(isAsked), values);
    const set = setupOf(all.filter(isAsked), values);
    const parts =
      this.isComposed.value && all.some(({ name }) => name === "parts")
        ? { parts: (values.only ? values.parts : "color") || undefined, no_pause: true }
        : {};
    // The size in the image file does not matter, and a small image is checked faster.
    const width = item.format === "image" ? { width: IMAGE_WIDTH } : {};
    return { ...set, ...parts, ...width, ...this.fixed };
  }

  /** Checks one object at its place. An unchanged object is not checked again. */
  private async checkObject(item: Item, others: readonly CheckedObject[]): Promise<CheckedObject> {
    const options = await this.optionsFor(item);
    const version = entryOf(item.source.program)?.modified ?? 0;
    if (store.arm.value?.virtual === true && world.value === null) await readWorld();
    const context = [item.source, version, sheet.value, store.armName.value, corners()];
    const key = JSON.stringify([context, options, item.place]);
    // The division into parts does not affect the automatic place.
    const { parts: _, no_pause: _pause, ...placementSetup } = options;
    const placementKey = JSON.stringify([context, placementSetup]);
    const known = this.checkedObjects.value.get(item.id);
    if (this.isComposed.value && known?.key === key) return known;
    let place = item.place;
    if (place === null) {
      const spot = this.spots.get(item.id);
      if (spot?.key !== placementKey) {
        const [natural, found] = await this.placeAutomatically(item, options, others);
        this.spots.set(item.id, { key: placementKey, place: found });
        if (found === null) return this.checkedObject(key, natural);
        place = found;
      } else place = spot.place;
    }
    this.requestedSetup = { ...options, ...this.placementOptions(place, item.place !== null) };
    const report = await this.requestReport(item.source, this.requestedSetup);
    if (place === null) return this.checkedObject(key, report);
    if (item.place !== null) return this.checkedObject(key, report, item.place);
    // The note about scaling refers to an attempt of this page, so it is dropped.
    const notes = (report.notes ?? []).filter(({ code }) => code !== "placed");
    return this.checkedObject(key, { ...report, notes }, { ...place, scale: report.placed?.scale ?? place.scale });
  }
  /** Setup of the last requested object. */
  private requestedSetup: Record<string, unknown> = {};

  /**
   * Converts a report into a result, for `requestedPlace` if there is one. The middle is computed
   * from the lines, because lines that fill a shape have another middle than its edges.
   */
  private checkedObject(key: string, report: Report, requestedPlace: Place | null = null): CheckedObject {
    const { placed, preview } = report;
    if (placed === undefined) return { key, report, place: null, sides: [0, 0], middle: [0, 0] };
    const place = requestedPlace ?? { at: placed.at, scale: placed.scale, turn: normalizedTurn(turnOf(placed.turn)) };
    return { key, report, place, ...boxOf(preview?.strokes ?? [], uprightRotation() + place.turn, place.at) };
  }

  /**
   * Returns the report of an object as the station places it, and a place with more room for it;
   * null if the station's place is good.
   */
  private async placeAutomatically(
    item: Item,
    options: Record<string, unknown>,
    others: readonly CheckedObject[],
  ): Promise<[Report, Place | null]> {
    const setup = { ...options, ...this.placementOptions(null, false) };
    const report = await this.requestReport(item.source, setup);
    this.requestedSetup = setup;
    this.isFull.value = false;
    this.shrunk.value = null;
    const { place, sides, middle } = this.checkedObject("", report);
    const strokes = report.preview?.strokes ?? [];
    const [first] = strokes;
    if (place === null || first === undefined) return [report, null];
    // With `page` or `move` these options determine the place.
    if (["page", "move"].some((name) => options[name] !== undefined)) return [report, null];
    // A repeated object is not shrunk, because its distances were given.
    const isRepeated = options.grid !== undefined;
    const room = await this.freeRoom(first.height, others);
    const longest = Math.max(...sides);
    const isWritten = item.format === "text" && (item.values.size ?? "") !== "";
    const fills = FILLING_FORMATS.includes(item.format) && !isWritten;
    const most = (MAX_SIDE[this.tool]?.[item.format] ?? Infinity) / longest;
    const isTaken = (frame = boundsOf(strokes.flatMap(({ points }) => points))) =>
      room.taken.some((one) => overlaps(one, frame));
    // On a measured sheet the page of a file coincides with the paper.
    const isKept = room.paper === null || sheet.value !== null;
    if (!fills && isKept && !isTaken() && report.ok) return [report, null];
    // An object that fills the room is upright; others keep a turn that the station needed. Its box
    // is along the arm's x and y.
    const turn = fills ? 0 : place.turn;
    const [sin, cos] = [Math.sin, Math.cos].map((of) => Math.abs(of(((uprightRotation() + turn) * Math.PI) / 180))) as [
      number,
      number,
    ];
    const [along, across] = [sides[0] * cos + sides[1] * sin, sides[0] * sin + sides[1] * cos];
    const least = Math.min(1, MIN_SIZE / longest);
    const largest = fills && !isRepeated ? most : Math.min(1, most);
    const within = (of: Room) =>
      freeSpot(of, [along, across], isRepeated ? largest : Math.min(least, largest), largest);
    const blank = room.taken.length === 0 ? null : within({ ...room, taken: [] });
    let spot = within(room);
    this.isFull.value = blank !== null && (spot === null || spot.scale < FULL_SHEET_SHARE * blank.scale);
    spot ??= blank;
    if (spot === null) return [report, null];
    if (!fills && spot.scale < SHRINK_NOTE_SHARE * largest)
      this.shrunk.value = { id: item.id, from: sides[0], to: sides[0] * spot.scale };
    const [mx, my] = rotated([middle[0] * spot.scale, middle[1] * spot.scale], uprightRotation() + turn);
    const at: [number, number] = [spot.at[0] - mx, spot.at[1] - my];
    return [report, roundedPlace({ at, scale: spot.scale * place.scale, turn })];
  }

  protected override async requestCheck(): Promise<Report | null> {
    const { items } = this.doc.now.value;
    const selection = this.selectionKey();
    const checkNumber = this.checks;
    const alone =
      items.length > 1 && this.tool === "laser"
        ? items.find(({ format }) => UNCOMBINABLE_FORMATS.includes(format))
        : undefined;
    if (alone !== undefined) throw new RpcError(0, w("draw.alone", { name: alone.name }));
    const found = new Map<number, CheckedObject>();
    if (items.every(({ place }) => place !== null)) this.isFull.value = false;
    for (const item of items) {
      const otherObjects = items.flatMap(({ id }) =>
        id === item.id ? [] : (found.get(id) ?? this.checkedObjects.value.get(id) ?? []),
      );
      found.set(item.id, await this.checkObject(item, otherObjects));
      if (checkNumber !== this.checks) return null;
    }
    this.checkedKey = selection;
    this.checkedObjects.value = found;
    const [only] = items;
    const of = only === undefined ? undefined : found.get(only.id);
    if (!this.isComposed.value && only !== undefined && of !== undefined) {
      this.job.value = { source: only.source, setup: this.requestedSetup };
      return of.report;
    }
    return this.checkComposition(items, found);
  }

  /** Checks all objects as one drawing. */
  private async checkComposition(items: readonly Item[], found: ReadonlyMap<number, CheckedObject>): Promise<Report> {
    const inks = drawnItems(items).flatMap((item) => {
      const report = found.get(item.id)?.report;
      const points = report?.preview?.strokes.reduce((sum, stroke) => sum + stroke.points.length, 0) ?? 0;
      if (points > MAX_PREVIEW_POINTS) throw new RpcError(0, w("draw.alone", { name: item.name }));
      return report === undefined ? [] : linesByColor(report, item.color);
    });
    const { text, at } = compose(inks);
    if (text.length > MAX_TEXT_LENGTH) throw new RpcError(0, w("draw.alone", { name: items.at(-1)?.name ?? "" }));
    const all = (await optionsOf("svg")).filter((option) => this.isSettable(option.name) && !isObjectOption(option));
    requireValid(all, this.common.value);
    const colors = new Set(inks.map(({ color }) => color));
    const parts = colors.size > 1 ? { parts: "color", no_pause: this.common.value.no_pause !== "false" } : {};
    const setup = {
      ...setupOf(all, this.common.value),
      ...parts,
      ...this.fixed,
      at,
      rotate: sheet.value === null ? 0 : -sheet.value.rotation,
      turn: false,
      white: "draw",
    };
    const source = { text, format: "svg" };
    this.job.value = { source, setup };
    return this.requestReport(source, setup);
  }

  /** Reachable lines of the current check, to be recorded as drawn on the paper. */
  drawnLines(): Points[] {
    return (this.report.value?.preview?.strokes ?? []).filter(({ reachable }) => reachable).map(({ points }) => points);
  }

  /** Title of the job. */
  readonly title = computed(() => {
    const names = this.doc.now.value.items.map(({ name }) => name);
    return names.join(", ").slice(0, 40);
  });
}

export const benches = { pen: new Bench("pen"), laser: new Bench("laser") };
