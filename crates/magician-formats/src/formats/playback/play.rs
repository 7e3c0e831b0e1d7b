//! What the arm does for a playback file.

use std::collections::HashMap;

use magician_motion::{
    ArmModel, ArmState, Ceilings, Geometry, JointAngles, MotionError, Planner, Pose,
};

use super::{Playback, Point, PointMotion, Row};
use crate::formats::rail::RailCourse;
use crate::{Action, Diagnostic, Grip, Origin, Parsed, Plan, Tool, Travel};

/// Points nearer than this are the same to the arm, mm (model section 15a).
const SAME: f64 = 1e-4;

impl Playback {
    /// What the arm does for it: for each row the move, then what the tool does, then the pause.
    ///
    /// Where a row has a position on the rail other than 0, every move takes the rail along, to that of its row.
    ///
    /// The tool is told in the first row and where a row wants something else of it than the one before: players tell it in
    /// every row, which changes nothing, as a tool that is told twice does what it did.
    ///
    /// An arc whose three points (the end of the row before is the first) make no circle, because two of them are the same or
    /// all are on one line, would stop the arm with alarm 0x13 or 0x14 (model section 9). Files have such arcs, so they are
    /// played as straight lines through the same points, and a note says so. The start of the first row is unknown; its
    /// arc is left to the arm.
    #[must_use]
    pub fn to_plan(&self) -> Parsed<Plan> {
        let mut player = Player {
            plan: Plan {
                tool: self.tool(),
                ..Plan::default()
            },
            rail: RailCourse::of(self.rows.iter().map(|row| row.point.rail)),
            ..Player::default()
        };
        player.notes.extend(player.rail.note());
        for row in &self.rows {
            player.play(row);
        }
        Parsed {
            content: player.plan,
            notes: player.notes,
        }
    }
}

#[derive(Default)]
struct Player {
    plan: Plan,
    notes: Vec<Diagnostic>,
    names: HashMap<String, usize>,
    /// Where the last row ended.
    at: Option<[f32; 4]>,
    gripper: Option<Grip>,
    suction: Option<bool>,
    rail: RailCourse,
}

impl Player {
    fn play(&mut self, row: &Row) {
        let Point {
            gripper,
            suction,
            pause,
            ..
        } = row.point;
        let name = self.name(row);
        let places = row.places;
        self.go(row, places.motion.named(name));
        // Of a file that has both columns only the one counts that it uses.
        let gripper = gripper.filter(|_| self.plan.tool != Some(Tool::Suction));
        if let Some(grip) = gripper.filter(|grip| self.gripper != Some(*grip)) {
            self.plan
                .push(Action::Gripper(grip), places.gripper.named(name));
            self.gripper = Some(grip);
        }
        let suction = suction.filter(|_| self.plan.tool != Some(Tool::Gripper));
        if let Some(on) = suction.filter(|on| self.suction != Some(*on)) {
            self.plan
                .push(Action::Suction(on), places.suction.named(name));
            self.suction = Some(on);
        }
        if pause > 0 {
            self.plan
                .push(Action::Wait(pause), places.pause.named(name));
        }
        self.at = Some(row.point.to);
    }

    /// The name that complaints about a row use: its point's, else its own.
    fn name(&mut self, row: &Row) -> usize {
        let name = match row.point.name.as_str() {
            "" => format!("row{}", row.number),
            name => name.to_owned(),
        };
        if let Some(known) = self.names.get(&name) {
            return *known;
        }
        let index = self.plan.name(name.clone());
        self.names.insert(name, index);
        index
    }

    fn go(&mut self, row: &Row, origin: Origin) {
        if let (Some(from), PointMotion::Arc { via }) = (self.at, row.point.way)
            && let Some(why) = no_circle(from, via, row.point.to)
        {
            let lines = straight(from, via, row.point.to);
            let how = match lines.as_slice() {
                [_] => "a straight line to its end",
                _ => "straight lines through its points",
            };
            let note = format!("{why}, so it is not an arc: it is played as {how}");
            let name = format!("row{}", row.number);
            self.notes
                .push(Diagnostic::new(row.places.motion, note).named(name));
            for to in lines {
                let by = Travel::Line;
                self.push(Action::Move { to, by }, row, origin);
            }
            return;
        }
        self.push(row.point.motion(), row, origin);
    }

    /// A motion, with the rail along. An arc on which the rail would move is refused by the reader.
    fn push(&mut self, motion: Action, row: &Row, origin: Origin) {
        let along = self.rail.lead(motion.clone(), row.point.rail);
        self.plan.push(along.unwrap_or(motion), origin);
    }
}

/// Why three points make no circle, by the arm's own measure.
fn no_circle(from: [f32; 4], via: [f32; 4], to: [f32; 4]) -> Option<&'static str> {
    let [from, via, to] = [from, via, to].map(|pose| Pose::from(pose.map(f64::from)));
    let planner = Planner {
        geometry: Geometry::default(),
        limits: ArmModel::MAGICIAN.certain,
        ceilings: Ceilings::default(),
        law: ArmModel::MAGICIAN.law,
        speeds: ArmModel::MAGICIAN.power_up.speeds(),
    };
    // Only the three points are asked about: whether the arm gets there depends on its tool, and is for the check.
    let from = ArmState {
        joints: JointAngles::HOME,
        pose: from,
    };
    match planner.arc(&from, &via, &to) {
        Err(MotionError::Coincident) => Some("two of its three points are the same"),
        Err(MotionError::Collinear) => Some("its three points are on one line"),
        _ => None,
    }
}

/// The corners of the way that goes straight through points which make no circle. r changes evenly, as on an arc.
fn straight(from: [f32; 4], via: [f32; 4], to: [f32; 4]) -> Vec<[f32; 4]> {
    let [ahead, on] = [(from, via), (via, to)].map(|(a, b)| {
        let between = |axis: usize| f64::from(b[axis]) - f64::from(a[axis]);
        [between(0), between(1), between(2)]
    });
    let length = |way: [f64; 3]| way.iter().map(|part| part * part).sum::<f64>().sqrt();
    let (first, second) = (length(ahead), length(on));
    let forwards = ahead.iter().zip(on).map(|(a, b)| a * b).sum::<f64>() > 0.0;
    if first < SAME || second < SAME || forwards {
        return vec![to];
    }
    let [x, y, z, _] = via;
    let (start, end) = (f64::from(from[3]), f64::from(to[3]));
    let r = start + (end - start) * (first / (first + second));
    vec![[x, y, z, r as f32], to]
}
