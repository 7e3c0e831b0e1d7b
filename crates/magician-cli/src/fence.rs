//! The fence of an arm as JSON has it.

use magician::{Cuboid, Fence};
use serde::Serialize;

use crate::context::Context;

/// Its bounds by their names in the file of settings; what is not bounded is null.
#[derive(Serialize)]
pub(crate) struct Bounds {
    floor: Option<f64>,
    #[serde(rename = "box")]
    within: Option<[[f64; 3]; 2]>,
    keep_out: Vec<[[f64; 3]; 2]>,
    top_speed: Option<f64>,
    strongest_laser: Option<f64>,
}

impl From<&Fence> for Bounds {
    fn from(fence: &Fence) -> Self {
        let corners = |cuboid: &Cuboid| [cuboid.min, cuboid.max];
        Self {
            floor: fence.floor(),
            within: fence.within().as_ref().map(corners),
            keep_out: fence.keep_outs().iter().map(corners).collect(),
            top_speed: fence.top_speed(),
            strongest_laser: fence.strongest_laser(),
        }
    }
}

impl Context {
    /// The fence of the arm that is meant, as far as that is known without one.
    pub(crate) fn fence(&mut self) -> Option<Fence> {
        if let Some(arm) = self.connected() {
            return arm.fence().copied();
        }
        let target = self.target(None).ok()?;
        let config = self.config().ok()?;
        config.arm_at(&target)?.fence
    }
}
