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

const X: Member = is("x", Number, "the tip of the tool").in_unit("mm");
const Y: Member = is("y", Number, "the tip of the tool").in_unit("mm");
const Z: Member = is("z", Number, "the tip of the tool").in_unit("mm");
const R: Member = is("r", Number, "the turn of the tool").in_unit("deg");
const J1: Member = is("j1", Number, "joint 1, the base").in_unit("deg");
const J2: Member = is("j2", Number, "joint 2, the rear arm").in_unit("deg");
const J3: Member = is("j3", Number, "joint 3, the forearm").in_unit("deg");
const J4: Member = is("j4", Number, "joint 4, the tool").in_unit("deg");
const JOB_ID: Member = is("job", Id(Job), "the job that it is at")
    .null("none: none was started, or the last one is over");
const FREE: &str = "nobody has it";

/// State of an arm. A change contains the members that differ, and `t`.
const STATE: &[Member] = &[
    is("t", Number, "when the pose was read, by the station's clock").in_unit("Unix seconds"),
    is("arm", Text, "name of the arm"),
    X,
    Y,
    Z,
    R,
    J1,
    J2,
    J3,
    J4,
    is("rail", Number, "where the arm stands on its rail")
        .in_unit("mm")
        .null("it has no rail"),
    is("current_index", Count, "the command of the arm's queue that was finished last"),
    is(
        "left_space",
        Count,
        "places in the arm's queue that are free; 0: it is full, and the station waits. A queue that is empty has as many as the \
         firmware has places, 32 in the virtual arm",
    )
    .in_unit("commands"),
    is("alarms", List(&Count), "codes of the alarms that stand; `arm.alarms` explains them"),
    is("link", Choice(LINKS), "the line to the arm"),
    is("moving", Switch, "whether it moves, or may"),
    is("homed", Switch, "whether it was homed since it was switched on; false: it says that it was reset, and was not homed since")
        .null("not known: it says nothing of a reset, and this computer saw no homing"),
    is("tool", of("Tool"), "what its tools do"),
    is("speed", Number, "share of the set speed of moves")
        .in_unit("percent")
        .null("not known: it was neither read nor set since the line was found"),
    is(
        "pins",
        List(&of("Pin")),
        "the pins that some subscriber of the arm has asked for; none otherwise",
    ),
    JOB_ID,
    is("jog", Id(Jog), "the jog that it is at").null("none"),
    is("holder", of("Holder"), "who has the lease, and may move it").null(FREE),
];

/// Details of an error. Which of them are present depends on its kind.
pub(super) const ERROR_DATA: &[Member] = &[
    is("kind", Text, "a kind of the table of errors").optional(),
    is(
        "code",
        Text,
        "which error it is: programs decide by it, never by the message",
    )
    .optional(),
    is("param", Text, "the parameter that is wrong").optional(),
    is(
        "row",
        Count,
        "the row of `teach.plan` that is wrong, from 1",
    )
    .optional(),
    is("method", Text, "the method that helps, or that is meant").optional(),
    is("command", Text, "the command of the protocol").optional(),
    is(
        "danger",
        Choice(&["laser", "arm"]),
        "what `yes` is needed for",
    )
    .optional(),
    is("step", Count, "the step of a program, from 1").optional(),
    is("value", Number, "what was asked for").optional(),
    is(
        "limit",
        Number,
        "what is possible, or how many there may be",
    )
    .optional(),
    is("unit", Text, "the unit of both").optional(),
    is("fence", Text, "the part of the fence that it would break").optional(),
    is("from", Count, "the first index or step in doubt").optional(),
    is("to", Count, "the last index or step in doubt").optional(),
    is("remedies", List(&of("Remedy")), "what to do about it").optional(),
    is(
        "template",
        Text,
        "the sentence with the names of its values in braces: its identity in other languages",
    )
    .optional(),
    is(
        "values",
        List(&of("SentenceValue")),
        "the values in the sentence",
    )
    .optional(),
    is("report", of("Report"), "what the check of a program found").optional(),
    is("digest", Text, "the digest of the program as it is now").optional(),
    is("expected", of("Pose"), "where the arm should stand").optional(),
    is("pose", of("Pose"), "where it stands").optional(),
    is(
        "arm",
        Text,
        "the arm that is frozen, or that the schedule keeps",
    )
    .optional(),
    is(
        "until",
        Number,
        "until when the schedule keeps it, Unix time",
    )
    .in_unit("s")
    .null("it is not known")
    .optional(),
    is(
        "arms",
        List(&of("Stood")),
        "the arms that stand all the same",
    )
    .optional(),
    is("role", Choice(ROLES), "the role of the session").optional(),
    is("needs", Choice(ROLES), "the role that is needed").optional(),
    is(
        "may",
        List(&Choice(&["owner", "holder", "teacher"])),
        "who may change a job that waits: its owner, the holder of the lease, a teacher",
    )
    .optional(),
    is("wait_s", Number, "how long wrong codes have to wait")
        .in_unit("s")
        .optional(),
    is(
        "quota",
        of("LibraryUse"),
        "the quota of the library that is used up",
    )
    .optional(),
    is("used", of("LibraryUse"), "what is used of it").optional(),
    is("holder", of("Holder"), "who has the lease")
        .null(FREE)
        .optional(),
    is(
        "free_in_s",
        Number,
        "when the lease of a holder without a socket ends",
    )
    .in_unit("s")
    .optional(),
    is("reason", Choice(&["unkept"]), "the disk did not take it").optional(),
    is("by", Id(Session), "whose stop it was")
        .null("not a session's")
        .optional(),
    is("job", Id(Job), "the job that has the arm").optional(),
    is("jog", Id(Jog), "the jog that has the arm").optional(),
    is("recording", Text, "the recording that is under way").optional(),
];

/// Error of a job, which has its message among the details.
const JOB_ERROR: &[Member] = &{
    let mut all = [ERROR_DATA[0]; ERROR_DATA.len() + 1];
    let mut at = 0;
    while at < ERROR_DATA.len() {
        all[at] = ERROR_DATA[at];
        at += 1;
    }
    all[at] = is("message", Text, "what is wrong, in a sentence");
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
    is("turn_s", Number, "how long a turn is; 0 without end")
        .in_unit("s")
        .null("there are no turns"),
    is(
        "arms",
        List(&Object(&[
            is("arm", Text, "its name"),
            is("person", Text, "whose turn it is").null("nobody's"),
            is(
                "state",
                Choice(TURN_STATES),
                "kept: for somebody who is not there; suspended: a teacher has the arm",
            )
            .null("nobody's turn"),
            is("left_s", Number, "what is left of the turn")
                .in_unit("s")
                .null("it has no end, or is nobody's"),
            is("frozen", Switch, "whether a teacher has frozen the arm"),
            is(
                "jobs",
                List(&Object(&[
                    is("job", Id(Job), "the job"),
                    is("title", Text, "its title").null("it has none"),
                    is("person", Text, "its owner").null("a teacher"),
                    is(
                        "reason",
                        Choice(JOB_REASONS),
                        "what keeps it: yes, stopped, restart, unkept as in `job.get`; frozen: the arm is; schedule: no slot of its owner is open; turn: somebody else's; busy: something moves the arm or has its lease; lost: the arm is",
                    )
                    .null("the jobs in front of it alone"),
                ])),
                "the jobs that wait for the arm, in order",
            ),
            is(
                "slot",
                Object(&[
                    is("who", List(&Text), "who may have the arm: pupils, groups, tokens, or teacher"),
                    is("until", Number, "when it ends, Unix time")
                        .in_unit("s")
                        .null("it has no end"),
                ]),
                "the slot of the schedule that is open",
            )
            .null("anybody may have the arm, or none is open"),
            is("free_at", Number, "when the next slot begins, Unix time")
                .in_unit("s")
                .null("the arm may be had now, or no slot is known"),
        ])),
        "the arms of the station",
    ),
    is(
        "queue",
        List(&Object(&[
            is("place", Count, "from 1"),
            is("person", Text, "who waits"),
            is("arms", List(&Text), "the arms that will do"),
            is(
                "missed",
                Switch,
                "whether a turn came while the person was not there",
            ),
            is(
                "reason",
                Choice(&["schedule", "frozen", "away"]),
                "what keeps it: no slot of the person is open, all its arms are frozen, or the person is not there",
            )
            .null("those in front of it alone"),
            is("from", Number, "when a slot of the person begins, Unix time")
                .in_unit("s")
                .null("the schedule does not keep it, or has no slot"),
        ])),
        "who waits, in order",
    ),
];

/// Row of a plan.
const ROW: &[Member] = &[
    is("name", Text, "what the row is called"),
    is("motion", of("PlanStep"), "a step as in plan files").null("it stays where it is"),
    is(
        "gripper",
        Choice(&["off", "open", "close"]),
        "what the gripper does",
    )
    .null("nothing"),
    is("suction", Switch, "the suction cup").null("nothing"),
    is("wait", Number, "how long it stays")
        .in_unit("s")
        .null("not at all"),
];

/// Turns in the answer of `turn.list`.
const TURN_LIST: &[Member] = &[
    TURNS[0],
    TURNS[1],
    TURNS[2],
    is(
        "you",
        Object(&[
            is("person", Text, "the name under which the asker takes turns").null("none"),
            is(
                "arms",
                List(&Text),
                "the arms that `turn.join` without `arm` means",
            ),
        ]),
        "who asks",
    )
    .optional(),
];

/// All named types, in documentation order.
pub static TYPES: &[Type] = &[
    Type {
        name: "State",
        about: "The state of an arm, as it was read last.",
        members: STATE,
    },
    Type {
        name: "Tool",
        about: "What the tools of an arm do, by the commands that went to it; null is not known.",
        members: &[
            is("name", TOOL_NAME, "the tool that is mounted")
                .null("not known, or its tip is that of no tool with a name"),
            is("bias", BIAS, "its tip from the flange, x, y, z")
                .in_unit("mm")
                .null("not known"),
            is("suction", Switch, "whether the suction cup is on").null("not known"),
            is("gripper", Choice(GRIPPERS), "the gripper; off: its pump is off").null("not known"),
            is("laser", Switch, "whether the laser may burn: the last command that is known lets it")
                .null("not known"),
        ],
    },
    Type {
        name: "Pin",
        about: "The level of a pin that is watched.",
        members: &[
            is("kind", Choice(PIN_KINDS), "how it is read"),
            is("address", Count, "its EIO address, 1 to 20"),
            is("value", Count, "0 or 1; of an analog input counts, 4095 at 3.3 V"),
        ],
    },
    Type {
        name: "Holder",
        about: "A session that has the lease of an arm.",
        members: &[
            is("session", Id(Session), "its id"),
            is("name", Text, "what it calls itself"),
        ],
    },
    Type {
        name: "Pose",
        about: "Where an arm is.",
        members: &[X, Y, Z, R, J1, J2, J3, J4],
    },
    Type {
        name: "LibraryUse",
        about: "Room in the library of programs.",
        members: &[
            is("programs", Count, "number of programs"),
            is("bytes", Count, "their bytes").in_unit("bytes"),
        ],
    },
    Type {
        name: "Stood",
        about: "An arm that stands after a stop.",
        members: &[
            is("arm", Text, "its name"),
            is("stood", Switch, "true: two readings were equal"),
            is("pose", of("Pose"), "where it stands"),
        ],
    },
    Type {
        name: "Lease",
        about: "A lease that was given.",
        members: &[
            is("arm", Text, "name of the arm"),
            is("lease", Id(Lease), "its id, for `lease.renew` and `lease.release`"),
            is("ttl_s", Number, "it ends when its holder says nothing for so long").in_unit("s"),
        ],
    },
    Type {
        name: "Session",
        about: "A session of the station.",
        members: &[
            is("session", Id(Session), "its id"),
            is("name", Text, "what it calls itself"),
            is("role", Choice(ROLES), "what it may do"),
            is("leases", List(&Text), "the arms whose lease it has"),
            is("since", Number, "when it said hello").in_unit("Unix seconds"),
        ],
    },
    Type {
        name: "Job",
        about: "A job, also one that is over.",
        members: &[
            is("job", Id(Job), "its id, never used twice"),
            is("arm", Text, "name of the arm"),
            is("title", Text, "what its program is called").null("it is not read yet, or has no title"),
            is("state", Choice(JOB_STATES), "what it does; from `done` on it is over"),
            is("step", Count, "steps of loop `loop` that the arm has finished; the pair never goes back"),
            is("steps", Count, "steps of one loop").null("it is not read yet"),
            is("first_step", Count, "the step that it began with, from 1").null("it is not read yet"),
            is("loops", Count, "how often it is done; 0 until it is stopped"),
            is("loop", Count, "the loop under way, from 1"),
            is("seconds_left", Number, "how long the rest takes")
                .in_unit("s")
                .null("not known, or without end"),
            is("drawn_mm", Number, "length of what it drew or burnt")
                .in_unit("mm")
                .null("it is not done"),
            is("travel_mm", Number, "length of the moves between")
                .in_unit("mm")
                .null("it is not done"),
            is("started", Number, "when it began")
                .in_unit("Unix seconds")
                .null("it waits in the queue"),
            is("ended", Number, "when it was over")
                .in_unit("Unix seconds")
                .null("it is not over"),
            is("holder", of("Holder"), "whose it is").null("not known"),
            is("part", Count, "the part that comes next, from 1").null("it does not wait between parts"),
            is(
                "reason",
                Choice(REASONS),
                "of a `paused` job: `person`: somebody asked for it, or the lease ended; `part`: a part is done; `program`: the program \
                 says so. Of a `queued` job that does not begin by itself: `stopped`: the arm was stopped, `job.resume` lets it go on; \
                 `yes`: it may burn or is dangerous, and waits for `job.resume` with `yes` by who may; `restart`: the station was \
                 started anew, and `unkept`: the disk did not take its start, `job.resume` lets both go on",
            )
            .null("neither"),
            is("text", Text, "what the person at the arm is to do before it goes on").null("nothing is said"),
            is("place", Count, "its place in the queue of its arm, from 1").null("it does not wait"),
            is("error", of("JobError"), "why it failed or was interrupted").null("it has not failed"),
            is("notes", List(&of("Note")), "what it has left switched on, and grips of a virtual arm that took nothing").null("nothing"),
            is("digest", Text, "the digest of its program, as `job.check` answers it").null("not read yet"),
        ],
    },
    Type {
        name: "JobError",
        about: "Why a job failed: `data` of the error, and its message.",
        members: JOB_ERROR,
    },
    Type {
        name: "ErrorData",
        about: "`data` of an error. Which members there are depends on its kind: see the table of errors.",
        members: ERROR_DATA,
    },
    Type {
        name: "Remedy",
        about: "Something that can be done about an error, one of `action`, `option`, `without` and `system`.",
        members: &[
            is("action", Text, "what to do, such as `home`, `clear-alarms`").optional(),
            is("option", Text, "an option to give").optional(),
            is("value", Either(&[Number, Switch, Text, List(&Number)]), "its value; the person chooses it where there is none").optional(),
            is("without", Text, "an option to leave out").optional(),
            is("system", Text, "a command for a shell of the station's machine").optional(),
            is("effect", Text, "what comes of it").optional(),
        ],
    },
    Type {
        name: "SentenceValue",
        about: "A value in a sentence, one of `text`, `option` and `template`.",
        members: &[
            is("name", Text, "its name in the template"),
            is("text", Text, "a number or a quotation, as it is printed").optional(),
            is("option", Text, "an option by its name, which a client calls as it likes").optional(),
            is("template", Text, "words that are a sentence of their own").optional(),
            is("values", List(&of("SentenceValue")), "the values in those").optional(),
        ],
    },
    Type {
        name: "Turns",
        about: "Whose turn it is in a class, and who waits.",
        members: TURNS,
    },
    Type {
        name: "TurnList",
        about: "Turns, and what they are for the asker.",
        members: TURN_LIST,
    },
    Type {
        name: "ClientName",
        about: "The program that says hello.",
        members: &[
            is("name", Text, "what it is called, 1 to 80 characters"),
            is("version", Text, "its version, up to 80 characters").optional(),
        ],
    },
    Type {
        name: "Pupil",
        about: "A pupil of the class who signs in.",
        members: &[is("name", Text, "the name"), is("code", Text, "the pupil's code")],
    },
    Type {
        name: "ExpectedArm",
        about: "An arm that is expected on a site.",
        members: &[
            is("arm", Text, "its name"),
            is("machine", Text, "the machine of its station").optional(),
        ],
    },
    Type {
        name: "PinAddress",
        about: "A pin to watch.",
        members: &[
            is("kind", Choice(PIN_KINDS), "how it is read"),
            is("address", Count, "its EIO address, 1 to 20"),
        ],
    },
    Type {
        name: "Laser",
        about: "What the laser is to do.",
        members: &[
            is("on", Switch, "whether it burns"),
            is("power", Number, "0 to 100; a laser that stands burns at 100 or not at all: less is `unsupported`")
                .in_unit("percent")
                .optional(),
        ],
    },
    Type {
        name: "Box",
        about: "A box with sides along the axes.",
        members: BOX,
    },
    Type {
        name: "Fence",
        about: "Where an arm may be, how fast, and how strong its laser.",
        members: &[
            is("floor", Number, "the least z of the tip").in_unit("mm").null(NO_BOUND),
            is("box", of("Box"), "where the tip has to be").null(NO_BOUND),
            is("keep_out", List(&of("Box")), "where it must not be"),
            is("speed", Number, "the highest speed").in_unit("mm/s").null(NO_BOUND),
            is("power", Number, "the highest power of the laser").in_unit("percent").null(NO_BOUND),
        ],
    },
    Type {
        name: "FenceChange",
        about: "The members of a fence that become something else; null takes the bound away.",
        members: &[
            is("floor", Number, "the least z of the tip").in_unit("mm").null(NO_BOUND).optional(),
            is("box", of("Box"), "where the tip has to be").null(NO_BOUND).optional(),
            is("keep_out", List(&of("Box")), "where it must not be").null("nowhere").optional(),
            is("speed", Number, "the highest speed").in_unit("mm/s").null(NO_BOUND).optional(),
            is("power", Number, "the highest power of the laser").in_unit("percent").null(NO_BOUND).optional(),
        ],
    },
    Type {
        name: "Surface",
        about: "The surface that a plan works on.",
        members: &[
            is("height", Number, "the z that the arm reports where the tool touches it, at x = y = 0").in_unit("mm"),
            is("slope", Several(2, &Number), "how much higher it is for each mm in x and in y; level without it").optional(),
        ],
    },
    Type {
        name: "MeasuredSurface",
        about: "What is known of the work surface under an arm.",
        members: &[
            is("touches", Count, "how many touches it comes from; 0 while nothing is known"),
            is("plane", of("Plane"), "the surface").null("nothing is known"),
            is("residual", Number, "the largest distance of a touch from it").in_unit("mm").null("nothing is known"),
            is("corners", List(&Choice(SHEET_CORNERS)), "corners that were taken of a sheet that is not complete"),
            is("sheet", of("MeasuredSheet"), "the sheet of paper").null("none was measured"),
        ],
    },
    Type {
        name: "Plane",
        about: "A plane, by a place of it.",
        members: &[
            is("at", Several(2, &Number), "x and y of the place").in_unit("mm"),
            is("z", Number, "the z that the arm reports where the tool touches it there").in_unit("mm"),
            is("slope_x", Number, "how much higher it is for each mm in x"),
            is("slope_y", Number, "how much higher it is for each mm in y"),
        ],
    },
    Type {
        name: "MeasuredSheet",
        about: "A sheet of paper as it lies before the arm.",
        members: &[
            is("corner", Several(2, &Number), "x and y of its lower left corner, for its reader").in_unit("mm"),
            is("rotation", Number, "from the arm's X to its lower edge").in_unit("deg"),
            is("size", Several(2, &Number), "width and height").in_unit("mm").null("not known"),
            is("outline", List(&Several(2, &Number)), "its four corners, from the lower left one against the clock").in_unit("mm"),
        ],
    },
    Type {
        name: "Row",
        about: "A row of the table of a plan: where the arm goes, what its tool does there, how long it stays.",
        members: ROW,
    },
    Type {
        name: "GivenRow",
        about: "A row for `teach.plan`: as Row, and a member that is null may be missing.",
        members: &[
            ROW[0].optional(),
            ROW[1].optional(),
            ROW[2].optional(),
            ROW[3].optional(),
            ROW[4].optional(),
        ],
    },
];
