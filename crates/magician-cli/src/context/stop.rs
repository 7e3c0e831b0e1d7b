//! Stops the arm and words the result.

use magician::commands::Pose;
use magician::{Arm, ErrorKind};
use tokio::time::timeout;

use super::{DISCONNECT_TIMEOUT, STOP_CONFIRM_TIMEOUT};
use crate::failure::{Failure, Kind};
use crate::saved::SavedSettings;

/// Cause of an end that the user asked for.
pub(crate) const INTERRUPTED: &str = "interrupted";
/// Cause of an end because the station is about to end.
pub(crate) const STATION_ENDED: &str = "the station ended";

/// Returns the kind of failure of stopped work. The user's own signal counts as an interruption,
/// even if it comes while the work is ending because its station does (`line_ends`).
pub(crate) const fn kind_of_stop(line_ends: bool, by_person: bool) -> Kind {
    if line_ends && !by_person {
        Kind::Driver(ErrorKind::Port)
    } else {
        Kind::Interrupted
    }
}

/// Stops the arm, restores its settings, and returns a sentence with `cause` and where the arm
/// stands.
pub(crate) async fn stop(arm: &Arm, saved: &SavedSettings, cause: &str) -> Result<String, String> {
    let told = |failure: Failure| not_confirmed(cause, &failure.message);
    let slow = |_| not_confirmed(cause, "it took too long");
    let stood = timeout(STOP_CONFIRM_TIMEOUT, stop_and_read_pose(arm))
        .await
        .map_err(slow)?;
    let pose = stood.map_err(told)?;
    let restored = timeout(STOP_CONFIRM_TIMEOUT, saved.restore(arm))
        .await
        .map_err(slow)?;
    restored.map_err(|error| not_confirmed(cause, &error.to_string()))?;
    Ok(format!("{cause}: {}; queue empty", format_position(&pose)))
}

/// Handles the second stop: sends a stop again and restores settings, neither of which moves the
/// arm. Bounded in time, whatever the arm does.
pub(super) async fn stop_again(arm: &Arm, saved: &SavedSettings) -> Result<String, String> {
    let unknown = "interrupted twice: the arm may still be moving";
    let stood = timeout(DISCONNECT_TIMEOUT, stop_and_read_pose(arm)).await;
    let pose = stood.ok().and_then(Result::ok).ok_or(unknown)?;
    // A restore that fails or takes too long is left to the next command, which finds it in the
    // saved settings.
    let _ = timeout(DISCONNECT_TIMEOUT, saved.restore(arm)).await;
    Ok(format!(
        "interrupted twice: {}; queue empty",
        format_position(&pose)
    ))
}

/// Stops the arm and returns the pose at which it stands.
async fn stop_and_read_pose(arm: &Arm) -> Result<Pose, Failure> {
    arm.stop().await?;
    Ok(arm.get::<Pose>().await?)
}

pub(crate) fn format_position(Pose { x, y, z, r, .. }: &Pose) -> String {
    format!("the arm stands at x {x:.1} y {y:.1} z {z:.1} r {r:.1}")
}

pub(crate) fn not_confirmed(cause: &str, why: &str) -> String {
    format!("{cause}, but the arm did not confirm that it has stopped: {why}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_signal_is_an_interruption_even_while_the_station_ends() {
        assert_eq!(kind_of_stop(true, false).status(), 4);
        assert_eq!(kind_of_stop(true, true).status(), 130);
        assert_eq!(kind_of_stop(false, false).status(), 130);
    }
}
