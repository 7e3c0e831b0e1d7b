//! Stops.
//!
//! A stop goes to its stations before anything else, as a single request beside all lines. It must
//! also win against earlier requests that may reach the station later. If such a request is still
//! in the hub, it fails. If it may be in flight on a line, a second stop is queued on the same
//! line, so that it arrives after the request.

use std::collections::BTreeSet;

use magician_station::api::{Needs, RpcError, notification};
use serde_json::json;

use super::Hub;
use super::gather::GatherPurpose;
use super::requests::{Call, Handled};
use super::socket::Via;
use crate::site::StationId;

impl Hub {
    /// Stops one arm at every station that has it, or all arms.
    pub(super) fn stop(&mut self, call: Call, arm: Option<&str>) -> Handled {
        let addressed = self.addressed(arm);
        if addressed.at.is_empty() && addressed.unreachable.is_empty() && arm.is_some() {
            return self.station_of(arm).map(|_| None);
        }
        let (at, params) = (addressed.at.clone(), call.params.clone());
        // Send the stops first. `arm.stop` without an arm stops all arms of a station.
        self.gather(
            call.clone(),
            GatherPurpose::Stops,
            "arm.stop",
            params,
            addressed,
        )?;
        for (station, arms) in &at {
            for arm in arms {
                self.cancel_earlier_motions(&call, *station, arm);
            }
        }
        Ok(None)
    }

    /// Keeps earlier requests of any client from moving the arm after the stop: fails the waiting
    /// ones, and queues a stop behind requests in flight.
    fn cancel_earlier_motions(&mut self, call: &Call, station: StationId, arm: &str) {
        let by = { self.sockets.get(&call.socket) }.and_then(|open| open.session.clone());
        let (mut waiting, mut on_their_way) = (Vec::new(), BTreeSet::new());
        for (request, pending) in &self.pending {
            let handle_for_arm = match pending.via {
                Via::Line(line) => {
                    let at = self.lines.get(&line).map(|line| line.station);
                    // A job method names its job and no arm, so it may concern this arm.
                    let is_meant = pending.arm.as_deref() == Some(arm);
                    at == Some(station) && (is_meant || !pending.method.takes_arm())
                }
                // A job whose program is still being read from the library.
                Via::Home => pending.arm.as_deref() == Some(arm),
                Via::Call(_) => false,
            };
            // Requests that need no lease cannot move an arm.
            if !handle_for_arm || !matches!(pending.method.needs, Needs::Lease(_)) {
                continue;
            }
            match pending.via {
                Via::Line(line) if pending.sent => drop(on_their_way.insert(line)),
                // Still in the hub.
                _ => waiting.push(*request),
            }
        }
        for request in waiting {
            let Some(pending) = self.pending.remove(&request) else {
                continue;
            };
            if let Via::Line(line) = pending.via
                && let Some(line) = self.lines.get_mut(&line)
            {
                line.queue.retain(|(id, _)| *id != Some(request));
            }
            let error = RpcError::new(RpcError::STOPPED, "a stop ended it").with("by", json!(by));
            self.finish(pending.socket, pending.id.as_ref(), &Err(error));
        }
        let text = notification("arm.stop", &json!({"arm": arm}));
        for line in on_their_way {
            self.queue(line, None, text.clone(), false);
        }
    }
}
