//! Settings above the ceilings: the arm stores them as their ceiling (model section 6).

use magician_motion::Ceilings;
use magician_protocol::Set;
use magician_protocol::commands::{
    JogCoordinateParams, JogJointParams, PtpCoordinateParams, PtpJointParams,
};

/// A setting of speeds that the arm lowers to its ceilings when it is set. Those of continuous paths and of the rail it keeps
/// as they are.
pub trait Capped {
    /// Lowers what is above its ceiling to it; true if anything was.
    fn cap(&mut self, ceilings: &Ceilings) -> bool;
}

impl Capped for JogJointParams {
    fn cap(&mut self, ceilings: &Ceilings) -> bool {
        lower_joints(&mut self.velocity, &mut self.acceleration, ceilings)
    }
}

impl Capped for PtpJointParams {
    fn cap(&mut self, ceilings: &Ceilings) -> bool {
        lower_joints(&mut self.velocity, &mut self.acceleration, ceilings)
    }
}

impl Capped for JogCoordinateParams {
    fn cap(&mut self, ceilings: &Ceilings) -> bool {
        let of = |line: f64, rotation: f64| [line, line, line, rotation];
        let velocity = of(ceilings.linear_velocity, ceilings.rotation_velocity);
        let acceleration = of(ceilings.linear_acceleration, ceilings.rotation_acceleration);
        let above = lower(self.velocity.each_mut(), velocity);
        lower(self.acceleration.each_mut(), acceleration) || above
    }
}

impl Capped for PtpCoordinateParams {
    fn cap(&mut self, ceilings: &Ceilings) -> bool {
        lower(
            [
                &mut self.xyz_velocity,
                &mut self.r_velocity,
                &mut self.xyz_acceleration,
                &mut self.r_acceleration,
            ],
            [
                ceilings.linear_velocity,
                ceilings.rotation_velocity,
                ceilings.linear_acceleration,
                ceilings.rotation_acceleration,
            ],
        )
    }
}

/// A command as the arm stores it.
pub(crate) fn as_stored(command: &Set, ceilings: &Ceilings) -> Set {
    let mut stored = *command;
    match &mut stored {
        Set::JogJointParams(set) => set.cap(ceilings),
        Set::JogCoordinateParams(set) => set.cap(ceilings),
        Set::PtpJointParams(set) => set.cap(ceilings),
        Set::PtpCoordinateParams(set) => set.cap(ceilings),
        _ => false,
    };
    stored
}

fn lower_joints(velocity: &mut [f32; 4], acceleration: &mut [f32; 4], most: &Ceilings) -> bool {
    let above = lower(velocity.each_mut(), most.joint_velocity);
    lower(acceleration.each_mut(), [most.joint_acceleration; 4]) || above
}

/// Lowers values to their ceilings, rounded to what the wire has; true if any was above.
fn lower<const N: usize>(values: [&mut f32; N], ceilings: [f64; N]) -> bool {
    let mut above = false;
    for (value, ceiling) in values
        .into_iter()
        .zip(ceilings.map(|ceiling| ceiling as f32))
    {
        if *value > ceiling {
            (*value, above) = (ceiling, true);
        }
    }
    above
}
