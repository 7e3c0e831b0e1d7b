//! The carriage on the rail, as far as a program tells (model section 12).

use magician_motion::RAIL_LENGTH;
use magician_protocol::PtpMode;

use super::Preflight;
use super::path::microseconds;
use crate::{Error, ErrorCode, Result};

/// The rail's length, mm (model section 12).
const LENGTH: f64 = RAIL_LENGTH;
/// A way shorter than this takes no time, mm (model section 7).
const SHORTEST: f64 = 1e-4;

/// What a command does on the rail.
#[derive(Clone, Copy, Debug)]
pub(super) struct RailMove {
    /// Where the carriage is then, if that is known.
    pub(super) to: Option<f64>,
    /// How long it takes at least, us; nothing if that is not known.
    pub(super) time: Option<u64>,
}

impl Preflight {
    /// The way on the rail to `l`, or by so much in the incremental modes. Without a rail the arm ignores it.
    pub(super) fn rail_move(&self, mode: PtpMode, l: Option<f32>) -> Result<RailMove> {
        let stays = RailMove {
            to: self.rail,
            time: Some(0),
        };
        let Some(l) = l.filter(|_| self.now.with_rail).map(f64::from) else {
            return Ok(stays);
        };
        let relative = matches!(
            mode,
            PtpMode::MovjAngleInc | PtpMode::MovlXyzInc | PtpMode::MovjXyzInc
        );
        let to = match (relative, self.rail) {
            (false, _) => l,
            (true, Some(from)) => from + l,
            (true, None) => {
                self.unknown_way("how far the carriage on the rail may go")?;
                return Ok(RailMove {
                    to: None,
                    time: None,
                });
            }
        };
        if self.guards.reach && !(0.0..=LENGTH).contains(&to) {
            let limit = if to < 0.0 { 0.0 } else { LENGTH };
            let message = format!("the rail would be at {to} mm, limit {limit} mm");
            return Err(Error::new(ErrorCode::OutOfReach, message).with_limit(to, limit, "mm"));
        }
        let to = to.clamp(0.0, LENGTH);
        let time = match self.rail.map(|from| (to - from).abs()) {
            None => None,
            Some(way) if way < SHORTEST => Some(0),
            Some(way) => {
                let rates = self.now.rail_rates().ok_or_else(|| {
                    Error::invalid("speeds on the rail and their ratios must be above 0")
                })?;
                let profile = self.model.law.rest_to_rest(way, &rates);
                Some(microseconds(profile.duration()))
            }
        };
        Ok(RailMove { to: Some(to), time })
    }
}
