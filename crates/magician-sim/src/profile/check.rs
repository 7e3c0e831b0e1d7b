//! Validation of a profile.

use magician_motion::{Ceilings, Limits, Range};

use super::{
    Defaults, MAX_NAME, MAX_SERIAL, MAX_STORED_COMMANDS, PINS, Profile, ProfileError, QueueRules,
};

/// Largest queue depth that a profile may set. It bounds the controller's memory; real arms have 32
/// places (model section 14).
const MAX_DEPTH: usize = 1024;

impl Profile {
    /// Checks that the values are valid: no NaN, no negative speeds, lists of the right length.
    ///
    /// [`from_toml`](Self::from_toml) calls it; call it after changing a profile in code.
    ///
    /// # Errors
    /// [`ProfileError::Value`] for the first invalid value.
    pub fn check(&self) -> Result<(), ProfileError> {
        self.check_text()?;
        self.check_queue()?;
        ranges("limits.controller", &self.limits.controller)?;
        ranges("limits.certain", &self.limits.certain)?;
        ranges("limits.guaranteed", &self.limits.guaranteed)?;
        finite("power_up.joints", &self.power_up.joints)?;
        let tool = self.power_up.tool;
        finite("power_up.tool", &[tool.x, tool.y, tool.z])?;
        finite("home.joints", &self.home.joints.to_array())?;
        // Not limited to J1's range: the switch may lie beyond a soft limit.
        angle("home.switch", self.home.switch)?;
        self.check_speeds()?;
        self.check_numbers()?;
        duration("tools.vacuum_delay", self.tools.vacuum_delay)?;
        duration("tools.gripper_delay", self.tools.gripper_delay)?;
        let pins = self.io.pins.len();
        ensure(pins == PINS, "io.pins", pins, "a list of 20 pins")
    }

    fn check_text(&self) -> Result<(), ProfileError> {
        let texts: [(_, &str, usize, _); 4] = [
            (
                "identity.name",
                &self.identity.name,
                MAX_NAME,
                "text of at most 64 bytes without NUL",
            ),
            (
                "identity.serial",
                &self.identity.serial,
                MAX_SERIAL,
                "text of at most 23 bytes without NUL",
            ),
            (
                "defaults.wifi.ssid",
                &self.defaults.wifi.ssid,
                MAX_NAME,
                "text of at most 64 bytes without NUL",
            ),
            (
                "defaults.wifi.password",
                &self.defaults.wifi.password,
                MAX_NAME,
                "text of at most 64 bytes without NUL",
            ),
        ];
        for (name, text, max, wanted) in texts {
            // NUL ends a text on the wire (E17).
            let good = text.len() <= max && !text.contains('\0');
            ensure(good, name, format!("{text:?}"), wanted)?;
        }
        Ok(())
    }

    fn check_queue(&self) -> Result<(), ProfileError> {
        let QueueRules {
            depth, first_index, ..
        } = self.queue;
        ensure(
            (1..=MAX_DEPTH).contains(&depth),
            "queue.depth",
            depth,
            "1 to 1024",
        )?;
        ensure(
            // The arm never assigns index 0: hosts read it as an error (model section 14).
            first_index >= 1,
            "queue.first_index",
            first_index,
            "at least 1",
        )
    }

    fn check_speeds(&self) -> Result<(), ProfileError> {
        let Ceilings {
            joint_velocity,
            joint_acceleration,
            linear_velocity,
            linear_acceleration,
            rotation_velocity,
            rotation_acceleration,
        } = self.ceilings;
        positive("ceilings.joint_velocity", &joint_velocity)?;
        for (name, value) in [
            ("ceilings.joint_acceleration", joint_acceleration),
            ("ceilings.linear_velocity", linear_velocity),
            ("ceilings.linear_acceleration", linear_acceleration),
            ("ceilings.rotation_velocity", rotation_velocity),
            ("ceilings.rotation_acceleration", rotation_acceleration),
        ] {
            positive(name, &[value])?;
        }
        positive("home.velocity", &self.home.velocity)?;
        positive("home.acceleration", &self.home.acceleration)?;
        positive("home.search", &[self.home.search])?;
        positive("home.back_off", &[self.home.back_off])?;
        positive("home.creep", &self.home.creep)?;
        positive("teach.period", &[self.teach.period])?;
        duration("wifi.association", self.wifi.association)?;
        ensure(
            (1..=MAX_STORED_COMMANDS).contains(&self.offline.capacity),
            "offline.capacity",
            self.offline.capacity,
            "1 to 65536",
        )?;
        // With 0 no corner could be passed at any speed (model section 8).
        positive("path.period", &[self.path.period])?;
        let period = self.motion.period;
        ensure(
            // Periods below 1 ms would cost time without a visible effect; above 1 s motion would
            // look broken. Both bounds are choices.
            period == 0.0 || (0.001..=1.0).contains(&period),
            "motion.period",
            period,
            "0 or 0.001 to 1",
        )?;
        // With 0 the planner would stop the arm at once instead of braking it.
        positive("stop.force_factor", &[self.stop.force_factor])?;
        positive("rail.length", &[self.rail.length])?;
        positive("rail.home_velocity", &[self.rail.home_velocity])?;
        positive("rail.home_acceleration", &[self.rail.home_acceleration])?;
        let Defaults { jog, ptp, .. } = &self.defaults;
        positive32("defaults.jog.joint_velocity", &jog.joint_velocity)?;
        positive32("defaults.jog.joint_acceleration", &jog.joint_acceleration)?;
        positive32("defaults.jog.coordinate_velocity", &jog.coordinate_velocity)?;
        positive32(
            "defaults.jog.coordinate_acceleration",
            &jog.coordinate_acceleration,
        )?;
        positive32("defaults.ptp.joint_velocity", &ptp.joint_velocity)?;
        positive32("defaults.ptp.joint_acceleration", &ptp.joint_acceleration)?;
        for (name, value) in self.scalar_speeds() {
            positive32(name, &[value])?;
        }
        Ok(())
    }

    /// Checks the numbers that may have any sign.
    fn check_numbers(&self) -> Result<(), ProfileError> {
        let Defaults {
            ptp, cp, lost_step, ..
        } = &self.defaults;
        let numbers: [(_, &[f32]); 6] = [
            ("defaults.ptp.jump_height", &[ptp.jump_height]),
            ("defaults.ptp.z_limit", &[ptp.z_limit]),
            ("defaults.cp.acceleration", &[cp.acceleration]),
            ("defaults.cp.velocity_ratio", &[cp.velocity_ratio]),
            ("defaults.cp.acceleration_ratio", &[cp.acceleration_ratio]),
            ("defaults.lost_step.threshold", &[lost_step.threshold]),
        ];
        for (name, values) in numbers {
            let good = values.iter().all(|value| value.is_finite());
            ensure(good, name, format!("{values:?}"), "finite")?;
        }
        Ok(())
    }

    fn scalar_speeds(&self) -> [(&'static str, f32); 20] {
        let Defaults {
            jog, ptp, cp, arc, ..
        } = &self.defaults;
        [
            ("defaults.jog.velocity_ratio", jog.velocity_ratio),
            ("defaults.jog.acceleration_ratio", jog.acceleration_ratio),
            ("defaults.jog.rail_velocity", jog.rail_velocity),
            ("defaults.jog.rail_acceleration", jog.rail_acceleration),
            ("defaults.ptp.linear_velocity", ptp.linear_velocity),
            ("defaults.ptp.linear_acceleration", ptp.linear_acceleration),
            ("defaults.ptp.rotation_velocity", ptp.rotation_velocity),
            (
                "defaults.ptp.rotation_acceleration",
                ptp.rotation_acceleration,
            ),
            ("defaults.ptp.velocity_ratio", ptp.velocity_ratio),
            ("defaults.ptp.acceleration_ratio", ptp.acceleration_ratio),
            ("defaults.ptp.rail_velocity", ptp.rail_velocity),
            ("defaults.ptp.rail_acceleration", ptp.rail_acceleration),
            ("defaults.cp.plan_acceleration", cp.plan_acceleration),
            ("defaults.cp.junction_velocity", cp.junction_velocity),
            ("defaults.arc.linear_velocity", arc.linear_velocity),
            ("defaults.arc.linear_acceleration", arc.linear_acceleration),
            ("defaults.arc.rotation_velocity", arc.rotation_velocity),
            (
                "defaults.arc.rotation_acceleration",
                arc.rotation_acceleration,
            ),
            ("defaults.arc.velocity_ratio", arc.velocity_ratio),
            ("defaults.arc.acceleration_ratio", arc.acceleration_ratio),
        ]
    }
}

fn ranges(name: &'static str, limits: &Limits) -> Result<(), ProfileError> {
    let Limits {
        j1,
        j2,
        j3,
        j4,
        j2_minus_j3,
    } = *limits;
    for Range { min, max } in [j1, j2, j3, j4, j2_minus_j3] {
        let good = min.is_finite() && max.is_finite() && min < max;
        ensure(
            good,
            name,
            format!("[{min}, {max}]"),
            "pairs of numbers, the smaller first",
        )?;
    }
    Ok(())
}

fn ensure(
    good: bool,
    name: &'static str,
    value: impl ToString,
    rule: &'static str,
) -> Result<(), ProfileError> {
    if good {
        return Ok(());
    }
    let value = value.to_string();
    Err(ProfileError::Value { name, value, rule })
}

fn finite(name: &'static str, values: &[f64]) -> Result<(), ProfileError> {
    let good = values.iter().all(|value| value.is_finite());
    ensure(good, name, format!("{values:?}"), "finite numbers")
}

fn positive(name: &'static str, values: &[f64]) -> Result<(), ProfileError> {
    let good = values.iter().all(|value| value.is_finite() && *value > 0.0);
    ensure(good, name, format!("{values:?}"), "above 0")
}

fn positive32(name: &'static str, values: &[f32]) -> Result<(), ProfileError> {
    let good = values.iter().all(|value| value.is_finite() && *value > 0.0);
    ensure(good, name, format!("{values:?}"), "above 0")
}
/// Checks a delay. An hour is beyond any delay of a real arm; the bound is a choice.
fn duration(name: &'static str, seconds: f64) -> Result<(), ProfileError> {
    ensure(
        (0.0..=3600.0).contains(&seconds),
        name,
        seconds,
        "0 to 3600 seconds",
    )
}

fn angle(name: &'static str, degrees: f64) -> Result<(), ProfileError> {
    ensure(
        (-360.0..=360.0).contains(&degrees),
        name,
        degrees,
        "-360 to 360 degrees",
    )
}
