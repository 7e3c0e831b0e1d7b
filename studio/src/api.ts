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
  /** Begins the session. The first message of a socket, once. */
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
  /** The sessions of the station. */
  "session.list": {
    params: {
    };
    result: {
      sessions: Session[];
    };
  };
  /** The station itself. */
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
  /** The arms of the station. */
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
  /** Identity and state of an arm. */
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
  /** What the pins, sensors and steppers of an arm are and do, by the protocol's table: for pages that know no command. */
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
  /** The state, read not longer ago than 100 ms. */
  "arm.state": {
    params: {
      arm?: string;
    };
    result: State;
  };
  /** Sends the state again and again, the newest one when several are due. */
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
  /** Reads a value of the protocol. */
  "arm.get": {
    params: {
      arm?: string;
      command: string;
      query?: Fields;
    };
    result: Fields;
  };
  /** Sends a command that acts at once. */
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
  /** Moves the arm, checked first. */
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
  /** Clears the alarms, which releases the queue. */
  "arm.clear_alarms": {
    params: {
      arm?: string;
      yes?: boolean;
    };
    result: State;
  };
  /** Chooses the tool, or has it do something. One of the parameters beside `arm` and `yes`. */
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
  /** Sets the speed of moves and jogs as a whole, also of a job that runs, or one setting of speeds. */
  "arm.speed": {
    params: {
      arm?: string;
      percent?: number;
      row?: string;
      fields?: Fields;
    };
    result: null;
  };
  /** The alarms that stand, with cause and remedy. */
  "arm.alarms": {
    params: {
      arm?: string;
    };
    result: {
      alarms: Array<{
        code: number;
        name: string;
        cause: string;
        cure: string;
        holds_queue: boolean;
      }>;
    };
  };
  /** Stops an arm, or all; never needs the lease, and lifts no pen. */
  "arm.stop": {
    params: {
      arm?: string;
    };
    result: {
      arms: Stood[];
    };
  };
  /** The fence of an arm: what crosses it is refused as `unreachable`. A change ends what is under way. */
  "arm.fence": {
    params: {
      arm?: string;
      set?: FenceChange | null;
    };
    result: {
      fence: Fence | null;
    };
  };
  /** The arm as a chain of links, its limits and its tool, for pages that draw it. */
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
  /** Earlier events of an arm, 1000 at most. */
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
  /** Asks for the lease of an arm: the right to move it. */
  "lease.acquire": {
    params: {
      arm?: string;
      wait_s?: number;
    };
    result: Lease;
  };
  /** Says that its holder is there; any message does. */
  "lease.renew": {
    params: {
      lease: string;
    };
    result: null;
  };
  /** Gives it back; answered in the same way if it has ended already. What the arm has queued goes on; a jog, stepper motors and the belt are stopped, and a job pauses unless its `on_lost` says otherwise. */
  "lease.release": {
    params: {
      lease: string;
    };
    result: null;
  };
  /** Asks the holder for the lease. Without an answer in 20 s it is granted. */
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
  /** Answers a session that asks. */
  "lease.answer": {
    params: {
      arm?: string;
      session: string;
      grant: boolean;
    };
    result: null;
  };
  /** Takes the lease away from its holder, at once. */
  "lease.take": {
    params: {
      arm?: string;
    };
    result: Lease;
  };
  /** Jogs until it is stopped, or is not kept up. */
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
  /** Keeps a jog up. A notification: it has no answer. */
  "jog.keep": {
    params: {
      jog: string;
    };
    result: null;
  };
  /** Stops a jog, also one whose `jog.start` is not answered yet. */
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
  /** Moves by a step, checked first. */
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
  /** Checks a program from where the arm stands; nothing moves. */
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
  /** Checks a program and runs it. What is answered is on the disk. */
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
  /** A job, also one that is over. */
  "job.get": {
    params: {
      job: string;
    };
    result: Job;
  };
  /** The last 50 jobs of an arm, the newest last. */
  "job.list": {
    params: {
      arm?: string;
    };
    result: {
      jobs: Job[];
    };
  };
  /** Pauses a job: nothing of it waits in the arm, the laser is off, the pen is up. The arm may be moved then. */
  "job.pause": {
    params: {
      job: string;
    };
    result: Job;
  };
  /** Goes on with a job that is paused, or that ended before its end. */
  "job.resume": {
    params: {
      job: string;
      approach?: boolean;
      overlap?: number;
      yes?: boolean;
    };
    result: Job;
  };
  /** Stops a job, and lifts its pen; never needs the lease. */
  "job.stop": {
    params: {
      job: string;
    };
    result: Job;
  };
  /** The jobs of an arm that are kept, the newest last, and sums over all that ran. */
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
  /** Gives a job that waits another place in the queue of its arm; one that waits no more is answered as it is. */
  "job.reorder": {
    params: {
      job: string;
      position: number;
    };
    result: Job;
  };
  /** Takes a job that is over out of the list. It counts in the totals all the same. */
  "job.delete": {
    params: {
      job: string;
    };
    result: null;
  };
  /** Keeps a program in the library. */
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
  /** The programs of the library. */
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
  /** A program of the library; one above 700 KiB comes by GET alone. */
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
  /** Makes another file of a program, and keeps it in the library. */
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
  /** What a person is asked before a program of this format is done: members of `setup`, the usual ones first. */
  "program.options": {
    params: {
      format: string;
      all?: boolean;
    };
    result: {
      options: Option[];
    };
  };
  /** Removes a program from the library. */
  "program.delete": {
    params: {
      name: string;
    };
    result: null;
  };
  /** Keeps options under a name; what was kept under it is replaced. It goes before one of this name that comes with this program. */
  "preset.save": {
    params: {
      name: string;
      setup?: Setup;
      note?: string;
      text?: string;
    };
    result: Preset;
  };
  /** The presets of drawing and engraving, for `setup.preset`: those that come with this program first. */
  "preset.list": {
    params: {
    };
    result: {
      presets: Preset[];
    };
  };
  /** What a preset says. */
  "preset.show": {
    params: {
      name: string;
    };
    result: Preset;
  };
  /** Removes a preset that was kept; one that comes with this program stays. */
  "preset.remove": {
    params: {
      name: string;
    };
    result: null;
  };
  /** Takes the height of the work surface from where the tool touches it, and keeps it for drawings, engravings and what else lies on it. The arm has to stand, with the laser off. Three touches within 30 mm or nearly in line are refused. */
  "surface.touch": {
    params: {
      arm?: string;
      add?: boolean;
      forget?: boolean;
      unhomed?: boolean;
    };
    result: MeasuredSurface;
  };
  /** Takes a corner of a sheet of paper from where the tool touches it. With the third one the sheet is kept, with its height and tilt: drawings lie on it then, upright for its reader. Corners within 30 mm, nearly in line or without a right angle are refused, and what was taken before stays. The arm has to stand, with the laser off. */
  "surface.corner": {
    params: {
      arm?: string;
      corner: "lower-left" | "lower-right" | "upper-left";
      unhomed?: boolean;
    };
    result: MeasuredSurface;
  };
  /** The height of the work surface that was touched. */
  "surface.get": {
    params: {
      arm?: string;
    };
    result: MeasuredSurface;
  };
  /** A step of a program that leads to where the arm stands. */
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
  /** Has the arm tell where its unlock key is released: each time an event `hand-trigger` with the `step` that leads there. */
  "teach.guide": {
    params: {
      arm?: string;
      on: boolean;
      unhomed?: boolean;
    };
    result: null;
  };
  /** A plan as rows of a table: in each where the arm goes, what its tool does there, and how long it stays. */
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
  /** A step of a program that sets the level of an output. */
  "teach.output": {
    params: {
      address: number;
      high: boolean;
    };
    result: {
      step: PlanStep;
    };
  };
  /** The plan of rows. What is wrong names its row in `data.row`. */
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
  /** The world around a virtual arm. This and its kin are `unsupported` of other arms. */
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
  /** The scenarios that need no file, for `world.scenario`. */
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
  /** Presses the key at the base: it runs the program that the arm keeps, or stops it. */
  "world.press": {
    params: {
      arm?: string;
      long?: boolean;
    };
    result: null;
  };
  /** Holds or releases the unlock key: while it is held the arm can be guided. */
  "world.unlock": {
    params: {
      arm?: string;
      held: boolean;
    };
    result: null;
  };
  /** Pulls the cable, or plugs it in again. */
  "world.unplug": {
    params: {
      arm?: string;
      plugged: boolean;
    };
    result: null;
  };
  /** Moves the arm by hand, while the unlock key is held. */
  "world.guide": {
    params: {
      arm?: string;
      joints: number[];
    };
    result: State;
  };
  /** Switches the arm off, and on again in the world of a scenario. */
  "world.scenario": {
    params: {
      arm?: string;
      text: string;
    };
    result: {
      objects: string[];
    };
  };
  /** Puts an object somewhere, by hand. */
  "world.place": {
    params: {
      arm?: string;
      name: string;
      at: number[];
    };
    result: null;
  };
  /** Lays a new sheet of paper: what pen and laser have left so far is gone. Refused while a job is under way. */
  "world.paper": {
    params: {
      arm?: string;
    };
    result: null;
  };
  /** Drives an input from outside: from now on it reads this. */
  "world.input": {
    params: {
      arm?: string;
      address: number;
      level?: boolean;
      value?: number;
    };
    result: null;
  };
  /** Lets something go wrong, also while a job runs. */
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
  /** Records an arm into a file, until `record.stop`. */
  "record.start": {
    params: {
      arm?: string;
      rate?: number;
    };
    result: {
      name: string;
    };
  };
  /** Ends the recording of an arm. */
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
  /** Writes what is kept of an arm's last minutes into a file: readings, what passed on its line, and what happened. */
  "record.save_last": {
    params: {
      arm?: string;
      seconds: number;
    };
    result: {
      name: string;
    };
  };
  /** The pose of joints, by the arm's geometry. */
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
  /** The joints of a pose; refused where the arm does not get there. */
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
  /** What the tip reaches at a height. */
  "motion.reach": {
    params: {
      z: number;
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[];
    };
    result: {
      outlines: number[][][];
    };
  };
  /** Gives the station a class, in the place of the one before. Pupils who were in it keep their codes, whatever the file says, and so does the teacher the PIN; the others get one. */
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
  /** The class: its rules and pupils. */
  "class.get": {
    params: {
    };
    result: Class;
  };
  /** Makes new codes: pupils who signed in with an old code have to sign in again. */
  "class.codes": {
    params: {
      pupils?: string[];
    };
    result: Class;
  };
  /** Stops arms: a job pauses where its step ends within a second, and ends elsewhere, at once if it burns (`job.resume` goes on with both); the rest ends, and the laser is off. Nobody but a teacher moves them until `class.free`; the time of turns stands. */
  "class.freeze": {
    params: {
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Lets arms be moved again. */
  "class.free": {
    params: {
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Puts a program to arms: it begins where the arm is free, and waits in the arm's queue elsewhere. */
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
  /** What pupils have made: their jobs that are done. As a page: GET /api/v1/class/results.html. */
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
  /** Joins the queue for a turn, of persons and not of sockets: a page that is loaded anew has lost nothing. Who has a turn, or waits for the same arms, keeps it. A teacher needs none. */
  "turn.join": {
    params: {
      arm?: string;
      group?: string;
    };
    result: TurnList;
  };
  /** Gives turn and place up. */
  "turn.leave": {
    params: {
      person?: string;
    };
    result: null;
  };
  /** Ends the turn at an arm, at some, or at all: its person has no place any more, and the next who waits gets the arm. What moves stops as at any end of a turn. */
  "turn.end": {
    params: {
      arm?: string;
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Passes the turn at an arm, at some, or at all, to the next who waits for it: the person who had it gets the last place of the queue. Refused for `arm` where nobody who is there waits; of others such an arm is left out. */
  "turn.next": {
    params: {
      arm?: string;
      arms?: string[];
    };
    result: {
      arms: string[];
    };
  };
  /** Whose turn it is, and who waits. */
  "turn.list": {
    params: {
      group?: string;
    };
    result: TurnList;
  };
  /** Says who may have the lease of which arm when, by the station's own clock. An arm that is in no slot is free at any time. */
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
  /** The schedule. */
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
  /** The arms that this station expects on its site. */
  "site.roster": {
    params: {
    };
    result: {
      arms: ExpectedArm[];
    };
  };
  /** Replaces the roster: whatever is asked of all arms of the site names those of the roster that are missing. */
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
  /** A session came, went, or got or lost a lease. Five times a second at most: the list is the newest one. */
  "session.changed": {
    sessions: Session[];
  };
  /** The lease of an arm was given, given back, taken or lost. */
  "lease.changed": {
    arm: string;
    holder: Holder | null;
  };
  /** Another session asks for it by `lease.ask`. Answer by `lease.answer`; without an answer it passes after 20 s. A session that asks again meanwhile is told once, and one answer is for all that it asked. */
  "lease.asked": {
    arm: string;
    session: string;
    name: string;
    message: string | null;
  };
  /** It waits for a lease by `lease.acquire` with `wait_s`: at once, and whenever the queue has moved; its place may be the same as before. */
  "lease.queue": {
    arm: string;
    place: number;
  };
  /** A job has another state, at once; its progress, ten times a second at most; its place in the queue, five times a second at most: it is the newest one. */
  "job.changed": {
    job: Job;
  };
  /** A jog is over. The stop has gone out to the arm; it may still come to rest. */
  "jog.ended": {
    arm: string;
    jog: string;
    why: "released" | "not-kept" | "stopped" | "lease" | "link" | "replaced" | "limit";
  };
  /** The work surface under an arm was touched or forgotten, a corner of a sheet was taken; or another program has measured it, which shows with the next `surface.get`. */
  "surface.changed": {
    arm: string;
    surface: MeasuredSurface;
  };
  /** As often as `arm.subscribe` asks for, the newest state when several are due; at once when job, jog or holder change, and once when the line is lost. */
  "arm.state": {
    subscription: number;
    state: StateChange;
  };
  /** The station begins to end, and to each session that says hello after that. Who holds an arm stops it within 1 s (`arm.stop`), lifts its pen and gives the lease back. */
  "server.ending": {
    left_s: number;
  };
  /** A turn began or ended, somebody joined or left the queue, an arm was frozen or freed, a class was set. */
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
  /** A turn ends in 60 s, and in 10 s. */
  "turn.ending": {
    arm: string;
    person: string;
    left_s: number;
  };
  /** Its turn begins, or goes on after a teacher had the arm: it has the lease from now on. */
  "turn.granted": {
    arm: string;
    lease: string;
    ttl_s: number;
    left_s: number | null;
  };
  /** Something happened: see the table of events. */
  "arm.event": Event;
}
