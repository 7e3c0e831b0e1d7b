//! Paths and braking distances, for drawings and previews.

use magician_model::PtpMove;
use magician_motion::{ArmState, CpSegment, Geometry, LookAhead, Trajectory};
use magician_protocol::{CpMode, Set};

use super::Preflight;

/// Deceleration of a forced stop as a multiple of the acceleration in force (model section 14).
const FORCED_STOP_FACTOR: f64 = 2.0;
/// Number of instants of a motion at which the braking distance is evaluated.
const BRAKING_SAMPLES: u64 = 8;

/// Speed and braking distance of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopping {
    /// Largest speed of the tool, mm/s.
    pub speed: f64,
    /// Longest distance from the beginning of a forced stop to standstill, mm.
    pub braking: f64,
}

impl Preflight {
    /// Speed and braking distance of a motion command from the arm's present position, with the
    /// settings in force.
    ///
    /// A segment of a path counts as if it were at full speed throughout. `None` for a command
    /// without a path, and if the arm's position is unknown.
    ///
    /// ```
    /// use magician_host::build;
    /// use magician_host::preflight::Preflight;
    /// use magician_host::{JointAngles, ToolBias};
    ///
    /// let mut course = Preflight::at(JointAngles::HOME, ToolBias::LASER);
    /// course.check(&build::path_speed(60.0, 100.0))?;
    /// course.check(&build::line_to(220.0, -40.0, 0.0, 0.0))?;
    /// let stopping = course.stopping(&build::engrave_to(220.0, 40.0, 0.0, 50.0)).unwrap();
    /// assert_eq!(stopping.speed, 60.0);
    /// assert!((1.0..4.0).contains(&stopping.braking));
    /// # Ok::<(), magician_host::Error>(())
    /// ```
    #[must_use]
    pub fn stopping(&self, command: &Set) -> Option<Stopping> {
        let from = self.at?;
        let planner = self.planner(self.now.settings.speeds());
        let (mode, point) = match command {
            Set::CpCmd(cp) => (cp.cp_mode, [cp.x, cp.y, cp.z]),
            // Paths are judged at full speed: the real speed depends on the segments that follow.
            Set::CpLeCmd(cp) => (cp.cp_mode, [cp.x, cp.y, cp.z]),
            _ => return self.stopping_of(&self.motion_of(&from, command)?),
        };
        let start = [from.pose.x, from.pose.y, from.pose.z];
        let to = match mode {
            CpMode::Relative => [0, 1, 2].map(|axis| start[axis] + f64::from(point[axis])),
            _ => point.map(f64::from),
        };
        let way = CpSegment::between(start, to);
        let look_ahead = LookAhead::new(
            &self.now.settings.cp(&self.model),
            &self.model.ceilings,
            self.model.law,
        );
        let rates = look_ahead.ok()?.rates(&way);
        let plan = planner.segment(&from, to, rates.velocity, rates.velocity, rates);
        let stopping = self.stopping_of(&plan.ok()?.trajectory)?;
        Some(Stopping {
            speed: rates.velocity,
            ..stopping
        })
    }

    fn stopping_of(&self, motion: &Trajectory) -> Option<Stopping> {
        let planner = self.planner(self.now.settings.speeds());
        let all = motion.duration_us();
        // A motion without duration has no speed.
        if all == 0 {
            return None;
        }
        let at = |nth: u64| all * nth / BRAKING_SAMPLES;
        let (mut speed, mut braking) = (0.0_f64, 0.0_f64);
        for nth in 0..BRAKING_SAMPLES {
            let [before, after] = [nth, nth + 1].map(|nth| motion.curve(at(nth)).pose);
            let seconds = (at(nth + 1) - at(nth)) as f64 / 1e6;
            // At least a microsecond, the resolution of the arm's clock, to avoid dividing by 0.
            speed = speed.max(before.distance_to(&after) / seconds.max(1e-6));
            let stands = planner
                .brake(motion, at(nth), FORCED_STOP_FACTOR)
                .trajectory
                .end()
                .pose;
            braking = braking.max(before.distance_to(&stands));
        }
        Some(Stopping { speed, braking })
    }

    /// Geometry of the arm, with the tool bias in force after the commands checked so far.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.model.geometry(self.now.settings.tool())
    }

    /// Motion of a point-to-point, arc or circle command from `from`, with the speeds in force
    /// after the commands checked so far, up to the point where its path is blocked.
    ///
    /// `None` for any other command, and for a motion that cannot be planned.
    ///
    /// ```
    /// use magician_host::build;
    /// use magician_host::preflight::Preflight;
    /// use magician_host::{ArmState, JointAngles, ToolBias};
    ///
    /// let course = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// let from = ArmState::at_joints(&course.geometry(), &JointAngles::HOME);
    /// let motion = course.motion_of(&from, &build::jump_to(200.0, 100.0, 0.0, 0.0)).unwrap();
    /// assert_eq!(motion.end().pose.x, 200.0);
    /// // Halfway it is raised.
    /// assert!(motion.sample(motion.duration_us() / 2).pose.z > 10.0);
    /// ```
    #[must_use]
    pub fn motion_of(&self, from: &ArmState, command: &Set) -> Option<Trajectory> {
        let pose = |point: [f32; 4]| point.map(f64::from).into();
        let plan = match command {
            Set::ArcCmd(arc) => {
                let planner = self.planner(self.now.settings.arc_speeds());
                planner.arc(from, &pose(arc.cir_point), &pose(arc.to_point))
            }
            Set::CircleCmd(circle) => {
                let [via, over] = [circle.cir_point, circle.to_point].map(pose);
                let planner = self.planner(self.now.settings.arc_speeds());
                planner.circle(from, &via, &over, circle.count)
            }
            _ => {
                let request = self.request(&PtpMove::from_command(command)?).ok()?;
                self.planner(self.now.settings.speeds())
                    .plan(from, &request)
            }
        };
        plan.ok().map(|plan| plan.trajectory)
    }
}
