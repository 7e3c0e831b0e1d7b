//! Hand-guided points: the arm reports when its unlock key is released.

use std::time::Duration;

use magician::commands::{HhtTrigMode, HhtTrigOutput, HhtTrigOutputEnabled, Pose};
use magician::protocol::{Flag, TeachTrigger};
use magician::{Arm, ErrorKind, Result, SettingsBackup};

use crate::{Polled, SavedSettings};

/// Interval between polls of the trigger. A compromise between the delay of a stored point and the
/// load on the line.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Makes the arm report releases of its unlock key (document 1.7). The returned value polls the
/// report ten times a second, and yields the pose after each release. `None` if the arm does not
/// have these commands. `saved` restores the changed settings.
///
/// # Errors
/// Fails if the line is gone, if the arm refuses the settings, or if it is not known to be homed
/// ([`Homing::check`](magician::Homing::check)).
pub async fn guided_points(arm: &Arm, saved: &SavedSettings) -> Result<Option<Polled<Pose>>> {
    arm.homing().check().await?;
    let read_settings = async {
        let mode = arm.get::<HhtTrigMode>().await?;
        let enabled = arm.get::<HhtTrigOutputEnabled>().await?;
        Ok::<_, magician::Error>((mode, enabled))
    };
    let (mode, enabled) = match read_settings.await {
        Ok(settings) => settings,
        Err(error) if matches!(error.kind(), ErrorKind::Port | ErrorKind::Closed) => {
            return Err(error);
        }
        // The arm lacks these commands.
        Err(_) => return Ok(None),
    };
    let mut backup = SettingsBackup::default();
    backup.save(mode);
    backup.save(enabled);
    saved.save_all(arm, backup).await;
    arm.set(&HhtTrigMode {
        mode: TeachTrigger::OnRelease,
    })
    .await?;
    let is_enabled = Flag::ON;
    arm.set(&HhtTrigOutputEnabled { is_enabled }).await?;
    // Reading the trigger clears it: a release before the start belongs to no program.
    let _ = arm.get::<HhtTrigOutput>().await?;
    let arm = arm.clone();
    Ok(Some(Polled::every(POLL_INTERVAL, move || {
        let arm = arm.clone();
        async move {
            let trigger = arm.get::<HhtTrigOutput>().await.ok()?;
            if trigger.is_triggered.is_on() {
                arm.get::<Pose>().await.ok()
            } else {
                None
            }
        }
    })))
}
