//! Table of the objects in messages. Schemas, documentation and the types of other languages are
//! derived from it. The table stays in one file, however long.

use super::IdKind::{Job, Jog, Lease, Session};
use super::shape::{Member, Shape, Type, is};
use Shape::{Choice, Count, Either, Id, List, Number, Object, Several, Switch, Text};

/// States of a job.
pub(crate) const JOB_STATES: &[&str] = &[
    "queued",
    "checking",
    "running",
    "pausing",
    "paused",
    "stopping",
    "done",
    "stopped",
    "failed",
    "interrupted",
];
/// Reasons why a job is paused, or does not start although it is its turn.
pub(crate) const REASONS: &[&str] = &[
    "person", "part", "program", "stopped", "yes", "restart", "unkept",
];
pub(crate) const ROLES: &[&str] = &["viewer", "student", "teacher"];
pub(crate) const SHEET_CORNERS: &[&str] = &["lower-left", "lower-right", "upper-left"];
const LINKS: &[&str] = &["up", "lost"];
const GRIPPERS: &[&str] = &["open", "closed", "off"];
const TOOLS: &[&str] = &["none", "suction", "gripper", "pen", "laser"];
const PIN_KINDS: &[&str] = &["input", "output", "analog"];
const TURN_STATES: &[&str] = &["running", "kept", "suspended"];

const TOOL_NAME: Shape = Choice(TOOLS);
const BIAS: Shape = Several(3, &Number);
/// Refers to a type by name.
const fn of(name: &'static str) -> Shape {
    Shape::Type(name)
}

const X: Member = is("x", Number, "position of the tool tip").in_unit("mm");
const Y: Member = is("y", Number, "position of the tool tip").in_unit("mm");
const Z: Member = is("z", Number, "position of the tool tip").in_unit("mm");
const R: Member = is("r", Number, "rotation of the tool").in_unit("deg");
const J1: Member = is("j1", Number, "joint 1, the base").in_unit("deg");
const J2: Member = is("j2", Number, "joint 2, the rear arm").in_unit("deg");
const J3: Member = is("j3", Number, "joint 3, the forearm").in_unit("deg");
const J4: Member = is("j4", Number, "joint 4, the tool").in_unit("deg");
const JOB_ID: Member = is("job", Id(Job), "current job").null("no job is in progress");
const FREE: &str = "the arm is free";

/// State of an arm. A change contains the members that differ, and `t`.
const STATE: &[Member] = &[
    is("t", Number, "time of the reading, by the station's clock").in_unit("Unix seconds"),
    is("arm", Text, "name of the arm"),
    X,
    Y,
    Z,
    R,
    J1,
    J2,
    J3,
    J4,
    is("rail", Number, "position on the rail")
        .in_unit("mm")
        .null("the arm has no rail"),
    is("current_index", Count, "queue index of the last finished command"),
    is(
        "left_space",
        Count,
        "free places in the arm's queue; 0 if it is full, and the station waits. The size of the queue \
         depends on the firmware; the virtual arm has 32 places",
    )
    .in_unit("commands"),
    is("alarms", List(&Count), "codes of the active alarms; `arm.alarms` explains them"),
    is("link", Choice(LINKS), "state of the line to the arm"),
    is("moving", Switch, "true if the arm moves, or may move"),
    is("homed", Switch, "true if homed since power-up; false if it reported a reset and was not homed since")
        .null("unknown: no reset was reported, and this computer saw no homing"),
    is("tool", of("Tool"), "state of the tools"),
    is("speed", Number, "speed ratio of moves")
        .in_unit("percent")
        .null("unknown: neither read nor set on this connection"),
    is(
        "pins",
        List(&of("Pin")),
        "pins watched by subscribers of the arm",
    ),
    JOB_ID,
    is("jog", Id(Jog), "current jog").null("no jog is in progress"),
    is("holder", of("Holder"), "holder of the lease, who may move the arm").null(FREE),
];

/// Details of an error. Which of them are present depends on its kind.
pub(super) const ERROR_DATA: &[Member] = &[
    is("kind", Text, "kind from the table of errors").optional(),
    is(
        "code",
        Text,
        "identity of the error: programs decide by it, not by the message",
    )
    .optional(),
    is("param", Text, "name of the invalid parameter").optional(),
    is("row", Count, "invalid row of `teach.plan`, from 1").optional(),
    is("method", Text, "method that helps, or that is concerned").optional(),
    is("command", Text, "command of the protocol").optional(),
    is(
        "danger",
        Choice(&["laser", "arm"]),
        "danger that `yes` confirms",
    )
    .optional(),
    is("step", Count, "step of the program, from 1").optional(),
    is("value", Number, "requested value").optional(),
    is("limit", Number, "limit of the value, or of the number").optional(),
    is("unit", Text, "unit of both").optional(),
    is("fence", Text, "bound of the fence that would be crossed").optional(),
    is("from", Count, "first index or step in doubt").optional(),
    is("to", Count, "last index or step in doubt").optional(),
    is("remedies", List(&of("Remedy")), "possible remedies").optional(),
    is(
        "template",
        Text,
        "message with the names of its values in braces: key for translations",
    )
    .optional(),
    is(
        "values",
        List(&of("SentenceValue")),
        "values in the template",
    )
    .optional(),
    is("report", of("Report"), "result of the check of the program").optional(),
    is("digest", Text, "current digest of the program").optional(),
    is("expected", of("Pose"), "expected pose").optional(),
    is("pose", of("Pose"), "current pose").optional(),
    is(
        "arm",
        Text,
        "arm that is frozen, or reserved by the schedule",
    )
    .optional(),
    is("until", Number, "end of the reservation, Unix time")
        .in_unit("s")
        .null("unknown")
        .optional(),
    is("arms", List(&of("Stood")), "arms that stand nevertheless").optional(),
    is("role", Choice(ROLES), "role of the session").optional(),
    is("needs", Choice(ROLES), "required role").optional(),
    is(
        "may",
        List(&Choice(&["owner", "holder", "teacher"])),
        "who may change a queued job: its owner, the holder of the lease, a teacher",
    )
    .optional(),
    is("wait_s", Number, "time until codes are accepted again")
        .in_unit("s")
        .optional(),
    is("quota", of("LibraryUse"), "quota of the library").optional(),
    is("used", of("LibraryUse"), "used part of the quota").optional(),
    is("holder", of("Holder"), "holder of the lease")
        .null(FREE)
        .optional(),
    is(
        "free_in_s",
        Number,
        "time until the lease of a holder without a socket ends",
    )
    .in_unit("s")
    .optional(),
    is("reason", Choice(&["unkept"]), "the disk could not store it").optional(),
    is("by", Id(Session), "session that stopped it")
        .null("not stopped by a session")
        .optional(),
    is("job", Id(Job), "job that has the arm").optional(),
    is("jog", Id(Jog), "jog that has the arm").optional(),
    is("recording", Text, "recording in progress").optional(),
];

/// Error of a job, which has its message among the details.
const JOB_ERROR: &[Member] = &{
    let mut all = [ERROR_DATA[0]; ERROR_DATA.len() + 1];
    let mut at = 0;
    while at < ERROR_DATA.len() {
        all[at] = ERROR_DATA[at];
        at += 1;
    }
    all[at] = is("message", Text, "cause, as a sentence");
    all
};

const BOX: &[Member] = &[
    is("x", Several(2, &Number), "least and most").in_unit("mm"),
    is("y", Several(2, &Number), "least and most").in_unit("mm"),
    is("z", Several(2, &Number), "least and most").in_unit("mm"),
];
const NO_BOUND: &str = "no bound";

const JOB_REASONS: &[&str] = &[
    "yes", "stopped", "restart", "unkept", "frozen", "schedule", "turn", "busy", "lost",
];

/// Turns of a class.
pub(super) const TURNS: &[Member] = &[
    is("turn_s", Number, "length of a turn; 0 for unlimited turns")
        .in_unit("s")
        .null("there are no turns"),
    is(
        "arms",
        List(&Object(&[
            is("arm", Text, "name of the arm"),
            is("person", Text, "person whose turn it is").null("no turn"),
            is(
                "state",
                Choice(TURN_STATES),
                "kept: the person is away; suspended: a teacher has the arm",
            )
            .null("no turn"),
            is("left_s", Number, "time left in the turn")
                .in_unit("s")
                .null("unlimited, or no turn"),
            is("frozen", Switch, "true if a teacher has frozen the arm"),
            is(
                "jobs",
                List(&Object(&[
                    is("job", Id(Job), "id of the job"),
                    is("title", Text, "title").null("no title"),
                    is("person", Text, "owner").null("a teacher"),
                    is(
                        "reason",
                        Choice(JOB_REASONS),
                        "reason for waiting: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is frozen; schedule: no slot of its owner is open; turn: another person's turn; busy: the arm moves, or its lease is taken; lost: the line to the arm is lost",
                    )
                    .null("only the jobs before it"),
                ])),
                "jobs queued for the arm, in order",
            ),
            is(
                "slot",
                Object(&[
                    is("who", List(&Text), "who may acquire the arm: pupils, groups, tokens, or teacher"),
                    is("until", Number, "end, Unix time")
                        .in_unit("s")
                        .null("unlimited"),
                ]),
                "open slot of the schedule",
            )
            .null("free for all, or no slot is open"),
            is("free_at", Number, "begin of the next slot, Unix time")
                .in_unit("s")
                .null("available now, or no slot is known"),
        ])),
        "arms of the station",
    ),
    is(
        "queue",
        List(&Object(&[
            is("place", Count, "place, from 1"),
            is("person", Text, "person that waits"),
            is("arms", List(&Text), "acceptable arms"),
            is(
                "missed",
                Switch,
                "true if a turn came while the person was away",
            ),
            is(
                "reason",
                Choice(&["schedule", "frozen", "away"]),
                "reason for waiting: no slot of the person is open, all acceptable arms are frozen, or the person is away",
            )
            .null("only the persons before it"),
            is("from", Number, "begin of the person's next slot, Unix time")
                .in_unit("s")
                .null("no reservation, or no slot"),
        ])),
        "waiting persons, in order",
    ),
];

/// Row of a plan.
const ROW: &[Member] = &[
    is("name", Text, "name of the row"),
    is("motion", of("PlanStep"), "step as in plan files").null("the arm stays"),
    is(
        "gripper",
        Choice(&["off", "open", "close"]),
        "action of the gripper",
    )
    .null("unchanged"),
    is("suction", Switch, "action of the suction cup").null("unchanged"),
    is("wait", Number, "waiting time")
        .in_unit("s")
        .null("no wait"),
];

/// Turns in the answer of `turn.list`.
const TURN_LIST: &[Member] = &[
    TURNS[0],
    TURNS[1],
    TURNS[2],
    is(
        "you",
        Object(&[
            is("person", Text, "name under which the caller takes turns").null("none"),
            is(
                "arms",
                List(&Text),
                "arms meant by `turn.join` without `arm`",
            ),
        ]),
        "the caller",
    )
    .optional(),
];

/// All named types, in documentation order.
pub static TYPES: &[Type] = &[
    Type {
        name: "State",
        about: "Latest state of an arm.",
        members: STATE,
    },
    Type {
        name: "Tool",
        about: "State of the tools of an arm, derived from the commands sent to it; null means unknown.",
        members: &[
            is("name", TOOL_NAME, "mounted tool")
                .null("unknown, or no named tool has this tip"),
            is("bias", BIAS, "offset of the tip from the flange, x, y, z")
                .in_unit("mm")
                .null("unknown"),
            is("suction", Switch, "true if the suction cup is on").null("unknown"),
            is("gripper", Choice(GRIPPERS), "state of the gripper; off: its pump is off").null("unknown"),
            is("laser", Switch, "true if the laser may burn by the last known command")
                .null("unknown"),
        ],
    },
    Type {
        name: "Pin",
        about: "Level of a watched pin.",
        members: &[
            is("kind", Choice(PIN_KINDS), "kind of reading"),
            is("address", Count, "EIO address, 1 to 20"),
            is("value", Count, "0 or 1; for an analog input counts, 4095 at 3.3 V"),
        ],
    },
    Type {
        name: "Holder",
        about: "Session that holds the lease of an arm.",
        members: &[
            is("session", Id(Session), "id of the session"),
            is("name", Text, "name of the session"),
        ],
    },
    Type {
        name: "Pose",
        about: "Pose of an arm.",
        members: &[X, Y, Z, R, J1, J2, J3, J4],
    },
    Type {
        name: "LibraryUse",
        about: "Use of the library of programs.",
        members: &[
            is("programs", Count, "number of programs"),
            is("bytes", Count, "total size").in_unit("bytes"),
        ],
    },
    Type {
        name: "Stood",
        about: "Arm at standstill after a stop.",
        members: &[
            is("arm", Text, "name of the arm"),
            is("stood", Switch, "true if two consecutive readings were equal"),
            is("pose", of("Pose"), "pose of the arm"),
        ],
    },
    Type {
        name: "Lease",
        about: "Granted lease.",
        members: &[
            is("arm", Text, "name of the arm"),
            is("lease", Id(Lease), "id, for `lease.renew` and `lease.release`"),
            is("ttl_s", Number, "lease timeout: the lease ends if the holder sends nothing for this long").in_unit("s"),
        ],
    },
    Type {
        name: "Session",
        about: "Session of the station.",
        members: &[
            is("session", Id(Session), "id of the session"),
            is("name", Text, "name of the session"),
            is("role", Choice(ROLES), "role of the session"),
            is("leases", List(&Text), "arms whose lease it holds"),
            is("since", Number, "begin of the session").in_unit("Unix seconds"),
        ],
    },
    Type {
        name: "Job",
        about: "Job, in progress or finished.",
        members: &[
            is("job", Id(Job), "id, never reused"),
            is("arm", Text, "name of the arm"),
            is("title", Text, "title of the program").null("not read yet, or no title"),
            is("state", Choice(JOB_STATES), "state; from `done` on the job has ended"),
            is("step", Count, "finished steps of loop `loop`; the pair never decreases"),
            is("steps", Count, "steps of one loop").null("not read yet"),
            is("first_step", Count, "first step, from 1").null("not read yet"),
            is("loops", Count, "number of repetitions; 0 until stopped"),
            is("loop", Count, "current loop, from 1"),
            is("seconds_left", Number, "estimated time left")
                .in_unit("s")
                .null("unknown, or unlimited"),
            is("drawn_mm", Number, "drawn or burnt length")
                .in_unit("mm")
                .null("not done"),
            is("travel_mm", Number, "length of travel moves")
                .in_unit("mm")
                .null("not done"),
            is("started", Number, "start time")
                .in_unit("Unix seconds")
                .null("queued"),
            is("ended", Number, "end time")
                .in_unit("Unix seconds")
                .null("not ended"),
            is("holder", of("Holder"), "owner of the job").null("unknown"),
            is("part", Count, "next part, from 1").null("not waiting between parts"),
            is(
                "reason",
                Choice(REASONS),
                "for a `paused` job: `person`: on request, or because the lease ended; `part`: a part is done; `program`: the program \
                 asks for it. For a `queued` job that does not start by itself: `stopped`: the arm was stopped; `yes`: it may burn or \
                 is dangerous, and needs `job.resume` with `yes`; `restart`: the station was restarted; `unkept`: the disk could \
                 not store its start. `job.resume` continues all of them",
            )
            .null("neither paused nor held back"),
            is("text", Text, "instruction for the person at the arm before the job continues").null("no instruction"),
            is("place", Count, "place in the queue of its arm, from 1").null("not queued"),
            is("error", of("JobError"), "cause of the failure or interruption").null("not failed"),
            is("notes", List(&of("Note")), "outputs left switched on, and grips of a virtual arm that picked nothing up").null("no notes"),
            is("digest", Text, "digest of its program, as from `job.check`").null("not read yet"),
        ],
    },
    Type {
        name: "JobError",
        about: "Cause of a failed job: `data` of the error, and its message.",
        members: JOB_ERROR,
    },
    Type {
        name: "ErrorData",
        about: "`data` of an error. Its members depend on the kind: see the table of errors.",
        members: ERROR_DATA,
    },
    Type {
        name: "Remedy",
        about: "Remedy for an error: one of `action`, `option`, `without` and `system`.",
        members: &[
            is("action", Text, "action, such as `home`, `clear-alarms`").optional(),
            is("option", Text, "option to set").optional(),
            is("value", Either(&[Number, Switch, Text, List(&Number)]), "value of the option; without it the user chooses one").optional(),
            is("without", Text, "option to leave out").optional(),
            is("system", Text, "shell command for the station's machine").optional(),
            is("effect", Text, "effect").optional(),
        ],
    },
    Type {
        name: "SentenceValue",
        about: "Value in a template: one of `text`, `option` and `template`.",
        members: &[
            is("name", Text, "name in the template"),
            is("text", Text, "number or quotation, as printed").optional(),
            is("option", Text, "name of an option, which a client may translate").optional(),
            is("template", Text, "nested template").optional(),
            is("values", List(&of("SentenceValue")), "values of the nested template").optional(),
        ],
    },
    Type {
        name: "Turns",
        about: "Turns and queue of a class.",
        members: TURNS,
    },
    Type {
        name: "TurnList",
        about: "Turns, with the caller's own part.",
        members: TURN_LIST,
    },
    Type {
        name: "ClientName",
        about: "Client program that begins a session.",
        members: &[
            is("name", Text, "name, 1 to 80 characters"),
            is("version", Text, "version, up to 80 characters").optional(),
        ],
    },
    Type {
        name: "Pupil",
        about: "Sign-in of a pupil.",
        members: &[is("name", Text, "name of the pupil"), is("code", Text, "code of the pupil")],
    },
    Type {
        name: "ExpectedArm",
        about: "Arm expected on a site.",
        members: &[
            is("arm", Text, "name of the arm"),
            is("machine", Text, "machine of its station").optional(),
        ],
    },
    Type {
        name: "PinAddress",
        about: "Pin to watch.",
        members: &[
            is("kind", Choice(PIN_KINDS), "kind of reading"),
            is("address", Count, "EIO address, 1 to 20"),
        ],
    },
    Type {
        name: "Laser",
        about: "Command for the laser.",
        members: &[
            is("on", Switch, "true to switch it on"),
            is("power", Number, "0 to 100; while the arm stands only 100 is possible, less is `unsupported`")
                .in_unit("percent")
                .optional(),
        ],
    },
    Type {
        name: "Box",
        about: "Axis-aligned box.",
        members: BOX,
    },
    Type {
        name: "Fence",
        about: "Bounds of an arm: position, speed and laser power.",
        members: &[
            is("floor", Number, "smallest z of the tip").in_unit("mm").null(NO_BOUND),
            is("box", of("Box"), "box that the tip must stay in").null(NO_BOUND),
            is("keep_out", List(&of("Box")), "boxes that the tip must not enter"),
            is("speed", Number, "highest speed").in_unit("mm/s").null(NO_BOUND),
            is("power", Number, "highest power of the laser").in_unit("percent").null(NO_BOUND),
        ],
    },
    Type {
        name: "FenceChange",
        about: "Members of a fence to change; null removes the bound.",
        members: &[
            is("floor", Number, "smallest z of the tip").in_unit("mm").null(NO_BOUND).optional(),
            is("box", of("Box"), "box that the tip must stay in").null(NO_BOUND).optional(),
            is("keep_out", List(&of("Box")), "boxes that the tip must not enter").null("no box").optional(),
            is("speed", Number, "highest speed").in_unit("mm/s").null(NO_BOUND).optional(),
            is("power", Number, "highest power of the laser").in_unit("percent").null(NO_BOUND).optional(),
        ],
    },
    Type {
        name: "Surface",
        about: "Work surface of a plan.",
        members: &[
            is("height", Number, "z of the surface at x = y = 0, as the arm reports it when the tool touches").in_unit("mm"),
            is("slope", Several(2, &Number), "slope in x and in y, mm per mm; default level").optional(),
        ],
    },
    Type {
        name: "MeasuredSurface",
        about: "Measured work surface of an arm.",
        members: &[
            is("touches", Count, "number of touches; 0 if nothing was measured"),
            is("plane", of("Plane"), "surface").null("nothing measured"),
            is("residual", Number, "largest distance of a touch from the plane").in_unit("mm").null("nothing measured"),
            is("corners", List(&Choice(SHEET_CORNERS)), "corners measured so far of an incomplete sheet"),
            is("sheet", of("MeasuredSheet"), "sheet of paper").null("no sheet"),
        ],
    },
    Type {
        name: "Plane",
        about: "Plane through a point.",
        members: &[
            is("at", Several(2, &Number), "x and y of the point").in_unit("mm"),
            is("z", Number, "z at the point, as the arm reports it when the tool touches").in_unit("mm"),
            is("slope_x", Number, "slope in x, mm per mm"),
            is("slope_y", Number, "slope in y, mm per mm"),
        ],
    },
    Type {
        name: "MeasuredSheet",
        about: "Position of a sheet of paper.",
        members: &[
            is("corner", Several(2, &Number), "x and y of its lower left corner, as its reader sees it").in_unit("mm"),
            is("rotation", Number, "angle from the arm's X to its lower edge").in_unit("deg"),
            is("size", Several(2, &Number), "width and height").in_unit("mm").null("unknown"),
            is("outline", List(&Several(2, &Number)), "four corners, counterclockwise from the lower left one").in_unit("mm"),
        ],
    },
    Type {
        name: "Row",
        about: "Row of the table of a plan: target, action of the tool, waiting time.",
        members: ROW,
    },
    Type {
        name: "GivenRow",
        about: "Row for `teach.plan`: as Row, but null members may be missing.",
        members: &[
            ROW[0].optional(),
            ROW[1].optional(),
            ROW[2].optional(),
            ROW[3].optional(),
            ROW[4].optional(),
        ],
    },
];
