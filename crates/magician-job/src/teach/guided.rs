//! Hand-guided points: the arm reports when its unlock key is released.

use std::time::Duration;

use magician::commands::{HhtTrigMode, HhtTrigOutput, HhtTrigOutputEnabled, Pose};
use magician::protocol::{Flag, TeachTrigger};
use magician::{Arm, ErrorKind, Result, SettingsBackup};

use crate::{Polled, SavedSettings};

/// Interval between polls of the trigger. A choice between the delay of a stored point and load on
/// the line.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Makes the arm report releases of its unlock key (document 1.7), and polls the pose at each
/// release, ten times a second. `None` if the arm cannot do that. `saved` restores the changed
/// settings.
///
/// # Errors
/// Fails if the line is gone, if the arm refuses the settings, or if it is not known to be homed
/// ([`Homing::check`](magician::Homing::check)).
pub async fn guided_points(arm: &Arm, saved: &SavedSettings) -> Result<Option<Polled<Pose>>> {
    arm.homing().check().await?;
    let before = async {
        let mode = arm.get::<HhtTrigMode>().await?;
        let enabled = arm.get::<HhtTrigOutputEnabled>().await?;
        Ok::<_, magician::Error>((mode, enabled))
    };
    let (mode, enabled) = match before.await {
        Ok(before) => before,
        Err(error) if matches!(error.kind(), ErrorKind::Port | ErrorKind::Closed) => {
            return Err(error);
        }
        // The arm lacks these commands.
        Err(_) => return Ok(None),
    };
    let mut before = SettingsBackup::default();
    before.save(mode);
    before.save(enabled);
    saved.save_all(arm, before).await;
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
            let told = arm.get::<HhtTrigOutput>().await.ok()?;
            if told.is_triggered.is_on() {
                arm.get::<Pose>().await.ok()
            } else {
                None
            }
        }
    })))
}
