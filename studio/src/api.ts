// The methods of a station. Written by `cargo xtask studio-api` from the table that the station itself works by.

export type State = {
  t: number;
  arm: string;
  x: number;
  y: number;
  z: number;
  r: number;
  j1: number;
  j2: number;
  j3: number;
  j4: number;
  rail: number | null;
  current_index: number;
  left_space: number;
  alarms: number[];
  link: "up" | "lost";
  moving: boolean;
  homed: boolean | null;
  tool: Tool;
  speed: number | null;
  pins: Pin[];
  job: string | null;
  jog: string | null;
  holder: Holder | null;
};

export type Tool = {
  name: "none" | "suction" | "gripper" | "pen" | "laser" | null;
  bias: [number, number, number] | null;
  suction: boolean | null;
  gripper: "open" | "closed" | "off" | null;
  laser: boolean | null;
};

export type Pin = {
  kind: "input" | "output" | "analog";
  address: number;
  value: number;
};

export type Holder = {
  session: string;
  name: string;
};

export type Pose = {
  x: number;
  y: number;
  z: number;
  r: number;
  j1: number;
  j2: number;
  j3: number;
  j4: number;
};

export type LibraryUse = {
  programs: number;
  bytes: number;
};

export type Stood = {
  arm: string;
  stood: boolean;
  pose: Pose;
};

export type Lease = {
  arm: string;
  lease: string;
  ttl_s: number;
};

export type Session = {
  session: string;
  name: string;
  role: "viewer" | "student" | "teacher";
  leases: string[];
  since: number;
};

export type Job = {
  job: string;
  arm: string;
  title: string | null;
  state: "queued" | "checking" | "running" | "pausing" | "paused" | "stopping" | "done" | "stopped" | "failed" | "interrupted";
  step: number;
  steps: number | null;
  first_step: number | null;
  loops: number;
  loop: number;
  seconds_left: number | null;
  drawn_mm: number | null;
  travel_mm: number | null;
  started: number | null;
  ended: number | null;
  holder: Holder | null;
  part: number | null;
  reason: "person" | "part" | "program" | "stopped" | "yes" | "restart" | "unkept" | null;
  text: string | null;
  place: number | null;
  error: JobError | null;
  notes: Note[] | null;
  digest: string | null;
};

export type JobError = {
  kind?: string;
  code?: string;
  param?: string;
  row?: number;
  method?: string;
  command?: string;
  danger?: "laser" | "arm";
  step?: number;
  value?: number;
  limit?: number;
  unit?: string;
  fence?: string;
  from?: number;
  to?: number;
  remedies?: Remedy[];
  template?: string;
  values?: SentenceValue[];
  report?: Report;
  digest?: string;
  expected?: Pose;
  pose?: Pose;
  arm?: string;
  until?: number | null;
  arms?: Stood[];
  role?: "viewer" | "student" | "teacher";
  needs?: "viewer" | "student" | "teacher";
  may?: Array<"owner" | "holder" | "teacher">;
  wait_s?: number;
  quota?: LibraryUse;
  used?: LibraryUse;
  holder?: Holder | null;
  free_in_s?: number;
  reason?: "unkept";
  by?: string | null;
  job?: string;
  jog?: string;
  recording?: string;
  message: string;
};

export type ErrorData = {
  kind?: string;
  code?: string;
  param?: string;
  row?: number;
  method?: string;
  command?: string;
  danger?: "laser" | "arm";
  step?: number;
  value?: number;
  limit?: number;
  unit?: string;
  fence?: string;
  from?: number;
  to?: number;
  remedies?: Remedy[];
  template?: string;
  values?: SentenceValue[];
  report?: Report;
  digest?: string;
  expected?: Pose;
  pose?: Pose;
  arm?: string;
  until?: number | null;
  arms?: Stood[];
  role?: "viewer" | "student" | "teacher";
  needs?: "viewer" | "student" | "teacher";
  may?: Array<"owner" | "holder" | "teacher">;
  wait_s?: number;
  quota?: LibraryUse;
  used?: LibraryUse;
  holder?: Holder | null;
  free_in_s?: number;
  reason?: "unkept";
  by?: string | null;
  job?: string;
  jog?: string;
  recording?: string;
};

export type Remedy = {
  action?: string;
  option?: string;
  value?: number | boolean | string | number[];
  without?: string;
  system?: string;
  effect?: string;
};

export type SentenceValue = {
  name: string;
  text?: string;
  option?: string;
  template?: string;
  values?: SentenceValue[];
};

export type Turns = {
  turn_s: number | null;
  arms: Array<{
    arm: string;
    person: string | null;
    state: "running" | "kept" | "suspended" | null;
    left_s: number | null;
    frozen: boolean;
    jobs: Array<{
      job: string;
      title: string | null;
      person: string | null;
      reason: "yes" | "stopped" | "restart" | "unkept" | "frozen" | "schedule" | "turn" | "busy" | "lost" | null;
    }>;
    slot: {
      who: string[];
      until: number | null;
    } | null;
    free_at: number | null;
  }>;
  queue: Array<{
    place: number;
    person: string;
    arms: string[];
    missed: boolean;
    reason: "schedule" | "frozen" | "away" | null;
    from: number | null;
  }>;
};

export type TurnList = {
  turn_s: number | null;
  arms: Array<{
    arm: string;
    person: string | null;
    state: "running" | "kept" | "suspended" | null;
    left_s: number | null;
    frozen: boolean;
    jobs: Array<{
      job: string;
      title: string | null;
      person: string | null;
      reason: "yes" | "stopped" | "restart" | "unkept" | "frozen" | "schedule" | "turn" | "busy" | "lost" | null;
    }>;
    slot: {
      who: string[];
      until: number | null;
    } | null;
    free_at: number | null;
  }>;
  queue: Array<{
    place: number;
    person: string;
    arms: string[];
    missed: boolean;
    reason: "schedule" | "frozen" | "away" | null;
    from: number | null;
  }>;
  you?: {
    person: string | null;
    arms: string[];
  };
};

export type ClientName = {
  name: string;
  version?: string;
};

export type Pupil = {
  name: string;
  code: string;
};

export type ExpectedArm = {
  arm: string;
  machine?: string;
};

export type PinAddress = {
  kind: "input" | "output" | "analog";
  address: number;
};

export type Laser = {
  on: boolean;
  power?: number;
};

export type Box = {
  x: [number, number];
  y: [number, number];
  z: [number, number];
};

export type Fence = {
  floor: number | null;
  box: Box | null;
  keep_out: Box[];
  speed: number | null;
  power: number | null;
};

export type FenceChange = {
  floor?: number | null;
  box?: Box | null;
  keep_out?: Box[] | null;
  speed?: number | null;
  power?: number | null;
};

export type Surface = {
  height: number;
  slope?: [number, number];
};

export type MeasuredSurface = {
  touches: number;
  plane: Plane | null;
  residual: number | null;
  corners: Array<"lower-left" | "lower-right" | "upper-left">;
  sheet: MeasuredSheet | null;
};

export type Plane = {
  at: [number, number];
  z: number;
  slope_x: number;
  slope_y: number;
};

export type MeasuredSheet = {
  corner: [number, number];
  rotation: number;
  size: [number, number] | null;
  outline: Array<[number, number]>;
};

export type Row = {
  name: string;
  motion: PlanStep | null;
  gripper: "off" | "open" | "close" | null;
  suction: boolean | null;
  wait: number | null;
};

export type GivenRow = {
  name?: string;
  motion?: PlanStep | null;
  gripper?: "off" | "open" | "close" | null;
  suction?: boolean | null;
  wait?: number | null;
};

export type StateChange = {
  t: number;
  arm?: string;
  x?: number;
  y?: number;
  z?: number;
  r?: number;
  j1?: number;
  j2?: number;
  j3?: number;
  j4?: number;
  rail?: number | null;
  current_index?: number;
  left_space?: number;
  alarms?: number[];
  link?: "up" | "lost";
  moving?: boolean;
  homed?: boolean | null;
  tool?: Tool;
  speed?: number | null;
  pins?: Pin[];
  job?: string | null;
  jog?: string | null;
  holder?: Holder | null;
};

export type Event = {
  arm: string;
  seq: number;
  t: number;
  event: "alarm-raised";
  code: number;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "alarm-cleared";
  code: number;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "command-finished";
  index: number;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "unaccounted";
  index: number;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "link-lost";
} | {
  arm: string;
  seq: number;
  t: number;
  event: "link-found";
} | {
  arm: string;
  seq: number;
  t: number;
  event: "reset";
} | {
  arm: string;
  seq: number;
  t: number;
  event: "missed";
  count: number;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "hand-trigger";
  step: PlanStep;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "stop";
  by: string | null;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "lease";
  holder: Holder | null;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "job";
  job: string;
  state: "queued" | "checking" | "running" | "pausing" | "paused" | "stopping" | "done" | "stopped" | "failed" | "interrupted";
} | {
  arm: string;
  seq: number;
  t: number;
  event: "jog";
  jog: string;
  axis?: "x+" | "x-" | "y+" | "y-" | "z+" | "z-" | "r+" | "r-" | "j1+" | "j1-" | "j2+" | "j2-" | "j3+" | "j3-" | "j4+" | "j4-" | "l+" | "l-";
  why?: "released" | "not-kept" | "stopped" | "lease" | "link" | "replaced" | "limit";
} | {
  arm: string;
  seq: number;
  t: number;
  event: "recording-saved";
  name: string;
  bytes: number;
} | {
  arm: string;
  seq: number;
  t: number;
  event: "recording-lost";
  name: string;
  message: string;
};

export type Fields = Record<string, number | string | boolean | Array<number | string | Record<string, number>>>;

export type Setup = {
  preset?: string;
  work?: "draw" | "engrave";
  font?: string;
  size?: number;
  wrap?: number;
  place?: boolean;
  tool?: string | number[];
  fill?: "none" | "hatch" | "cross" | "contour";
  image?: "outline" | "centerline" | "halftone" | "squiggle" | "hatch";
  surface?: number;
  at?: number[];
  scale?: number;
  width?: number;
  rotate?: number;
  fit?: boolean;
  height?: number;
  clip_page?: boolean;
  page?: string;
  margin?: number;
  turn?: boolean;
  mirror?: boolean;
  move?: number[];
  grid?: string;
  raw?: boolean;
  fill_spacing?: number;
  fill_angle?: number;
  fill_inset?: number;
  white?: "skip" | "draw";
  align?: "left" | "center" | "right";
  line_height?: number;
  text?: "outline" | "stroke";
  system_fonts?: "on" | "off";
  strict_text?: boolean;
  parts?: "none" | "layer" | "color";
  only?: string[];
  passes?: number;
  pens?: PenSetup[];
  no_pause?: boolean;
  levels?: number;
  despeckle?: number;
  pen_width?: number;
  spacing?: number;
  threshold?: number;
  crop?: number[];
  brightness?: number;
  contrast?: number;
  gamma?: number;
  invert?: boolean;
  power?: number | string;
  mode?: "grey" | "threshold" | "dither";
  one_way?: boolean;
  overscan?: number;
  frame?: "box" | "hull" | "outline";
  frame_power?: number;
  lift?: number;
  hop?: number;
  travel_speed?: number;
  stay?: boolean;
  depths?: "flatten" | "keep";
  order?: boolean;
  merge?: number;
  dedupe?: boolean;
  simplify?: number;
  tolerance?: number;
  speed?: number;
  speed_ratio?: number;
  park?: number[];
  dialect?: "pen" | "laser" | "servo";
  s_max?: number;
  pen_z?: number;
  start?: number[];
  resample?: number;
};

export type PenSetup = {
  match: string | number;
  surface_offset?: number;
  lift?: number;
  speed?: number;
  power?: number;
  passes?: number;
  fill?: string;
};

export type Plan = {
  steps: PlanStep[];
  format: "magician-plan";
  version: 1 | 2;
  title?: string;
  tool?: null | "none" | "suction" | "gripper" | "pen" | "laser" | number[];
  surface?: null | {
    height: number;
    slope?: number[];
  };
  names?: string[];
};

export type PlanOrigin = number[];

export type PlanName = string | number;

export type PlanOutput = {
  ratio: number;
  address: number;
  level: number;
};

export type PlanStep = {
  move: number[];
  by?: "joints" | "line" | "jump";
  at?: PlanOrigin;
  name?: PlanName;
} | {
  joints: number[];
  by?: "joints" | "line" | "jump";
  at?: PlanOrigin;
  name?: PlanName;
} | {
  shift: number[];
  by?: "joints" | "line";
  at?: PlanOrigin;
  name?: PlanName;
} | {
  arc: number[];
  via: number[];
  at?: PlanOrigin;
  name?: PlanName;
} | {
  path: number[];
  at?: PlanOrigin;
  name?: PlanName;
} | {
  burn: number[];
  power: number;
  at?: PlanOrigin;
  name?: PlanName;
} | {
  suction: boolean;
  at?: PlanOrigin;
  name?: PlanName;
} | {
  gripper: "off" | "open" | "close";
  at?: PlanOrigin;
  name?: PlanName;
} | {
  laser: boolean;
  at?: PlanOrigin;
  name?: PlanName;
} | {
  part: {
    n: number;
    name?: null | string;
    color?: null | string;
    pass?: number;
  };
  at?: PlanOrigin;
  name?: PlanName;
} | {
  pause: string;
  reason: "part" | "program";
  at?: PlanOrigin;
  name?: PlanName;
} | {
  wait: number;
  at?: PlanOrigin;
  name?: PlanName;
} | {
  home: true;
  at?: PlanOrigin;
  name?: PlanName;
} | {
  command: string;
  values?: Record<string, number | string | Array<number | string | PlanOutput>>;
  at?: PlanOrigin;
  name?: PlanName;
};

export type Field = {
  name: string;
  about: string;
  unit: string;
  kind: string;
  least: number | null;
  most: number | null;
  choices: Choice[];
};

export type Choice = {
  value: number;
  name: string;
};

export type Option = {
  name: string;
  kind: "choice" | "number" | "integer" | "point" | "place" | "area" | "switch" | "text" | "list" | "pens";
  unit: string;
  choices: string[];
  default: number | string | boolean | null;
  least: number | null;
  above: number | null;
  most: number | null;
  with: string | null;
  when: string[];
  group: "place" | "fill" | "text" | "parts" | "image" | "laser" | "pen" | "more";
  usual: boolean;
  about: string;
};

export type Report = {
  ok: boolean;
  seconds: number | null;
  steps: number | null;
  drawn_mm: number;
  travel_mm: number;
  bounds?: Bounds;
  travel_bounds?: Bounds;
  power?: {
    most: number;
    least: number;
  };
  refused: number;
  would_fit?: {
    scale: number;
    rotate: number;
  } | null;
  complaints: Complaint[];
  fence?: {
    floor: number | null;
    box: Array<[number, number, number]> | null;
    keep_out: Array<Array<[number, number, number]>>;
    top_speed: number | null;
    strongest_laser: number | null;
  };
  placed?: {
    scale: number;
    turn: number;
    at: [number, number];
    page?: Array<[number, number]>;
  };
  parts: Part[];
  notes?: Note[];
  preview?: Preview;
  digest?: string;
};

export type Bounds = {
  x: [number, number];
  y: [number, number];
  z: [number, number];
};

export type Complaint = {
  step: number;
  line?: number;
  column?: number;
  name?: string;
  kind: string;
  message: string;
  template?: string;
  values?: SentenceValue[];
  beyond?: number;
  code?: string;
  command?: string;
  value?: number;
  limit?: number;
  unit?: string;
  fence?: string;
  from?: number;
  to?: number;
  remedies?: Remedy[];
};

export type Note = {
  code: string;
  text: string;
  template?: string;
  values?: SentenceValue[];
  help?: {
    template: string;
    values?: SentenceValue[];
  };
  line?: number;
  element?: string;
  remedies?: Remedy[];
};

export type Part = {
  n: number;
  name: string | null;
  color: string | null;
  strokes: number;
  drawn_mm: number;
  seconds: number | null;
  skipped: boolean;
};

export type Preview = {
  strokes: Array<{
    points: Array<[number, number]>;
    height: number;
    part: number | null;
    power: number;
    reachable: boolean;
  }>;
  travels: Array<Array<[number, number, number]>>;
};

export type Preset = {
  name: string;
  shipped: boolean;
  note: string | null;
  path: string | null;
  options?: Setup;
  text?: string;
  problem?: string;
};

export type Class = {
  class: {
    turn_s: number;
    grace_s: number;
    finish_job: boolean;
    speed: number | null;
    fence: FenceChange | null;
    arms: string[];
  } | null;
  groups: Record<string, string[]>;
  pupils: Array<{
    name: string;
    group: string | null;
    code: string | null;
    here: boolean | null;
    place: number | null;
    arm: string | null;
  }>;
  pin: string | null;
  text: string | null;
  codes_kept?: string[];
};

export interface Methods {
  /** Begins a session. Must be the first message on a socket, and is sent once. */
  "session.hello": {
    params: {
      client: ClientName;
      token?: string;
      pupil?: Pupil;
      pin?: string;
      resume?: string;
      role?: "viewer" | "student" | "teacher";
    };
    result: {
      session: string;
      resume: string;
      resumed: boolean;
      role: string;
      api: number;
      version: string;
      arms: string[];
      limits: {
        message: number;
        rate: number;
        sockets: number;
      };
    };
  };
  /** Lists the sessions of the station. */
  "session.list": {
    params: {
    };
    result: {
      sessions: Session[];
    };
  };
  /** Returns facts about the station. */
  "server.info": {
    params: {
    };
    result: {
      version: string;
      api: number;
      uptime_s: number;
      arms: string[];
      programs: string | null;
      recording: boolean;
      features: string[];
    };
  };
  /** Lists the arms of the station. */
  "arm.list": {
    params: {
    };
    result: {
      arms: Array<{
        name: string;
        port: string;
        virtual: boolean;
        link: string;
        holder: Holder | null;
        waiting: Array<{
          session: string;
          name: string;
          asks: boolean;
        }>;
        job: string | null;
      }>;
    };
  };
  /** Returns identity and state of an arm. */
  "arm.info": {
    params: {
      arm?: string;
    };
    result: {
      port: string;
      device_name: string;
      device_sn: string;
      firmware: string;
      device_id: number[] | null;
      uptime_ms: number;
      with_l: boolean;
      alarms: number[];
      queue_current_index: number;
      queue_left_space: number;
      laser: boolean | null;
      suction: boolean | null;
      gripper: string | null;
      fence: Fence | null;
    };
  };
  /** Describes the pins, sensors and steppers of an arm by the protocol's table, for clients that know no command. */
  "arm.io": {
    params: {
      arm?: string;
    };
    result: {
      analog: {
        counts: number;
        volts: number;
      };
      functions: Array<{
        value: number;
        name: string;
        about: string;
        watch: string | null;
      }>;
      pins: Array<{
        address: number;
        function: number;
        can: number[] | null;
        level: number | null;
        frequency: number | null;
        duty_cycle: number | null;
      }>;
      rows: Array<{
        role: string;
        command: string;
        about: string;
        asks: Field[] | null;
        tells: Field[] | null;
        sets: Field[] | null;
      }>;
    };
  };
  /** Returns the state, at most 100 ms old. */
  "arm.state": {
    params: {
      arm?: string;
    };
    result: State;
  };
  /** Subscribes to the state. If several states are due, only the newest is sent. */
  "arm.subscribe": {
    params: {
      arm?: string;
      rate: number;
      frame?: "json" | "binary";
      pins?: PinAddress[];
    };
    result: {
      subscription: number;
      rate: number;
      fields: string[];
    };
  };
  /** Ends a subscription. */
  "arm.unsubscribe": {
    params: {
      subscription: number;
    };
    result: null;
  };
  /** Reads a value by a command of the protocol. */
  "arm.get": {
    params: {
      arm?: string;
      command: string;
      query?: Fields;
    };
    result: Fields;
  };
  /** Sends a command that takes effect immediately. */
  "arm.set": {
    params: {
      arm?: string;
      command: string;
      fields?: Fields;
      yes?: boolean;
    };
    result: null;
  };
  /** Queues a command. */
  "arm.enqueue": {
    params: {
      arm?: string;
      command: string;
      fields?: Fields;
      yes?: boolean;
    };
    result: {
      index: number;
    };
  };
  /** Moves the arm, after a check of the motion. */
  "arm.move": {
    params: {
      arm?: string;
      to: number[];
      by?: "joint" | "linear" | "jump";
      frame?: "xyz" | "joints";
      relative?: boolean;
      wait?: boolean;
    };
    result: State | {
      index: number;
    };
  };
  /** Homes the arm. */
  "arm.home": {
    params: {
      arm?: string;
      yes?: boolean;
    };
    result: State;
  };
  /** Clears all alarms, which releases the queue. */
  "arm.clear_alarms": {
    params: {
      arm?: string;
      yes?: boolean;
    };
    result: State;
  };
  /** Selects or operates the tool. Takes exactly one parameter besides `arm` and `yes`. */
  "arm.tool": {
    params: {
      arm?: string;
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[];
      suction?: boolean;
      gripper?: "open" | "closed" | "off";
      laser?: Laser;
      yes?: boolean;
    };
    result: State;
  };
  /** Sets the speed ratio of moves and jogs, also of a running job, or one speed setting. */
  "arm.speed": {
    params: {
      arm?: string;
      percent?: number;
      row?: string;
      fields?: Fields;
    };
    result: null;
  };
  /** Lists the active alarms with cause and remedy. */
  "arm.alarms": {
    params: {
      arm?: string;
    };
    result: {
      alarms: Array<{
        code: number;
        name: string;
        cause: string;
        remedy: string;
        cure: string;
        holds_queue: boolean;
      }>;
    };
  };
  /** Stops an arm, or all arms. Never needs the lease, and does not lift the pen. */
  "arm.stop": {
    params: {
      arm?: string;
    };
    result: {
      arms: Stood[];
    };
  };
  /** Returns or changes the fence of an arm. Motion that crosses the fence is refused as `unreachable`. A change ends motion in progress. */
  "arm.fence": {
    params: {
      arm?: string;
      set?: FenceChange | null;
    };
    result: {
      fence: Fence | null;
    };
  };
  /** Returns the arm as a chain of links, its limits and its tool, for clients that draw it. */
  "arm.model": {
    params: {
      arm?: string;
    };
    result: {
      frame: string;
      links: Array<{
        name: string;
        parent: string | null;
        joint: string | null;
        axis: number[];
        at: number[];
        shape: string;
        size: number[];
        turn: number[];
        color: string;
      }>;
      limits: {
        j1: number[];
        j2: number[];
        j3: number[];
        j4: number[];
        j2_minus_j3: number[];
        l: [number, number] | null;
      };
      tool: {
        name: string | null;
        bias: number[];
      };
    };
  };
  /** Lists past events of an arm, at most 1000. */
  "events.since": {
    params: {
      arm?: string;
      seq: number;
    };
    result: {
      events: Event[];
      seq: number;
    };
  };
  /** Acquires the lease of an arm: the exclusive right to move it. */
  "lease.acquire": {
    params: {
      arm?: string;
      wait_s?: number;
    };
    result: Lease;
  };
  /** Keeps the lease alive (so does any message). */
  "lease.renew": {
    params: {
      lease: string;
    };
    result: null;
  };
  /** Gives the lease back. Succeeds also if the lease has already ended. Queued commands continue; a jog, the stepper motors and the belt are stopped, and a job pauses unless its `on_lost` says otherwise. */
  "lease.release": {
    params: {
      lease: string;
    };
    result: null;
  };
  /** Asks the holder for the lease. Granted if the holder does not answer within 20 s. */
  "lease.ask": {
    params: {
      arm?: string;
      message?: string;
    };
    result: {
      granted: boolean;
      lease?: string;
      ttl_s?: number;
    };
  };
  /** Answers a session that asked for the lease. */
  "lease.answer": {
    params: {
      arm?: string;
      session: string;
      grant: boolean;
    };
    result: null;
  };
  /** Takes the lease from its holder immediately. */
  "lease.take": {
    params: {
      arm?: string;
    };
    result: Lease;
  };
  /** Jogs the arm until the jog is stopped or its hold time expires. */
  "jog.start": {
    params: {
      arm?: string;
      axis: "x+" | "x-" | "y+" | "y-" | "z+" | "z-" | "r+" | "r-" | "j1+" | "j1-" | "j2+" | "j2-" | "j3+" | "j3-" | "j4+" | "j4-" | "l+" | "l-";
      keep_ms?: number;
      percent?: number;
    };
    result: {
      jog: string;
    };
  };
  /** Renews the hold time of a jog. Sent as a notification, without an answer. */
  "jog.keep": {
    params: {
      jog: string;
    };
    result: null;
  };
  /** Stops a jog, including one whose `jog.start` has not been answered yet. */
  "jog.stop": {
    params: {
      arm?: string;
      jog?: string;
    };
    result: {
      stood: boolean;
      pose: Pose;
    };
  };
  /** Moves by a step, after a check of the motion. */
  "jog.step": {
    params: {
      arm?: string;
      axis: "x" | "y" | "z" | "r" | "j1" | "j2" | "j3" | "j4" | "l";
      by: number;
      frame?: "base" | "tool";
      percent?: number;
    };
    result: State;
  };
  /** Checks a program from the current position of the arm, without moving it. */
  "job.check": {
    params: {
      arm?: string;
      program?: string;
      text?: string;
      data?: string;
      format?: string;
      setup?: Setup;
      preview?: boolean;
    };
    result: Report;
  };
  /** Checks a program and runs it. The job is on the disk when this is answered. */
  "job.start": {
    params: {
      arm?: string;
      program?: string;
      text?: string;
      data?: string;
      format?: string;
      setup?: Setup;
      from?: number;
      loops?: number;
      keep?: boolean;
      require_homed?: boolean;
      unhomed?: boolean;
      yes?: boolean;
      on_lost?: "pause" | "stop" | "continue";
      queue?: boolean;
      after_check?: boolean;
      key?: string;
      digest?: string;
    };
    result: {
      job: string;
    };
  };
  /** Returns a job, also a finished one. */
  "job.get": {
    params: {
      job: string;
    };
    result: Job;
  };
  /** Lists the last 50 jobs of an arm, newest last. */
  "job.list": {
    params: {
      arm?: string;
    };
    result: {
      jobs: Job[];
    };
  };
  /** Pauses a job: the queue of the arm is empty, the laser off, the pen up. The arm may then be moved. */
  "job.pause": {
    params: {
      job: string;
    };
    result: Job;
  };
  /** Resumes a paused, stopped or interrupted job. */
  "job.resume": {
    params: {
      job: string;
      approach?: boolean;
      overlap?: number;
      yes?: boolean;
    };
    result: Job;
  };
  /** Stops a job and lifts its pen. Never needs the lease. */
  "job.stop": {
    params: {
      job: string;
    };
    result: Job;
  };
  /** Lists the stored jobs of an arm, newest last, with totals over all jobs that ran. */
  "job.history": {
    params: {
      arm?: string;
      skip?: number;
      limit?: number;
    };
    result: {
      jobs: Job[];
      more: boolean;
      totals: {
        jobs: number;
        done: number;
        stopped: number;
        failed: number;
        interrupted: number;
        drawn_mm: number;
        travel_mm: number;
        seconds: number;
      };
    };
  };
  /** Moves a queued job to another place in the queue of its arm. No effect on a job that is no longer queued. */
  "job.reorder": {
    params: {
      job: string;
      position: number;
    };
    result: Job;
  };
  /** Deletes a finished job from the list. The totals still include it. */
  "job.delete": {
    params: {
      job: string;
    };
    result: null;
  };
  /** Stores a program in the library. */
  "program.put": {
    params: {
      name: string;
      text?: string;
      data?: string;
      replace?: boolean;
    };
    result: {
      name: string;
      bytes: number;
    };
  };
  /** Lists the programs of the library. */
  "program.list": {
    params: {
    };
    result: {
      programs: Array<{
        name: string;
        bytes: number;
        modified: number;
        format: string | null;
      }>;
    };
  };
  /** Returns a program of the library. Above 700 KiB use GET. */
  "program.get": {
    params: {
      name: string;
    };
    result: {
      name: string;
      format: string | null;
      data: string;
    };
  };
  /** Converts a program to another format and stores the result. */
  "program.convert": {
    params: {
      name: string;
      to: string;
      setup?: Setup;
      replace?: boolean;
    };
    result: {
      from: string;
      to: string;
      steps: number;
      lost: string[];
      notes: Array<{
        code: string;
        text: string;
        template: string;
      }>;
    };
  };
  /** Lists the options for programs of a format: members of `setup`, usual ones first. */
  "program.options": {
    params: {
      format: string;
      all?: boolean;
    };
    result: {
      options: Option[];
    };
  };
  /** Deletes a program from the library. */
  "program.delete": {
    params: {
      name: string;
    };
    result: null;
  };
  /** Stores options under a name, replacing a stored preset. It takes precedence over a built-in preset of the same name. */
  "preset.save": {
    params: {
      name: string;
      setup?: Setup;
      note?: string;
      text?: string;
    };
    result: Preset;
  };
  /** Lists the presets for `setup.preset`, built-in ones first. */
  "preset.list": {
    params: {
    };
    result: {
      presets: Preset[];
    };
  };
  /** Returns the options of a preset. */
  "preset.show": {
    params: {
      name: string;
    };
    result: Preset;
  };
  /** Deletes a stored preset. Built-in presets stay. */
  "preset.remove": {
    params: {
      name: string;
    };
    result: null;
  };
  /** Measures the work surface at the point that the tool touches, and stores it for drawing and engraving. The arm must stand still with the laser off. Refuses three touches within 30 mm or nearly collinear. */
  "surface.touch": {
    params: {
      arm?: string;
      add?: boolean;
      forget?: boolean;
      unhomed?: boolean;
    };
    result: MeasuredSurface;
  };
  /** Measures a corner of a sheet of paper at the point that the tool touches. The third corner completes the sheet with its height and tilt; drawings are then placed on it, upright for its reader. Refuses corners within 30 mm, nearly collinear, or without a right angle, and keeps the earlier state. The arm must stand still with the laser off. */
  "surface.corner": {
    params: {
      arm?: string;
      corner: "lower-left" | "lower-right" | "upper-left";
      unhomed?: boolean;
    };
    result: MeasuredSurface;
  };
  /** Returns the measured work surface. */
  "surface.get": {
    params: {
      arm?: string;
    };
    result: MeasuredSurface;
  };
  /** Returns a program step to the current position of the arm. */
  "teach.capture": {
    params: {
      arm?: string;
      by?: "joint" | "linear" | "jump";
      unhomed?: boolean;
    };
    result: {
      step: PlanStep;
    };
  };
  /** Sends an event `hand-trigger` with a `step` to the position each time the unlock key of the arm is released. */
  "teach.guide": {
    params: {
      arm?: string;
      on: boolean;
      unhomed?: boolean;
    };
    result: null;
  };
  /** Returns a plan as rows of a table: target, action of the tool and waiting time. */
  "teach.rows": {
    params: {
      plan: Plan;
    };
    result: {
      title: string;
      tool: string | number[] | null;
      surface: Surface | null;
      rows: Row[];
    };
  };
  /** Returns a program step that sets the level of an output. */
  "teach.output": {
    params: {
      address: number;
      high: boolean;
    };
    result: {
      step: PlanStep;
    };
  };
  /** Builds a plan from rows. An error names its row in `data.row`. */
  "teach.plan": {
    params: {
      title?: string;
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[] | null;
      surface?: Surface | null;
      rows: GivenRow[];
    };
    result: {
      plan: Plan;
      first: number[];
    };
  };
  /** Returns the world around a virtual arm. All `world.*` methods are `unsupported` for other arms. */
  "world.look": {
    params: {
      arm?: string;
      mark?: string;
    };
    result: {
      objects: Array<{
        name: string;
        at: number[];
        turn: number;
        size: number[];
        color: string;
        held: boolean;
      }>;
      title: string | null;
      table: {
        height: number;
        x: number[];
        y: number[];
      } | null;
      draws: string | null;
      belt: {
        start: number[];
        direction: number;
        length: number;
        width: number;
        height: number;
        travel: number;
      } | null;
      drawing: string | null;
      strokes: Array<{
        burnt: boolean;
        power: number;
        points: number[][];
      }> | null;
      mark: string;
      unlocked: boolean;
      plugged: boolean;
    };
  };
  /** Lists the built-in scenarios for `world.scenario`. */
  "world.scenarios": {
    params: {
      arm?: string;
    };
    result: {
      scenarios: Array<{
        name: string;
        title: string;
        text: string;
      }>;
    };
  };
  /** Presses the key at the base, which runs or stops the program stored in the arm. */
  "world.press": {
    params: {
      arm?: string;
      long?: boolean;
    };
    result: null;
  };
  /** Holds or releases the unlock key. While held, the arm can be guided by hand. */
  "world.unlock": {
    params: {
      arm?: string;
      held: boolean;
    };
    result: null;
  };
  /** Unplugs the cable, or plugs it in again. */
  "world.unplug": {
    params: {
      arm?: string;
      plugged: boolean;
    };
    result: null;
  };
  /** Moves the arm by hand while the unlock key is held. */
  "world.guide": {
    params: {
      arm?: string;
      joints: number[];
    };
    result: State;
  };
  /** Power-cycles the arm in the world of a scenario. */
  "world.scenario": {
    params: {
      arm?: string;
      text: string;
    };
    result: {
      objects: string[];
    };
  };
  /** Moves an object by hand. */
  "world.place": {
    params: {
      arm?: string;
      name: string;
      at: number[];
    };
    result: null;
  };
  /** Replaces the paper by a new sheet, which removes all marks of pen and laser. Refused while a job is in progress. */
  "world.paper": {
    params: {
      arm?: string;
    };
    result: null;
  };
  /** Drives an input from outside with a constant level or voltage. */
  "world.input": {
    params: {
      arm?: string;
      address: number;
      level?: boolean;
      value?: number;
    };
    result: null;
  };
  /** Injects a fault, also while a job runs. */
  "world.fault": {
    params: {
      arm?: string;
      fault: "alarm" | "slip" | "reset";
      alarm?: number;
      joint?: number;
      degrees?: number;
    };
    result: null;
  };
  /** Records an arm to a file until `record.stop`. */
  "record.start": {
    params: {
      arm?: string;
      rate?: number;
    };
    result: {
      name: string;
    };
  };
  /** Ends a recording. */
  "record.stop": {
    params: {
      arm?: string;
    };
    result: {
      name: string;
      seconds: number;
      bytes: number;
    };
  };
  /** Saves the last minutes of an arm to a file: readings, frames on the line, and events. */
  "record.save_last": {
    params: {
      arm?: string;
      seconds: number;
    };
    result: {
      name: string;
    };
  };
  /** Computes the pose of joint angles (forward kinematics). */
  "motion.forward": {
    params: {
      joints: number[];
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[];
    };
    result: {
      x: number;
      y: number;
      z: number;
      r: number;
    };
  };
  /** Computes the joint angles of a pose (inverse kinematics). Refused if the pose is out of reach. */
  "motion.inverse": {
    params: {
      pose: number[];
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[];
    };
    result: {
      j1: number;
      j2: number;
      j3: number;
      j4: number;
    };
  };
  /** Computes the reachable area at a height. */
  "motion.reach": {
    params: {
      z: number;
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[];
    };
    result: {
      outlines: number[][][];
    };
  };
  /** Replaces the class. Pupils keep their codes and the teacher keeps the PIN, whatever the file says; new pupils get a code. */
  "class.set": {
    params: {
      text?: string;
      names?: string[];
      arms?: string[];
      turn_s?: number;
      offset?: string;
      use_codes?: boolean;
      elsewhere?: boolean;
    };
    result: Class;
  };
  /** Returns the class: its rules and pupils. */
  "class.get": {
    params: {
    };
    result: Class;
  };
  /** Generates new codes. Pupils signed in with an old code must sign in again. */
  "class.codes": {
    params: {
      pupils?: string[];
    };
    result: Class;
  };
  /** Stops and freezes arms. A job pauses if its step ends within a second; otherwise, or if it burns, it is stopped (`job.resume` continues both). Other motion ends, and the laser is off. Until `class.free` only teachers can move these arms, and the clocks of turns stand. */
  "class.freeze": {
    params: {
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Unfreezes arms. */
  "class.free": {
    params: {
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Starts a program on each free arm, and queues it on the others. */
  "class.send": {
    params: {
      program?: string;
      text?: string;
      data?: string;
      format?: string;
      setup?: Setup;
      arms?: string[];
      yes?: boolean;
    };
    result: {
      jobs: Array<{
        arm: string;
        job: string | null;
        state: string | null;
        error: string | null;
      }>;
    };
  };
  /** Lists the finished jobs of pupils. As a page: GET /api/v1/class/results.html. */
  "class.results": {
    params: {
    };
    result: {
      results: Array<{
        job: string;
        pupil: string;
        group: string | null;
        title: string;
        arm: string;
        time: string;
        time_local: string;
        drawn_mm: number | null;
        svg: string;
      }>;
    };
  };
  /** Joins the queue for a turn. The queue holds persons, not sockets: reloading a page loses nothing. No effect for a person who has a turn or already waits for the same arms. Teachers need no turn. */
  "turn.join": {
    params: {
      arm?: string;
      group?: string;
    };
    result: TurnList;
  };
  /** Gives up turn and place. */
  "turn.leave": {
    params: {
      person?: string;
    };
    result: null;
  };
  /** Ends the turn on one, several or all arms. Its person loses the place, and the next one in the queue gets the arm. Motion stops as at any end of a turn. */
  "turn.end": {
    params: {
      arm?: string;
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Passes the turn on one, several or all arms to the next person in the queue; the former person gets the last place. With `arm` it is refused if no signed-in person waits; otherwise such arms are skipped. */
  "turn.next": {
    params: {
      arm?: string;
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Lists turns and queue. */
  "turn.list": {
    params: {
      group?: string;
    };
    result: TurnList;
  };
  /** Sets who may acquire which arm when, by the station's clock. An arm without slots is free at any time. */
  "schedule.set": {
    params: {
      text: string;
      elsewhere?: boolean;
    };
    result: {
      text: string;
      slots: Array<{
        arms: string[];
        who: string[];
        days: string[] | null;
        from: number;
        until: number;
      }>;
      now: number;
      error: string | null;
    };
  };
  /** Returns the schedule. */
  "schedule.get": {
    params: {
    };
    result: {
      text: string;
      slots: Array<{
        arms: string[];
        who: string[];
        days: string[] | null;
        from: number;
        until: number;
      }>;
      now: number;
      error: string | null;
    };
  };
  /** Lists the arms that this station expects on its site. */
  "site.roster": {
    params: {
    };
    result: {
      arms: ExpectedArm[];
    };
  };
  /** Replaces the roster. Requests to all arms of the site report arms of the roster that are missing. */
  "site.expect": {
    params: {
      arms: ExpectedArm[];
    };
    result: {
      arms: ExpectedArm[];
    };
  };
}

/** What a station tells by itself: parameters by notification. */
export interface Notifications {
  /** A session began or ended, or acquired or lost a lease. At most five times per second, with the latest list. */
  "session.changed": {
    sessions: Session[];
  };
  /** The lease of an arm was granted, given back, taken or lost. */
  "lease.changed": {
    arm: string;
    holder: Holder | null;
  };
  /** Another session called `lease.ask`. Reply with `lease.answer`; without a reply the lease passes after 20 s. Repeated questions of one session are sent once, and one reply answers all of them. */
  "lease.asked": {
    arm: string;
    session: string;
    name: string;
    message: string | null;
  };
  /** The session waits for a lease by `lease.acquire` with `wait_s`: sent at once and whenever the queue moves, even if its place is unchanged. */
  "lease.queue": {
    arm: string;
    place: number;
  };
  /** The state of a job changed (sent at once), its progress (at most ten times per second), or its place in the queue (at most five times per second). Carries the latest values. */
  "job.changed": {
    job: Job;
  };
  /** A jog ended. The stop was sent to the arm, which may still be decelerating. */
  "jog.ended": {
    arm: string;
    jog: string;
    why: "released" | "not-kept" | "stopped" | "lease" | "link" | "replaced" | "limit";
  };
  /** The work surface of an arm was measured or forgotten, or a corner of a sheet was measured. A measurement by another program is noticed at the next `surface.get`. */
  "surface.changed": {
    arm: string;
    surface: MeasuredSurface;
  };
  /** At the rate of `arm.subscribe`, with the latest state if several are due; immediately when job, jog or holder change; once when the line is lost. */
  "arm.state": {
    subscription: number;
    state: StateChange;
  };
  /** The station begins to end; also sent to sessions that begin afterwards. Holders should stop their arm within 1 s (`arm.stop`), lift the pen and give the lease back. */
  "server.ending": {
    left_s: number;
  };
  /** A turn began or ended, a person joined or left the queue, an arm was frozen or freed, or a class was set. */
  "turn.changed": {
    turn_s: number | null;
    arms: Array<{
      arm: string;
      person: string | null;
      state: "running" | "kept" | "suspended" | null;
      left_s: number | null;
      frozen: boolean;
      jobs: Array<{
        job: string;
        title: string | null;
        person: string | null;
        reason: "yes" | "stopped" | "restart" | "unkept" | "frozen" | "schedule" | "turn" | "busy" | "lost" | null;
      }>;
      slot: {
        who: string[];
        until: number | null;
      } | null;
      free_at: number | null;
    }>;
    queue: Array<{
      place: number;
      person: string;
      arms: string[];
      missed: boolean;
      reason: "schedule" | "frozen" | "away" | null;
      from: number | null;
    }>;
  };
  /** 60 s and 10 s before the end of a turn. */
  "turn.ending": {
    arm: string;
    person: string;
    left_s: number;
  };
  /** A turn begins, or continues after a teacher had the arm. The session holds the lease from now on. */
  "turn.granted": {
    arm: string;
    lease: string;
    ttl_s: number;
    left_s: number | null;
  };
  /** An event occurred; see the table of events. */
  "arm.event": Event;
}
