// The methods of a station. Written by `cargo xtask studio-api` from the table that the station itself works by.

export type State = {
  x: number;
  y: number;
  z: number;
  r: number;
  j1: number;
  j2: number;
  j3: number;
  j4: number;
  t: number;
  arm: string;
  current_index: number;
  left_space: number;
  alarms: number[];
  link: string;
  moving: boolean;
  homed: boolean | null;
  rail: number | null;
  tool: Tool;
  speed: number | null;
  pins: unknown[];
  job: string | null;
  jog: string | null;
  holder: Holder | null;
};

export type Tool = {
  name: string | null;
  bias: number[] | null;
  suction: boolean | null;
  gripper: string | null;
  laser: boolean | null;
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

export type Lease = {
  arm: string;
  lease: string;
  ttl_s: number;
};

export type Job = {
  job: string;
  arm: string;
  title: string | null;
  state: string;
  step: number;
  steps: number | null;
  first_step: number | null;
  /** 0: until it is stopped. */
  loops: number;
  loop: number;
  seconds_left: number | null;
  drawn_mm: number | null;
  travel_mm: number | null;
  started: number | null;
  ended: number | null;
  holder: Holder | null;
  part: number | null;
  reason: string | null;
  text: string | null;
  place: number | null;
  error: {
    message: string;
  } | null;
  notes: Note[] | null;
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
  beyond?: number;
  code?: string;
  command?: string;
  value?: number;
  limit?: number;
  unit?: string;
  fence?: string;
  from?: number;
  to?: number;
  remedies?: Array<Record<string, unknown>>;
};

export type Note = {
  code: string;
  text: string;
  line?: number;
  element?: string;
  remedies?: Array<Record<string, unknown>>;
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
  options?: Record<string, unknown>;
  text?: string;
  problem?: string;
};

export interface Methods {
  /** Begins the session. The first message of a socket, once. */
  "session.hello": {
    params: {
      client: Record<string, unknown>;
      token?: string;
      pupil?: Record<string, unknown>;
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
      sessions: Array<{
        session: string;
        name: string;
        role: string;
        leases: string[];
        since: number;
      }>;
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
      fence: Record<string, unknown> | null;
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
      pins?: Array<Record<string, unknown>>;
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
      query?: Record<string, unknown>;
    };
    result: Record<string, unknown>;
  };
  /** Sends a command that acts at once. */
  "arm.set": {
    params: {
      arm?: string;
      command: string;
      fields?: Record<string, unknown>;
      yes?: boolean;
    };
    result: null;
  };
  /** Queues a command. */
  "arm.enqueue": {
    params: {
      arm?: string;
      command: string;
      fields?: Record<string, unknown>;
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
      laser?: Record<string, unknown>;
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
      fields?: Record<string, unknown>;
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
      arms: Array<{
        stood: boolean;
        pose: Pose;
        arm: string;
      }>;
    };
  };
  /** The fence of an arm: what crosses it is refused as `unreachable`. A change ends what is under way. */
  "arm.fence": {
    params: {
      arm?: string;
      set?: Record<string, unknown> | null;
    };
    result: {
      fence: {
        floor: number | null;
        box: Record<string, [number, number]> | null;
        keep_out: unknown[];
        speed: number | null;
        power: number | null;
      } | null;
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
      events: Array<{
        arm: string;
        seq: number;
        t: number;
        event: string;
      }>;
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
  /** Gives it back. What the arm has queued goes on; a jog, stepper motors and the belt are stopped, and a job pauses unless its `on_lost` says otherwise. */
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
      lease: string;
      ttl_s: number;
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
    result: unknown;
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
      setup?: Record<string, unknown>;
      preview?: boolean;
    };
    result: Report;
  };
  /** Checks a program and runs it. */
  "job.start": {
    params: {
      arm?: string;
      program?: string;
      text?: string;
      data?: string;
      format?: string;
      setup?: Record<string, unknown>;
      from?: number;
      loops?: number;
      keep?: boolean;
      require_homed?: boolean;
      unhomed?: boolean;
      yes?: boolean;
      on_lost?: "pause" | "stop" | "continue";
      queue?: boolean;
      after_check?: boolean;
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
  /** Keeps a program in the library; one of this name is replaced. */
  "program.put": {
    params: {
      name: string;
      text?: string;
      data?: string;
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
  /** Makes another file of a program. */
  "program.convert": {
    params: {
      name: string;
      to: string;
      setup?: Record<string, unknown>;
    };
    result: {
      from: string;
      to: string;
      steps: number;
      lost: string[];
      notes: Array<{
        code: string;
        text: string;
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
      setup?: Record<string, unknown>;
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
  /** Takes the height of the level work surface from where the tool touches it, and keeps it for drawings, engravings and what else lies on it. The arm has to stand, with the laser off. */
  "surface.touch": {
    params: {
      arm?: string;
      forget?: boolean;
      unhomed?: boolean;
    };
    result: {
      touches: number;
      plane: {
        at: number[];
        z: number;
        slope_x: number;
        slope_y: number;
      } | null;
      residual: number | null;
    };
  };
  /** The height of the work surface that was touched. */
  "surface.get": {
    params: {
      arm?: string;
    };
    result: {
      touches: number;
      plane: {
        at: number[];
        z: number;
        slope_x: number;
        slope_y: number;
      } | null;
      residual: number | null;
    };
  };
  /** A step of a program that leads to where the arm stands. */
  "teach.capture": {
    params: {
      arm?: string;
      by?: "joint" | "linear" | "jump";
      unhomed?: boolean;
    };
    result: {
      step: {
        move: number[];
        by: string;
        name: string;
      };
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
      plan: Record<string, unknown>;
    };
    result: {
      title: string;
      tool: string | number[] | null;
      surface: Record<string, unknown> | null;
      rows: Array<{
        name: string;
        motion: Record<string, unknown> | null;
        gripper: string | null;
        suction: boolean | null;
        wait: number | null;
      }>;
    };
  };
  /** A step of a program that sets the level of an output. */
  "teach.output": {
    params: {
      address: number;
      high: boolean;
    };
    result: {
      step: {
        command: string;
        values: {
          address: number;
          level: number;
        };
      };
    };
  };
  /** The plan of rows. What is wrong names its row in `data.row`. */
  "teach.plan": {
    params: {
      title?: string;
      tool?: "none" | "suction" | "gripper" | "pen" | "laser" | number[] | null;
      surface?: Record<string, unknown> | null;
      rows: Array<Record<string, unknown>>;
    };
    result: {
      plan: Record<string, unknown>;
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
  /** Gives the station a class, in the place of the one before. Pupils keep their codes; the others get one. */
  "class.set": {
    params: {
      text: string;
      elsewhere?: boolean;
    };
    result: {
      class: {
        turn_s: number;
        grace_s: number;
        finish_job: boolean;
        speed: number | null;
        fence: Record<string, unknown> | null;
      } | null;
      groups: {
      };
      pupils: Array<{
        name: string;
        group: string | null;
        code: string | null;
      }>;
      text: string;
    };
  };
  /** The class: its rules and pupils. */
  "class.get": {
    params: {
    };
    result: {
      class: {
        turn_s: number;
        grace_s: number;
        finish_job: boolean;
        speed: number | null;
        fence: Record<string, unknown> | null;
      } | null;
      groups: {
      };
      pupils: Array<{
        name: string;
        group: string | null;
        code: string | null;
      }>;
      text: string;
    };
  };
  /** Makes new codes: pupils who signed in with an old code have to sign in again. */
  "class.codes": {
    params: {
      pupils?: string[];
    };
    result: {
      class: {
        turn_s: number;
        grace_s: number;
        finish_job: boolean;
        speed: number | null;
        fence: Record<string, unknown> | null;
      } | null;
      groups: {
      };
      pupils: Array<{
        name: string;
        group: string | null;
        code: string | null;
      }>;
      text: string;
    };
  };
  /** Stops arms: jobs pause, the rest ends, the laser is off. Nobody but a teacher moves them until `class.free`; the time of turns stands. */
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
      setup?: Record<string, unknown>;
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
        title: string | null;
        arm: string;
        time: string;
        drawn_mm: number | null;
        strokes: number[][][];
      }>;
    };
  };
  /** Joins the queue for a turn, of persons and not of sockets: a page that is loaded anew has lost nothing. Who has a turn, or waits for the same arms, keeps it. A teacher needs none. */
  "turn.join": {
    params: {
      arm?: string;
      group?: string;
    };
    result: {
      turn_s: number | null;
      arms: Array<{
        arm: string;
        person: string | null;
        state: string | null;
        left_s: number | null;
        frozen: boolean;
      }>;
      queue: Array<{
        place: number;
        person: string;
        arms: string[];
        missed: boolean;
      }>;
    };
  };
  /** Gives turn and place up. */
  "turn.leave": {
    params: {
    };
    result: null;
  };
  /** Whose turn it is, and who waits. */
  "turn.list": {
    params: {
      group?: string;
    };
    result: {
      turn_s: number | null;
      arms: Array<{
        arm: string;
        person: string | null;
        state: string | null;
        left_s: number | null;
        frozen: boolean;
      }>;
      queue: Array<{
        place: number;
        person: string;
        arms: string[];
        missed: boolean;
      }>;
    };
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
    };
  };
}
