//! Stops: they go out before all else, and nothing that was handed over earlier moves an arm after them.

use std::collections::BTreeSet;

use magician_station::api::{Needs, RpcError, notification};
use serde_json::json;

use super::Hub;
use super::gather::Gathers;
use super::requests::{Call, Handled};
use super::socket::Via;
use crate::site::StationId;

impl Hub {
    /// Stops an arm, wherever it is, or all.
    pub(super) fn stop(&mut self, call: Call, arm: Option<&str>) -> Handled {
        let meant = self.meant(arm);
        if meant.at.is_empty() && meant.beyond.is_empty() && arm.is_some() {
            return self.station_of(arm).map(|_| None);
        }
        let (at, params) = (meant.at.clone(), call.params.clone());
        // The stops go out before anything else is done; one of a station is of all its arms.
        self.gather(call.clone(), Gathers::Stops, "arm.stop", params, meant)?;
        for (station, arms) in &at {
            for arm in arms {
                self.stop_behind(&call, *station, arm);
            }
        }
        Ok(None)
    }

    /// What was handed over before a stop, by whomever, does not move the arm after it: what waits here is ended, and what may be
    /// on its way gets a stop behind it.
    fn stop_behind(&mut self, call: &Call, station: StationId, arm: &str) {
        let by = { self.sockets.get(&call.socket) }.and_then(|open| open.session.clone());
        let (mut waiting, mut on_their_way) = (Vec::new(), BTreeSet::new());
        for (request, pending) in &self.pending {
            let of_arm = match pending.via {
                Via::Line(line) => {
                    let at = self.lines.get(&line).map(|line| line.station);
                    // A job is named by its id alone: it may be of this arm.
                    let is_meant = pending.arm.as_deref() == Some(arm);
                    at == Some(station) && (is_meant || !pending.method.takes_arm())
                }
                // Its program is read.
                Via::Home => pending.arm.as_deref() == Some(arm),
                Via::Call(_) => false,
            };
            // What does not move the arm goes on.
            if !of_arm || !matches!(pending.method.needs, Needs::Lease(_)) {
                continue;
            }
            match pending.via {
                Via::Line(line) if pending.sent => drop(on_their_way.insert(line)),
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
