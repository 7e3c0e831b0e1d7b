//! Baseline for comparison: a simulation of the arm in steps of a fixed length.
//!
//! The stepped simulation belongs to this benchmark and is as simple as such a simulation can be.
//! It runs the same commands with the same acceleration, but each step adds acceleration × step to
//! the speed and speed × step to the position, and updates joints and pose by the same kinematics.
//! It does less than the virtual arm: no bytes, queue, replies or limits. It is also less exact: a
//! motion ends up to one step early or late.

use std::error::Error;
use std::hint::black_box;

use magician_motion::{Geometry, JointAngles, Pose, ToolBias};
use magician_protocol::PtpMode;
use magician_protocol::commands::{CpCmd, PtpCmd};

use super::figure::{Figure, rate};
use super::program::{pick_and_place, ring};
use super::speed;

/// Commands of a round.
const MOVES: usize = 96;
const SEGMENTS: usize = 2_000;
/// Speed and acceleration of a move, in mm or deg. Half of the settings at power-up: 200 mm/s,
/// 200 mm/s², 200 deg/s and 200 deg/s².
const MOVE_LIMITS: (f64, f64) = (100.0, 100.0);
/// Speed and acceleration of a path at power-up.
const PATH_LIMITS: (f64, f64) = (100.0, 100.0);
/// Look-ahead of the path with a queue full of segments of 1 mm, mm.
const LOOK_AHEAD_MM: f64 = 31.0;

struct Stepped {
    geometry: Geometry,
    step: f64,
    joints: JointAngles,
    pose: Pose,
    steps: u64,
}

impl Stepped {
    fn new(step: f64) -> Self {
        let geometry = Geometry::magician(ToolBias::SUCTION);
        let joints = JointAngles::HOME;
        Self {
            pose: geometry.forward(&joints),
            geometry,
            step,
            joints,
            steps: 0,
        }
    }

    /// Covers a distance in steps, never faster than the arm can still brake. Each step calls `at`
    /// with the share of the distance covered.
    fn cover_distance(
        &mut self,
        distance: f64,
        (max_speed, acceleration): (f64, f64),
        mut on_step: impl FnMut(&mut Self, f64),
    ) {
        let (mut done, mut speed) = (0.0, 0.0);
        while done < distance {
            let brakes_in_time = (2.0 * acceleration * (distance - done)).sqrt();
            let accelerated: f64 = speed + acceleration * self.step;
            speed = accelerated
                .min(max_speed)
                .min(brakes_in_time.max(acceleration * self.step));
            done += speed * self.step;
            on_step(self, (done / distance).min(1.0));
            self.steps += 1;
            black_box((&self.joints, &self.pose));
        }
    }

    fn move_joints_to(&mut self, to: &Pose) {
        let (from, to) = (self.joints.to_array(), self.inverse(to).to_array());
        let distance = from
            .iter()
            .zip(to)
            .map(|(from, to)| (to - from).abs())
            .fold(0.0, f64::max);
        self.cover_distance(distance, MOVE_LIMITS, |arm, share| {
            let joint = |at: usize| from[at] + (to[at] - from[at]) * share;
            arm.joints = JointAngles::new(joint(0), joint(1), joint(2), joint(3));
            arm.pose = arm.geometry.forward(&arm.joints);
        });
    }

    fn move_straight_to(&mut self, to: &Pose) {
        let (from, distance) = (self.pose, self.pose.distance_to(to));
        self.cover_distance(distance, MOVE_LIMITS, |arm, share| {
            arm.set_between(&from, to, share)
        });
    }

    fn set_between(&mut self, from: &Pose, to: &Pose, share: f64) {
        let (from, to) = (from.to_array(), to.to_array());
        let value = |at: usize| from[at] + (to[at] - from[at]) * share;
        self.pose = Pose::new(value(0), value(1), value(2), value(3));
        self.joints = self.inverse(&self.pose);
    }

    fn inverse(&self, pose: &Pose) -> JointAngles {
        self.geometry
            .inverse(pose)
            .expect("the programs stay within reach")
    }

    fn point_to_point(&mut self, command: &PtpCmd) {
        let [x, y, z, r] = [command.x, command.y, command.z, command.r].map(f64::from);
        let to = Pose::new(x, y, z, r);
        match command.ptp_mode {
            PtpMode::MovjXyz => self.move_joints_to(&to),
            PtpMode::MovlXyz => self.move_straight_to(&to),
            _ => {
                let top = self.pose.z.max(z) + 20.0;
                self.move_straight_to(&Pose {
                    z: top,
                    ..self.pose
                });
                self.move_joints_to(&Pose { z: top, ..to });
                self.move_straight_to(&to);
            }
        }
    }

    /// Runs a path, never faster than the arm can still brake within the look-ahead.
    fn path(&mut self, commands: &[CpCmd]) {
        let (max_speed, acceleration) = PATH_LIMITS;
        let (mut speed, mut carried_over) = (0.0_f64, 0.0);
        let mut left = 0.0;
        let mut place = self.pose;
        for command in commands {
            let next = point(command, place.r);
            left += place.distance_to(&next);
            place = next;
        }
        let mut from = self.pose;
        for command in commands {
            let to = point(command, from.r);
            let length = from.distance_to(&to);
            let mut done: f64 = carried_over;
            while done < length {
                let brakes_in_time = (2.0 * acceleration * (left - done).min(LOOK_AHEAD_MM))
                    .max(0.0)
                    .sqrt();
                let accelerated = speed + acceleration * self.step;
                speed = accelerated
                    .min(max_speed)
                    .min(brakes_in_time.max(acceleration * self.step));
                done += speed * self.step;
                self.set_between(&from, &to, (done / length).min(1.0));
                self.steps += 1;
                black_box((&self.joints, &self.pose));
            }
            carried_over = done - length;
            left -= length;
            from = to;
        }
    }

    fn seconds(&self) -> f64 {
        self.steps as f64 * self.step
    }
}

fn point(command: &CpCmd, r: f64) -> Pose {
    let [x, y, z] = [command.x, command.y, command.z].map(f64::from);
    Pose::new(x, y, z, r)
}

/// Returns the best rate in arm-seconds per second with this step, and the duration by the
/// simulation's own time.
fn stepped_rate(step: f64, work: impl Fn(&mut Stepped)) -> (f64, f64) {
    let mut duration = 0.0;
    let (_, best) = rate(|| {
        let mut arm = Stepped::new(step);
        work(&mut arm);
        duration = arm.seconds();
        duration
    });
    (best, duration)
}

/// Work for a stepped arm.
type Work<'a> = &'a dyn Fn(&mut Stepped);

/// Measures virtual and stepped arm side by side.
pub(super) fn measure() -> Result<Vec<Figure>, Box<dyn Error>> {
    let moves: Vec<PtpCmd> = pick_and_place().into_iter().cycle().take(MOVES).collect();
    let segments: Vec<CpCmd> = ring().into_iter().cycle().take(SEGMENTS).collect();
    let mut figures = Vec::new();
    let works: [(&str, f64, Work<'_>); 2] = [
        ("ptp", speed::ptp_rate(), &|arm| {
            moves.iter().for_each(|command| arm.point_to_point(command))
        }),
        ("cp 1 mm", speed::cp_rate(), &|arm| {
            arm.pose = Pose::new(180.0, 0.0, 10.0, 0.0);
            arm.path(&segments);
        }),
    ];
    for (name, virtual_arm, work) in works {
        for (step, unit) in [(0.001, "1 ms"), (0.02, "20 ms")] {
            let (rate, duration) = stepped_rate(step, work);
            figures.push(
                Figure::new(
                    format!("{name}, ratio to steps of {unit}"),
                    virtual_arm / rate,
                    "times as fast",
                )
                .with("virtual arm-seconds/s", virtual_arm)
                .with("stepped arm-seconds/s", rate)
                .with("stepped s of a round", duration),
            );
        }
    }
    Ok(figures)
}
