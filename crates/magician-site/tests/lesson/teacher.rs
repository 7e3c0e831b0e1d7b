//! Behaviour of the teacher at the hub, and faults of the network.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::{Value, json};

use crate::bench::Tester;
use crate::class::{STATIONS, station_of};
use crate::drawing::{plan, strokes};
use crate::pictures::Camera;
use crate::room::{Room, Started};

const TEACHER: &str = "Ms Lee";

struct Teacher {
    room: Arc<Room>,
    hub: Tester,
    camera: Camera,
}

pub(crate) async fn teaches(room: Arc<Room>) {
    let hub = room.bench.join(TEACHER).await;
    let camera = Camera::of(&room.bench.hub).await;
    let mut teacher = Teacher { room, hub, camera };
    teacher
        .room
        .log_event(TEACHER, "opens the hub: ten arms at four stations");
    teacher.camera.takes("start").await;
    teacher.waits(10, 0).await;
    teacher.camera.takes("work").await;
    teacher.network().await;
    teacher.freezes().await;
    teacher.takes_one().await;
    teacher.sends().await;
    teacher.waits(44, 50).await;
    teacher.camera.takes("end").await;
    teacher.waits(45, 0).await;
    teacher
        .room
        .log_event("bell", "the slot of the lesson is over");
    teacher.waits(45, 30).await;
}

impl Teacher {
    async fn waits(&mut self, minute: u64, second: u64) {
        let until = Duration::from_secs(60 * minute + second);
        let left = until.saturating_sub(self.room.now());
        self.hub.run_for(left).await;
    }

    /// Unplugs the network cable of the third station for two minutes.
    async fn network(&mut self) {
        self.waits(11, 40).await;
        let before = self.jobs_of(3).await;
        self.room.site.cut(3);
        self.room
            .log_event("cable", "the network cable of a7 and a8 is out");
        self.waits(11, 50).await;
        self.camera.takes("cut").await;
        self.waits(13, 40).await;
        // The station has continued its jobs without the network.
        let mut done = 0;
        assert!(!before.is_empty(), "a job runs when the cable is cut");
        for job in before {
            let now = self.room.ask(3, "job.get", json!({"job": job})).await;
            assert_eq!(now["state"], "done", "{now}");
            done += 1;
        }
        self.room.site.restore_station(magician_site::StationId(3));
        self.room.log_event(
            "cable",
            format!("is in again; jobs that ran and have come to their end meanwhile: {done}"),
        );
    }

    /// Running jobs of a station.
    async fn jobs_of(&self, station: u64) -> Vec<Value> {
        let mut running = Vec::new();
        for arm in STATIONS[station as usize - 1] {
            let list = self
                .room
                .ask(station, "job.list", json!({"arm": arm}))
                .await;
            let jobs = list["jobs"].as_array().unwrap().iter();
            let runs = jobs.filter(|job| job["state"] == "running");
            running.extend(runs.map(|job| job["job"].clone()));
        }
        running
    }

    async fn freezes(&mut self) {
        self.waits(24, 0).await;
        self.room.was_frozen.store(true, Ordering::SeqCst);
        self.room.frozen.store(true, Ordering::SeqCst);
        self.hub.ok("class.freeze", json!({})).await;
        self.room.log_event(TEACHER, "freezes all arms");
        self.hub.run_for(Duration::from_millis(1500)).await;
        let stood = self.stand();
        self.hub.run_for(Duration::from_secs(20)).await;
        self.camera.takes("frozen").await;
        self.waits(25, 0).await;
        assert_eq!(self.stand(), stood, "an arm moved while it was frozen");
        self.hub.ok("class.free", json!({})).await;
        self.room.frozen.store(false, Ordering::SeqCst);
        self.room.log_event(TEACHER, "frees all arms");
    }

    /// Positions of all arms.
    fn stand(&self) -> Vec<[f64; 4]> {
        let arms = STATIONS.concat();
        arms.iter()
            .map(|arm| self.room.cell(arm).state().joints.to_array())
            .collect()
    }

    async fn takes_one(&mut self) {
        self.waits(33, 0).await;
        let lease = self.hub.take_arm("a2").await;
        self.room.log_event(TEACHER, "takes a2");
        // The running job is paused first.
        self.hub.run_for(Duration::from_secs(20)).await;
        let state = self.hub.ok("arm.state", json!({"arm": "a2"})).await;
        assert_eq!(state["moving"], false, "{state}");
        self.hub.ok("lease.release", json!({"lease": lease})).await;
        self.room.log_event(TEACHER, "gives a2 back");
    }

    async fn sends(&mut self) {
        self.waits(42, 0).await;
        let strokes = strokes("★★");
        let text = plan("stars", &strokes);
        let sent = self.hub.ok("class.send", json!({"text": text})).await;
        let (mut free, mut waits) = (0, 0);
        for job in sent["jobs"].as_array().unwrap() {
            match job["state"].as_str() {
                Some("queued") => waits += 1,
                _ => free += 1,
            }
            let arm = job["arm"].as_str().unwrap().to_owned();
            // Number of the station at the hub, and id of the job at the station.
            let (_, there) = job["job"].as_str().unwrap().split_once('.').unwrap();
            let started = Started {
                station: station_of(&arm),
                arm,
                job: there.to_owned(),
                pupil: None,
                strokes: strokes.clone(),
                interrupted: false,
            };
            self.room.notes.lock().unwrap().jobs.push(started);
        }
        self.room.log_event(
            TEACHER,
            format!("sends two stars to all arms: begun at {free}, waiting at {waits}"),
        );
    }
}
