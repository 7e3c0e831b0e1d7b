//! Methods of kinematics. They compute and need no arm.

use magician::{ArmModel, Geometry, JointAngles, ToolBias, message};
use magician_motion::Pose;
use magician_program::{Reach, Surface};
use serde_json::{Value, json};

use super::Station;
use crate::api::{Params, RpcError};

impl Station {
    pub(super) fn motion_call(name: &str, params: &Params) -> Result<Value, RpcError> {
        let bias = tool(params)?;
        let geometry = Geometry::magician(bias);
        // Adding zero turns -0 into 0.
        let plain = |values: [f64; 4]| values.map(|value| value + 0.0);
        match name {
            "motion.forward" => {
                let [j1, j2, j3, j4] = four(params, "joints")?;
                let pose = geometry.forward(&JointAngles::new(j1, j2, j3, j4));
                let [x, y, z, r] = plain(pose.to_array());
                Ok(json!({"x": x, "y": y, "z": z, "r": r}))
            }
            "motion.inverse" => {
                let [x, y, z, r] = four(params, "pose")?;
                let limits = &ArmModel::MAGICIAN.limits;
                let joints = geometry.inverse_within(&Pose::new(x, y, z, r), limits);
                let joints = joints.map_err(magician::Error::from)?;
                let [j1, j2, j3, j4] = plain(joints.to_array());
                Ok(json!({"j1": j1, "j2": j2, "j3": j3, "j4": j4}))
            }
            "motion.reach" => {
                let z = params.number("z").unwrap_or_default();
                let reach = Reach::new(bias, Surface::level(z), 0.0);
                Ok(json!({"outlines": reach.outline()}))
            }
            _ => Err(RpcError::internal(format!("{name} does nothing"))),
        }
    }
}

fn four(params: &Params, name: &str) -> Result<[f64; 4], RpcError> {
    let given = params.numbers(name).unwrap_or_default();
    let four = given.try_into();
    four.map_err(|_| RpcError::param(name, message!("`{name}` must be 4 numbers", name)))
}

/// Returns the tool of a request. Without one, the flange itself.
fn tool(params: &Params) -> Result<ToolBias, RpcError> {
    let bias = match (params.text("tool"), params.numbers("tool").as_deref()) {
        (Some(name), _) => ToolBias::named(name),
        (None, Some([x, y, z])) => Some(ToolBias::new(*x, *y, *z)),
        (None, _) => Some(ToolBias::default()),
    };
    bias.ok_or_else(|| RpcError::param("tool", message!("unknown tool")))
}
