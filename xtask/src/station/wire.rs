//! Parts of the API besides methods: messages, notifications, events, the binary frame, types.

use std::fmt::Write as _;

use magician_station::api::{
    CLOSE_CODES, ERRORS, EVENTS, FEATURES, FRAME_FLAGS, FRAME_PARTS, Member, NOTIFICATIONS, Notice,
    NotificationExample, TYPES,
};
use serde_json::json;

const MESSAGES: &str = "
## How a session goes

1. Open a WebSocket at `/api/v1/ws`. Each text message is one object of JSON-RPC 2.0; arrays of requests are refused.
2. Say `session.hello` within 5 s, from another machine 2 s, before anything else. Its `resume` is a secret that is *another one after each hello*: given in the hello
   of a new socket, within 5 s after the old one ended, it gives session and lease back (`resumed` true), with the same ids.
   Give `token` or `pupil` again, as before. A secret that is unknown, used, late or of another token begins a new session (`resumed`
   false). An old socket that is still open, as after a lost network, is closed with 4409. What the arm was told to do goes on meanwhile
   (a job that burns pauses), and its answers are lost: ask `job.get` and `arm.state`, and send `job.start` again with its `key`. A wait for a lease ends with
   the socket, and so do jogs. Subscriptions are made anew.
3. Answer pings. The station sends one every 2 s, with an empty payload; libraries and browsers answer by themselves, a client that writes its own frames sends a
   pong (opcode 10, masked, the same payload). Who says nothing for 5 s, neither a message nor a pong, loses the lease: what it moves is stopped.
4. Requests have an `id`, a text or a whole number, and are answered as they end, *not in order*. Notifications of the station have none; they come between the answers:
   `job.changed` tells of a job before `job.start` is answered.
   Ignore notifications, members and events that you do not know: more may come.
5. `arm.stop`, `job.stop`, `jog.stop` and `jog.keep` are obeyed without an `id` as well, and in any number; nothing is answered then. Anything else without an `id` is -32600.

**To jog** a client has the lease, calls `jog.start`, and from its answer on sends `jog.keep` *without an id* every `keep_ms` / 4: 62 ms for the usual 250. When no keep came for
`keep_ms` the arm is stopped. It ends by `jog.stop`; `jog.ended` says why it is over, whoever ended it.

**To run a program** it calls `job.start`, and follows `job.changed` until `state` is `done`, `stopped`, `failed` or `interrupted`. With `\"queue\": true` it needs no lease and waits (`state` `queued`,
`place`) until the arm is free of jobs and of others' turns; then it is checked again and begins by itself. The feature `job-queue` says whether a station has that queue.

[Clients in Python, Node and a browser](../guide/STATION-CLIENTS.md) do all of this in 80 lines each. `openrpc.json` has the types of everything on this page; `studio/src/api.ts` (TypeScript) and `magician/station_types.py` (Python) are made of it.
";

const DELTAS: &str = "
## States that come by themselves

`arm.subscribe` is answered with the id of a subscription. Then come notifications `arm.state {subscription, state}`:

* The first has a whole [State](#state), and so has every 100th state (counted as the sequence numbers of frames are; one that is dropped is not sent later). Each other has `t` and the members that differ from
  the last one *sent for this subscription*.
* Merge: each member takes the place of the one before, whole. `tool`, `holder`, `alarms` and `pins` are never sent in part, and null is a value: `Object.assign(state, change)` in JavaScript,
  `state.update(change)` in Python.
* Newest wins: a state that was not sent when a newer one is due is never sent. The rate is kept within 10 %.
* When the line to the arm is lost one change comes, `{\"link\": \"lost\", \"t\": ..}`, and nothing until it is found. What is known of before is stale meanwhile. Then the next change has `\"link\": \"up\"` and all that differs.

With `\"frame\": \"binary\"` each state is a binary message, laid out below. What has no place in it comes as `arm.state` in text when it changes: right behind the frame, first a whole State, then
`alarms`, `link`, `moving`, `homed`, `tool`, `speed`, `pins`, `job`, `jog`, `holder`, each with `t`. A lost line is told in text alone.

### The frame

112 bytes, little endian. NaN is not known.

| offset | type | name | unit | meaning |
|---|---|---|---|---|
";

/// Types that are described elsewhere.
const OTHERS: [(&str, &str); 4] = [
    (
        "StateChange",
        "A [State](#state), or `t` and the members of it that have changed: see [states](#states-that-come-by-themselves).",
    ),
    (
        "Report",
        "What the check of a program found: as `run --check --json`, and `parts`. `openrpc.json` has its members; [jobs](STATION.md#jobs) tell of them.",
    ),
    (
        "Note",
        "A `code`, a `text` for people, where it has one the `line` or the `element` of the file, and `remedies`. \
            `template` and `values` are the sentence without what to do about it, and `help` is advice that is no \
            remedy: see [errors](#errors).",
    ),
    (
        "PlanStep",
        "A step as in plan files: an object with one of `move`, `joints`, `shift`, `arc`, `path`, `burn`, `suction`, `gripper`, `laser`, `part`, `pause`, `wait`, `home`, `command`.",
    ),
];

/// Returns the sections before the methods and after the errors.
pub(super) fn sections() -> String {
    let mut page = MESSAGES.to_owned();
    page += &features();
    page += &notifications();
    page += &events();
    page += DELTAS;
    for part in FRAME_PARTS {
        let (offset, kind, name) = (part.offset, part.kind, part.name);
        let (unit, about) = (part.unit, part.about);
        let _ = writeln!(page, "| {offset} | {kind} | `{name}` | {unit} | {about} |");
    }
    page += "\n| flag | name | it is on when |\n|---|---|---|\n";
    for (bit, name, about) in FRAME_FLAGS {
        let _ = writeln!(page, "| {bit} | `{name}` | {about} |");
    }
    page
}

/// Returns the tables of errors and close codes.
pub(super) fn errors() -> String {
    let mut page = "
## Errors

An error has a `code`, a sentence as `message`, and `data`. Codes from -32700 to -32600 are JSON-RPC's own. Decide by `code`, then by `data.kind`, of the driver's errors by `data.code`; never by the message.
[ErrorData](#errordata) says what the members of `data` are.

A client that says it in another language, or calls options by its own names, does so by two further members: `template` is the English
sentence with the names of its `values` in braces, and stays the same whatever the values are. Notes, complaints and the error of a job
have them too. A value is a `text` (a number or a quotation, as it is printed), an `option` by its name, or has a `template` of its own.
A sentence whose template is not known is shown in English: the template with its values.

| code | `data.kind` | meaning | further `data`, where it applies |
|---|---|---|---|
"
    .to_owned();
    for row in ERRORS {
        let kind = match row.kind {
            "" => String::new(),
            kind => format!("`{kind}`"),
        };
        let data: Vec<_> = row.data.iter().map(|name| format!("`{name}`")).collect();
        let (code, about, data) = (row.code, row.about, data.join(", "));
        let _ = writeln!(page, "| {code} | {kind} | {about} | {data} |");
    }
    page += "\nA socket is closed with\n\n| code | when |\n|---|---|\n";
    for (code, about) in CLOSE_CODES {
        let _ = writeln!(page, "| {code} | {about} |");
    }
    page
}

fn features() -> String {
    let mut page = "
## Features

`features` of `server.info` names what this station can do. What is not in the list is not there: its methods are -32601, refused as a parameter, or `unsupported`.

| feature | what a client can do then |
|---|---|
"
    .to_owned();
    for row in FEATURES {
        let _ = writeln!(page, "| `{}` | {} |", row.name, row.about);
    }
    page
}

fn notifications() -> String {
    let mut page = "
## Notifications

What a station tells by itself. Nothing else comes. In the examples *Ada* and *Ben* are clients; a test runs them.

| notification | who gets it |
|---|---|
"
    .to_owned();
    for row in NOTIFICATIONS {
        let (name, to) = (row.name, row.to);
        let anchor = name.replace('.', "");
        let _ = writeln!(page, "| [`{name}`](#{anchor}) | {to} |");
    }
    for row in NOTIFICATIONS {
        let (name, when) = (row.name, row.when);
        let _ = write!(page, "\n### {name}\n\n{when} *{}*\n\n", row.to);
        if !row.channel.is_empty() {
            let _ = write!(page, "{}\n\n", row.channel);
        }
        page += &members(row.params);
        if name == Notice::ArmEvent.name() {
            page += "\nFurther members by `event`: see [events](#events).\n";
        }
        page += &example(name, name);
    }
    page
}

fn events() -> String {
    let mut page = "
## Events

Kinds of `arm.event`, with their members beside `arm`, `seq`, `t` and `event`. Where a fact has a channel of its own that one is for deciding, and the event for the log.

| event | when | further members | decide by |
|---|---|---|---|
"
    .to_owned();
    for row in EVENTS {
        let further = row.members.iter().map(|member| {
            let kind = member.shape.describe();
            let may = if member.optional {
                ", may be missing"
            } else {
                ""
            };
            format!("`{}` ({kind}{may}): {}", member.name, member.describe())
        });
        let further: Vec<_> = further.collect();
        let (name, when, instead) = (row.name, row.when, row.instead);
        let further = further.join("; ");
        let _ = writeln!(page, "| `{name}` | {when} | {further} | {instead} |");
    }
    page += "\n```text\n";
    for row in EVENTS {
        if let Some(example) = NotificationExample::of(row.name) {
            let _ = writeln!(page, "{}", example.params);
        }
    }
    page += "```\n";
    page
}

/// Returns an example of a notification as messages.
fn example(name: &str, method: &str) -> String {
    let Some(example) = NotificationExample::of(name) else {
        return String::new();
    };
    let mut text = "\n```text\n".to_owned();
    for said in &example.after {
        if said.method == Notice::ServerEnding.name() {
            let _ = writeln!(text, "the station is ended");
            continue;
        }
        let request = json!({"method": said.method, "params": said.params});
        let _ = writeln!(text, "{} --> {request}", said.client);
    }
    let told = json!({"method": method, "params": example.params});
    let _ = writeln!(text, "{} <-- {told}\n```", example.recipient);
    text
}

/// Returns the named types.
pub(super) fn types() -> String {
    let mut page = "\n## Types\n\nObjects that stand in several places. *May be null* says what null means; all members are there unless they *may be missing*.\n".to_owned();
    for one in TYPES {
        let _ = write!(page, "\n### {}\n\n{}\n\n", one.name, one.about);
        page += &members(one.members);
    }
    for (name, about) in OTHERS {
        let _ = write!(page, "\n### {name}\n\n{about}\n");
    }
    page
}

fn members(members: &[Member]) -> String {
    let mut text = "| member | value | unit | meaning | null |\n|---|---|---|---|---|\n".to_owned();
    for member in members {
        let may = if member.optional {
            ", may be missing"
        } else {
            ""
        };
        let (name, kind, unit) = (member.name, member.shape.describe(), member.unit);
        let (about, null) = (member.about, member.null.unwrap_or_default());
        let _ = writeln!(
            text,
            "| `{name}` | {kind}{may} | {unit} | {about} | {null} |"
        );
    }
    text
}
