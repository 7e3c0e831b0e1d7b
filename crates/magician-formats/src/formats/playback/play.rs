//! Conversion of playback files to plans.

use std::collections::HashMap;

use magician_host::{Message, message};
use magician_motion::{
    ArmModel, ArmState, Ceilings, Geometry, JointAngles, MotionError, Planner, Pose,
};

use super::{Playback, Point, PointMotion, Row};
use crate::formats::rail::RailCourse;
use crate::{Action, Diagnostic, Grip, Origin, Parsed, Plan, Tool, Travel};

/// Distance below which points coincide for the arm, mm (model section 15a).
const POINT_TOLERANCE: f64 = 1e-4;

impl Playback {
    /// Converts the file to a plan: for each row the move, then the tool's action, then the pause.
    ///
    /// If any row has a rail position other than 0, every move also moves the rail.
    ///
    /// A tool command is added only in the first row and where a row changes the tool's state.
    /// DobotStudio sends it in every row, which has the same effect.
    ///
    /// An arc whose three points (the first is the end of the previous row) do not define a circle
    /// would stop the arm with alarm 0x13 or 0x14 (model section 9). Since files contain such arcs,
    /// they become straight lines through the same points, with a note. The start of an arc in the
    /// first row is unknown, so the arm decides about that one.
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
    /// End of the last row.
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
        // If the file has both columns, only the one in use counts.
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

    /// Returns the index of the name that messages use for a row: that of its point, else `rowN`.
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
            && let Some(why) = degenerate_arc(from, via, row.point.to)
        {
            let lines = straight(from, via, row.point.to);
            let how = match lines.as_slice() {
                [_] => message!("a straight line to its end"),
                _ => message!("straight lines through its points"),
            };
            let note = message!(
                "{why}, so it is not an arc: it is played as {how}",
                why,
                how
            );
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

    /// Adds a motion with the rail. The reader has refused arcs during which the rail would move.
    fn push(&mut self, motion: Action, row: &Row, origin: Origin) {
        let along = self.rail.with_rail(motion.clone(), row.point.rail);
        self.plan.push(along.unwrap_or(motion), origin);
    }
}

/// Returns why three points do not define a circle by the arm's own criteria; `None` if they do.
fn degenerate_arc(from: [f32; 4], via: [f32; 4], to: [f32; 4]) -> Option<Message> {
    let [from, via, to] = [from, via, to].map(|pose| Pose::from(pose.map(f64::from)));
    let planner = Planner {
        geometry: Geometry::default(),
        limits: ArmModel::MAGICIAN.certain,
        ceilings: Ceilings::default(),
        law: ArmModel::MAGICIAN.law,
        speeds: ArmModel::MAGICIAN.power_up.speeds(),
    };
    // Only the three points matter here. Whether the arm reaches them depends on its tool and is
    // checked later.
    let from = ArmState {
        joints: JointAngles::HOME,
        pose: from,
    };
    match planner.arc(&from, &via, &to) {
        Err(MotionError::Coincident) => Some(message!("two of its three points are the same")),
        Err(MotionError::Collinear) => Some(message!("its three points are on one line")),
        _ => None,
    }
}

/// Returns the corners of the straight way through points that do not define a circle. r changes
/// linearly, as on an arc.
fn straight(from: [f32; 4], via: [f32; 4], to: [f32; 4]) -> Vec<[f32; 4]> {
    let [ahead, on] = [(from, via), (via, to)].map(|(a, b)| {
        let between = |axis: usize| f64::from(b[axis]) - f64::from(a[axis]);
        [between(0), between(1), between(2)]
    });
    let length = |way: [f64; 3]| way.iter().map(|part| part * part).sum::<f64>().sqrt();
    let (first, second) = (length(ahead), length(on));
    let forwards = ahead.iter().zip(on).map(|(a, b)| a * b).sum::<f64>() > 0.0;
    if first < POINT_TOLERANCE || second < POINT_TOLERANCE || forwards {
        return vec![to];
    }
    let [x, y, z, _] = via;
    let (start, end) = (f64::from(from[3]), f64::from(to[3]));
    let r = start + (end - start) * (first / (first + second));
    vec![[x, y, z, r as f32], to]
}
