//! State of the arm as far as the blocks determine it (dead reckoning).

use magician_motion::{Geometry, JointAngles, Pose, ToolBias};

/// Known state of the arm. A program may start anywhere, and the home point is configurable, so
/// nothing is known before the first block that moves to coordinates or joint angles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KnownState {
    /// Position x, y, z.
    pub(super) at: Option<[f64; 3]>,
    pub(super) r: Option<f64>,
    joints: Option<[f64; 4]>,
    /// Tool bias, once the program has set it.
    tool: Option<ToolBias>,
    /// Position of the rail's carriage.
    pub(super) rail: Option<f64>,
}

impl KnownState {
    pub(super) fn home(&mut self) {
        *self = Self {
            tool: self.tool,
            ..Self::default()
        };
    }

    pub(super) fn go(&mut self, [x, y, z, r]: [f64; 4]) {
        (self.at, self.r, self.joints) = (Some([x, y, z]), Some(r), None);
    }

    pub(super) fn shift(&mut self, by: [f64; 3]) {
        if let Some(at) = &mut self.at {
            at.iter_mut().zip(by).for_each(|(at, by)| *at += by);
        }
        self.joints = None;
    }

    pub(super) fn bend(&mut self, joints: [f64; 4]) {
        let [j1, _, _, j4] = joints;
        let pose = self
            .tool
            .map(|tool| Geometry::magician(tool).forward(&joints.into()));
        self.at = pose.map(|pose| [pose.x, pose.y, pose.z]);
        (self.r, self.joints) = (Some(j1 + j4), Some(joints));
    }

    /// Changes the tool. Joints and r stay, so x, y and z change.
    pub(super) fn fit(&mut self, tool: ToolBias) {
        self.tool = Some(tool);
        match self.joints {
            Some(joints) => self.bend(joints),
            None => self.at = None,
        }
    }

    /// Returns all four joint angles.
    pub(super) fn joints(&self) -> Option<[f64; 4]> {
        if self.joints.is_some() {
            return self.joints;
        }
        let ([x, y, z], r) = (self.at?, self.r?);
        let joints = Geometry::magician(self.tool?).inverse(&Pose { x, y, z, r });
        joints.ok().map(JointAngles::to_array)
    }

    /// Returns J1. It depends on the tool only if that has a sideways bias, which no tool of the
    /// vendor has.
    pub(super) fn j1(&self) -> Option<f64> {
        if let Some([j1, ..]) = self.joints() {
            return Some(j1);
        }
        let [x, y, _] = self.at?;
        let straight = self.tool.is_none_or(|tool| tool.y == 0.0);
        straight.then(|| libm::atan2(y, x).to_degrees())
    }

    /// Returns J4: r is the sum of J1 and J4.
    pub(super) fn j4(&self) -> Option<f64> {
        Some(self.r? - self.j1()?)
    }
}
