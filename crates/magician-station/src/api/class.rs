//! Table of the methods of classes: persons and their turns, the schedule, and a teacher's
//! operations on all arms.

use super::method::{method, optional_param, required_param};
use super::{Kind, Method, Param, Role};

use Role::{Student, Teacher, Viewer};

const ARMS: Param = optional_param("arms", Kind::Texts(64), "names of arms; default all");
const ARM: Param = optional_param(
    "arm",
    Kind::Text(32),
    "name of the arm; alternatively `arms`",
);
const ELSEWHERE: Param = optional_param(
    "elsewhere",
    Kind::Switch,
    "accepts arms of other stations of the site; otherwise an unknown arm is an error",
);
const FILE: Kind = Kind::Text(64 * 1024);
const PROGRAM: Kind = Kind::Text(1024 * 1024);

/// Methods of classes, in documentation order.
pub(super) const CLASS: &[Method] = &[
    method(
        "class.set",
        Teacher,
        &[
            optional_param(
                "text",
                FILE,
                "class file, TOML; empty text ends the class; alternatively `names`",
            ),
            optional_param(
                "names",
                Kind::Texts(60),
                "pupils of a class without groups; all other rules are kept; alternatively `text`",
            ),
            optional_param(
                "arms",
                Kind::Texts(64),
                "with `names`: arms available to the pupils; default all",
            ),
            optional_param(
                "turn_s",
                Kind::Integer(0, 86_400),
                "with `names`: length of a turn, s; 0 for unlimited turns; default unchanged",
            ),
            optional_param(
                "offset",
                Kind::Text(6),
                "with `names`: offset of local time from UTC, such as `+01:00`; default unchanged",
            ),
            optional_param(
                "use_codes",
                Kind::Switch,
                "replaces existing codes and PIN by those of the file",
            ),
            ELSEWHERE,
        ],
        "Replaces the class. Pupils keep their codes and the teacher keeps the PIN, whatever the file says; new pupils get a code.",
        "as `class.get` for a teacher, and {codes_kept: [name]}: pupils whose code in the file was ignored",
    ),
    method(
        "class.get",
        Viewer,
        &[],
        "Returns the class: its rules and pupils.",
        "{class: {turn_s, grace_s, finish_job, speed, fence, arms}, groups, pupils: [{name, group, code, here, place, arm}], pin, text}: `class` is null if none is set; `arms`: arms available to pupils, empty for all; only teachers see `code`, `here` (signed in), `place` (in the queue), `arm` (of the turn), `pin`, and the class file as `text`: null for others",
    ),
    method(
        "class.codes",
        Teacher,
        &[optional_param(
            "pupils",
            Kind::Texts(60),
            "names of pupils; default all",
        )],
        "Generates new codes. Pupils signed in with an old code must sign in again.",
        "as `class.set`",
    ),
    method(
        "class.freeze",
        Teacher,
        &[ARMS],
        "Stops and freezes arms. A job pauses if its step ends within a second; otherwise, or if it burns, it is stopped (`job.resume` continues both). Other motion ends, and the laser is off. Until `class.free` only teachers can move these arms, and the clocks of turns stand.",
        "{arms}",
    ),
    method("class.free", Teacher, &[ARMS], "Unfreezes arms.", "{arms}"),
    method(
        "class.send",
        Teacher,
        &[
            optional_param(
                "program",
                Kind::Text(80),
                "name of a program in the library; alternatively `text` or `data`",
            ),
            optional_param(
                "text",
                PROGRAM,
                "content of the program as text; alternatively `data`",
            ),
            optional_param(
                "data",
                PROGRAM,
                "content of the program in base64; alternatively `text`",
            ),
            optional_param("format", Kind::Text(20), "format, as in `job.start`"),
            optional_param("setup", Kind::Object("Setup"), "options, as in `job.start`"),
            ARMS,
            optional_param("yes", Kind::Switch, "confirms that it may burn"),
        ],
        "Starts a program on each free arm, and queues it on the others.",
        "{jobs: [{arm, job, state, error}]}",
    ),
    method(
        "class.results",
        Teacher,
        &[],
        "Lists the finished jobs of pupils. As a page: GET /api/v1/class/results.html.",
        "{results: [{job, pupil, group, title, time, time_local, arm, drawn_mm, svg}]}: `svg`: the drawing as placed, x to the right, empty if there is none; `time_local`: by the offset of the schedule, else of the class",
    ),
    method(
        "turn.join",
        Student,
        &[
            optional_param(
                "arm",
                Kind::Text(32),
                "name of the arm; default: any arm of the group, or any arm",
            ),
            optional_param(
                "group",
                Kind::Text(40),
                "group whose arms are requested; default: the pupil's group",
            ),
        ],
        "Joins the queue for a turn. The queue holds persons, not sockets: reloading a page loses nothing. No effect for a person who has a turn or already waits for the same arms. Teachers need no turn.",
        "as `turn.list`",
    ),
    method(
        "turn.leave",
        Student,
        &[optional_param(
            "person",
            Kind::Text(80),
            "person, for teachers; default: the caller",
        )],
        "Gives up turn and place.",
        "null",
    ),
    method(
        "turn.end",
        Teacher,
        &[ARM, ARMS],
        "Ends the turn on one, several or all arms. Its person loses the place, and the next one in the queue gets the arm. Motion stops as at any end of a turn.",
        "{arms}: arms that had a turn",
    ),
    method(
        "turn.next",
        Teacher,
        &[ARM, ARMS],
        "Passes the turn on one, several or all arms to the next person in the queue; the former person gets the last place. With `arm` it is refused if no signed-in person waits; otherwise such arms are skipped.",
        "{arms}: arms with a new turn",
    ),
    method(
        "turn.list",
        Viewer,
        &[optional_param(
            "group",
            Kind::Text(40),
            "as for `turn.join`: selects the arms in `you`",
        )],
        "Lists turns and queue.",
        "{turn_s, arms: [{arm, person, state, left_s, frozen, jobs, slot, free_at}], queue: [{place, person, arms, missed, reason, from}], you: {person, arms}}: `jobs`: jobs queued for the arm; `slot`: open slot of the schedule, and `free_at`: begin of the next one, both null if the arm is free for all; `you`: name under which the caller takes turns, and the arms meant by `turn.join` without `arm`; not in `turn.changed`; `turn_s`: 0 for unlimited turns, null without turns; `state`: running, kept (the person is away) or suspended (a teacher has the arm)",
    ),
    method(
        "schedule.set",
        Teacher,
        &[
            required_param(
                "text",
                FILE,
                "schedule, TOML; empty text removes all limits",
            ),
            ELSEWHERE,
        ],
        "Sets who may acquire which arm when, by the station's clock. An arm without slots is free at any time.",
        "as `schedule.get`",
    ),
    method(
        "schedule.get",
        Viewer,
        &[],
        "Returns the schedule.",
        "{text, slots: [{arms, who, days, from, until}], now, error}: times in Unix seconds, or with `days` in seconds of the local day; `error`: reason why the schedule cannot be read, in which case only teachers may have arms, else null",
    ),
    method(
        "site.roster",
        Viewer,
        &[],
        "Lists the arms that this station expects on its site.",
        "{arms: [{arm, machine}]}: `machine` is empty if unknown",
    ),
    method(
        "site.expect",
        Teacher,
        &[required_param(
            "arms",
            Kind::Objects("ExpectedArm"),
            "all expected arms, at most 10,000",
        )],
        "Replaces the roster. Requests to all arms of the site report arms of the roster that are missing.",
        "as `site.roster`",
    ),
];
