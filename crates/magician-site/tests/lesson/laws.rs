//! Laws that hold in every lesson.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};

use crate::LESSON;
use crate::class::{STATIONS, pupils};
use crate::drawing::check_strokes;
use crate::room::Room;

/// Checks all stations every second: every holder of an arm has its turn, and is within its slot.
pub(crate) async fn watches(room: Arc<Room>) {
    let mut held = 0;
    loop {
        tokio::time::sleep(Duration::from_secs(1)).await;
        let now = room.now();
        if now > LESSON + Duration::from_secs(25) {
            break;
        }
        for station in 1..=STATIONS.len() as u64 {
            let arms = room.ask(station, "arm.list", json!({})).await;
            let turns = room.ask(station, "turn.list", json!({})).await;
            for row in arms["arms"].as_array().unwrap() {
                let holder = row["holder"]["name"].as_str();
                let Some(holder) = holder else { continue };
                held += 1;
                let of = |turn: &&Value| turn["arm"] == row["name"];
                let turn = turns["arms"].as_array().unwrap().iter().find(of).unwrap();
                let fine = holder == "Ms Lee" || turn["person"] == holder;
                assert!(
                    fine,
                    "{now:?}: {holder} holds {row} without the turn: {turn}"
                );
                assert!(
                    now <= LESSON + Duration::from_secs(1),
                    "{now:?}: {holder} holds {} after the lesson",
                    row["name"]
                );
            }
        }
    }
    assert!(held > 1000, "somebody held an arm: {held}");
}

/// Checks the laws that can only be judged at the end.
pub(crate) async fn hold(room: &Room) {
    one_holder(room);
    every_pupil_had_a_turn(room);
    drawn_once(room).await;
    results(room).await;
}

/// By the notes of all pages, no arm had two pupils at a time.
fn one_holder(room: &Room) {
    let mut notes = room.notes.lock().unwrap();
    notes
        .spans
        .sort_by(|a, b| (&a.arm, a.from).cmp(&(&b.arm, b.from)));
    for two in notes.spans.windows(2) {
        let [one, next] = two else { continue };
        let apart = one.arm != next.arm || one.until <= next.from;
        let (arm, from) = (&one.arm, next.from);
        assert!(
            apart,
            "{arm} had {} and {} at {from:?}",
            one.person, next.person
        );
    }
}

fn every_pupil_had_a_turn(room: &Room) {
    let notes = room.notes.lock().unwrap();
    for pupil in pupils() {
        assert!(
            notes.turns.contains_key(pupil.name),
            "{} had no turn",
            pupil.name
        );
    }
    assert!(
        notes.reloads > 5,
        "{} pages were loaded anew",
        notes.reloads
    );
}

/// Each paper has the strokes of its jobs, each exactly once.
async fn drawn_once(room: &Room) {
    let jobs = room.notes.lock().unwrap().jobs.clone();
    let mut by_arm: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for job in jobs {
        let shown = room
            .ask(job.station, "job.get", json!({"job": job.job}))
            .await;
        if let Some(started) = shown["started"].as_f64() {
            let end = if job.interrupted {
                "interrupted"
            } else {
                "done"
            };
            assert_eq!(shown["state"], end, "{shown}");
            let row = (started, job.strokes, job.interrupted);
            by_arm.entry(job.arm).or_default().push(row);
        }
    }
    assert_eq!(by_arm.len(), 10);
    for (arm, mut rows) in by_arm {
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        let plans: Vec<_> = rows.into_iter().map(|row| (row.1, row.2)).collect();
        let drawing = room.cell(&arm).with(|arm| arm.drawing());
        let paper: Vec<_> = { drawing.strokes().iter() }
            .map(|stroke| stroke.points.clone())
            .collect();
        if let Err(why) = check_strokes(&paper, &plans) {
            panic!("{arm}, {} drawings: {why}", plans.len());
        }
    }
}

/// Each drawing is listed under the name of its pupil.
async fn results(room: &Room) {
    let mut of: BTreeMap<(u64, String), String> = BTreeMap::new();
    for station in 1..=STATIONS.len() as u64 {
        let answer = room.ask(station, "class.results", json!({})).await;
        for result in answer["results"].as_array().unwrap() {
            let text = |name: &str| result[name].as_str().unwrap().to_owned();
            of.insert((station, text("job")), text("pupil"));
        }
    }
    let jobs = room.notes.lock().unwrap().jobs.clone();
    for job in &jobs {
        let shown = room
            .ask(job.station, "job.get", json!({"job": job.job}))
            .await;
        let kept = of.get(&(job.station, job.job.clone())).map(String::as_str);
        let expected = job.pupil.filter(|_| shown["state"] == "done");
        assert_eq!(kept, expected, "{shown}");
    }
    for pupil in pupils() {
        assert!(
            of.values().any(|name| name == pupil.name),
            "{} has no result",
            pupil.name
        );
    }
}
