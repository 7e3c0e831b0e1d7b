//! The methods of classes: persons and their turns, the schedule, and what a teacher does for all.

use super::method::{may, method, needed};
use super::{Kind, Method, Param, Role};

use Role::{Student, Teacher, Viewer};

const ARMS: Param = may("arms", Kind::Texts(64), "names of arms; all unless given");
const ELSEWHERE: Param = may(
    "elsewhere",
    Kind::Switch,
    "that arms which this station has not are other stations' of its site, not mistakes",
);
const FILE: Kind = Kind::Text(64 * 1024);
const PROGRAM: Kind = Kind::Text(1024 * 1024);

/// All of them, in the order of the documents.
pub(super) const CLASS: &[Method] = &[
    method(
        "class.set",
        Teacher,
        &[
            needed(
                "text",
                FILE,
                "a class file, TOML; empty text ends the class",
            ),
            ELSEWHERE,
        ],
        "Gives the station a class, in the place of the one before. Pupils keep their codes; the others get one.",
        "as `class.get`, with the codes",
    ),
    method(
        "class.get",
        Viewer,
        &[],
        "The class: its rules and pupils.",
        "{class: {turn_s, grace_s, finish_job, speed, fence}, groups, pupils: [{name, group, code}], pin, text}: `class` null where there is none; codes, the teacher's PIN, and the class file as `text`, for teachers alone, null for others",
    ),
    method(
        "class.codes",
        Teacher,
        &[may("pupils", Kind::Texts(60), "whose; of all unless given")],
        "Makes new codes: pupils who signed in with an old code have to sign in again.",
        "as `class.get`",
    ),
    method(
        "class.freeze",
        Teacher,
        &[ARMS],
        "Stops arms: jobs pause, the rest ends, the laser is off. Nobody but a teacher moves them until `class.free`; the time of turns stands.",
        "{arms}",
    ),
    method(
        "class.free",
        Teacher,
        &[ARMS],
        "Lets arms be moved again.",
        "{arms}",
    ),
    method(
        "class.send",
        Teacher,
        &[
            may(
                "program",
                Kind::Text(80),
                "a program of the library; or `text`, or `data`",
            ),
            may("text", PROGRAM, "the program as text; or `data`"),
            may("data", PROGRAM, "the program's bytes in base64; or `text`"),
            may("format", Kind::Text(20), "its type, as in `job.start`"),
            may(
                "setup",
                Kind::Object("Setup"),
                "how it is drawn or engraved, as in `job.start`",
            ),
            ARMS,
            may("yes", Kind::Switch, "that it may burn"),
        ],
        "Puts a program to arms: it begins where the arm is free, and waits in the arm's queue elsewhere.",
        "{jobs: [{arm, job, state, error}]}",
    ),
    method(
        "class.results",
        Teacher,
        &[],
        "What pupils have made: their jobs that are done. As a page: GET /api/v1/class/results.html.",
        "{results: [{job, pupil, group, title, time, arm, drawn_mm, strokes: [[[x, y]]]}]}",
    ),
    method(
        "turn.join",
        Student,
        &[
            may(
                "arm",
                Kind::Text(32),
                "the arm; without it any of the group's, or any at all",
            ),
            may(
                "group",
                Kind::Text(40),
                "the group whose arms are meant; the pupil's own unless given",
            ),
        ],
        "Joins the queue for a turn, of persons and not of sockets: a page that is loaded anew has lost nothing. Who has a turn, or waits for the same arms, keeps it. A teacher needs none.",
        "as `turn.list`",
    ),
    method(
        "turn.leave",
        Student,
        &[],
        "Gives turn and place up.",
        "null",
    ),
    method(
        "turn.list",
        Viewer,
        &[may(
            "group",
            Kind::Text(40),
            "as for `turn.join`: whose arms are told in `you`",
        )],
        "Whose turn it is, and who waits.",
        "{turn_s, arms: [{arm, person, state, left_s, frozen}], queue: [{place, person, arms, missed}], you: {person, arms}}: `you` the name under which the asker takes turns, and the arms that `turn.join` without `arm` means; not in `turn.changed`; `turn_s` 0 for turns without end, null where there are none; `state` running, kept (for somebody who is not there) or suspended (a teacher has the arm)",
    ),
    method(
        "schedule.set",
        Teacher,
        &[
            needed(
                "text",
                FILE,
                "a schedule, TOML; empty text lets everybody in at any time",
            ),
            ELSEWHERE,
        ],
        "Says who may have the lease of which arm when, by the station's own clock. An arm that is in no slot is free at any time.",
        "as `schedule.get`",
    ),
    method(
        "schedule.get",
        Viewer,
        &[],
        "The schedule.",
        "{text, slots: [{arms, who, days, from, until}], now}: Unix seconds, and with `days` seconds of the local day",
    ),
];
