//! The path itself, for drawing it.

use magician_motion::{ArmState, Geometry, Trajectory};
use magician_protocol::Set;

use super::Preflight;
use super::motion::ptp_of;

impl Preflight {
    /// The arm's measures, with the tool bias in force after the commands checked so far.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.model.geometry(self.now.tool())
    }

    /// The motion that a point-to-point, arc or circle command would be from where the arm stands so, at the speeds in
    /// force after the commands checked so far, as far as something on the way lets it go. `None` for any other command, and
    /// for a motion that cannot be planned.
    ///
    /// ```
    /// use magician_host::words::{self, Preflight};
    /// use magician_host::{ArmState, JointAngles, ToolBias};
    ///
    /// let course = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// let from = ArmState::at_joints(&course.geometry(), &JointAngles::HOME);
    /// let way = course.way(&from, &words::jump_to(200.0, 100.0, 0.0, 0.0)).unwrap();
    /// assert_eq!(way.end().pose.x, 200.0);
    /// // Halfway it is up.
    /// assert!(way.sample(way.duration_us() / 2).pose.z > 10.0);
    /// ```
    #[must_use]
    pub fn way(&self, from: &ArmState, command: &Set) -> Option<Trajectory> {
        let pose = |point: [f32; 4]| point.map(f64::from).into();
        let plan = match command {
            Set::ArcCmd(arc) => {
                let planner = self.planner(self.now.arc_speeds());
                planner.arc(from, &pose(arc.cir_point), &pose(arc.to_point))
            }
            Set::CircleCmd(circle) => {
                let [via, over] = [circle.cir_point, circle.to_point].map(pose);
                let planner = self.planner(self.now.arc_speeds());
                planner.circle(from, &via, &over, circle.count)
            }
            _ => {
                let request = self.request(&ptp_of(command)?).ok()?;
                self.planner(self.now.ptp_speeds()).plan(from, &request)
            }
        };
        plan.ok().map(|plan| plan.trajectory)
    }
}
