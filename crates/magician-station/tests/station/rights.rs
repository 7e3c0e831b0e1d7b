//! Rights: the table in docs/reference/STATION.md for every method and role; every path to the
//! laser; queued jobs.

use std::collections::BTreeSet;
use std::time::Duration;

use magician_station::api::{Example, METHODS};
use magician_station::{Grant, Role};
use serde_json::{Map, Value, json};

use crate::bench::{LocalStation, Tester};

const FORBIDDEN: i64 = -32001;
const LEASE: i64 = -32002;
const DANGEROUS: i64 = -32005;

/// Columns of the table.
const CALLERS: [&str; 6] = ["viewer", "pupil", "student", "teacher", "holder", "owner"];

pub(crate) const CLASS: &str = r#"
[class]
turn_s = 0
pin = "482913"
[[pupil]]
name = "Ada"
code = "AAAA"
[[pupil]]
name = "Ben"
code = "BBBB"
[[pupil]]
name = "Cem"
code = "CCCC"
"#;

/// Row of the table: description, methods, and a cell for each of [`CALLERS`].
pub(crate) struct Row {
    pub(crate) what: String,
    pub(crate) methods: Vec<String>,
    pub(crate) cells: Vec<String>,
}

/// Returns the rows of the documented table.
pub(crate) fn table() -> Vec<Row> {
    let text = include_str!("../../../../docs/reference/STATION.md");
    let rows = text
        .lines()
        .skip_while(|line| !line.starts_with("| what | methods |"));
    let rows = rows.skip(2).take_while(|line| line.starts_with('|'));
    let read = rows.map(|line| {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        let methods = cells[1].split('`').skip(1).step_by(2);
        Row {
            what: cells[0].to_owned(),
            methods: methods.map(str::to_owned).collect(),
            cells: cells[2..].iter().map(|cell| (*cell).to_owned()).collect(),
        }
    });
    read.collect()
}

/// Class at one arm, which Ada holds and which runs her job; a job of Cem's waits.
pub(crate) struct ClassBench {
    pub(crate) bench: LocalStation,
    ada: Tester,
    cem: Tester,
    teacher: Tester,
    lease: Value,
    job: Value,
    waits: Value,
}

impl ClassBench {
    pub(crate) async fn new() -> Self {
        let bench = LocalStation::new(1).await;
        let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
        teacher.ok("class.set", json!({"text": CLASS})).await;
        let mut ada = pupil(&bench, "Ada", "AAAA").await;
        let lease = ada.lease().await;
        let job = ada.begin_job().await;
        let mut cem = pupil(&bench, "Cem", "CCCC").await;
        let waits = queue(&mut cem).await;
        Self {
            bench,
            ada,
            cem,
            teacher,
            lease,
            job,
            waits,
        }
    }

    /// Returns the session for a column.
    async fn who(&mut self, who: &str) -> Tester {
        match who {
            "viewer" => self.bench.join_as("viewer", Role::Viewer).await,
            "pupil" => pupil(&self.bench, "Ben", "BBBB").await,
            "student" => {
                let grant = Grant {
                    role: Role::Student,
                    token: Some("tablet".to_owned()),
                };
                let mut tester = self.bench.socket_of(Some(grant), "127.0.0.1:1");
                tester
                    .ok("session.hello", json!({"client": {"name": "tablet"}}))
                    .await;
                tester
            }
            // Sessions that exist already, on another socket of the same person, except for the
            // holder's.
            "owner" => std::mem::replace(&mut self.cem, self.bench.socket(None)),
            "holder" => std::mem::replace(&mut self.ada, self.bench.socket(None)),
            "teacher" => std::mem::replace(&mut self.teacher, self.bench.socket(None)),
            other => panic!("{other}"),
        }
    }

    /// Returns parameters that confirm the method.
    pub(crate) fn params(&self, row: &Row, method: &str) -> Map<String, Value> {
        let example = Example::of(method).unwrap();
        let mut params = example.params_after(&json!({"job": self.job, "lease": self.lease}));
        let named = params.as_object_mut().unwrap();
        if named.contains_key("job") {
            let waits = row.what.contains("waits");
            named.insert(
                "job".to_owned(),
                if waits { &self.waits } else { &self.job }.clone(),
            );
        }
        if named.contains_key("lease") {
            named.insert("lease".to_owned(), self.lease.clone());
        }
        if row.what.contains("fence") {
            named.insert("set".to_owned(), json!({"floor": -50}));
        } else if method == "arm.fence" {
            named.remove("set");
        }
        std::mem::take(named)
    }
}

async fn pupil(bench: &LocalStation, name: &str, code: &str) -> Tester {
    let mut page = bench.socket(None);
    let hello = json!({"client": {"name": "page"}, "pupil": {"name": name, "code": code}});
    page.ok("session.hello", hello).await;
    page
}

fn plan() -> String {
    let step = json!({"move": [220, 0, 20, 0]});
    json!({"format": "magician-plan", "version": 1, "steps": [step]}).to_string()
}

/// Queues a job while the arm is not free.
async fn queue(tester: &mut Tester) -> Value {
    let queued = tester
        .ok("job.start", json!({"text": plan(), "queue": true}))
        .await;
    let shown = tester.ok("job.get", json!({"job": queued["job"]})).await;
    assert_eq!(shown["state"], "queued");
    queued["job"].clone()
}

#[tokio::test(start_paused = true)]
async fn documented_rights_table_matches_the_station() {
    let rows = table();
    assert!(rows.len() >= 8, "{}", rows.len());
    let mut wrong = Vec::new();
    let mut named = BTreeSet::new();
    for row in &rows {
        assert_eq!(row.cells.len(), CALLERS.len(), "{}", row.what);
        for method in row
            .methods
            .iter()
            .filter(|method| *method != "session.hello")
        {
            let special = row.what.contains("waits") || row.what.contains("fence");
            let is_first = named.insert(method.clone());
            assert!(special || is_first, "{method} stands there twice");
            for (who, cell) in CALLERS.iter().zip(&row.cells) {
                let mut lesson = ClassBench::new().await;
                let mut tester = lesson.who(who).await;
                let mut params = Value::Object(lesson.params(row, method));
                let mut asker = lesson.bench.join_as("asker", Role::Teacher).await;
                if method == "lease.answer" {
                    asker.send("lease.ask", json!({}));
                    let sessions = asker.ok("session.list", json!({})).await["sessions"].clone();
                    let mut sessions = sessions.as_array().unwrap().iter();
                    let own = sessions.find(|one| one["name"] == "asker").unwrap();
                    params["session"] = own["session"].clone();
                }
                let outcome = tester.call(method, params).await;
                let code = outcome
                    .as_ref()
                    .err()
                    .and_then(|error| error["code"].as_i64());
                // A request for the lease is denied with the name of the holder.
                let asks = matches!(method.as_str(), "lease.acquire" | "lease.ask");
                let found = match code {
                    Some(FORBIDDEN) => "no",
                    Some(LEASE) if !asks => "lease",
                    _ => "yes",
                };
                if found != cell {
                    wrong.push(format!(
                        "{}: {method} as {who} is {found}, not {cell}: {outcome:?}",
                        row.what
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let all: BTreeSet<_> = { METHODS.iter().map(|method| method.name.to_owned()) }
        .filter(|name| name != "session.hello")
        .collect();
    let missing: Vec<_> = all.difference(&named).collect();
    assert!(
        missing.is_empty(),
        "not in the table of docs/reference/STATION.md: {missing:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn waiting_job_may_be_changed_by_owner_holder_and_teacher() {
    for who in CALLERS {
        let mut lesson = ClassBench::new().await;
        let waits = json!({"job": lesson.waits});
        let mut tester = lesson.who(who).await;
        let outcome = tester.call("job.stop", waits.clone()).await;
        let mut looks = lesson.bench.join_as("looks", Role::Viewer).await;
        let state = looks.ok("job.get", waits).await["state"].clone();
        if ["teacher", "holder", "owner"].contains(&who) {
            assert_eq!(outcome.unwrap()["state"], "stopped", "{who}");
            assert_eq!(state, "stopped", "{who}");
        } else {
            let error = outcome.unwrap_err();
            assert_eq!(error["code"], FORBIDDEN, "{who}: {error}");
            assert_eq!(error["data"]["may"], json!(["owner", "holder", "teacher"]));
            assert_eq!(error["data"]["needs"], "teacher");
            assert!(
                error["message"].as_str().unwrap().contains("its owner Cem"),
                "{error}"
            );
            assert_eq!(state, "queued", "{who}");
        }
        // Any session may stop a moving job.
        let mut anybody = lesson.bench.join_as("anybody", Role::Viewer).await;
        let stopped = anybody.ok("job.stop", json!({"job": lesson.job})).await;
        assert_eq!(stopped["state"], "stopped", "{who}");
    }
}

#[tokio::test(start_paused = true)]
async fn waiting_job_of_a_teacher_is_protected_from_strangers() {
    let mut lesson = ClassBench::new().await;
    let job = json!({"job": queue(&mut lesson.teacher).await});
    // An anonymous student does not own a job without an owner.
    let mut nobody = lesson.bench.join_as("nobody", Role::Student).await;
    assert_eq!(nobody.code("job.stop", job.clone()).await, FORBIDDEN);
    assert_eq!(nobody.code("job.resume", job.clone()).await, FORBIDDEN);
    // A second page of the holder counts as the holder.
    let mut page = pupil(&lesson.bench, "Ada", "AAAA").await;
    assert_eq!(page.ok("job.stop", job).await["state"], "stopped");
}

/// Paths to the laser.
const LASER_METHODS: [&str; 5] = ["arm.set", "arm.enqueue", "arm.tool", "job.start", "queue"];

fn burning(method: &str, yes: bool) -> Value {
    let plan = json!({"format": "magician-plan", "version": 1, "tool": "laser", "steps": [
        {"laser": true}, {"laser": false}]});
    let mut params = match method {
        "arm.set" => {
            json!({"command": "SetEndEffectorLaser", "fields": {"enable_ctrl": 1, "on": 1}})
        }
        "arm.enqueue" => json!({"command": "IODO", "fields": {"address": 2, "level": 1}}),
        "arm.tool" => json!({"laser": {"on": true}}),
        _ => json!({"text": plan.to_string()}),
    };
    if yes {
        params["yes"] = json!(true);
    }
    params
}

/// Returns the code with which a path to the laser is refused. `None` if it is permitted.
async fn lights(bench: &LocalStation, role: Role, method: &str, yes: bool) -> Option<i64> {
    let grant = Grant {
        role,
        token: Some("tablet".to_owned()),
    };
    let mut tester = bench.socket_of(Some(grant), "127.0.0.1:1");
    tester
        .ok("session.hello", json!({"client": {"name": "tablet"}}))
        .await;
    if method != "queue" {
        tester.lease().await;
        let outcome = tester.call(method, burning(method, yes)).await;
        return outcome.err().and_then(|error| error["code"].as_i64());
    }
    let mut holder = bench.join_as("holder", Role::Teacher).await;
    let lease = holder.lease().await;
    let mut params = burning(method, yes);
    params["queue"] = json!(true);
    let job = tester.ok("job.start", params).await;
    holder.ok("lease.release", json!({"lease": lease})).await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    let shown = tester.ok("job.get", job).await;
    // The job waits for a person who may confirm.
    (shown["reason"] == "yes").then_some(DANGEROUS)
}

#[tokio::test(start_paused = true)]
async fn every_laser_method_needs_the_same_role_and_confirmation() {
    for (is_virtual, students) in [(true, false), (false, false), (false, true)] {
        for role in [Role::Student, Role::Teacher] {
            for yes in [false, true] {
                for method in LASER_METHODS {
                    let bench = match (is_virtual, students) {
                        (true, _) => LocalStation::new(1).await,
                        (false, false) => LocalStation::real(1).await,
                        (false, true) => LocalStation::student_laser().await,
                    };
                    let found = lights(&bench, role, method, yes).await;
                    let may = students || role == Role::Teacher;
                    let expected = match (is_virtual, may, yes) {
                        (true, ..) | (false, true, true) => None,
                        (false, false, _) if method != "queue" => Some(FORBIDDEN),
                        _ => Some(DANGEROUS),
                    };
                    let told = format!(
                        "{method} by a {} with yes {yes}; virtual {is_virtual}, students {students}",
                        role.name()
                    );
                    assert_eq!(found, expected, "{told}");
                }
            }
        }
    }
}
