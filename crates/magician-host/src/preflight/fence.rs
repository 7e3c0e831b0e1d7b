//! Checks of commands against the fence of an arm.

use magician_motion::{
    ArmState, Fence, JointAngles, Limits, Move, MoveKind, Planner, Target, Trajectory,
};
use magician_protocol::Set;

use super::Preflight;
use crate::burning::{LASER_POWER, raises_laser_pin};
use crate::message;
use crate::{Action, Error, Result};

impl Preflight {
    /// Sets a fence: every motion is checked along its whole path, whatever the
    /// [`Guards`](super::Guards) permit, and so is the power of the laser.
    ///
    /// Commands that cannot be checked are refused: a motion from an unknown position, a queued
    /// jog, and [`ResetPose`](magician_protocol::commands::ResetPose), which would move the fence
    /// with the arm.
    ///
    /// Homing is checked along its path from where the arm believes itself to be: J1 to its switch,
    /// then to the home point. Its speed is not checked, because the arm chooses it.
    ///
    /// ```
    /// use magician_host::build;
    /// use magician_host::preflight::Preflight;
    /// use magician_host::{Fence, FencePart, JointAngles, ToolBias};
    ///
    /// let fence = Fence::default().with_floor(-60.0)?;
    /// let mut check = Preflight::at(JointAngles::HOME, ToolBias::PEN).fence(fence);
    /// check.check(&build::line_to(250.0, 0.0, -60.0, 0.0))?;
    ///
    /// let error = check.check(&build::line_to(250.0, 0.0, -71.2, 0.0)).unwrap_err();
    /// assert_eq!((error.value(), error.limit()), (Some(f64::from(-71.2_f32)), Some(-60.0)));
    /// assert_eq!(error.breach().map(|breach| breach.part), Some(FencePart::Floor));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn fence(mut self, fence: Fence) -> Self {
        // An empty fence bounds nothing, and must not refuse motions from unknown positions.
        self.fence = Some(fence).filter(|fence| !fence.is_empty());
        self
    }

    /// The fence. `None` without one.
    #[must_use]
    pub fn held_fence(&self) -> Option<&Fence> {
        self.fence.as_ref()
    }

    /// Planner for jogs from here. Its speeds are not those of the jog.
    #[must_use]
    pub fn jog_planner(&self) -> Planner {
        self.planner(self.model.power_up.speeds())
    }

    /// Declares whether a laser may be wired to the pins. The default is true.
    #[must_use]
    pub fn laser_pins(mut self, laser: bool) -> Self {
        self.laser_pins = laser;
        self
    }

    /// Checks what can be decided before the target of a command is known.
    pub(super) fn check_fence(&self, command: &Set) -> Result<()> {
        let Some(fence) = &self.fence else {
            return Ok(());
        };
        self.check_power(command)?;
        match command {
            Set::JogCmd(jog)
                if fence.bounds_motion() && jog.cmd != magician_protocol::JogCommand::Stop =>
            {
                let why = message!("a plain jog does not stop at the fence");
                Err(unchecked(why).remedy(Action::Jog, "stops before it"))
            }
            // After ResetPose the arm's coordinates, and with them its fence, are elsewhere.
            Set::ResetPose(_) if fence.bounds_space() => Err(unchecked(message!(
                "ResetPose changes the arm's own position, and with it that of its fence"
            ))
            .remedy(Action::Home, "corrects its position")),
            _ => Ok(()),
        }
    }

    /// Checks the power of the laser.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) with the power and its limit.
    pub fn check_power(&self, command: &Set) -> Result<()> {
        match self.fence.zip(self.power_of(command)) {
            Some((fence, power)) => fence.check_laser(power).map_err(Error::fenced),
            None => Ok(()),
        }
    }

    /// Power at which the laser would burn, percent. `None` if the command does not light it.
    fn power_of(&self, command: &Set) -> Option<f64> {
        match command {
            Set::CpLeCmd(segment) => Some(f64::from(segment.velocity_or_power)),
            // A switched laser burns at full power; only paths and PWM have a power of their own.
            Set::SetEndEffectorLaser(laser) => {
                (laser.enable_ctrl.is_on() && laser.on.is_on()).then_some(100.0)
            }
            Set::IoPwm(output) if self.laser_pins && output.address == LASER_POWER => {
                Some(f64::from(output.duty_cycle))
            }
            command => (self.laser_pins && raises_laser_pin(command)).then_some(100.0),
        }
    }

    /// Checks the whole path of a motion.
    pub(super) fn within_fence(&self, motion: &Trajectory) -> Result<()> {
        let checked = self
            .fence
            .map_or(Ok(()), |fence| fence.check_motion(motion));
        checked.map_err(Error::fenced)
    }

    /// Checks the speed of a motion.
    pub(super) fn slow_enough(&self, motion: &Trajectory) -> Result<()> {
        let checked = self
            .fence
            .map_or(Ok(()), |fence| fence.check_speed_of(motion));
        checked.map_err(Error::fenced)
    }

    /// Checks the speed of a continuous path, mm/s.
    pub(super) fn path_slow_enough(&self, speed: f64) -> Result<()> {
        let checked = self.fence.map_or(Ok(()), |fence| fence.check_speed(speed));
        checked.map_err(Error::fenced)
    }

    /// Checks a change of the tool, which moves the tip without moving the arm.
    pub(super) fn tool_within_fence(&self, before: &ArmState, after: &ArmState) -> Result<()> {
        let checked = (self.fence).map_or(Ok(()), |fence| {
            fence.check_tool_change(&before.pose, &after.pose)
        });
        checked.map_err(Error::fenced)
    }

    /// Refuses a motion that starts at an unknown position.
    pub(super) fn known_start(&self) -> Result<()> {
        if self.fence.as_ref().is_some_and(Fence::bounds_motion) {
            Err(unchecked(message!(
                "the position of the arm by then is unknown; wait until it has stopped, or go on \
                    in a separate program"
            )))
        } else {
            Ok(())
        }
    }

    /// Refuses a motion whose rules are not known here.
    pub(super) fn known_way(&self, command: &Set) -> Result<()> {
        match self.known_start() {
            // Restated, because waiting would not help this command.
            Err(_) => Err(unchecked(message!(
                "the end position of {command} is unknown; use a move instead",
                command = command.row().set_name
            ))),
            Ok(()) => Ok(()),
        }
    }

    /// Checks the path on which homing seeks the switch of J1: to the switch, a little back, and to
    /// the switch again.
    pub(super) fn search_within_fence(&self, from: &ArmState) -> Result<()> {
        if self.fence.is_none() {
            return Ok(());
        }
        // Joint limits do not apply: during the search the arm does not know its base angle.
        let planner = Planner {
            limits: Limits::NONE,
            ..self.planner(self.model.homing.speeds())
        };
        let mut from = *from;
        for j1 in [
            self.model.homing.switch,
            self.model.homing.switch + self.model.homing.back_off,
            self.model.homing.switch,
        ] {
            let target = Target::Joints(JointAngles { j1, ..from.joints });
            let request = Move {
                target,
                kind: MoveKind::Joint,
            };
            let motion = planner.plan(&from, &request)?.trajectory;
            self.within_fence(&motion)?;
            from = *motion.end();
        }
        Ok(())
    }
}

/// Error of a command that cannot be checked against a fence.
fn unchecked(why: crate::Message) -> Error {
    Error::guarded(
        "fence",
        message!(
            "this arm has a fence, and the command cannot be checked against it: {why}",
            why
        ),
    )
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use magician_motion::{Cuboid, Fence, FencePart, ToolBias};

    use super::*;
    use crate::build;
    use crate::preflight::Guards;
    use crate::{ErrorKind, commands};

    fn at(x: f32, y: f32, z: f32, fence: Fence) -> Preflight {
        let mut arm = Preflight::at(JointAngles::HOME, ToolBias::PEN);
        arm.check(&build::move_to(x, y, z, 0.0)).unwrap();
        arm.fence(fence).guards(Guards::NONE)
    }

    fn floor() -> Fence {
        Fence::default().with_floor(-60.0).unwrap()
    }

    fn part_of(checked: crate::Result<crate::preflight::Step>) -> Option<FencePart> {
        checked.unwrap_err().breach().map(|breach| breach.part)
    }

    #[test]
    fn every_kind_of_motion_is_held_whatever_the_guards_let_pass() {
        let start = at(220.0, -60.0, -50.0, floor());
        let across = Set::from(commands::ArcCmd {
            cir_point: [220.0, 0.0, -62.0, 0.0],
            to_point: [220.0, 60.0, -50.0, 0.0],
        });
        let crossing = [
            build::line_to(220.0, 0.0, -61.0, 0.0),
            build::move_to(220.0, 0.0, -61.0, 0.0),
            build::jump_to(220.0, 0.0, -61.0, 0.0),
            build::line_by(0.0, 0.0, -11.0, 0.0),
            build::path_to(220.0, 0.0, -61.0),
            build::engrave_to(220.0, 0.0, -61.0, 10.0),
            across,
        ];
        for command in crossing {
            let error = start.clone().check(&command).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Unreachable, "{command:?}");
            assert_eq!(error.limit(), Some(-60.0));
            let breach = error.breach().expect("data");
            assert_eq!(breach.part, FencePart::Floor, "{command:?}");
            // The same command passes without the fence.
            let mut free = at(220.0, -60.0, -50.0, Fence::default());
            assert!(free.check(&command).is_ok(), "{command:?}");
        }
        assert!(
            start
                .clone()
                .check(&build::line_to(220.0, 0.0, -60.0, 0.0))
                .is_ok()
        );
    }

    #[test]
    fn uncheckable_motion_is_refused() {
        let mut lost = at(220.0, 0.0, 0.0, floor());
        lost.at = None;
        for command in [
            build::move_to(220.0, 0.0, 0.0, 0.0),
            build::home(),
            build::path_to(220.0, 0.0, 0.0),
        ] {
            let error = lost.clone().check(&command).unwrap_err();
            assert_eq!(error.guard(), Some("fence"), "{command:?} {error}");
        }
        let start = at(220.0, 0.0, 0.0, floor());
        let pose = commands::ResetPose {
            manual: magician_protocol::Flag(0),
            rear_arm_angle: 0.0,
            front_arm_angle: 0.0,
        };
        for command in [build::Axis::J1.plus().into(), Set::from(pose)] {
            assert!(start.clone().check(&command).is_err(), "{command:?}");
        }
    }

    #[test]
    fn a_tool_of_another_length_is_a_motion_of_the_tip() {
        let low = at(220.0, 0.0, -55.0, floor());
        let longer = commands::EndEffectorParams {
            x_bias: 61.0,
            y_bias: 0.0,
            z_bias: 20.0,
        };
        assert_eq!(
            part_of(low.clone().check(&longer.into())),
            Some(FencePart::Floor)
        );
        assert!(at(220.0, 0.0, 0.0, floor()).check(&longer.into()).is_ok());
    }

    #[test]
    fn homing_goes_by_the_switch_of_the_base() {
        let behind = Cuboid {
            min: [-400.0, -400.0, -100.0],
            max: [-100.0, 0.0, 200.0],
        };
        let fence = Fence::default().with_keep_out(behind).unwrap();
        assert_eq!(
            part_of(at(220.0, 0.0, 0.0, fence).check(&build::home())),
            Some(FencePart::KeepOut(0))
        );
        assert!(at(220.0, 0.0, 0.0, floor()).check(&build::home()).is_ok());
    }

    #[test]
    fn speeds_count_where_they_are_reached() {
        let slow = Fence::default().with_top_speed(50.0).unwrap();
        let mut arm = at(220.0, -60.0, 0.0, slow);
        let line = build::line_to(220.0, 60.0, 0.0, 0.0);
        let error = arm.check(&line).unwrap_err();
        assert_eq!(
            (error.value(), error.limit(), error.unit()),
            (Some(100.0), Some(50.0), Some("mm/s"))
        );
        assert!(arm.check(&build::path_to(220.0, 60.0, 0.0)).is_err());
        assert!(arm.check(&build::move_to(220.0, 60.0, 0.0, 0.0)).is_err());
        arm.check(&build::speed(25.0, 50.0)).unwrap();
        assert!(arm.check(&line).is_ok());
        // The pen can be lifted nevertheless, at a permitted speed.
        let lift = at(220.0, 0.0, 0.0, slow).lift(50.0).unwrap();
        assert_eq!(lift.by, 50.0);
        let time = at(220.0, 0.0, 0.0, slow).estimate(&lift.commands).unwrap();
        assert!(time > Duration::from_millis(1000), "{time:?}");
    }

    #[test]
    fn a_laser_burns_as_strongly_as_it_may() {
        let dim = Fence::default().with_strongest_laser(60.0).unwrap();
        let mut arm = at(220.0, 0.0, 0.0, dim);
        assert!(arm.check(&build::engrave_to(230.0, 0.0, 0.0, 60.0)).is_ok());
        let error = arm
            .check(&build::engrave_to(220.0, 0.0, 0.0, 61.0))
            .unwrap_err();
        assert_eq!((error.value(), error.limit()), (Some(61.0), Some(60.0)));
        for full in [
            build::laser(true),
            build::output(4, true),
            build::pwm(4, 1000.0, 61.0),
        ] {
            assert_eq!(
                part_of(arm.clone().check(&full)),
                Some(FencePart::Laser),
                "{full:?}"
            );
        }
        assert!(arm.clone().check(&build::laser(false)).is_ok());
        let mut without = arm.laser_pins(false);
        assert!(without.check(&build::output(4, true)).is_ok());
    }
}
