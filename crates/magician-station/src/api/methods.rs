//! Table of methods. The check of requests, the documentation and the tests are derived from it.
//! The table stays in one file, however long.

use super::method::{method, optional_param, required_param};
use super::types::SHEET_CORNERS;
use super::{IdKind, Kind, Method, Param, Role};
use crate::control::WorkKind;

// The limit of names of programs. Other names have the same one.
const NAME: Kind = Kind::Text(80);
const ANY_NUMBER: Kind = Kind::Number(f64::MIN, f64::MAX);
const ARM: Param = optional_param("arm", Kind::Text(32), "name of the arm");
const YES: Param = optional_param(
    "yes",
    Kind::Switch,
    "confirms a dangerous command, or one that may burn",
);
const UNHOMED: Param = optional_param(
    "unhomed",
    Kind::Switch,
    "accepts an arm not known to be homed: it may act in the wrong place",
);
const TOOL: Kind = Kind::Either(&[
    Kind::Choice(&["none", "suction", "gripper", "pen", "laser"]),
    Kind::Numbers(3, 3),
]);
const TOOL_PARAM: Param = optional_param(
    "tool",
    TOOL,
    "tool whose tip the pose refers to, or offset of the tip from the flange (mm); default none",
);
const PERCENT: Kind = Kind::Number(1.0, 100.0);
/// Program as text. Bounded by the size of a message.
const PROGRAM: Kind = Kind::Text(1024 * 1024);
const PROGRAM_NAME: Param = optional_param(
    "program",
    NAME,
    "name of a program in the library; alternatively `text` or `data`",
);
const NAMED: Param = required_param("name", NAME, "name of the program");
const TEXT: Param = optional_param(
    "text",
    PROGRAM,
    "content of the program as text; alternatively `data`",
);
const DATA: Param = optional_param(
    "data",
    PROGRAM,
    "content of the program in base64; alternatively `text`",
);
const REPLACE: Param = optional_param(
    "replace",
    Kind::Switch,
    "replaces a program of the same name; if false, a taken name is refused; default true",
);
const FORMAT: Param = optional_param(
    "format",
    Kind::Text(20),
    "format, if its first bytes do not show it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, plan, testgrid",
);
const SETUP: Param = optional_param(
    "setup",
    Kind::Object("Setup"),
    "options of drawing and engraving: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset for all other options; without `setup` the program runs unchanged",
);
const PRESET: Param = required_param(
    "name",
    Kind::Text(64),
    "name of the preset: letters, digits, - and _",
);
const JOB: Param = required_param("job", Kind::Id(IdKind::Job), "id of the job");
pub(super) const JOGS: &[&str] = &[
    "x+", "x-", "y+", "y-", "z+", "z-", "r+", "r-", "j1+", "j1-", "j2+", "j2-", "j3+", "j3-",
    "j4+", "j4-", "l+", "l-",
];
const AXES: &[&str] = &["x", "y", "z", "r", "j1", "j2", "j3", "j4", "l"];

use Role::{Student, Teacher, Viewer};
use WorkKind::{JobSetting, Motion, Queued, Setting, StartJob, SteerJob};

/// All methods except those of classes, in documentation order.
pub(super) const STATION: &[Method] = &[
    method(
        "session.hello",
        Viewer,
        &[
            required_param(
                "client",
                Kind::Object("ClientName"),
                "client program: `name`, and optionally `version`",
            ),
            optional_param("token", Kind::Text(200), "token of the station"),
            optional_param(
                "pupil",
                Kind::Object("Pupil"),
                "sign-in of a pupil: `name` and `code`; replaces a token",
            ),
            optional_param(
                "pin",
                Kind::Text(6),
                "teacher's PIN of the class, on this machine only; replaces a token",
            ),
            optional_param(
                "resume",
                Kind::Text(200),
                "secret of a session to resume, from an earlier answer",
            ),
            optional_param(
                "role",
                Kind::Choice(&["viewer", "student", "teacher"]),
                "upper limit for the role of the session, below that of its token",
            ),
        ],
        "Begins a session. Must be the first message on a socket, and is sent once.",
        "{session, resume, resumed, role, api, version, arms, limits}: `resumed` is false if no session was resumed and this one is new; `limits`: bytes per message, messages per second, sockets of the station",
    )
    .of_sessions(),
    method(
        "session.list",
        Viewer,
        &[],
        "Lists the sessions of the station.",
        "{sessions: [{session, name, role, leases, since}]}",
    )
    .of_sessions(),
    method(
        "server.info",
        Viewer,
        &[],
        "Returns facts about the station.",
        "{version, api, uptime_s, arms, programs, recording, features}: `recording`: true if an arm is being recorded; `features`: optional features of this station, see [features](#features)",
    ),
    method(
        "arm.list",
        Viewer,
        &[],
        "Lists the arms of the station.",
        "{arms: [{name, port, virtual, link, holder, waiting: [{session, name, asks}], job}]}: `waiting`: sessions that wait for the lease, in order, and those that ask its holder",
    ),
    method(
        "arm.info",
        Viewer,
        &[ARM],
        "Returns identity and state of an arm.",
        "as `info --json`",
    ),
    method(
        "arm.io",
        Viewer,
        &[ARM],
        "Describes the pins, sensors and steppers of an arm by the protocol's table, for clients that know no command.",
        "{analog: {counts, volts}, functions: [{value, name, about, watch}], pins: [{address, function, can, level, frequency, duty_cycle}], rows: [{role, command, about, asks, tells, sets}]}: `watch`: kind of the pin for `arm.subscribe`; `can`: functions supported by the pin's connector, null if unknown; `asks`, `tells`, `sets`: fields of query, reply and set {name, about, unit, kind, least, most, choices: [{value, name}]}, null if the command has no such form",
    ),
    method(
        "arm.state",
        Viewer,
        &[ARM],
        "Returns the state, at most 100 ms old.",
        "State",
    ),
    method(
        "arm.subscribe",
        Viewer,
        &[
            ARM,
            required_param("rate", Kind::Integer(1, 50), "states per second"),
            optional_param(
                "frame",
                Kind::Choice(&["json", "binary"]),
                "encoding of the states; default json",
            ),
            optional_param(
                "pins",
                Kind::Objects("PinAddress"),
                "pins to read as well: `kind` (input, output, analog) and `address` (1 to 20)",
            ),
        ],
        "Subscribes to the state. If several states are due, only the newest is sent.",
        "{subscription, rate, fields}",
    )
    .of_sessions(),
    method(
        "arm.unsubscribe",
        Viewer,
        &[required_param(
            "subscription",
            Kind::Id(IdKind::Subscription),
            "id of the subscription",
        )],
        "Ends a subscription.",
        "null",
    )
    .of_sessions(),
    method(
        "arm.get",
        Viewer,
        &[
            ARM,
            required_param("command", NAME, "a command of the protocol"),
            optional_param(
                "query",
                Kind::Object("Fields"),
                "fields of the query",
            ),
        ],
        "Reads a value by a command of the protocol.",
        "the fields, as `get --json`",
    ),
    method(
        "arm.set",
        Student,
        &[
            ARM,
            required_param("command", NAME, "a command of the protocol"),
            optional_param("fields", Kind::Object("Fields"), "its fields"),
            YES,
        ],
        "Sends a command that takes effect immediately.",
        "null",
    )
    .leased(Setting),
    method(
        "arm.enqueue",
        Student,
        &[
            ARM,
            required_param(
                "command",
                NAME,
                "a command of the protocol that can be queued",
            ),
            optional_param("fields", Kind::Object("Fields"), "its fields"),
            YES,
        ],
        "Queues a command.",
        "{index}",
    )
    .leased(Queued),
    method(
        "arm.move",
        Student,
        &[
            ARM,
            required_param(
                "to",
                Kind::Numbers(4, 5),
                "target: x, y, z (mm), r (deg), or four joints (deg); then the rail (mm) if there is one",
            ),
            optional_param(
                "by",
                Kind::Choice(&["joint", "linear", "jump"]),
                "path; default joint",
            ),
            optional_param(
                "frame",
                Kind::Choice(&["xyz", "joints"]),
                "coordinates of `to`; default xyz",
            ),
            optional_param(
                "relative",
                Kind::Switch,
                "interprets `to` relative to the current position",
            ),
            optional_param(
                "wait",
                Kind::Switch,
                "answers only after the motion; default true",
            ),
        ],
        "Moves the arm, after a check of the motion.",
        "State, or {index} without `wait`",
    )
    .leased(Motion),
    method("arm.home", Student, &[ARM, YES], "Homes the arm.", "State").leased(Motion),
    method(
        "arm.clear_alarms",
        Student,
        &[ARM, YES],
        "Clears all alarms, which releases the queue.",
        "State",
    )
    .leased(Setting),
    method(
        "arm.tool",
        Student,
        &[
            ARM,
            optional_param(
                "tool",
                TOOL,
                "mounted tool, or offset of its tip from the flange (mm)",
            ),
            optional_param("suction", Kind::Switch, "switches the suction cup"),
            optional_param(
                "gripper",
                Kind::Choice(&["open", "closed", "off"]),
                "state of the gripper",
            ),
            optional_param(
                "laser",
                Kind::Object("Laser"),
                "laser: `on`, and `power` (percent), which must be 100 while the arm stands",
            ),
            YES,
        ],
        "Selects or operates the tool. Takes exactly one parameter besides `arm` and `yes`.",
        "State",
    )
    .leased(Setting),
    method(
        "arm.speed",
        Student,
        &[
            ARM,
            optional_param(
                "percent",
                PERCENT,
                "speed ratio of moves and jogs; alternatively `row`",
            ),
            optional_param("row", NAME, "command of the protocol that sets speeds"),
            optional_param("fields", Kind::Object("Fields"), "its fields"),
        ],
        "Sets the speed ratio of moves and jogs, also of a running job, or one speed setting.",
        "null",
    )
    .leased(JobSetting),
    method(
        "arm.alarms",
        Viewer,
        &[ARM],
        "Lists the active alarms with cause and remedy.",
        "as `alarms --json`",
    ),
    method(
        // The lowest role and no lease: anyone who sees an arm must be able to stop it.
        "arm.stop",
        Viewer,
        &[ARM],
        "Stops an arm, or all arms. Never needs the lease, and does not lift the pen.",
        "{arms: [{arm, stood, pose}]}, after standstill; an error lists in `arms` those that stand nevertheless",
    )
    .always(),
    method(
        "arm.fence",
        Viewer,
        &[
            ARM,
            optional_param(
                "set",
                Kind::Either(&[Kind::Object("FenceChange"), Kind::Null]),
                "members to change: `floor` (mm), `box` {x, y, z: [least, most]} (mm), `keep_out` (boxes), `speed` (mm/s), `power` (percent); null removes a bound, or all; needs the role teacher",
            ),
        ],
        "Returns or changes the fence of an arm. Motion that crosses the fence is refused as `unreachable`. A change ends motion in progress.",
        "{fence}: null if the arm has no fence",
    ),
    method(
        "arm.model",
        Viewer,
        &[ARM],
        "Returns the arm as a chain of links, its limits and its tool, for clients that draw it.",
        "{frame, links: [{name, parent, joint, axis, at, shape, size, turn, color}], limits, tool}",
    ),
    method(
        "events.since",
        Viewer,
        &[
            ARM,
            required_param(
                "seq",
                Kind::Integer(0, i64::MAX),
                "sequence number of the last known event; 0 for all",
            ),
        ],
        "Lists past events of an arm, at most 1000.",
        "{events, seq}",
    ),
    method(
        "lease.acquire",
        Student,
        &[
            ARM,
            optional_param(
                "wait_s",
                // The bound is `MAX_LEASE_WAIT` of control.
                Kind::Number(0.0, 3600.0),
                "longest wait for the lease, s; default 0. Refused with -32002 when the time is over",
            ),
        ],
        "Acquires the lease of an arm: the exclusive right to move it.",
        "{arm, lease, ttl_s}",
    )
    .of_sessions(),
    method(
        "lease.renew",
        Student,
        &[required_param("lease", Kind::Id(IdKind::Lease), "id of the lease")],
        "Keeps the lease alive (so does any message).",
        "null",
    )
    .of_sessions(),
    method(
        "lease.release",
        Student,
        &[required_param("lease", Kind::Id(IdKind::Lease), "id of the lease")],
        "Gives the lease back. Succeeds also if the lease has already ended. Queued commands continue; a jog, the stepper motors and \
         the belt are stopped, and a job pauses unless its `on_lost` says otherwise.",
        "null",
    )
    .of_sessions(),
    method(
        "lease.ask",
        Student,
        &[
            ARM,
            optional_param("message", Kind::Text(200), "message for the holder"),
        ],
        "Asks the holder for the lease. Granted if the holder does not answer within 20 s.",
        "{granted, lease, ttl_s}: only `granted` (false) if the holder refuses",
    )
    .of_sessions(),
    method(
        "lease.answer",
        Student,
        &[
            ARM,
            required_param("session", Kind::Id(IdKind::Session), "session that asked"),
            required_param("grant", Kind::Switch, "true to pass the lease on"),
        ],
        "Answers a session that asked for the lease.",
        "null",
    )
    .of_sessions(),
    method(
        "lease.take",
        Teacher,
        &[ARM],
        "Takes the lease from its holder immediately.",
        "{arm, lease, ttl_s}",
    )
    .of_sessions(),
    method(
        "jog.start",
        Student,
        &[
            ARM,
            required_param(
                "axis",
                Kind::Choice(JOGS),
                "axis, joint or rail, with direction",
            ),
            optional_param(
                "keep_ms",
                // A choice: below 100 ms a slow network ends jogs, and above 1 s the arm moves too
                // long after its client is gone.
                Kind::Integer(100, 1000),
                "hold time, ms: the jog stops if `jog.keep` does not renew it; default 250",
            ),
            optional_param("percent", PERCENT, "speed ratio of the jog"),
        ],
        "Jogs the arm until the jog is stopped or its hold time expires.",
        "{jog}",
    )
    .leased(Motion)
    .of_sessions(),
    method(
        // Sent several times per second. An answer to each would only load the line.
        "jog.keep",
        Viewer,
        &[required_param("jog", Kind::Id(IdKind::Jog), "the jog")],
        "Renews the hold time of a jog. Sent as a notification, without an answer.",
        "nothing",
    )
    .always()
    .of_sessions(),
    method(
        "jog.stop",
        Viewer,
        &[
            ARM,
            optional_param("jog", Kind::Id(IdKind::Jog), "id of the jog; default: the current jog of the arm"),
        ],
        "Stops a jog, including one whose `jog.start` has not been answered yet.",
        "{stood, pose}, after standstill",
    )
    .always()
    .of_sessions(),
    method(
        "jog.step",
        Student,
        &[
            ARM,
            required_param("axis", Kind::Choice(AXES), "axis, joint or rail"),
            required_param("by", ANY_NUMBER, "signed distance, mm or deg"),
            optional_param(
                "frame",
                Kind::Choice(&["base", "tool"]),
                "frame of x and y: the base, or rotated by r; default base",
            ),
            optional_param("percent", PERCENT, "speed ratio of the move"),
        ],
        "Moves by a step, after a check of the motion.",
        "State",
    )
    .leased(Motion),
    method(
        "job.check",
        Viewer,
        &[
            ARM,
            PROGRAM_NAME,
            TEXT,
            DATA,
            FORMAT,
            SETUP,
            optional_param(
                "preview",
                Kind::Switch,
                "adds `preview`, the expected result: `{strokes: [{points, height, part, power, reachable}], travels}`, at most 20,000 points each; `part` is a number of `parts`, or null; `power` of the laser in percent, 100 for ink",
            ),
        ],
        "Checks a program from the current position of the arm, without moving it.",
        "Report: as `run --check --json`, and `parts`, the first 256, as `run --list-parts --json`; `seconds` of a part is null if the program is not divided into parts; `digest` for `job.start`",
    ),
    method(
        "job.start",
        Student,
        &[
            ARM,
            PROGRAM_NAME,
            TEXT,
            DATA,
            FORMAT,
            SETUP,
            optional_param(
                "from",
                Kind::Integer(1, i64::MAX),
                "first step, from 1, counted over all loops",
            ),
            optional_param(
                "loops",
                Kind::Integer(0, i64::MAX),
                "number of repetitions; 0 repeats until stopped; default 1",
            ),
            optional_param(
                "keep",
                Kind::Switch,
                "lets the commands in the arm's queue finish first",
            ),
            optional_param(
                "require_homed",
                Kind::Switch,
                "refuses an arm that has not been homed",
            ),
            UNHOMED,
            YES,
            optional_param(
                "on_lost",
                Kind::Choice(&["pause", "stop", "continue"]),
                "action when the lease ends; default pause, or continue if the caller has no session",
            ),
            optional_param(
                "queue",
                Kind::Switch,
                "queues the job, without the lease, until the arm has no job and no turn of others; it is then checked again",
            ),
            optional_param(
                "after_check",
                Kind::Switch,
                "answers only after the check; default true",
            ),
            optional_param(
                "key",
                Kind::Text(64),
                "idempotency key chosen by the caller, such as a UUID. A second start with the same key starts nothing and returns the first answer, even after a restart of the station. Refused if program, `digest`, `setup`, `loops`, `from`, `keep`, `require_homed` or `unhomed` differ. Keys are per arm",
            ),
            optional_param(
                "digest",
                Kind::Text(64),
                "`digest` of the check that the user saw: refused with -32009 if the program, or the preset named in `setup`, has changed since",
            ),
        ],
        "Checks a program and runs it. The job is on the disk when this is answered.",
        "{job}",
    )
    .leased(StartJob),
    method(
        "job.get",
        Viewer,
        &[JOB],
        "Returns a job, also a finished one.",
        "Job",
    ),
    method(
        "job.list",
        Viewer,
        &[ARM],
        "Lists the last 50 jobs of an arm, newest last.",
        "{jobs: [Job]}",
    ),
    method(
        "job.pause",
        Student,
        &[JOB],
        "Pauses a job: the queue of the arm is empty, the laser off, the pen up. The arm may then be moved.",
        "Job, once paused",
    )
    .leased(SteerJob),
    method(
        "job.resume",
        Student,
        &[
            JOB,
            optional_param(
                "approach",
                Kind::Switch,
                "approaches the drawing safely, because the arm may have been moved; default true",
            ),
            optional_param(
                "overlap",
                Kind::Number(0.0, 1000.0),
                "length of a burnt line to burn again before the point of interruption, mm; default 0",
            ),
            YES,
        ],
        "Resumes a paused, stopped or interrupted job.",
        "Job, once running",
    )
    .leased(SteerJob),
    method(
        "job.stop",
        Viewer,
        &[JOB],
        "Stops a job and lifts its pen. Never needs the lease.",
        "Job, once ended",
    )
    .always(),
    method(
        "job.history",
        Viewer,
        &[
            ARM,
            optional_param(
                "skip",
                // 500 jobs per arm are kept (`KEPT` in `station/store.rs`).
                Kind::Integer(0, 500),
                "number of newest jobs to skip; default 0",
            ),
            optional_param("limit", Kind::Integer(1, 500), "largest number of jobs to return; default 50"),
        ],
        "Lists the stored jobs of an arm, newest last, with totals over all jobs that ran.",
        "{jobs: [Job], more, totals: {jobs, done, stopped, failed, interrupted, drawn_mm, travel_mm, seconds}}: `more`: true if older jobs are stored; `totals` include jobs no longer stored",
    ),
    method(
        "job.reorder",
        Student,
        &[
            JOB,
            required_param(
                "position",
                Kind::Integer(1, i64::MAX),
                "new `place`, from 1; larger values mean the last place",
            ),
        ],
        "Moves a queued job to another place in the queue of its arm. No effect on a job that is no longer queued.",
        "Job",
    ),
    method(
        "job.delete",
        Teacher,
        &[JOB],
        "Deletes a finished job from the list. The totals still include it.",
        "null",
    ),
    method(
        // Needs no lease, because the library belongs to no arm.
        "program.put",
        Student,
        &[NAMED, TEXT, DATA, REPLACE],
        "Stores a program in the library.",
        "{name, bytes}",
    ),
    method(
        "program.list",
        Viewer,
        &[],
        "Lists the programs of the library.",
        "{programs: [{name, bytes, modified, format}]}",
    ),
    method(
        "program.get",
        Viewer,
        &[NAMED],
        "Returns a program of the library. Above 700 KiB use GET.",
        "{name, format, data}: base64",
    ),
    method(
        "program.convert",
        Student,
        &[
            NAMED,
            required_param(
                "to",
                NAME,
                "name of the new program; its extension selects the format: .plan.json, .playback, .svg, .png, .csv",
            ),
            SETUP,
            REPLACE,
        ],
        "Converts a program to another format and stores the result.",
        "as `convert --json`",
    ),
    method(
        "program.options",
        Viewer,
        &[
            required_param("format", Kind::Text(20), "format, as in `program.list`"),
            optional_param("all", Kind::Switch, "lists all applicable options, not only the usual ones"),
        ],
        "Lists the options for programs of a format: members of `setup`, usual ones first.",
        "{options: [Option]}: the range of a number is `least` (inclusive) or `above` (exclusive) to `most`; `default` is null if it depends on other options; an option with `with` applies only if that other option applies and has one of the values `when`, or is on if `when` is empty; `work` is not listed: by default the laser engraves and other tools draw; `group` serves for folding",
    ),
    method(
        "program.delete",
        Student,
        &[NAMED],
        "Deletes a program from the library.",
        "null",
    ),
    method(
        "preset.save",
        Student,
        &[
            PRESET,
            optional_param("setup", Kind::Object("Setup"), "options of the preset, as for `job.check`; alternatively `text`"),
            optional_param("note", Kind::Text(500), "note for users of the preset; with `setup`"),
            optional_param("text", Kind::Text(65536), "preset file, TOML; alternatively `setup`"),
        ],
        "Stores options under a name, replacing a stored preset. It takes precedence over a built-in preset of the same name.",
        "as `preset.show`",
    ),
    method(
        "preset.list",
        Viewer,
        &[],
        "Lists the presets for `setup.preset`, built-in ones first.",
        "{presets: [{name, shipped, note, path}]}: an invalid preset has a `problem`",
    ),
    method(
        "preset.show",
        Viewer,
        &[PRESET],
        "Returns the options of a preset.",
        "{name, shipped, note, path, options, text}: `options` as in `setup`, `text` as in a preset file",
    ),
    method(
        "preset.remove",
        Student,
        &[PRESET],
        "Deletes a stored preset. Built-in presets stay.",
        "null",
    ),
    method(
        "surface.touch",
        Student,
        &[
            ARM,
            optional_param(
                "add",
                Kind::Switch,
                "adds this touch to the earlier ones; from three touches on the surface is a tilted plane",
            ),
            optional_param(
                "forget",
                Kind::Switch,
                "forgets the measured surface and sheet instead of measuring",
            ),
            UNHOMED,
        ],
        "Measures the work surface at the point that the tool touches, and stores it for drawing and engraving. The arm must stand still with the laser off. Refuses three touches within 30 mm or nearly collinear.",
        "{touches, plane: {at, z, slope_x, slope_y}, residual, corners, sheet}: the surface has height `z` (mm) at `at` [x, y] and rises by `slope_x` and `slope_y` per mm; `residual` is the largest distance of a touch from it (mm); `plane` and `residual` are null after `forget`; `corners` and `sheet` as in `surface.corner`",
    )
    .leased(Setting),
    method(
        "surface.corner",
        Student,
        &[
            ARM,
            required_param(
                "corner",
                Kind::Choice(SHEET_CORNERS),
                "corner of the sheet, as its reader sees it",
            ),
            UNHOMED,
        ],
        "Measures a corner of a sheet of paper at the point that the tool touches. The third corner completes the sheet with its height and tilt; drawings are then placed on it, upright for its reader. Refuses corners within 30 mm, nearly collinear, or without a right angle, and keeps the earlier state. The arm must stand still with the laser off.",
        "as `surface.touch`: `corners`: corners measured so far of an incomplete sheet; `sheet` {corner, rotation, size, outline}: lower left corner, angle from the arm's X to the lower edge (deg), width and height (mm), and the four corners, or null",
    )
    .leased(Setting),
    method(
        "surface.get",
        Viewer,
        &[ARM],
        "Returns the measured work surface.",
        "as `surface.touch`; `plane` is null if nothing was measured",
    ),
    method(
        "teach.capture",
        Student,
        &[
            ARM,
            optional_param(
                "by",
                Kind::Choice(&["joint", "linear", "jump"]),
                "path to the step; default joint",
            ),
            UNHOMED,
        ],
        "Returns a program step to the current position of the arm.",
        "{step}, as in plan files",
    ),
    method(
        "teach.guide",
        Student,
        &[
            ARM,
            required_param("on", Kind::Switch, "true to begin; ends with the lease as well"),
            UNHOMED,
        ],
        "Sends an event `hand-trigger` with a `step` to the position each time the unlock key of the arm is released.",
        "null",
    )
    .leased(Setting),
    method(
        "teach.rows",
        Viewer,
        &[required_param("plan", Kind::Object("Plan"), "a plan, as in plan files")],
        "Returns a plan as rows of a table: target, action of the tool and waiting time.",
        "{title, tool, surface, rows: [{name, motion, gripper, suction, wait}]}: `motion` is a step as in plan files, the others are members of such steps, or null",
    ),
    method(
        "teach.output",
        Viewer,
        &[
            required_param("address", Kind::Integer(1, 20), "EIO address of the pin"),
            required_param("high", Kind::Switch, "true for high"),
        ],
        "Returns a program step that sets the level of an output.",
        "{step}, as in plan files",
    ),
    method(
        "teach.plan",
        Viewer,
        &[
            optional_param("title", Kind::Text(200), "title of the plan"),
            optional_param("tool", Kind::Either(&[TOOL, Kind::Null]), "tool whose tip reaches the points"),
            optional_param(
                "surface",
                Kind::Either(&[Kind::Object("Surface"), Kind::Null]),
                "work surface, as in plan files",
            ),
            required_param("rows", Kind::Objects("GivenRow"), "rows, as from `teach.rows`"),
        ],
        "Builds a plan from rows. An error names its row in `data.row`.",
        "{plan, first}: number of steps before each row",
    ),
    method(
        "world.look",
        Viewer,
        &[
            ARM,
            optional_param(
                "mark",
                NAME,
                "`mark` of an earlier answer: `drawing` and `strokes` are null while the drawing is unchanged",
            ),
        ],
        "Returns the world around a virtual arm. All `world.*` methods are `unsupported` for other arms.",
        "{objects: [{name, at, turn, size, color, held}], title, table: {height, x, y}, draws: \"pen\" or \"laser\", belt: {start, direction, length, width, height, travel}, drawing: SVG, strokes: [{burnt, power, points: [[x, y]]}], mark, unlocked, plugged}; `table` and `belt` are null if the scenario has none, `draws` is null if its tool leaves no lines; `power` of the laser in percent, 100 for ink",
    ),
    method(
        "world.scenarios",
        Viewer,
        &[ARM],
        "Lists the built-in scenarios for `world.scenario`.",
        "{scenarios: [{name, title, text}]}",
    ),
    method(
        "world.press",
        Student,
        &[
            ARM,
            optional_param("long", Kind::Switch, "holds the key, which homes the arm"),
        ],
        "Presses the key at the base, which runs or stops the program stored in the arm.",
        "null",
    )
    .leased(Setting),
    method(
        "world.unlock",
        Student,
        &[ARM, required_param("held", Kind::Switch, "true to hold, false to release")],
        "Holds or releases the unlock key. While held, the arm can be guided by hand.",
        "null",
    )
    .leased(Setting),
    method(
        "world.unplug",
        Student,
        &[ARM, required_param("plugged", Kind::Switch, "true to plug in, false to unplug")],
        "Unplugs the cable, or plugs it in again.",
        "null",
    )
    .leased(Setting),
    method(
        "world.guide",
        Student,
        &[
            ARM,
            required_param(
                "joints",
                Kind::Numbers(4, 4),
                "target joint angles, deg; clamped to the limits",
            ),
        ],
        "Moves the arm by hand while the unlock key is held.",
        "State",
    )
    .leased(Setting),
    method(
        "world.scenario",
        Teacher,
        &[ARM, required_param("text", PROGRAM, "a scenario, TOML")],
        "Power-cycles the arm in the world of a scenario.",
        "{objects: [name]}",
    )
    .leased(Setting),
    method(
        "world.place",
        Student,
        &[
            ARM,
            required_param("name", NAME, "name of the object"),
            required_param(
                "at",
                Kind::Numbers(3, 3),
                "x, y, z of the centre of its underside, mm; it falls onto the surface below",
            ),
        ],
        "Moves an object by hand.",
        "null",
    )
    .leased(Setting),
    method(
        "world.paper",
        Student,
        &[ARM],
        "Replaces the paper by a new sheet, which removes all marks of pen and laser. Refused while a job is in progress.",
        "null",
    )
    .leased(Setting),
    method(
        "world.input",
        Student,
        &[
            ARM,
            required_param("address", Kind::Integer(1, 20), "EIO address"),
            optional_param("level", Kind::Switch, "true for high; alternatively `value`"),
            optional_param("value", Kind::Integer(0, 4095), "voltage in counts, 4095 at 3.3 V; alternatively `level`"),
        ],
        "Drives an input from outside with a constant level or voltage.",
        "null",
    )
    .leased(JobSetting),
    method(
        "world.fault",
        Student,
        &[
            ARM,
            required_param(
                "fault",
                Kind::Choice(&["alarm", "slip", "reset"]),
                "fault: an alarm, a slipping joint, or a reset of the controller",
            ),
            optional_param("alarm", Kind::Integer(0, 255), "code of the alarm"),
            optional_param("joint", Kind::Integer(1, 4), "slipping joint; default 1"),
            optional_param("degrees", Kind::Number(-90.0, 90.0), "angle of the slip, deg"),
        ],
        "Injects a fault, also while a job runs.",
        "null",
    )
    .leased(JobSetting),
    method(
        "record.start",
        Student,
        &[
            ARM,
            optional_param(
                "rate",
                Kind::Integer(1, 50),
                "readings per second; default 20",
            ),
        ],
        "Records an arm to a file until `record.stop`.",
        "{name}, for GET /api/v1/recordings/{name}",
    ),
    method(
        "record.stop",
        Student,
        &[ARM],
        "Ends a recording.",
        "{name, seconds, bytes}",
    ),
    method(
        "record.save_last",
        Student,
        &[
            ARM,
            // The history covers 600 s (`KEPT` in `station/recordings.rs`).
            required_param("seconds", Kind::Number(1.0, 600.0), "length of the recording, s"),
        ],
        "Saves the last minutes of an arm to a file: readings, frames on the line, and events.",
        "{name}",
    ),
    method(
        "motion.forward",
        Viewer,
        &[
            required_param("joints", Kind::Numbers(4, 4), "joint angles, deg"),
            TOOL_PARAM,
        ],
        "Computes the pose of joint angles (forward kinematics).",
        "{x, y, z, r}",
    ),
    method(
        "motion.inverse",
        Viewer,
        &[
            required_param("pose", Kind::Numbers(4, 4), "x, y, z (mm) and r (deg)"),
            TOOL_PARAM,
        ],
        "Computes the joint angles of a pose (inverse kinematics). Refused if the pose is out of reach.",
        "{j1, j2, j3, j4}",
    ),
    method(
        "motion.reach",
        Viewer,
        &[required_param("z", ANY_NUMBER, "height of the tip, mm"), TOOL_PARAM],
        "Computes the reachable area at a height.",
        "{outlines: [[[x, y]]]}: closed polygons",
    ),
];
