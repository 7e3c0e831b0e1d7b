//! Speed settings above the ceilings: the arm stores the ceiling instead (model section 6).

use magician_motion::Ceilings;
use magician_protocol::Set;
use magician_protocol::commands::{
    JogCoordinateParams, JogJointParams, PtpCoordinateParams, PtpJointParams,
};

/// A speed setting that the arm lowers to its ceilings when it is set. Settings of continuous paths
/// and of the rail are stored unchanged.
pub trait Capped {
    /// Lowers values above their ceiling. True if any was lowered.
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

/// The command as the arm stores it.
pub(crate) fn as_stored(command: &Set, ceilings: &Ceilings) -> Set {
    let mut stored = *command;
    match &mut stored {
        Set::JogJointParams(set) => set.cap(ceilings),
        Set::JogCoordinateParams(set) => set.cap(ceilings),
        Set::PtpJointParams(set) => set.cap(ceilings),
        Set::PtpCoordinateParams(set) => set.cap(ceilings),
        // Other settings are stored as sent.
        _ => false,
    };
    stored
}

fn lower_joints(velocity: &mut [f32; 4], acceleration: &mut [f32; 4], most: &Ceilings) -> bool {
    let above = lower(velocity.each_mut(), most.joint_velocity);
    lower(acceleration.each_mut(), [most.joint_acceleration; 4]) || above
}

/// Lowers values to their ceilings, rounded to `f32` as on the wire. True if any was lowered.
fn lower<const N: usize>(values: [&mut f32; N], ceilings: [f64; N]) -> bool {
    let mut above = false;
    for (value, ceiling) in values
        .into_iter()
        .zip(ceilings.map(|ceiling| ceiling as f32))
    {
        // NaN compares as not above: it is stored as sent and refused where a motion uses it.
        if *value > ceiling {
            (*value, above) = (ceiling, true);
        }
    }
    above
}
