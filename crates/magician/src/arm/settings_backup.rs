//! Backup of the settings that a program changes.

use std::mem::{discriminant, take};

use magician_protocol::Set;
use magician_protocol::commands::{
    ArcParams, CpParams, PtpCommonParams, PtpCoordinateParams, PtpJointParams, PtpJump2Params,
    PtpLParams,
};

use super::Arm;
use crate::Result;
use crate::preflight::{Preflight, Readings};

/// Settings of an arm from before a program, to be restored however the program ends.
///
/// ```
/// use magician::commands::PtpCommonParams;
/// use magician::{Arm, SettingsBackup, build};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// # let arm = Arm::connect("sim").await?;
/// let program = [build::speed(80.0, 80.0), build::line_to(220.0, 0.0, 50.0, 0.0)];
/// let mut saved = SettingsBackup::read(&arm, &program).await?;
/// let ran = arm.run(&program).await;
/// if ran.is_err() {
///     // After an error its remaining commands would run later, at the earlier speeds.
///     arm.stop().await?;
/// }
/// saved.restore(&arm).await?;
/// assert_eq!(arm.get::<PtpCommonParams>().await?.velocity_ratio, 50.0);
/// # ran.map(drop)
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct SettingsBackup(Vec<Set>);

impl SettingsBackup {
    /// Reads the current values of the settings that these commands change: speeds, and jump
    /// heights. Tool settings, and all that does not affect motion, are left out.
    ///
    /// # Errors
    /// Same as [`Arm::get`].
    pub async fn read<'s>(arm: &Arm, changes: impl IntoIterator<Item = &'s Set>) -> Result<Self> {
        let mut saved = Self::default();
        let mut known = Vec::new();
        for change in changes {
            let kind = discriminant(change);
            if known.contains(&kind) {
                continue;
            }
            known.push(kind);
            saved.0.extend(before(arm, change).await?);
        }
        Ok(saved)
    }

    /// Adds a setting to the backup.
    pub fn save(&mut self, setting: impl Into<Set>) {
        self.0.push(setting.into());
    }

    /// Adds all settings of another backup.
    pub fn append(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Creates a backup from settings stored outside of the process, as returned by
    /// [`settings`](Self::settings).
    ///
    /// Returns `None` if any of them is not a setting that a program may owe an arm, or has a value
    /// that no arm accepts.
    #[must_use]
    pub fn from_saved(settings: Vec<Set>) -> Option<Self> {
        let mut check = Preflight::new(&Readings::default());
        let mut sound = |setting: &Set| is_saved(setting) && check.check(setting).is_ok();
        settings.iter().all(&mut sound).then_some(Self(settings))
    }

    /// Returns the settings in the order of restoration.
    #[must_use]
    pub fn settings(&self) -> &[Set] {
        &self.0
    }

    /// True if nothing is saved.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Restores the settings. The backup is empty afterwards, even after an error.
    ///
    /// # Errors
    /// Same as [`Arm::set`], at the first setting that the arm refuses.
    pub async fn restore(&mut self, arm: &Arm) -> Result<()> {
        for setting in take(&mut self.0) {
            arm.set_any(&setting).await?;
        }
        Ok(())
    }
}

/// True for settings that programs change temporarily. None of them moves the arm, so restoring a
/// file of them is safe.
const fn is_saved(setting: &Set) -> bool {
    matches!(
        setting,
        Set::PtpJointParams(_)
            | Set::PtpCoordinateParams(_)
            | Set::PtpCommonParams(_)
            | Set::PtpJumpParams(_)
            | Set::PtpJump2Params(_)
            | Set::PtpLParams(_)
            | Set::CpParams(_)
            | Set::ArcParams(_)
            | Set::JogCommonParams(_)
            | Set::EndEffectorParams(_)
            | Set::HhtTrigMode(_)
            | Set::HhtTrigOutputEnabled(_)
    )
}

/// Reads the current value of the setting that a command changes; `None` for any other command.
async fn before(arm: &Arm, change: &Set) -> Result<Option<Set>> {
    Ok(Some(match change {
        Set::PtpJointParams(_) => arm.get::<PtpJointParams>().await?.into(),
        Set::PtpCoordinateParams(_) => arm.get::<PtpCoordinateParams>().await?.into(),
        Set::PtpCommonParams(_) => arm.get::<PtpCommonParams>().await?.into(),
        // PTPJumpParams sets both heights of PTPJump2Params to one value, so the pair is saved.
        Set::PtpJumpParams(_) | Set::PtpJump2Params(_) => arm.get::<PtpJump2Params>().await?.into(),
        Set::PtpLParams(_) => arm.get::<PtpLParams>().await?.into(),
        Set::CpParams(_) => arm.get::<CpParams>().await?.into(),
        Set::ArcParams(_) => arm.get::<ArcParams>().await?.into(),
        // No setting of motion: nothing to restore.
        _ => return Ok(None),
    }))
}

#[cfg(all(test, feature = "sim"))]
mod tests {
    use magician_protocol::commands::PtpJumpParams;
    use magician_sim::{Controller, Profile};

    use super::*;
    use crate::{Options, SimSpeed, VirtualArm, build};

    async fn arm() -> Arm {
        let arm = VirtualArm::new(Controller::new(Profile::default()), SimSpeed::Max);
        Arm::simulated(arm, Options::default())
            .await
            .expect("a virtual arm")
    }

    async fn motion(arm: &Arm) -> Vec<Set> {
        vec![
            arm.get::<PtpCommonParams>().await.unwrap().into(),
            arm.get::<PtpJump2Params>().await.unwrap().into(),
            arm.get::<CpParams>().await.unwrap().into(),
        ]
    }

    fn changes() -> Vec<Set> {
        let jump = PtpJumpParams {
            jump_height: 33.0,
            z_limit: 90.0,
        };
        vec![
            build::speed(11.0, 12.0),
            jump.into(),
            build::path_speed(13.0, 14.0),
            build::speed(15.0, 16.0),
            build::line_to(220.0, 0.0, 50.0, 0.0),
        ]
    }

    #[tokio::test]
    async fn what_was_kept_is_settings_that_an_arm_takes() {
        let arm = arm().await;
        let saved = SettingsBackup::read(&arm, &changes()).await.unwrap();
        let kept = SettingsBackup::from_saved(saved.settings().to_vec()).expect("sound");
        assert_eq!(kept.settings(), saved.settings());
        for foreign in [
            build::laser(true),
            build::line_to(220.0, 0.0, 50.0, 0.0),
            build::speed(f32::NAN, 50.0),
            build::path_speed(-1.0, 50.0),
        ] {
            let mut settings = saved.settings().to_vec();
            settings.push(foreign);
            assert!(
                SettingsBackup::from_saved(settings).is_none(),
                "{foreign:?}"
            );
        }
    }

    #[tokio::test]
    async fn the_arm_gets_back_what_it_had() {
        let arm = arm().await;
        let before = motion(&arm).await;
        let mut saved = SettingsBackup::read(&arm, &changes()).await.unwrap();
        assert_eq!(saved.0, before);
        for change in &changes()[..4] {
            arm.set_any(change).await.unwrap();
        }
        assert_ne!(motion(&arm).await, before);
        saved.restore(&arm).await.unwrap();
        assert_eq!(motion(&arm).await, before);
        assert!(saved.is_empty());
    }
}
