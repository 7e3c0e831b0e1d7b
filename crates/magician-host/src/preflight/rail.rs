//! The carriage on the rail during a program (model section 12).

use magician_model::PtpMove;

use super::Preflight;
use super::path::microseconds;
use crate::message;
use crate::{Error, ErrorCode, Result};

/// Distance below which a move of the carriage takes no time, mm (model section 7).
const SHORTEST: f64 = 1e-4;

/// Effect of a command on the rail.
#[derive(Clone, Copy, Debug)]
pub(super) struct RailMove {
    /// Position of the carriage afterwards. `None` if unknown.
    pub(super) to: Option<f64>,
    /// Shortest duration, us. `None` if unknown.
    pub(super) time: Option<u64>,
}

impl Preflight {
    /// Move of the carriage during a point-to-point command. Without a rail the arm ignores it.
    pub(super) fn rail_move(&self, ptp: &PtpMove) -> Result<RailMove> {
        let stays = RailMove {
            to: self.rail,
            time: Some(0),
        };
        let has_rail = self.now.settings.has_rail();
        let Some(l) = ptp.rail.filter(|_| has_rail).map(f64::from) else {
            return Ok(stays);
        };
        let to = match (ptp.mode.is_relative(), self.rail) {
            (false, _) => l,
            (true, Some(from)) => from + l,
            (true, None) => {
                self.unknown_way(message!("how far the carriage on the rail may go"))?;
                return Ok(RailMove {
                    to: None,
                    time: None,
                });
            }
        };
        let length = self.model.rail.length;
        if self.guards.reach && !(0.0..=length).contains(&to) {
            let limit = if to < 0.0 { 0.0 } else { length };
            let message = message!("the rail would be at {to} mm, limit {limit} mm", to, limit);
            return Err(Error::new(ErrorCode::OutOfReach, message).with_limit(to, limit, "mm"));
        }
        // With the guard off the carriage stops at the end of the rail.
        let to = to.clamp(0.0, length);
        let time = match self.rail.map(|from| (to - from).abs()) {
            None => None,
            Some(way) if way < SHORTEST => Some(0),
            Some(way) => {
                let rates = self.now.settings.rail().ok_or_else(|| {
                    Error::invalid(message!(
                        "speeds on the rail and their ratios must be above 0"
                    ))
                })?;
                let profile = self.model.law.rest_to_rest(way, &rates);
                Some(microseconds(profile.duration()))
            }
        };
        Ok(RailMove { to: Some(to), time })
    }
}
