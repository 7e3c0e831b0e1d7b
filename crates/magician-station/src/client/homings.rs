//! Homings seen by a station, for a driver behind a [`StationLine`](super::StationLine).

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use magician::{ArmIdentity, ClockRate, HomingRecord};
use serde_json::json;

use super::{ClientError, StationClient};

/// [`HomingRecord`] that asks the station. Needed because a driver behind a
/// [`StationLine`](super::StationLine) sees only the traffic on that line.
#[derive(Debug, Default)]
pub struct StationHomings {
    is_homed: AtomicBool,
}

impl StationHomings {
    /// Reads the state of an arm from the station.
    ///
    /// # Errors
    /// The same as [`StationClient::call`].
    pub async fn read_from(
        &self,
        client: &StationClient,
        arm: Option<&str>,
    ) -> Result<(), ClientError> {
        let asked = arm.map_or_else(|| json!({}), |arm| json!({ "arm": arm }));
        let state = client.call("arm.state", asked).await?;
        // Unknown (null) counts as not homed.
        self.set(state["homed"] == true);
        Ok(())
    }

    fn set(&self, is_homed: bool) {
        self.is_homed.store(is_homed, Ordering::SeqCst);
    }
}

impl HomingRecord for StationHomings {
    fn keep(&self, _: &ArmIdentity, _: Duration, _: ClockRate) {
        self.set(true);
    }

    fn forget(&self, _: &ArmIdentity) {
        self.set(false);
    }

    fn is_homed(&self, _: &ArmIdentity, _: Duration) -> bool {
        self.is_homed.load(Ordering::SeqCst)
    }
}
