//! Table of methods. The check of requests, the documentation and the tests are derived from it.
//! The table stays in one file, however long.

use super::method::{may, method, needed};
use super::types::SHEET_CORNERS;
use super::{IdKind, Kind, Method, Param, Role};
use crate::control::WorkKind;

// The limit of names of programs. Other names have the same one.
const NAME: Kind = Kind::Text(80);
const ANY: Kind = Kind::Number(f64::MIN, f64::MAX);
const ARM: Param = may("arm", Kind::Text(32), "name of the arm");
const YES: Param = may(
    "yes",
    Kind::Switch,
    "that it is meant: for what is dangerous or may burn",
);
const UNHOMED: Param = may(
    "unhomed",
    Kind::Switch,
    "takes an arm that is not known to be homed: perhaps in the wrong place",
);
const TOOL: Kind = Kind::Either(&[
    Kind::Choice(&["none", "suction", "gripper", "pen", "laser"]),
    Kind::Numbers(3, 3),
]);
const OF_TOOL: Param = may(
    "tool",
    TOOL,
    "the tool whose tip is meant, or its tip from the flange (mm); none unless given",
);
const PERCENT: Kind = Kind::Number(1.0, 100.0);
/// Program as text. Bounded by the size of a message.
const PROGRAM: Kind = Kind::Text(1024 * 1024);
const PROGRAM_NAME: Param = may(
    "program",
    NAME,
    "a program of the library; or `text`, or `data`",
);
const NAMED: Param = needed("name", NAME, "the program");
const TEXT: Param = may("text", PROGRAM, "the program as text; or `data`");
const REPLACE: Param = may(
    "replace",
    Kind::Switch,
    "whether a program that has this name already is replaced, or the request refused; yes unless given",
);
const DATA: Param = may("data", PROGRAM, "the program's bytes in base64; or `text`");
const FORMAT: Param = may(
    "format",
    Kind::Text(20),
    "its type, where its first bytes do not show it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, plan, testgrid",
);
const SETUP: Param = may(
    "setup",
    Kind::Object("Setup"),
    "how it is drawn or engraved: the flags of `magician draw` and `magician engrave` in snake_case, `work` (draw, engrave), and `preset`, the name of a preset that says the rest; without it the program is run as it is",
);
const PRESET: Param = needed(
    "name",
    Kind::Text(64),
    "the preset: letters, digits, - and _",
);
const JOB: Param = needed("job", Kind::Id(IdKind::Job), "the job");
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
            needed(
                "client",
                Kind::Object("ClientName"),
                "the program: `name`, and `version` if it has one",
            ),
            may("token", Kind::Text(200), "a token of the station"),
            may(
                "pupil",
                Kind::Object("Pupil"),
                "a pupil of the class signs in: `name` and `code`; instead of a token",
            ),
            may(
                "pin",
                Kind::Text(6),
                "the teacher's PIN of the class, on this machine; instead of a token",
            ),
            may(
                "resume",
                Kind::Text(200),
                "the secret of a session whose socket has ended",
            ),
            may(
                "role",
                Kind::Choice(&["viewer", "student", "teacher"]),
                "the most that the session may do, where the token allows more",
            ),
        ],
        "Begins the session. The first message of a socket, once.",
        "{session, resume, resumed, role, api, version, arms, limits}: `resumed` false where `resume` gave nothing back: the session is a new one then; `limits` are bytes of a message, messages a second, and sockets of the station",
    )
    .of_sessions(),
    method(
        "session.list",
        Viewer,
        &[],
        "The sessions of the station.",
        "{sessions: [{session, name, role, leases, since}]}",
    )
    .of_sessions(),
    method(
        "server.info",
        Viewer,
        &[],
        "The station itself.",
        "{version, api, uptime_s, arms, programs, recording, features}: `recording` whether an arm is being recorded; `features` what this station can do of what not every one can: see [features](#features)",
    ),
    method(
        "arm.list",
        Viewer,
        &[],
        "The arms of the station.",
        "{arms: [{name, port, virtual, link, holder, waiting: [{session, name, asks}], job}]}: `waiting` are the sessions that wait for the lease in their order, and those that ask its holder",
    ),
    method(
        "arm.info",
        Viewer,
        &[ARM],
        "Identity and state of an arm.",
        "as `info --json`",
    ),
    method(
        "arm.io",
        Viewer,
        &[ARM],
        "What the pins, sensors and steppers of an arm are and do, by the protocol's table: for pages that know no command.",
        "{analog: {counts, volts}, functions: [{value, name, about, watch}], pins: [{address, function, can, level, frequency, duty_cycle}], rows: [{role, command, about, asks, tells, sets}]}: `watch` is what `arm.subscribe` calls such a pin, `can` the functions that the pin's connector is made for, null where that is not known; `asks`, `tells`, `sets` are fields {name, about, unit, kind, least, most, choices: [{value, name}]}, null where the command has no such form",
    ),
    method(
        "arm.state",
        Viewer,
        &[ARM],
        "The state, read not longer ago than 100 ms.",
        "State",
    ),
    method(
        "arm.subscribe",
        Viewer,
        &[
            ARM,
            needed("rate", Kind::Integer(1, 50), "states a second"),
            may(
                "frame",
                Kind::Choice(&["json", "binary"]),
                "the form of the states; json unless given",
            ),
            may(
                "pins",
                Kind::Objects("PinAddress"),
                "pins to read as well: `kind` (input, output, analog) and `address` (1 to 20)",
            ),
        ],
        "Sends the state again and again, the newest one when several are due.",
        "{subscription, rate, fields}",
    )
    .of_sessions(),
    method(
        "arm.unsubscribe",
        Viewer,
        &[needed(
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
            needed("command", NAME, "a command of the protocol"),
            may(
                "query",
                Kind::Object("Fields"),
                "what the reading is asked for, by field",
            ),
        ],
        "Reads a value of the protocol.",
        "the fields, as `get --json`",
    ),
    method(
        "arm.set",
        Student,
        &[
            ARM,
            needed("command", NAME, "a command of the protocol"),
            may("fields", Kind::Object("Fields"), "its fields"),
            YES,
        ],
        "Sends a command that acts at once.",
        "null",
    )
    .leased(Setting),
    method(
        "arm.enqueue",
        Student,
        &[
            ARM,
            needed(
                "command",
                NAME,
                "a command of the protocol that can be queued",
            ),
            may("fields", Kind::Object("Fields"), "its fields"),
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
            needed(
                "to",
                Kind::Numbers(4, 5),
                "x, y, z (mm), r (deg), or four joints (deg); then the rail (mm) if there is one",
            ),
            may(
                "by",
                Kind::Choice(&["joint", "linear", "jump"]),
                "the path; joint unless given",
            ),
            may(
                "frame",
                Kind::Choice(&["xyz", "joints"]),
                "what `to` counts in; xyz unless given",
            ),
            may(
                "relative",
                Kind::Switch,
                "whether `to` counts from where the arm stands",
            ),
            may(
                "wait",
                Kind::Switch,
                "whether the answer comes when the arm is there; yes unless given",
            ),
        ],
        "Moves the arm, checked first.",
        "State, or {index} without `wait`",
    )
    .leased(Motion),
    method("arm.home", Student, &[ARM, YES], "Homes the arm.", "State").leased(Motion),
    method(
        "arm.clear_alarms",
        Student,
        &[ARM, YES],
        "Clears the alarms, which releases the queue.",
        "State",
    )
    .leased(Setting),
    method(
        "arm.tool",
        Student,
        &[
            ARM,
            may(
                "tool",
                TOOL,
                "the tool that is mounted, or its tip from the flange (mm)",
            ),
            may("suction", Kind::Switch, "the suction cup"),
            may(
                "gripper",
                Kind::Choice(&["open", "closed", "off"]),
                "the gripper",
            ),
            may(
                "laser",
                Kind::Object("Laser"),
                "the laser: `on`, and `power` (percent), which is 100 where it stands",
            ),
            YES,
        ],
        "Chooses the tool, or has it do something. One of the parameters beside `arm` and `yes`.",
        "State",
    )
    .leased(Setting),
    method(
        "arm.speed",
        Student,
        &[
            ARM,
            may(
                "percent",
                PERCENT,
                "share of the set speeds of moves and jogs; or `row`",
            ),
            may("row", NAME, "a command of the protocol that holds speeds"),
            may("fields", Kind::Object("Fields"), "its fields"),
        ],
        "Sets the speed of moves and jogs as a whole, also of a job that runs, or one setting of speeds.",
        "null",
    )
    .leased(JobSetting),
    method(
        "arm.alarms",
        Viewer,
        &[ARM],
        "The alarms that stand, with cause and remedy.",
        "as `alarms --json`",
    ),
    method(
        // The lowest role and no lease: anyone who sees an arm must be able to stop it.
        "arm.stop",
        Viewer,
        &[ARM],
        "Stops an arm, or all; never needs the lease, and lifts no pen.",
        "{arms: [{arm, stood, pose}]}, when they stand; an error has those that stand all the same as `arms`",
    )
    .always(),
    method(
        "arm.fence",
        Viewer,
        &[
            ARM,
            may(
                "set",
                Kind::Either(&[Kind::Object("FenceChange"), Kind::Null]),
                "the members to change: `floor` (mm), `box` {x, y, z: [least, most]} (mm), `keep_out` (boxes), `speed` (mm/s), `power` (percent), each or all null for no bound; for teachers",
            ),
        ],
        "The fence of an arm: what crosses it is refused as `unreachable`. A change ends what is under way.",
        "{fence}: null without one",
    ),
    method(
        "arm.model",
        Viewer,
        &[ARM],
        "The arm as a chain of links, its limits and its tool, for pages that draw it.",
        "{frame, links: [{name, parent, joint, axis, at, shape, size, turn, color}], limits, tool}",
    ),
    method(
        "events.since",
        Viewer,
        &[
            ARM,
            needed(
                "seq",
                Kind::Integer(0, i64::MAX),
                "the last event that is known; 0 for all",
            ),
        ],
        "Earlier events of an arm, 1000 at most.",
        "{events, seq}",
    ),
    method(
        "lease.acquire",
        Student,
        &[
            ARM,
            may(
                "wait_s",
                // The bound is `LONGEST_WAIT` of control.
                Kind::Number(0.0, 3600.0),
                "how long to wait for it, s; 0 unless given: then, and when the time is over, it is refused with -32002",
            ),
        ],
        "Asks for the lease of an arm: the right to move it.",
        "{arm, lease, ttl_s}",
    )
    .of_sessions(),
    method(
        "lease.renew",
        Student,
        &[needed("lease", Kind::Id(IdKind::Lease), "the lease")],
        "Says that its holder is there; any message does.",
        "null",
    )
    .of_sessions(),
    method(
        "lease.release",
        Student,
        &[needed("lease", Kind::Id(IdKind::Lease), "the lease")],
        "Gives it back; answered in the same way if it has ended already. What the arm has queued goes on; a jog, stepper motors and \
         the belt are stopped, and a job pauses unless its `on_lost` says otherwise.",
        "null",
    )
    .of_sessions(),
    method(
        "lease.ask",
        Student,
        &[
            ARM,
            may("message", Kind::Text(200), "a sentence for the holder"),
        ],
        "Asks the holder for the lease. Without an answer in 20 s it is granted.",
        "{granted, lease, ttl_s}: `granted` false, and nothing else, if the holder says no",
    )
    .of_sessions(),
    method(
        "lease.answer",
        Student,
        &[
            ARM,
            needed("session", Kind::Id(IdKind::Session), "the session that asks"),
            needed("grant", Kind::Switch, "whether it gets the lease"),
        ],
        "Answers a session that asks.",
        "null",
    )
    .of_sessions(),
    method(
        "lease.take",
        Teacher,
        &[ARM],
        "Takes the lease away from its holder, at once.",
        "{arm, lease, ttl_s}",
    )
    .of_sessions(),
    method(
        "jog.start",
        Student,
        &[
            ARM,
            needed(
                "axis",
                Kind::Choice(JOGS),
                "axis, joint or rail, and the direction",
            ),
            may(
                "keep_ms",
                // A choice: below 100 ms a slow network ends jogs, and above 1 s the arm moves too
                // long after its client is gone.
                Kind::Integer(100, 1000),
                "how long it goes on without being kept up, ms; 250 unless given",
            ),
            may("percent", PERCENT, "share of the set jog speed"),
        ],
        "Jogs until it is stopped, or is not kept up.",
        "{jog}",
    )
    .leased(Motion)
    .of_sessions(),
    method(
        // Sent several times per second. An answer to each would only load the line.
        "jog.keep",
        Viewer,
        &[needed("jog", Kind::Id(IdKind::Jog), "the jog")],
        "Keeps a jog up. A notification: it has no answer.",
        "nothing",
    )
    .always()
    .of_sessions(),
    method(
        "jog.stop",
        Viewer,
        &[
            ARM,
            may("jog", Kind::Id(IdKind::Jog), "the jog; that of the arm unless given"),
        ],
        "Stops a jog, also one whose `jog.start` is not answered yet.",
        "{stood, pose}, when the arm stands",
    )
    .always()
    .of_sessions(),
    method(
        "jog.step",
        Student,
        &[
            ARM,
            needed("axis", Kind::Choice(AXES), "axis, joint or rail"),
            needed("by", ANY, "how far, with its sign: mm or deg"),
            may(
                "frame",
                Kind::Choice(&["base", "tool"]),
                "the frame of x and y: base, or turned by r; base unless given",
            ),
            may("percent", PERCENT, "share of the set speeds of moves"),
        ],
        "Moves by a step, checked first.",
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
            may(
                "preview",
                Kind::Switch,
                "whether `preview` has what it leaves: `{strokes: [{points, height, part, power, reachable}], travels}`, of no more than 20,000 points each; `part` is the number of one of `parts`, or null; `power` of the laser in percent, 100 of ink",
            ),
        ],
        "Checks a program from where the arm stands; nothing moves.",
        "Report: as `run --check --json`, and `parts`, the first 256, as `run --list-parts --json`: `seconds` is null in a program that is not divided into them; `digest` is for `job.start`",
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
            may(
                "from",
                Kind::Integer(1, i64::MAX),
                "the first step, counted from 1 over all loops",
            ),
            may(
                "loops",
                Kind::Integer(0, i64::MAX),
                "how often; 0 until it is stopped, 1 unless given",
            ),
            may(
                "keep",
                Kind::Switch,
                "whether what is in the queue is done first",
            ),
            may(
                "require_homed",
                Kind::Switch,
                "whether an arm that was not homed is refused",
            ),
            UNHOMED,
            YES,
            may(
                "on_lost",
                Kind::Choice(&["pause", "stop", "continue"]),
                "what becomes of it when the lease ends; pause unless given, continue without a session",
            ),
            may(
                "queue",
                Kind::Switch,
                "whether it waits, without the lease, until the arm is free of jobs and of others' turns; then it is checked again",
            ),
            may(
                "after_check",
                Kind::Switch,
                "whether the answer comes when the check is over; yes unless given",
            ),
            may(
                "key",
                Kind::Text(64),
                "a name of the caller's choice, such as a UUID: a second start with the same key starts nothing and answers as the first, also by a later server; with another program, `digest`, `setup`, `loops`, `from`, `keep`, `require_homed` or `unhomed` it is refused. Each arm has its keys",
            ),
            may(
                "digest",
                Kind::Text(64),
                "the `digest` of the check that a person has seen: it starts nothing, with -32009, if the program, or the preset that `setup` names, has changed since",
            ),
        ],
        "Checks a program and runs it. What is answered is on the disk.",
        "{job}",
    )
    .leased(StartJob),
    method(
        "job.get",
        Viewer,
        &[JOB],
        "A job, also one that is over.",
        "Job",
    ),
    method(
        "job.list",
        Viewer,
        &[ARM],
        "The last 50 jobs of an arm, the newest last.",
        "{jobs: [Job]}",
    ),
    method(
        "job.pause",
        Student,
        &[JOB],
        "Pauses a job: nothing of it waits in the arm, the laser is off, the pen is up. The arm may be moved then.",
        "Job, when it is paused",
    )
    .leased(SteerJob),
    method(
        "job.resume",
        Student,
        &[
            JOB,
            may(
                "approach",
                Kind::Switch,
                "whether the arm may have been moved since; yes unless given",
            ),
            may(
                "overlap",
                Kind::Number(0.0, 1000.0),
                "how far before the place where the light of a burn went out it begins, along its line, mm; 0 unless given",
            ),
            YES,
        ],
        "Goes on with a job that is paused, or that ended before its end.",
        "Job, when it runs",
    )
    .leased(SteerJob),
    method(
        "job.stop",
        Viewer,
        &[JOB],
        "Stops a job, and lifts its pen; never needs the lease.",
        "Job, when it is over",
    )
    .always(),
    method(
        "job.history",
        Viewer,
        &[
            ARM,
            may(
                "skip",
                // 500 jobs per arm are kept (`KEPT` in `station/store.rs`).
                Kind::Integer(0, 500),
                "so many of the newest are left out; 0 unless given",
            ),
            may("limit", Kind::Integer(1, 500), "so many at most; 50 unless given"),
        ],
        "The jobs of an arm that are kept, the newest last, and sums over all that ran.",
        "{jobs: [Job], more, totals: {jobs, done, stopped, failed, interrupted, drawn_mm, travel_mm, seconds}}: `more` is true if older ones are kept; `totals` also count jobs that are not kept any more",
    ),
    method(
        "job.reorder",
        Student,
        &[
            JOB,
            needed(
                "position",
                Kind::Integer(1, i64::MAX),
                "its new `place`, from 1; more than there are is the last",
            ),
        ],
        "Gives a job that waits another place in the queue of its arm; one that waits no more is answered as it is.",
        "Job",
    ),
    method(
        "job.delete",
        Teacher,
        &[JOB],
        "Takes a job that is over out of the list. It counts in the totals all the same.",
        "null",
    ),
    method(
        // Needs no lease, because the library belongs to no arm.
        "program.put",
        Student,
        &[NAMED, TEXT, DATA, REPLACE],
        "Keeps a program in the library.",
        "{name, bytes}",
    ),
    method(
        "program.list",
        Viewer,
        &[],
        "The programs of the library.",
        "{programs: [{name, bytes, modified, format}]}",
    ),
    method(
        "program.get",
        Viewer,
        &[NAMED],
        "A program of the library; one above 700 KiB comes by GET alone.",
        "{name, format, data}: base64",
    ),
    method(
        "program.convert",
        Student,
        &[
            NAMED,
            needed(
                "to",
                NAME,
                "the name of the new program, whose ending says what it becomes: .plan.json, .playback, .svg, .png, .csv",
            ),
            SETUP,
            REPLACE,
        ],
        "Makes another file of a program, and keeps it in the library.",
        "as `convert --json`",
    ),
    method(
        "program.options",
        Viewer,
        &[
            needed("format", Kind::Text(20), "a format, as `program.list` has it"),
            may("all", Kind::Switch, "whether all options come that count for it, not only the usual ones"),
        ],
        "What a person is asked before a program of this format is done: members of `setup`, the usual ones first.",
        "{options: [Option]}: the range of a number is `least` or `above` to `most`; `default` holds where it is not given, null if that depends; with `with` it counts only where that other option has one of the values `when`, or is on where `when` is empty, and that one counts itself; `work` is no option of this list: where it is not given the laser engraves and every other tool draws; `group` is for folding them",
    ),
    method(
        "program.delete",
        Student,
        &[NAMED],
        "Removes a program from the library.",
        "null",
    ),
    method(
        "preset.save",
        Student,
        &[
            PRESET,
            may("setup", Kind::Object("Setup"), "what it says, as `job.check` takes it; or `text`"),
            may("note", Kind::Text(500), "what is told to people who use it; beside `setup`"),
            may("text", Kind::Text(65536), "a file of a preset, TOML; or `setup`"),
        ],
        "Keeps options under a name; what was kept under it is replaced. It goes before one of this name that comes with this program.",
        "as `preset.show`",
    ),
    method(
        "preset.list",
        Viewer,
        &[],
        "The presets of drawing and engraving, for `setup.preset`: those that come with this program first.",
        "{presets: [{name, shipped, note, path}]}: one that is wrong has a `problem`",
    ),
    method(
        "preset.show",
        Viewer,
        &[PRESET],
        "What a preset says.",
        "{name, shipped, note, path, options, text}: `options` as in `setup`, `text` as a file has it",
    ),
    method(
        "preset.remove",
        Student,
        &[PRESET],
        "Removes a preset that was kept; one that comes with this program stays.",
        "null",
    ),
    method(
        "surface.touch",
        Student,
        &[
            ARM,
            may(
                "add",
                Kind::Switch,
                "adds the touch to those before: from three on the plane through them is tilted as the table is",
            ),
            may(
                "forget",
                Kind::Switch,
                "forgets what was measured, a sheet as well, instead of taking it",
            ),
            UNHOMED,
        ],
        "Takes the height of the work surface from where the tool touches it, and keeps it for drawings, engravings and what else lies on it. The arm has to stand, with the laser off. Three touches within 30 mm or nearly in line are refused.",
        "{touches, plane: {at, z, slope_x, slope_y}, residual, corners, sheet}: the surface has the height `z` (mm) at `at` [x, y], and rises by `slope_x` and `slope_y` per mm; no touch is farther from it than `residual` (mm); `plane` and `residual` are null after `forget`; `corners` and `sheet` as `surface.corner`",
    )
    .leased(Setting),
    method(
        "surface.corner",
        Student,
        &[
            ARM,
            needed(
                "corner",
                Kind::Choice(SHEET_CORNERS),
                "which one it is, for the reader of the paper",
            ),
            UNHOMED,
        ],
        "Takes a corner of a sheet of paper from where the tool touches it. With the third one the sheet is kept, with its height and tilt: drawings lie on it then, upright for its reader. Corners within 30 mm, nearly in line or without a right angle are refused, and what was taken before stays. The arm has to stand, with the laser off.",
        "as `surface.touch`: `corners` are those that are taken of a sheet that is not complete; `sheet` {corner, rotation, size, outline} has its lower left corner, degrees from the arm's X to its lower edge, width and height (mm), and four corners, or is null",
    )
    .leased(Setting),
    method(
        "surface.get",
        Viewer,
        &[ARM],
        "The height of the work surface that was touched.",
        "as `surface.touch`; `plane` null if none was",
    ),
    method(
        "teach.capture",
        Student,
        &[
            ARM,
            may(
                "by",
                Kind::Choice(&["joint", "linear", "jump"]),
                "how the step is reached; joint unless given",
            ),
            UNHOMED,
        ],
        "A step of a program that leads to where the arm stands.",
        "{step}, as in plan files",
    ),
    method(
        "teach.guide",
        Student,
        &[
            ARM,
            needed("on", Kind::Switch, "whether it tells; it ends with the lease as well"),
            UNHOMED,
        ],
        "Has the arm tell where its unlock key is released: each time an event `hand-trigger` with the `step` that leads there.",
        "null",
    )
    .leased(Setting),
    method(
        "teach.rows",
        Viewer,
        &[needed("plan", Kind::Object("Plan"), "a plan, as in plan files")],
        "A plan as rows of a table: in each where the arm goes, what its tool does there, and how long it stays.",
        "{title, tool, surface, rows: [{name, motion, gripper, suction, wait}]}: `motion` is a step as in plan files, the others the members of such steps, or null",
    ),
    method(
        "teach.output",
        Viewer,
        &[
            needed("address", Kind::Integer(1, 20), "the pin"),
            needed("high", Kind::Switch, "its level"),
        ],
        "A step of a program that sets the level of an output.",
        "{step}, as in plan files",
    ),
    method(
        "teach.plan",
        Viewer,
        &[
            may("title", Kind::Text(200), "what the plan is called"),
            may("tool", Kind::Either(&[TOOL, Kind::Null]), "the tool whose tip is at the points"),
            may(
                "surface",
                Kind::Either(&[Kind::Object("Surface"), Kind::Null]),
                "the surface that it works on, as in plan files",
            ),
            needed("rows", Kind::Objects("GivenRow"), "as `teach.rows` has them"),
        ],
        "The plan of rows. What is wrong names its row in `data.row`.",
        "{plan, first}: how many steps of the plan come before each row",
    ),
    method(
        "world.look",
        Viewer,
        &[
            ARM,
            may(
                "mark",
                NAME,
                "the `mark` of an earlier look: while the drawing is the same, `drawing` and `strokes` are null",
            ),
        ],
        "The world around a virtual arm. This and its kin are `unsupported` of other arms.",
        "{objects: [{name, at, turn, size, color, held}], title, table: {height, x, y}, draws: \"pen\" or \"laser\", belt: {start, direction, length, width, height, travel}, drawing: SVG, strokes: [{burnt, power, points: [[x, y]]}], mark, unlocked, plugged}; `table` and `belt` null where the scenario has no such thing, `draws` null where its tool leaves no lines; `power` of the laser in percent, 100 of ink",
    ),
    method(
        "world.scenarios",
        Viewer,
        &[ARM],
        "The scenarios that need no file, for `world.scenario`.",
        "{scenarios: [{name, title, text}]}",
    ),
    method(
        "world.press",
        Student,
        &[
            ARM,
            may("long", Kind::Switch, "whether the key is held: it homes the arm"),
        ],
        "Presses the key at the base: it runs the program that the arm keeps, or stops it.",
        "null",
    )
    .leased(Setting),
    method(
        "world.unlock",
        Student,
        &[ARM, needed("held", Kind::Switch, "whether it is held")],
        "Holds or releases the unlock key: while it is held the arm can be guided.",
        "null",
    )
    .leased(Setting),
    method(
        "world.unplug",
        Student,
        &[ARM, needed("plugged", Kind::Switch, "whether the cable is in")],
        "Pulls the cable, or plugs it in again.",
        "null",
    )
    .leased(Setting),
    method(
        "world.guide",
        Student,
        &[
            ARM,
            needed(
                "joints",
                Kind::Numbers(4, 4),
                "where the joints are bent to, deg, as far as they go",
            ),
        ],
        "Moves the arm by hand, while the unlock key is held.",
        "State",
    )
    .leased(Setting),
    method(
        "world.scenario",
        Teacher,
        &[ARM, needed("text", PROGRAM, "a scenario, TOML")],
        "Switches the arm off, and on again in the world of a scenario.",
        "{objects: [name]}",
    )
    .leased(Setting),
    method(
        "world.place",
        Student,
        &[
            ARM,
            needed("name", NAME, "the object"),
            needed(
                "at",
                Kind::Numbers(3, 3),
                "x, y, z of the middle of its underside, mm; it falls onto what is below",
            ),
        ],
        "Puts an object somewhere, by hand.",
        "null",
    )
    .leased(Setting),
    method(
        "world.paper",
        Student,
        &[ARM],
        "Lays a new sheet of paper: what pen and laser have left so far is gone. Refused while a job is under way.",
        "null",
    )
    .leased(Setting),
    method(
        "world.input",
        Student,
        &[
            ARM,
            needed("address", Kind::Integer(1, 20), "EIO address"),
            may("level", Kind::Switch, "whether it is high; or `value`"),
            may("value", Kind::Integer(0, 4095), "its voltage in counts, 4095 at 3.3 V"),
        ],
        "Drives an input from outside: from now on it reads this.",
        "null",
    )
    .leased(JobSetting),
    method(
        "world.fault",
        Student,
        &[
            ARM,
            needed(
                "fault",
                Kind::Choice(&["alarm", "slip", "reset"]),
                "an alarm, a joint that slips, or a reset of the controller",
            ),
            may("alarm", Kind::Integer(0, 255), "code of the alarm"),
            may("joint", Kind::Integer(1, 4), "the joint that slips; 1 unless given"),
            may("degrees", Kind::Number(-90.0, 90.0), "by how much, deg"),
        ],
        "Lets something go wrong, also while a job runs.",
        "null",
    )
    .leased(JobSetting),
    method(
        "record.start",
        Student,
        &[
            ARM,
            may(
                "rate",
                Kind::Integer(1, 50),
                "readings a second; 20 unless given",
            ),
        ],
        "Records an arm into a file, until `record.stop`.",
        "{name}, for GET /api/v1/recordings/{name}",
    ),
    method(
        "record.stop",
        Student,
        &[ARM],
        "Ends the recording of an arm.",
        "{name, seconds, bytes}",
    ),
    method(
        "record.save_last",
        Student,
        &[
            ARM,
            // The history covers 600 s (`KEPT` in `station/recordings.rs`).
            needed("seconds", Kind::Number(1.0, 600.0), "how far back, s"),
        ],
        "Writes what is kept of an arm's last minutes into a file: readings, what passed on its line, and what happened.",
        "{name}",
    ),
    method(
        "motion.forward",
        Viewer,
        &[
            needed("joints", Kind::Numbers(4, 4), "the joints, deg"),
            OF_TOOL,
        ],
        "The pose of joints, by the arm's geometry.",
        "{x, y, z, r}",
    ),
    method(
        "motion.inverse",
        Viewer,
        &[
            needed("pose", Kind::Numbers(4, 4), "x, y, z (mm) and r (deg)"),
            OF_TOOL,
        ],
        "The joints of a pose; refused where the arm does not get there.",
        "{j1, j2, j3, j4}",
    ),
    method(
        "motion.reach",
        Viewer,
        &[needed("z", ANY, "the height of the tip, mm"), OF_TOOL],
        "What the tip reaches at a height.",
        "{outlines: [[[x, y]]]}, closed",
    ),
];
