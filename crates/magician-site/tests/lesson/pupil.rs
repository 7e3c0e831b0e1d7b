//! Behaviour of a pupil in the lesson.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use magician::sim::ExternalEvent;
use serde_json::{Value, json};

use crate::LESSON;
use crate::class::{self, Pupil};
use crate::drawing::{Strokes, plan, step_after, strokes};
use crate::page::Page;
use crate::room::{Room, Started};

const SECOND: Duration = Duration::from_secs(1);
/// Time after which no pupil asks for a turn.
const LAST_TURN_REQUEST: Duration = Duration::from_secs(40 * 60);
const END: Duration = Duration::from_secs(45 * 60 + 30);
/// Pupils with a special behaviour: one types a wrong code, one tries to move another pupil's arm,
/// one closes the tablet, and one pulls out a cable.
const MISTYPING_PUPIL: &str = "Finn";
const INTRUDING_PUPIL: &str = "Ebru";
const LEAVING_PUPIL: &str = "Mei";
const STUMBLING_PUPIL: &str = "Jiří";

struct Script {
    room: Arc<Room>,
    pupil: Pupil,
    /// State of the random generator (xorshift).
    random: u64,
    drawn: usize,
    did_special: bool,
}

pub(crate) async fn take_part(room: Arc<Room>, at: usize) {
    let pupil = class::pupils()[at].clone();
    let random = (at as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut script = Script {
        room,
        pupil,
        random,
        drawn: 0,
        did_special: false,
    };
    script.run().await;
}

impl Script {
    fn random_below(&mut self, most: u64) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 20) % most
    }

    fn log_event(&self, event: impl Into<String>) {
        self.room.log_event(self.pupil.name, event);
    }

    async fn run(&mut self) {
        let arm = self.pupil.arm;
        let arrival_ms = 20_000 + self.random_below(100_000);
        tokio::time::sleep(Duration::from_millis(arrival_ms)).await;
        if self.pupil.name == MISTYPING_PUPIL {
            let refused = Page::load(&self.room, &self.pupil, "0000").await;
            assert_eq!(refused.err().expect("a wrong code")["code"], -32001);
            self.log_event("types a wrong code and is not let in");
            tokio::time::sleep(10 * SECOND).await;
        }
        let mut page = self.load_page().await;
        self.log_event("signs in");
        self.join_queue(&mut page).await;
        let mut until_reload = self.random_below(90);
        loop {
            if page.closed {
                self.log_event("has lost the station");
                page = self.load_page().await;
                self.log_event(format!("is back: {}", turn_description(&page)));
                if !page.has_turn() && page.place().is_none() {
                    self.join_queue(&mut page).await;
                }
            }
            if page.has_turn() {
                self.use_turn(&mut page).await;
                if self.room.now() > LAST_TURN_REQUEST {
                    break;
                }
                if !page.has_turn() && !page.closed && page.place().is_none() {
                    self.join_queue(&mut page).await;
                }
                until_reload = self.random_below(400);
            } else if until_reload == 0 {
                until_reload = 1000;
                page = self.reload_page(page).await;
            } else if self.room.now() > LAST_TURN_REQUEST && !page.has_turn() {
                if page.call("turn.leave", json!({})).await.is_ok() {
                    self.log_event(format!("gives the place at {arm} up: it is late"));
                }
                break;
            } else {
                until_reload -= 1;
                page.run_for(SECOND).await;
            }
        }
        while self.room.now() < LESSON + 5 * SECOND {
            page.run_for(SECOND).await;
        }
        if self.pupil.name == INTRUDING_PUPIL {
            let refused = page.call("lease.acquire", json!({"arm": arm})).await;
            let refused = refused.expect_err("the lesson is over");
            assert_eq!(refused["code"], -32002, "{refused}");
            self.log_event(format!("asks for {arm} after the bell and is refused"));
        }
        while self.room.now() < END {
            page.run_for(SECOND).await;
        }
    }

    /// Loads the page, and tries again until that succeeds.
    async fn load_page(&self) -> Page {
        loop {
            let page = Page::load(&self.room, &self.pupil, &self.pupil.code).await;
            match page {
                Ok(page) => return page,
                Err(_) => tokio::time::sleep(2 * SECOND).await,
            }
        }
    }

    async fn reload_page(&mut self, page: Page) -> Page {
        let before = page.place();
        drop(page);
        tokio::time::sleep(2 * SECOND).await;
        let page = self.load_page().await;
        let kept = page.has_turn()
            || page
                .place()
                .is_some_and(|place| before.is_some_and(|before| place <= before));
        assert!(
            kept || before.is_none(),
            "{} had place {before:?} and has {:?}",
            self.pupil.name,
            page.place()
        );
        self.room.notes.lock().unwrap().reloads += 1;
        self.log_event(format!("loads the page anew: {}", turn_description(&page)));
        page
    }

    async fn join_queue(&mut self, page: &mut Page) {
        let arm = self.pupil.arm;
        if page.call("turn.join", json!({"arm": arm})).await.is_err() {
            return;
        }
        page.run_for(Duration::from_millis(50)).await;
        if page.has_turn() {
            return self.log_event(format!("asks for {arm}, which is free"));
        }
        self.log_event(format!("asks for {arm}: {}", turn_description(page)));
        if self.random_below(3) == 0 {
            let (text, strokes) = self.drawing();
            let params = json!({"arm": arm, "text": text, "queue": true, "on_lost": "continue"});
            if let Ok(job) = page.call("job.start", params).await {
                self.log_event("puts a drawing into the queue of the arm");
                self.record_job(&job, strokes);
            }
        }
    }

    /// Returns the pupil's drawing, as a plan and as strokes.
    fn drawing(&self) -> (String, Strokes) {
        let strokes = strokes(self.pupil.name);
        (plan(self.pupil.name, &strokes), strokes)
    }

    fn record_job(&mut self, job: &Value, strokes: Strokes) -> String {
        let id = job["job"].as_str().unwrap().to_owned();
        self.room.notes.lock().unwrap().jobs.push(Started {
            station: self.pupil.station,
            arm: self.pupil.arm.to_owned(),
            job: id.clone(),
            pupil: Some(self.pupil.name),
            strokes,
            interrupted: false,
        });
        id
    }

    async fn use_turn(&mut self, page: &mut Page) {
        let (name, arm) = (self.pupil.name, self.pupil.arm);
        *self
            .room
            .notes
            .lock()
            .unwrap()
            .turns
            .entry(name)
            .or_default() += 1;
        self.log_event(format!("has the turn at {arm}"));
        let pause_s = 5 + self.random_below(15);
        page.run_for(Duration::from_secs(pause_s)).await;
        if name == INTRUDING_PUPIL && self.drawn == 0 {
            let params = json!({"arm": "a5", "to": [220, 0, 30, 0]});
            let refused = page.call("arm.move", params).await.unwrap_err();
            assert_eq!(refused["code"], -32002, "{refused}");
            self.log_event("tries to move a5, whose turn is somebody else's, and is refused");
        }
        if self.random_below(2) == 0 {
            self.jog(page).await;
        }
        // A job that waits in the arm's queue starts by itself.
        let own_job = self.unfinished_job(page).await;
        let job = match own_job {
            Some(job) => job,
            None => match self.start_drawing(page).await {
                Some(job) => job,
                None => return,
            },
        };
        self.watch_job(page, &job).await;
        if page.closed || !page.has_turn() {
            return;
        }
        if self.random_below(4) == 0 {
            self.log_event("keeps the arm to the end of the turn");
            while page.has_turn()
                && !page.closed
                && self.room.now() < LAST_TURN_REQUEST + 2 * 60 * SECOND
            {
                page.run_for(SECOND).await;
            }
            if page.closed || !page.has_turn() {
                return;
            }
        }
        let pause_s = 5 + self.random_below(20);
        page.run_for(Duration::from_secs(pause_s)).await;
        if page.call("turn.leave", json!({})).await.is_ok() {
            page.run_for(Duration::from_millis(50)).await;
            self.log_event(format!("gives {arm} to the next"));
        }
    }

    async fn jog(&mut self, page: &mut Page) {
        let axis = ["x+", "y-", "z+"][self.random_below(3) as usize];
        let params = json!({"arm": self.pupil.arm, "axis": axis, "percent": 30});
        let Ok(jog) = page.call("jog.start", params).await else {
            return;
        };
        for _ in 0..8 {
            page.keep(&jog["jog"]).await;
            page.run_for(Duration::from_millis(100)).await;
        }
        if page
            .call("jog.stop", json!({"jog": jog["jog"]}))
            .await
            .is_ok()
        {
            self.log_event(format!("jogs {} to {axis}", self.pupil.arm));
        }
    }

    /// Unfinished drawing of this pupil, if any.
    async fn unfinished_job(&mut self, page: &mut Page) -> Option<String> {
        let jobs: Vec<_> = {
            let notes = self.room.notes.lock().unwrap();
            let jobs = notes.jobs.iter();
            let mine = jobs.filter(|job| job.pupil == Some(self.pupil.name));
            mine.map(|job| job.job.clone()).collect()
        };
        for job in jobs {
            let state = page.call("job.get", json!({"job": job})).await.ok()?;
            if ["queued", "checking", "running", "paused"].contains(&state["state"].as_str()?) {
                return Some(job);
            }
        }
        None
    }

    /// Starts a drawing. Tries again while the arm is frozen or has another job.
    async fn start_drawing(&mut self, page: &mut Page) -> Option<String> {
        let (text, strokes) = self.drawing();
        let params = json!({"arm": self.pupil.arm, "text": text, "on_lost": "continue"});
        while page.has_turn() && !page.closed {
            match page.call("job.start", params.clone()).await {
                Ok(job) => {
                    self.log_event("starts to draw");
                    return Some(self.record_job(&job, strokes));
                }
                Err(error) => {
                    let code = error["code"].as_i64().unwrap();
                    assert!(
                        [0, -32002, -32003, -32008].contains(&code),
                        "{}: {error}",
                        self.pupil.name
                    );
                    page.run_for(2 * SECOND).await;
                }
            }
        }
        None
    }

    async fn watch_job(&mut self, page: &mut Page, job: &str) {
        let mut job = job.to_owned();
        let mut seconds = 0;
        loop {
            page.run_for(SECOND).await;
            if page.closed {
                return;
            }
            seconds += 1;
            let Ok(state) = page.call("job.get", json!({"job": job})).await else {
                continue;
            };
            match state["state"].as_str().unwrap() {
                "done" => {
                    self.drawn += 1;
                    self.log_event("has drawn the name");
                    return;
                }
                "failed" => panic!("{}: {state}", self.pupil.name),
                "stopped" if !self.room.was_frozen.load(Ordering::SeqCst) => {
                    panic!("{}: {state}", self.pupil.name)
                }
                "paused" | "interrupted" | "stopped"
                    if page.has_turn() && !self.room.is_frozen() =>
                {
                    let resumed = page.call("job.resume", json!({"job": job})).await;
                    if resumed.is_ok() {
                        self.log_event("goes on with the drawing");
                    }
                }
                "queued" if !page.has_turn() => return,
                "running"
                    if self.pupil.name == LEAVING_PUPIL && !self.did_special && seconds > 5 =>
                {
                    self.did_special = true;
                    self.log_event("closes the tablet in the middle of the drawing");
                    page.shut();
                    *page = self.reopen_page(40).await;
                }
                "running"
                    if self.pupil.name == STUMBLING_PUPIL
                        && !self.did_special
                        && seconds > 8
                        && self.drawn > 0 =>
                {
                    self.did_special = true;
                    job = self.unplug_cable(page, &job).await;
                }
                _ => {}
            }
        }
    }

    async fn reopen_page(&mut self, seconds: u64) -> Page {
        tokio::time::sleep(Duration::from_secs(seconds)).await;
        let page = self.load_page().await;
        self.log_event(format!(
            "opens the tablet again: {}",
            turn_description(&page)
        ));
        page
    }

    /// Unplugs the USB cable of the arm for twenty seconds.
    async fn unplug_cable(&mut self, page: &mut Page, job: &str) -> String {
        let arm = self.pupil.arm;
        let cell = self.room.cell(arm);
        cell.with(|arm| arm.inject(ExternalEvent::Cable { plugged: false }));
        self.log_event(format!("stumbles over the USB cable of {arm}: it is out"));
        {
            let mut notes = self.room.notes.lock().unwrap();
            let known = { notes.jobs.iter_mut() }
                .find(|known| known.job == job && known.station == self.pupil.station);
            known.unwrap().interrupted = true;
        }
        page.run_for(20 * SECOND).await;
        let state = page.ok("job.get", json!({"job": job})).await;
        self.log_event(format!(
            "sees that the job is {}",
            state["state"].as_str().unwrap()
        ));
        cell.with(|arm| arm.inject(ExternalEvent::Cable { plugged: true }));
        self.log_event("puts the cable in again");
        page.run_for(5 * SECOND).await;
        // With the cable unplugged, the progress of the arm is unknown. The station says so, and
        // the pupil looks at the paper.
        let refused = page
            .call("job.resume", json!({"job": job}))
            .await
            .unwrap_err();
        assert_eq!(refused["data"]["kind"], "uncertain", "{refused}");
        self.log_event(format!("is told: {}", refused["message"].as_str().unwrap()));
        let (text, strokes) = self.drawing();
        let paper = cell.with(|arm| arm.drawing());
        let pen = *paper.strokes().last().unwrap().points.last().unwrap();
        let from = step_after(&strokes, pen);
        let params = json!({"arm": arm, "text": text, "on_lost": "continue", "from": from});
        let job = page.ok("job.start", params).await;
        self.log_event(format!("looks at the paper and goes on from step {from}"));
        self.record_job(&job, Strokes::new())
    }
}

/// Describes the pupil's turn as the page shows it.
fn turn_description(page: &Page) -> String {
    match (page.has_turn(), page.place()) {
        (true, _) => "the turn is there".to_owned(),
        (false, Some(place)) => format!("place {place}"),
        (false, None) => "no place".to_owned(),
    }
}
