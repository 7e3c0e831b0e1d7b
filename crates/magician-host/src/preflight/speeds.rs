//! Speed of the tool on each segment of continuous paths.

use magician_model::{MotionSettings, PtpMove};
use magician_motion::{ArmModel, CpSegment, LookAhead, VelocityProfile};
use magician_protocol::{CpMode, Set};

use super::Preflight;
use super::path::Path;

/// Velocity profiles of continuous paths, by the same look-ahead as the times of a
/// [`Preflight`](super::Preflight) but without a check of reach.
///
/// ```
/// use magician_host::build;
/// use magician_host::preflight::PathProfiles;
///
/// let commands = [
///     build::path_speed(20.0, 100.0),
///     build::line_to(220.0, 0.0, 0.0, 0.0),
///     build::engrave_to(240.0, 0.0, 0.0, 50.0),
///     build::engrave_to(260.0, 0.0, 0.0, 50.0),
///     build::laser(false),
/// ];
/// let profiles = PathProfiles::of(&commands);
/// let speeds: Vec<_> = profiles.iter().map(|profile| profile.map(|profile| profile.length() / profile.duration())).collect();
/// // Accelerating to 20 mm/s from rest takes 2 mm, the other 18 mm pass at that speed.
/// assert!(speeds[2].is_some_and(|mean| (mean - 20.0 / 1.1).abs() < 1e-9));
/// assert_eq!([speeds[0], speeds[1], speeds[4]], [None; 3]);
/// ```
#[derive(Clone, Debug)]
pub struct PathProfiles {
    model: ArmModel,
    settings: MotionSettings,
    /// Position of the tool after the commands so far. `None` if unknown.
    at: Option<[f64; 3]>,
    path: Path,
}

impl Preflight {
    /// Velocity profile of each of these commands on this arm's model, with the settings at
    /// power-up. [`PathProfiles::of`] does the same for the built-in model.
    #[must_use]
    pub fn path_profiles(&self, commands: &[Set]) -> Vec<Option<VelocityProfile>> {
        PathProfiles::of_model(&self.model, commands)
    }
}

impl PathProfiles {
    /// Velocity profile of each of these commands, if the arm gets them as early as its queue
    /// permits.
    ///
    /// `None` for other commands than segments of a path, segments without length, and segments
    /// with an unknown start.
    #[must_use]
    pub fn of(commands: &[Set]) -> Vec<Option<VelocityProfile>> {
        Self::of_model(&ArmModel::MAGICIAN, commands)
    }

    fn of_model(model: &ArmModel, commands: &[Set]) -> Vec<Option<VelocityProfile>> {
        let mut course = Self {
            model: *model,
            settings: MotionSettings::at_power_up(model),
            at: None,
            path: Path::keeping_profiles(),
        };
        let are_segments: Vec<bool> = commands.iter().map(|one| course.follow(one)).collect();
        course.path.end();
        let mut profiles = course.path.take_profiles().into_iter();
        let each = are_segments.into_iter();
        each.map(|is_segment| is_segment.then(|| profiles.next()).flatten())
            .collect()
    }

    /// Follows a command. True if it was a segment.
    fn follow(&mut self, command: &Set) -> bool {
        let (mode, point) = match command {
            Set::CpCmd(cp) => (cp.cp_mode, [cp.x, cp.y, cp.z]),
            Set::CpLeCmd(cp) => (cp.cp_mode, [cp.x, cp.y, cp.z]),
            _ => {
                self.path.end();
                self.settings.apply(command);
                self.lead(command);
                return false;
            }
        };
        let [x, y, z] = point.map(f64::from);
        let from = self.at;
        self.at = match (mode, from) {
            (CpMode::Relative, Some([a, b, c])) => Some([a + x, b + y, c + z]),
            (CpMode::Relative, None) => None,
            _ => Some([x, y, z]),
        };
        let Some((from, to)) = from.zip(self.at) else {
            return false;
        };
        let way = CpSegment::between(from, to);
        let speeds = self.settings.cp(&self.model);
        match LookAhead::new(&speeds, &self.model.ceilings, self.model.law) {
            Ok(look_ahead) if !way.is_empty() => {
                self.path.add(look_ahead, way);
                true
            }
            // A segment without length or with invalid speeds has no profile.
            _ => false,
        }
    }

    /// Updates the position after any other command than a segment.
    fn lead(&mut self, command: &Set) {
        let point = |[x, y, z, _]: [f32; 4]| Some([x, y, z].map(f64::from));
        self.at = match command {
            Set::ArcCmd(arc) => point(arc.to_point),
            // A circle ends where it began.
            Set::CircleCmd(_) => self.at,
            // Their ends depend on the arm, or they change the meaning of positions.
            Set::HomeCmd(_) | Set::ResetPose(_) | Set::EndEffectorParams(_) | Set::JogCmd(_) => {
                None
            }
            _ => match PtpMove::from_command(command) {
                Some(ptp) => ptp.pose().and_then(point),
                None => self.at,
            },
        };
    }
}

#[cfg(test)]
mod tests {
    use magician_motion::{JointAngles, ToolBias};

    use super::super::Preflight;
    use super::super::path::microseconds;
    use super::*;
    use crate::build;

    #[test]
    fn laws_take_the_time_that_a_preflight_tells() {
        let mut commands = vec![
            build::path_speed(80.0, 100.0),
            build::line_to(220.0, 0.0, 20.0, 0.0),
        ];
        // A spiral of short segments, more than the queue holds, with corners and a repeated point.
        for nth in 0..150_u8 {
            let (sin, cos) = libm::sincosf(f32::from(nth) * 0.3);
            let far = 5.0 + f32::from(nth) * 0.2;
            let power = f32::from(nth % 7);
            commands.push(build::engrave_to(220.0 + far * cos, far * sin, 20.0, power));
            if nth == 90 {
                commands.push(build::engrave_to(220.0 + far * cos, far * sin, 20.0, power));
            }
        }
        commands.push(build::laser(false));
        let check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
        let [all, first] =
            [&commands[..], &commands[..2]].map(|some| check.estimate(some).expect("within reach"));
        let profiles = PathProfiles::of(&commands);
        assert_eq!(profiles.len(), commands.len());
        assert_eq!(profiles.iter().flatten().count(), 150);
        let sum: u64 = profiles
            .iter()
            .flatten()
            .map(|profile| microseconds(profile.duration()))
            .sum();
        assert_eq!(u128::from(sum), (all - first).as_micros());
    }
}
