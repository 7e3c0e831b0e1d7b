// Arms of a station, or of all stations of a site, for the teacher's view. They are polled while
// the view is shown. The number of requests per second is limited, and rendering costs more than
// polling, so tiles in view are updated often and all others rarely.
import { batch, type Signal, signal } from "@preact/signals";
import { complain, dangerOf } from "./actions";
import type { Job, State } from "./api";
import { queues } from "./class";
import type { Params } from "./client";
import { LINE_ENDED, RpcError } from "./client";
import { t } from "./i18n";
import { change, newest, kept as pictured } from "./results";
import { isUnderWay } from "./run/jobs";
import { call, notified } from "./session";
import * as shelf from "./shelf";
import * as store from "./store";
import type { Stroke } from "./view/seen";

/**
 * Requests for states per second for all arms in view together, as far as `LONGEST_IN_VIEW`
 * permits. A station accepts 200 messages a second from a page, and a hub needs two more for each
 * arm.
 */
const ASKED = 100;
/**
 * Interval between two requests for one arm, ms: at least, at most in view (a tile is to be less
 * than a second old), and out of view, where the limit of requests is counted separately.
 */
const SHORTEST = 200;
const LONGEST_IN_VIEW = 750;
const OUT_OF_VIEW = 5000;
const LIST = 1000;
/**
 * Time within which states, and changes of jobs, are collected before they are rendered together,
 * ms. Fifty drawing arms cause hundreds of changes of jobs a second.
 */
const TOGETHER = 50;
const JOBS = 250;

/** Values by arm, each a separate signal, so that a change renders only the tile of its arm. */
class ByArm<T> {
  private readonly signals = new Map<string, Signal<T | undefined>>();

  private at(arm: string): Signal<T | undefined> {
    let found = this.signals.get(arm);
    if (found === undefined) this.signals.set(arm, (found = signal(undefined)));
    return found;
  }

  get(arm: string): T | undefined {
    return this.at(arm).value;
  }

  set(arm: string, value: T): void {
    this.at(arm).value = value;
  }
}

export const states = new ByArm<State>();
export const jobs = new ByArm<Job>();
/** Arms selected for an action on several arms. */
export const chosen = signal<ReadonlySet<string>>(new Set());

/** Drawing of a virtual arm's job. */
export interface Picture {
  name: string;
  at: Date;
  svg: string;
  strokes: Stroke[];
}
/** Pictures, newest first. */
export const pictures = signal<readonly Picture[]>([]);
void pictured().then((before) => {
  const names = pictures.value.map(({ name }) => name);
  pictures.value = newest([...pictures.value, ...before.filter(({ name }) => !names.includes(name))]);
});

/**
 * Jobs whose pictures are kept, with their titles: those started by this tab, including before a
 * reload.
 */
const SENT = "sent";
const isSent = shelf.isListOf(shelf.isListOf(shelf.isText, 2));
const sent = new Map(shelf.kept<Array<[job: string, title: string]>>("sessionStorage", SENT, isSent) ?? []);
const keepSent = () => shelf.keep("sessionStorage", SENT, [...sent]);

/**
 * Polls the list, jobs and states until the returned function is called. `inView` contains the arms
 * that are polled first; all arms by default.
 */
export function watchSite(inView?: ReadonlySet<string>): () => void {
  let over = false;
  let timers: Array<ReturnType<typeof setTimeout>> = [];
  const again = (work: () => Promise<void>, pause: () => number) => {
    const turn = async () => {
      if (store.socket.value === "up" && !document.hidden) await work().catch(() => {});
      if (!over) timers = [...timers.slice(-4), setTimeout(() => void turn(), pause())];
    };
    void turn();
  };
  again(list, () => LIST);
  // Jobs that ended during a reload.
  for (const job of sent.keys()) {
    call("job.get", { job }).then(
      heard,
      (error: unknown) => error instanceof RpcError && error.code !== LINE_ENDED && sent.delete(job),
    );
  }
  again(
    async () => look(inView),
    () => SHORTEST,
  );
  return () => {
    over = true;
    timers.forEach(clearTimeout);
  };
}

/** True if the known state of an arm is current: both the arm and the station can be reached. */
export const isKnown = (arm: store.ArmEntry): boolean => arm.link === "up" && store.socket.value === "up";

/** Text for the active job of an arm; null if it has no job. */
export function jobOf(arm: store.ArmEntry): string | null {
  const job = jobs.get(arm.name);
  if (job === undefined || !isUnderWay(job)) return null;
  const percent = job.steps ? ` ${Math.floor((100 * job.step) / job.steps)} %` : "";
  return `${t(`job.${job.state}` as "job.running")}${percent}`;
}

/** Text for the activity of an arm. */
export function doingOf(arm: store.ArmEntry): string {
  if (!isKnown(arm)) return t(store.socket.value === "up" ? "arms.link.lost" : "arms.unknown");
  const job = jobOf(arm);
  if (job !== null) return [jobs.get(arm.name)?.title, job].filter(Boolean).join(": ");
  return t(states.get(arm.name)?.moving === true ? "site.moves" : "site.stands");
}

export async function list(): Promise<void> {
  const { arms } = await call("arm.list", {});
  const before = new Map(store.arms.value.map((arm) => [arm.name, arm]));
  // An unchanged entry remains the same object, so that its tile is not rendered again.
  const after = arms.map((arm) => {
    const known = before.get(arm.name);
    return known !== undefined && JSON.stringify(known) === JSON.stringify(arm) ? known : arm;
  });
  if (after.length !== before.size || after.some((arm, nth) => arm !== store.arms.value[nth])) store.arms.value = after;
  await Promise.all(
    arms.map(async ({ name, job }) => {
      if (job !== null && (changed.get(name) ?? jobs.get(name))?.job !== job) keep(await call("job.get", { job }));
    }),
  );
}

/** Time of the last request for each arm's state, ms; `Infinity` while one is in flight. */
const askedAt = new Map<string, number>();
/** States received since the last rendering. */
const arrived = new Map<string, State>();

/**
 * Requests the states that are due: first those in view, oldest first. An arm that does not answer
 * delays no other arm.
 */
function look(inView?: ReadonlySet<string>): void {
  const now = performance.now();
  const up = store.arms.value.filter(({ link }) => link === "up").map(({ name }) => name);
  const isIn = (arm: string) => inView === undefined || inView.has(arm);
  const [near, far] = [up.filter(isIn), up.filter((arm) => !isIn(arm))];
  const pause = Math.min(LONGEST_IN_VIEW, Math.max(SHORTEST, (1000 * near.length) / ASKED));
  const due = (arms: string[], after: number) => {
    // Half an interval of tolerance: without it a timer that fires slightly early would skip a
    // whole interval.
    const late = arms.filter((arm) => now - (askedAt.get(arm) ?? -Infinity) >= after - SHORTEST / 2);
    const most = Math.ceil((arms.length * SHORTEST) / after);
    return late.sort((one, two) => (askedAt.get(one) ?? 0) - (askedAt.get(two) ?? 0)).slice(0, most);
  };
  for (const arm of [...due(near, pause), ...due(far, OUT_OF_VIEW)]) {
    askedAt.set(arm, Infinity);
    const answered = () => void askedAt.set(arm, now);
    const heard = (state: State) => {
      answered();
      if (arrived.size === 0) setTimeout(showArrived, TOGETHER);
      arrived.set(arm, state);
    };
    // A refusal keeps the last known state. A lost arm is marked in the list.
    call("arm.state", { arm }).then(heard, answered);
  }
}

function showArrived(): void {
  batch(() => arrived.forEach((state, arm) => states.set(arm, state)));
  arrived.clear();
}

/** Jobs changed since the last rendering. */
const changed = new Map<string, Job>();

function keep(job: Job): void {
  if (changed.size === 0) setTimeout(showJobs, JOBS);
  changed.set(job.arm, job);
}

function showJobs(): void {
  batch(() => changed.forEach((job, arm) => jobs.set(arm, job)));
  changed.clear();
}

notified.add((method, params) => {
  if (method === "job.changed") heard(params.job);
});

function heard(job: Job): void {
  keep(job);
  if (job.state === "done" && job.job !== null && sent.has(job.job)) void picture(job, sent.get(job.job) ?? "");
}

/** Deletes the pictures with these names. */
export async function drop(names: readonly string[]): Promise<void> {
  await change(null, names);
  pictures.value = pictures.value.filter(({ name }) => !names.includes(name));
}

async function picture({ arm, job }: Job, title: string): Promise<void> {
  sent.delete(job ?? "");
  keepSent();
  if (!store.arms.value.find(({ name }) => name === arm)?.virtual) return;
  try {
    const { drawing, strokes } = await call("world.look", { arm });
    if (drawing === null || !strokes?.length) return;
    const name = `${arm}-${title.replace(/\.[^.]*$/, "")}`;
    const made = { name, at: new Date(), svg: drawing, strokes };
    const all = [made, ...pictures.value.filter((one) => one.name !== name)];
    pictures.value = newest(all);
    void change(
      made,
      all.filter((one) => !pictures.value.includes(one)).map((one) => one.name),
    );
  } catch (error) {
    complain(error);
  }
}

/**
 * Applies `work` to several arms concurrently and reports the first refusal with its arm. Returns
 * the number of arms for which it succeeded; `work` returns `false` if it did nothing.
 */
export async function each(arms: readonly string[], work: (arm: string) => Promise<unknown>): Promise<number> {
  const done = await Promise.allSettled(arms.map(work));
  const refused = done.findIndex(({ status }) => status === "rejected");
  const first = done[refused];
  if (first?.status === "rejected") complain(new Error(`${arms[refused]}: ${(first.reason as Error).message}`));
  await list().catch(() => {});
  return done.filter((one) => one.status === "fulfilled" && one.value !== false).length;
}

const holds = (arm: string) =>
  store.arms.value.find(({ name }) => name === arm)?.holder?.session === store.session.value;
/** Takes an arm: a teacher from its holder, everyone else only a free one. */
export const take = (arm: string) => call(store.role.value === "teacher" ? "lease.take" : "lease.acquire", { arm });
/** Releases an arm. Acquiring its lease again returns the lease's id to the holder. */
export async function give(arm: string): Promise<void> {
  if (!holds(arm)) return;
  const { lease } = await call("lease.acquire", { arm });
  await call("lease.release", { lease });
}
type Source = Omit<Params<"job.start">, "arm">;

/**
 * Starts a program on several arms, after confirmation for real arms and for a laser. Returns the
 * number of arms on which it started.
 */
export async function send(arms: readonly string[], source: Source, title: string): Promise<number> {
  const real = arms.filter((arm) => store.arms.value.find(({ name }) => name === arm)?.virtual !== true);
  const about = t("site.real.text", { names: real.join(", ") });
  if (real.length > 0 && !(await store.ask(t("site.real.title", { title }), about, t("run.start")))) return 0;
  // The station refused these as dangerous. Nothing was sent to the arms yet.
  const refused = new Map<string, string>();
  const begun = await each(arms, async (arm) => {
    try {
      await start(arm, source, title);
    } catch (error) {
      const danger = dangerOf(error);
      if (danger === null) throw error;
      refused.set(arm, danger);
      return false;
    }
    return true;
  });
  if (refused.size === 0) return begun;
  // In the order of the arms, independent of the order of the answers.
  const why = arms.flatMap((arm) => (refused.has(arm) ? [`${arm}: ${refused.get(arm)}`] : [])).join(" ");
  if (!(await store.ask(t("run.burns"), why, t("run.burns")))) return begun;
  return begun + (await each([...refused.keys()], (arm) => start(arm, { ...source, yes: true }, title)));
}

async function start(arm: string, source: Source, title: string): Promise<void> {
  const job = queues.value ? await queue(arm, source) : await begin(arm, source);
  if (job !== null) sent.set(job, title);
  keepSent();
}

async function begin(arm: string, source: Source): Promise<string | null> {
  if (!holds(arm)) await take(arm);
  return (await call("job.start", { ...source, arm, after_check: true })).job;
}

/** Queues a program in a class, behind the active job of the arm's pupil. */
async function queue(arm: string, source: Source): Promise<string | null> {
  const {
    jobs: [sent],
  } = await call("class.send", { ...source, arms: [arm] });
  if (sent?.error) throw new Error(sent.error);
  return sent?.job ?? null;
}
