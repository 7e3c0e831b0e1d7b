//! Table of the methods of classes: persons and their turns, the schedule, and a teacher's
//! operations on all arms.

use super::method::{may, method, needed};
use super::{Kind, Method, Param, Role};

use Role::{Student, Teacher, Viewer};

const ARMS: Param = may("arms", Kind::Texts(64), "names of arms; all unless given");
const ARM: Param = may("arm", Kind::Text(32), "the arm; or `arms`");
const ELSEWHERE: Param = may(
    "elsewhere",
    Kind::Switch,
    "that arms which this station has not are other stations' of its site, not mistakes",
);
const FILE: Kind = Kind::Text(64 * 1024);
const PROGRAM: Kind = Kind::Text(1024 * 1024);

/// Methods of classes, in documentation order.
pub(super) const CLASS: &[Method] = &[
    method(
        "class.set",
        Teacher,
        &[
            may(
                "text",
                FILE,
                "a class file, TOML; empty text ends the class; or `names`",
            ),
            may(
                "names",
                Kind::Texts(60),
                "the pupils of a class without groups, whose other rules are those of the class before; or `text`",
            ),
            may(
                "arms",
                Kind::Texts(64),
                "with `names`: the arms that they may have; all unless given",
            ),
            may(
                "turn_s",
                Kind::Integer(0, 86_400),
                "with `names`: how long a turn is, s, 0 for turns without end; as before unless given",
            ),
            may(
                "offset",
                Kind::Text(6),
                "with `names`: how far the clock on the wall is from UTC, such as `+01:00`; as before unless given",
            ),
            may(
                "use_codes",
                Kind::Switch,
                "that the codes and the PIN of the file count where the class before has others",
            ),
            ELSEWHERE,
        ],
        "Gives the station a class, in the place of the one before. Pupils who were in it keep their codes, whatever the file says, and so does the teacher the PIN; the others get one.",
        "as `class.get` for a teacher, and {codes_kept: [name]}: the pupils for whom the file has another code",
    ),
    method(
        "class.get",
        Viewer,
        &[],
        "The class: its rules and pupils.",
        "{class: {turn_s, grace_s, finish_job, speed, fence, arms}, groups, pupils: [{name, group, code, here, place, arm}], pin, text}: `class` null where there is none; `arms` those that pupils may have, all if empty; null for all but teachers are codes, whether a pupil is signed in (`here`), the place in the queue, the arm of the turn, the teacher's PIN, and the class file as `text`",
    ),
    method(
        "class.codes",
        Teacher,
        &[may("pupils", Kind::Texts(60), "whose; of all unless given")],
        "Makes new codes: pupils who signed in with an old code have to sign in again.",
        "as `class.set`",
    ),
    method(
        "class.freeze",
        Teacher,
        &[ARMS],
        "Stops arms: a job pauses where its step ends within a second, and ends elsewhere, at once if it burns (`job.resume` goes on with both); the rest ends, and the laser is off. Nobody but a teacher moves them until `class.free`; the time of turns stands.",
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
        "{results: [{job, pupil, group, title, time, time_local, arm, drawn_mm, svg}]}: `svg` the drawing as it was placed, x to the right, empty without one; `time_local` by the offset of the schedule, or else of the class",
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
        &[may(
            "person",
            Kind::Text(80),
            "whose, for a teacher; the asker's own unless given",
        )],
        "Gives turn and place up.",
        "null",
    ),
    method(
        "turn.end",
        Teacher,
        &[ARM, ARMS],
        "Ends the turn at an arm, at some, or at all: its person has no place any more, and the next who waits gets the arm. What moves stops as at any end of a turn.",
        "{arms}: those that had a turn",
    ),
    method(
        "turn.next",
        Teacher,
        &[ARM, ARMS],
        "Passes the turn at an arm, at some, or at all, to the next who waits for it: the person who had it gets the last place of the queue. Refused for `arm` where nobody who is there waits; of others such an arm is left out.",
        "{arms}: those that have another turn",
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
        "{turn_s, arms: [{arm, person, state, left_s, frozen, jobs, slot, free_at}], queue: [{place, person, arms, missed, reason, from}], you: {person, arms}}: `jobs` those that wait for the arm, `slot` that of the schedule that is open and `free_at` when the next begins, both null where anybody may have the arm; `you` the name under which the asker takes turns, and the arms that `turn.join` without `arm` means; not in `turn.changed`; `turn_s` 0 for turns without end, null where there are none; `state` running, kept (for somebody who is not there) or suspended (a teacher has the arm)",
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
        "{text, slots: [{arms, who, days, from, until}], now, error}: Unix seconds, and with `days` seconds of the local day; `error` why the schedule cannot be read, so that only teachers have arms, else null",
    ),
    method(
        "site.roster",
        Viewer,
        &[],
        "The arms that this station expects on its site.",
        "{arms: [{arm, machine}]}: `machine` empty where it is not known",
    ),
    method(
        "site.expect",
        Teacher,
        &[needed(
            "arms",
            Kind::Objects("ExpectedArm"),
            "all arms that are expected from now on, 10,000 at most",
        )],
        "Replaces the roster: whatever is asked of all arms of the site names those of the roster that are missing.",
        "as `site.roster`",
    ),
];
