//! Sampling of a virtual arm at instants of the arm's clock.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician_protocol::commands::{EndEffectorParams, Pose};
use magician_sim::{ArmInstant, Controller, Observer};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use super::VirtualArm;
use crate::Sample;

/// All samplers of an arm.
#[derive(Clone, Debug, Default)]
pub(super) struct Samplers {
    all: Arc<Mutex<BTreeMap<u64, Sampler>>>,
}

#[derive(Debug)]
struct Sampler {
    tell: UnboundedSender<Sample>,
    began: ArmInstant,
    every: Duration,
    /// Time of the next sample while the arm moves.
    due: ArmInstant,
    moves: bool,
    last: Option<Sample>,
}

fn sample(arm: &Controller, began: ArmInstant) -> (Sample, bool) {
    let state = arm.state();
    let (pose, joints, tool) = (state.pose, state.joints, state.tool);
    let taken = Sample {
        t: (state.now - began).as_secs_f64(),
        pose: Pose {
            x: pose.x as f32,
            y: pose.y as f32,
            z: pose.z as f32,
            r: pose.r as f32,
            joint_angle: [joints.j1, joints.j2, joints.j3, joints.j4].map(|angle| angle as f32),
        },
        bias: EndEffectorParams {
            x_bias: tool.x as f32,
            y_bias: tool.y as f32,
            z_bias: tool.z as f32,
        },
        index: state.queue.current_index,
        left_space: u32::try_from(state.queue.capacity - state.queue.waiting).unwrap_or(u32::MAX),
        alarms: state.alarms,
    };
    (taken, state.moving)
}

/// Occasion to take a sample.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Look {
    /// The arm's time passes.
    Passing,
    /// The arm was touched from outside, or observed.
    Touched,
    /// A sample was requested.
    Asked,
}

impl Sampler {
    /// Takes a sample if it is due or shows a change.
    fn look(&mut self, arm: &Controller, why: Look) {
        let (taken, moves) = sample(arm, self.began);
        let turns = moves != self.moves;
        let is_new = self
            .last
            // Compared without the time, which always differs.
            .is_none_or(|last| Sample { t: taken.t, ..last } != taken);
        let is_due = arm.now() >= self.due;
        self.moves = moves;
        let wanted = match why {
            Look::Passing => turns || is_due && (moves || is_new),
            Look::Touched => turns || is_due || is_new,
            Look::Asked => true,
        };
        if wanted {
            self.due = arm.now() + self.every;
            self.last = Some(taken);
            // An error means that the receiver has ended, or is about to.
            let _ = self.tell.send(taken);
        }
    }
}

impl Samplers {
    fn all(&self) -> MutexGuard<'_, BTreeMap<u64, Sampler>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a sample after the arm was touched from outside, or observed.
    pub(super) fn touched(&self, arm: &Controller) {
        for sampler in self.all().values_mut() {
            sampler.look(arm, Look::Touched);
        }
    }
}

impl Observer for Samplers {
    fn next_sample(&self) -> Option<ArmInstant> {
        let all = self.all();
        let due = all.values().filter(|sampler| sampler.moves);
        due.map(|sampler| sampler.due).min()
    }

    fn observe(&mut self, arm: &Controller) {
        for sampler in self.all().values_mut() {
            sampler.look(arm, Look::Passing);
        }
    }
}

impl VirtualArm {
    /// Starts sampling at this rate; returns the number of the sampler. `None` for an arm whose
    /// clock does not leap.
    pub(crate) fn samples(&self, rate: f64) -> Option<(u64, UnboundedReceiver<Sample>)> {
        // Zero, negative and NaN rates have no interval.
        let every = Duration::try_from_secs_f64(1.0 / rate).ok()?;
        let mut cell = self.lock();
        if !cell.can_be_led() {
            return None;
        }
        let now = cell.now();
        cell.runner.handle_timeout(now);
        let samplers = cell.samplers()?;
        let (tell, coming) = unbounded_channel();
        let arm = cell.runner.controller();
        let mut sampler = Sampler {
            tell,
            began: arm.now(),
            every: every.max(Duration::from_micros(1)),
            due: arm.now(),
            moves: false,
            last: None,
        };
        sampler.look(arm, Look::Asked);
        let mut all = samplers.all();
        let number = all.keys().next_back().map_or(0, |last| last + 1);
        all.insert(number, sampler);
        drop(all);
        Some((number, coming))
    }

    /// Takes a sample of the present.
    pub(crate) fn sample(&self, number: u64) {
        let mut cell = self.lock();
        let now = cell.now();
        cell.runner.handle_timeout(now);
        if let Some(samplers) = cell.samplers()
            && let Some(sampler) = samplers.all().get_mut(&number)
        {
            sampler.look(cell.runner.controller(), Look::Asked);
        }
        cell.wake();
    }

    pub(crate) fn end_samples(&self, number: u64) {
        if let Some(samplers) = self.lock().samplers() {
            samplers.all().remove(&number);
        }
    }
}

#[cfg(test)]
mod tests {
    use magician_motion::JointAngles;

    use super::*;
    use crate::{Arm, Options, SimSpeed, build};

    async fn moved(arm: &Arm) {
        let there = build::move_to(220.0, 60.0, 20.0, 0.0);
        arm.run(&[there]).await.expect("within reach");
    }

    #[tokio::test]
    async fn a_leap_is_sampled_on_its_way_and_is_the_same_leap() {
        let alone = VirtualArm::default().in_virtual_time();
        let arm = Arm::simulated(alone.clone(), Options::default()).await;
        moved(&arm.expect("an arm")).await;

        let cell = VirtualArm::default().in_virtual_time();
        let arm = Arm::simulated(cell.clone(), Options::default()).await;
        let arm = arm.expect("an arm");
        let mut samples = arm.samples(50.0).expect("its clock leaps");
        moved(&arm).await;
        samples.take();
        assert_eq!(cell.state().now, alone.state().now);
        assert_eq!(cell.state().pose, alone.state().pose);

        let mut taken = Vec::new();
        while let Some(sample) = samples.ready() {
            taken.push(sample);
        }
        let seconds = cell.state().now.as_micros() as f64 / 1e6;
        assert!(
            taken.len() as f64 >= 50.0 * seconds - 2.0,
            "{} in {seconds} s",
            taken.len()
        );
        for pair in taken.windows(2) {
            let [before, after] = pair else { continue };
            assert!(
                after.t >= before.t && after.t - before.t < 0.021,
                "{pair:?}"
            );
            assert!((after.pose.y - before.pose.y).abs() < 6.0, "{pair:?}");
        }
        let end = taken.last().expect("there are some");
        assert_eq!((end.pose.x, end.pose.y, end.index), (220.0, 60.0, 2));
    }

    #[tokio::test]
    async fn what_a_hand_does_is_sampled_as_it_is_done() {
        let cell = VirtualArm::default().in_virtual_time();
        let arm = Arm::simulated(cell.clone(), Options::default()).await;
        let arm = arm.expect("an arm");
        let mut samples = arm.samples(50.0).expect("its clock leaps");
        for j1 in [10.0, 20.0] {
            let joints = JointAngles {
                j1,
                ..cell.state().joints
            };
            cell.with(|arm| {
                arm.unlock(true);
                arm.guide(joints);
                arm.unlock(false);
            });
            cell.advance(Duration::from_millis(500));
        }
        let mut taken = Vec::new();
        while let Some(sample) = samples.ready() {
            taken.push((sample.t, sample.pose.joint_angle[0]));
        }
        assert_eq!(
            taken,
            [
                (0.0, 0.0),
                (0.0, 10.0),
                (0.5, 10.0),
                (0.5, 20.0),
                (1.0, 20.0)
            ]
        );
    }

    #[tokio::test]
    async fn an_arm_with_a_speed_has_none() {
        let cell = VirtualArm::new(Controller::default(), SimSpeed::Times(4.0));
        let arm = Arm::simulated(cell, Options::default())
            .await
            .expect("an arm");
        assert!(arm.samples(50.0).is_none());
    }
}
