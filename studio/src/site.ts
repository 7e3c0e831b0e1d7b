// Arms of a station, or of all stations of a site, for the teacher's view. They are polled while
// the view is shown. The number of requests per second is limited, and rendering costs more than
// polling, so tiles in view are updated often and all others rarely.
import { batch, type Signal, signal } from "@preact/signals";
import { dangerQuestion, reportError } from "./actions";
import type { Job, State } from "./api";
import { queuesPrograms } from "./class";
import type { Params } from "./client";
import { CONNECTION_ENDED, RpcError } from "./client";
import { t } from "./i18n";
import { newest, storedPictures as pictured, updatePictures } from "./results";
import { isActive } from "./run/jobs";
import { call, notificationListeners } from "./session";
import * as shelf from "./storage";
import * as store from "./store";
import type { Stroke } from "./view/world";

/**
 * Requests for states per second for all arms in view together, as far as `MAX_INTERVAL_IN_VIEW`
 * permits. A station accepts 200 messages a second from a page, and a hub needs two more for each
 * arm.
 */
const REQUEST_RATE = 100;
/**
 * Interval between two requests for one arm, ms: at least, at most in view (a tile is to be less
 * than a second old), and out of view, where the limit of requests is counted separately.
 */
const MIN_INTERVAL = 200;
const MAX_INTERVAL_IN_VIEW = 750;
const MAX_INTERVAL_HIDDEN = 5000;
const LIST_INTERVAL = 1000;
/**
 * Time within which states, and changes of jobs, are collected before they are rendered together,
 * ms. Fifty drawing arms cause hundreds of changes of jobs a second.
 */
const STATE_BATCH_TIME = 50;
const JOB_BATCH_TIME = 250;

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
const STORAGE_KEY = "sent";
const isSent = shelf.isListOf(shelf.isListOf(shelf.isText, 2));
const sent = new Map(
  shelf.readStored<Array<[job: string, title: string]>>("sessionStorage", STORAGE_KEY, isSent) ?? [],
);
const keepSent = () => shelf.writeStored("sessionStorage", STORAGE_KEY, [...sent]);

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
  again(readArms, () => LIST_INTERVAL);
  // Jobs that ended during a reload.
  for (const job of sent.keys()) {
    call("job.get", { job }).then(
      onJobChange,
      (error: unknown) => error instanceof RpcError && error.code !== CONNECTION_ENDED && sent.delete(job),
    );
  }
  again(
    async () => requestStates(inView),
    () => MIN_INTERVAL,
  );
  return () => {
    over = true;
    timers.forEach(clearTimeout);
  };
}

/** True if the known state of an arm is current: both the arm and the station can be reached. */
export const isKnown = (arm: store.ArmEntry): boolean => arm.link === "up" && store.socket.value === "up";

/** Text for the active job of an arm; null if it has no job. */
export function jobText(arm: store.ArmEntry): string | null {
  const job = jobs.get(arm.name);
  if (job === undefined || !isActive(job)) return null;
  const percent = job.steps ? ` ${Math.floor((100 * job.step) / job.steps)} %` : "";
  return `${t(`job.${job.state}` as "job.running")}${percent}`;
}

/** Text for the activity of an arm. */
export function activityText(arm: store.ArmEntry): string {
  if (!isKnown(arm)) return t(store.socket.value === "up" ? "arms.link.lost" : "arms.unknown");
  const job = jobText(arm);
  if (job !== null) return [jobs.get(arm.name)?.title, job].filter(Boolean).join(": ");
  return t(states.get(arm.name)?.moving === true ? "site.moves" : "site.stands");
}

export async function readArms(): Promise<void> {
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
      if (job !== null && (changedJobs.get(name) ?? jobs.get(name))?.job !== job)
        noteJob(await call("job.get", { job }));
    }),
  );
}

/** Time of the last request for each arm's state, ms; `Infinity` while one is in flight. */
const askedAt = new Map<string, number>();
/** States received since the last rendering. */
const arrivedStates = new Map<string, State>();

/**
 * Requests the states that are due: first those in view, oldest first. An arm that does not answer
 * delays no other arm.
 */
function requestStates(inView?: ReadonlySet<string>): void {
  const now = performance.now();
  const up = store.arms.value.filter(({ link }) => link === "up").map(({ name }) => name);
  const isIn = (arm: string) => inView === undefined || inView.has(arm);
  const [near, far] = [up.filter(isIn), up.filter((arm) => !isIn(arm))];
  const pause = Math.min(MAX_INTERVAL_IN_VIEW, Math.max(MIN_INTERVAL, (1000 * near.length) / REQUEST_RATE));
  const due = (arms: string[], after: number) => {
    // Half an interval of tolerance: without it a timer that fires slightly early would skip a
    // whole interval.
    const late = arms.filter((arm) => now - (askedAt.get(arm) ?? -Infinity) >= after - MIN_INTERVAL / 2);
    const most = Math.ceil((arms.length * MIN_INTERVAL) / after);
    return late.sort((one, two) => (askedAt.get(one) ?? 0) - (askedAt.get(two) ?? 0)).slice(0, most);
  };
  for (const arm of [...due(near, pause), ...due(far, MAX_INTERVAL_HIDDEN)]) {
    askedAt.set(arm, Infinity);
    const answered = () => void askedAt.set(arm, now);
    const heard = (state: State) => {
      answered();
      if (arrivedStates.size === 0) setTimeout(renderStates, STATE_BATCH_TIME);
      arrivedStates.set(arm, state);
    };
    // A refusal keeps the last known state. A lost arm is marked in the list.
    call("arm.state", { arm }).then(heard, answered);
  }
}

function renderStates(): void {
  batch(() => arrivedStates.forEach((state, arm) => states.set(arm, state)));
  arrivedStates.clear();
}

/** Jobs changed since the last rendering. */
const changedJobs = new Map<string, Job>();

function noteJob(job: Job): void {
  if (changedJobs.size === 0) setTimeout(renderJobs, JOB_BATCH_TIME);
  changedJobs.set(job.arm, job);
}

function renderJobs(): void {
  batch(() => changedJobs.forEach((job, arm) => jobs.set(arm, job)));
  changedJobs.clear();
}

notificationListeners.add((method, params) => {
  if (method === "job.changed") onJobChange(params.job);
});

function onJobChange(job: Job): void {
  noteJob(job);
  if (job.state === "done" && job.job !== null && sent.has(job.job)) void fetchPicture(job, sent.get(job.job) ?? "");
}

/** Deletes the pictures with these names. */
export async function deletePictures(names: readonly string[]): Promise<void> {
  await updatePictures(null, names);
  pictures.value = pictures.value.filter(({ name }) => !names.includes(name));
}

async function fetchPicture({ arm, job }: Job, title: string): Promise<void> {
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
    void updatePictures(
      made,
      all.filter((one) => !pictures.value.includes(one)).map((one) => one.name),
    );
  } catch (error) {
    reportError(error);
  }
}

/**
 * Applies `work` to several arms concurrently and reports the first refusal with its arm. Returns
 * the number of arms for which it succeeded; `work` returns `false` if it did nothing.
 */
export async function forEachArm(arms: readonly string[], work: (arm: string) => Promise<unknown>): Promise<number> {
  const done = await Promise.allSettled(arms.map(work));
  const refused = done.findIndex(({ status }) => status === "rejected");
  const first = done[refused];
  if (first?.status === "rejected") reportError(new Error(`${arms[refused]}: ${(first.reason as Error).message}`));
  await readArms().catch(() => {});
  return done.filter((one) => one.status === "fulfilled" && one.value !== false).length;
}

const holdsArm = (arm: string) =>
  store.arms.value.find(({ name }) => name === arm)?.holder?.session === store.session.value;
/** Takes an arm: a teacher from its holder, everyone else only a free one. */
export const takeArm = (arm: string) => call(store.role.value === "teacher" ? "lease.take" : "lease.acquire", { arm });
/** Releases an arm. Acquiring its lease again returns the lease's id to the holder. */
export async function releaseArm(arm: string): Promise<void> {
  if (!holdsArm(arm)) return;
  const { lease } = await call("lease.acquire", { arm });
  await call("lease.release", { lease });
}
type Source = Omit<Params<"job.start">, "arm">;

/**
 * Starts a program on several arms, after confirmation for real arms and for a laser. Returns the
 * number of arms on which it started.
 */
export async function startOnArms(arms: readonly string[], source: Source, title: string): Promise<number> {
  const real = arms.filter((arm) => store.arms.value.find(({ name }) => name === arm)?.virtual !== true);
  const about = t("site.real.text", { names: real.join(", ") });
  if (real.length > 0 && !(await store.ask(t("site.real.title", { title }), about, t("run.start")))) return 0;
  // The station refused these as dangerous. Nothing was sent to the arms yet.
  const refused = new Map<string, string>();
  const begun = await forEachArm(arms, async (arm) => {
    try {
      await startOnArm(arm, source, title);
    } catch (error) {
      const danger = dangerQuestion(error);
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
  return begun + (await forEachArm([...refused.keys()], (arm) => startOnArm(arm, { ...source, yes: true }, title)));
}

async function startOnArm(arm: string, source: Source, title: string): Promise<void> {
  const job = queuesPrograms.value ? await queueJob(arm, source) : await startJob(arm, source);
  if (job !== null) sent.set(job, title);
  keepSent();
}

async function startJob(arm: string, source: Source): Promise<string | null> {
  if (!holdsArm(arm)) await takeArm(arm);
  return (await call("job.start", { ...source, arm, after_check: true })).job;
}

/** Queues a program in a class, behind the active job of the arm's pupil. */
async function queueJob(arm: string, source: Source): Promise<string | null> {
  const {
    jobs: [sent],
  } = await call("class.send", { ...source, arms: [arm] });
  if (sent?.error) throw new Error(sent.error);
  return sent?.job ?? null;
}
