//! `forward`: computes the pose for joint angles.

use clap::Args;
use magician_motion::{ArmModel, Geometry, JointAngles};
use serde::Serialize;

use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;
use crate::options::{ToolOption, number};

/// Compute the tool's pose from four joint angles
#[derive(Args, Debug)]
pub(crate) struct Forward {
    /// Base (J1), degrees
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    j1: f64,
    /// Rear arm (J2), degrees from the vertical
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    j2: f64,
    /// Forearm (J3), degrees below the horizontal
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    j3: f64,
    /// End servo (J4), degrees
    #[arg(allow_negative_numbers = true, value_parser = number::<f64>)]
    j4: f64,
    #[command(flatten)]
    of: ToolOption,
}

#[derive(Serialize)]
struct TipPose {
    x: f64,
    y: f64,
    z: f64,
    r: f64,
}

impl Forward {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let joints = JointAngles::new(self.j1, self.j2, self.j3, self.j4);
        if !joints.is_finite() {
            return Err(Failure::invalid("the joint angles must be finite numbers"));
        }
        let pose = Geometry::magician(self.of.tool).forward(&joints);
        let [x, y, z, r] = pose.to_array().map(|value| value + 0.0);
        context.show(&TipPose { x, y, z, r }, |out| {
            let mut columns = Columns::default();
            for (name, value, unit) in [
                ("x", x, "mm"),
                ("y", y, "mm"),
                ("z", z, "mm"),
                ("r", r, "deg"),
            ] {
                columns.row([name, &format!("{value:10.4}"), unit]);
            }
            columns.write(out)?;
            if let Err(beyond) = ArmModel::MAGICIAN.limits.check(&joints) {
                let note = format!("note: the arm cannot reach this pose, {beyond}");
                out.line(out.paint.note(note))?;
            }
            Ok(())
        })
    }
}
