//! `inverse`: computes the joint angles for a pose.

use clap::Args;
use magician_motion::{ArmModel, Geometry, Pose};
use serde::Serialize;

use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;
use crate::options::{ToolOption, number};

/// Compute the joint angles of a pose
#[derive(Args, Debug)]
pub(crate) struct Inverse {
    /// x (forward), mm
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    x: f64,
    /// y (to the left), mm
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    y: f64,
    /// z (up), mm
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    z: f64,
    /// r (rotation of the tool), degrees
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    r: f64,
    #[command(flatten)]
    of: ToolOption,
}

#[derive(Serialize)]
struct JointSolution {
    j1: f64,
    j2: f64,
    j3: f64,
    j4: f64,
}

impl Inverse {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let pose = Pose::new(self.x, self.y, self.z, self.r);
        let joints =
            Geometry::magician(self.of.tool).inverse_within(&pose, &ArmModel::MAGICIAN.limits)?;
        let [j1, j2, j3, j4] = joints.to_array().map(|value| value + 0.0);
        context.show(&JointSolution { j1, j2, j3, j4 }, |out| {
            let mut columns = Columns::default();
            for (name, value) in [("j1", j1), ("j2", j2), ("j3", j3), ("j4", j4)] {
                columns.row([name, &format!("{value:10.4}"), "deg"]);
            }
            columns.write(out)
        })
    }
}
