//! Pace of a bounded jog: its speed, the length of its pieces, and the time for the next one.
//!
//! Everything keeps one promise: when a piece arrives, all that the arm then has is done within a
//! fixed time, wherever on its way it may be. So the computation assumes the longest remaining
//! distance that the last pose allows.

use magician_motion::{KinematicLimits, MotionLaw};

/// Shortest duration of a piece, s. Choice: shorter ones would cost more frames than distance.
const PIECE_S: f64 = 0.025;
/// Tolerance for a whole number of periods after rounding.
const ROUNDING: f64 = 1e-6;
/// Shortest piece, mm or degrees: above the resolution of a pose.
const SHORTEST: f64 = 0.01;
/// Lowest speed, mm/s or deg/s: 1 % of the joints' 15 deg/s at power-up. In one period it still
/// moves more than the resolution of a pose.
const SLOWEST: f64 = 0.15;

/// Behaviour of the arm at the end of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PieceEnd {
    /// Path segments: it passes each and rests at the end of the last.
    Through,
    /// Moves: it rests at the end of each.
    AtRest,
}

/// Pace of a bounded jog.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    joins: PieceEnd,
    /// Speed (mm/s or deg/s) and acceleration of the pieces.
    pub(super) rates: KinematicLimits,
    /// Time within which all queued pieces must be done, s.
    within: f64,
    /// Longest and shortest piece, mm or degrees.
    most: f64,
    least: f64,
    /// Computing period of the arm, s; 0 for continuous time. A piece takes a whole number of
    /// periods.
    period: f64,
}

/// Piece that the arm may not have finished.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) length: f64,
    /// Largest possible remainder of it.
    pub(super) left: f64,
}

impl Pace {
    /// Computes the pace closest to the rates of the arm's own jog that fits in the time, never
    /// faster. `ceilings` bound the planning of the pieces.
    pub(super) fn new(
        joins: PieceEnd,
        jog: KinematicLimits,
        ceilings: KinematicLimits,
        within: f64,
        law: MotionLaw,
    ) -> Self {
        let period = f64::from(law.period_us()) / 1e6;
        let within = match joins {
            // Intermediate pieces take whole periods; only the last, which brakes, is rounded up by
            // one.
            PieceEnd::Through => within - period,
            // A pose may already be the end one period before the move is over, and is up to a
            // period old.
            PieceEnd::AtRest => within - 1.5 * period,
        };
        let within = within.max(period);
        let wanted = jog.velocity.min(ceilings.velocity).max(SLOWEST);
        // Time left of `within` when the next piece arrives. The rest is for requests and answers.
        // Choices.
        let (short, long) = ((within / 4.0).min(0.06), (0.4 * within).min(0.12));
        let strongest = ceilings.acceleration;
        let (velocity, acceleration) = match joins {
            // From rest, `within` holds a ramp up, a ramp down and the distance between. Braking
            // from full speed takes half a ramp.
            PieceEnd::Through => {
                let least = jog.acceleration.min(strongest);
                let needed = 1.5 * wanted / (within - long);
                let velocity = wanted.min(strongest * (within - short) / 1.5);
                (velocity, needed.clamp(least, strongest))
            }
            // The end of one piece, and both ramps of the next.
            PieceEnd::AtRest => (wanted.min(strongest * (within - short) / 2.0), strongest),
        };
        let ramp = velocity / acceleration;
        let most = match joins {
            PieceEnd::Through => velocity * (within - ramp),
            PieceEnd::AtRest => {
                velocity * (whole_periods(within - short, period, f64::floor) - ramp)
            }
        };
        let least = match joins {
            PieceEnd::Through => {
                let lasting = whole_periods(PIECE_S, period, f64::ceil);
                (velocity * lasting).max(SHORTEST).min(most)
            }
            // Always the full length: a short move would be slow.
            PieceEnd::AtRest => most,
        };
        Self {
            joins,
            rates: KinematicLimits {
                velocity,
                acceleration,
            },
            within,
            most,
            least,
            period,
        }
    }

    /// Returns the longest time the arm may need for these pieces, s.
    fn time(&self, pieces: impl Iterator<Item = Piece>) -> f64 {
        match self.joins {
            PieceEnd::Through => self.rest_to_rest(pieces.map(|piece| piece.left).sum()),
            PieceEnd::AtRest => pieces.map(|piece| self.rest_of(piece)).sum(),
        }
    }

    /// Returns the time of a distance from rest to rest, s.
    fn rest_to_rest(&self, length: f64) -> f64 {
        whole_periods(self.rates.least_time(length), self.period, f64::ceil)
    }

    /// Returns the remaining time of a move, plus the part of a period by which the pose may lag. A
    /// move that may still accelerate counts in full.
    fn rest_of(&self, piece: Piece) -> f64 {
        let KinematicLimits {
            velocity,
            acceleration,
        } = self.rates;
        let ramp = velocity / acceleration;
        let speeding_up = (velocity * ramp).min(piece.length) / 2.0;
        if piece.left > piece.length - speeding_up {
            return self.rest_to_rest(piece.length);
        }
        let left = if piece.left > speeding_up {
            piece.left / velocity + ramp / 2.0
        } else {
            (2.0 * piece.left / acceleration).sqrt()
        };
        (left + self.period).min(self.rest_to_rest(piece.length))
    }

    /// Rounds a length down to whole periods at the speed of a piece, because any other length
    /// would be slowed down to fit.
    fn evenly(&self, length: f64) -> f64 {
        let a_period = self.rates.velocity * self.period;
        match self.joins {
            PieceEnd::Through if a_period > 0.0 && length > a_period => {
                a_period * (length / a_period + ROUNDING).floor()
            }
            // Moves rest at their end, and continuous time has no periods: any length will do.
            _ => length,
        }
    }

    /// Returns the length of the next piece behind these, or the time until the next look, s.
    pub(super) fn next(&self, pieces: impl Iterator<Item = Piece> + Clone) -> Result<f64, f64> {
        let (room, needed) = match self.joins {
            PieceEnd::Through => {
                let left: f64 = pieces.map(|piece| piece.left).sum();
                (self.most - left, self.least)
            }
            PieceEnd::AtRest => {
                let free = self.within - self.time(pieces);
                let needed = self.rest_to_rest(self.least);
                if free >= needed {
                    (self.least, self.least)
                } else {
                    (free * self.rates.velocity, needed * self.rates.velocity)
                }
            }
        };
        if room >= needed * (1.0 - ROUNDING) {
            Ok(self.evenly(room.min(self.most)))
        } else {
            Err((needed - room) / self.rates.velocity)
        }
    }
}

/// Rounds a time to whole periods.
fn whole_periods(time: f64, period: f64, rounded: fn(f64) -> f64) -> f64 {
    if period > 0.0 {
        // Rounding errors must not turn a whole number of periods into one more or one less.
        let off = if rounded(0.5) > 0.0 {
            -ROUNDING
        } else {
            ROUNDING
        };
        rounded(time / period + off) * period
    } else {
        time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CEILINGS: KinematicLimits = KinematicLimits {
        velocity: 300.0,
        acceleration: 400.0,
    };

    const LAW: MotionLaw = MotionLaw::MAGICIAN;

    fn jog(velocity: f64) -> KinematicLimits {
        KinematicLimits {
            velocity,
            acceleration: 60.0,
        }
    }

    #[test]
    fn pieces_never_exceed_the_stop_time() {
        for joins in [PieceEnd::Through, PieceEnd::AtRest] {
            for within in [0.06, 0.14, 0.29, 1.04, 2.04] {
                for velocity in [0.15, 0.5, 3.0, 7.5, 30.0, 60.0, 300.0] {
                    let pace = Pace::new(joins, jog(velocity), CEILINGS, within, LAW);
                    let mut has: Vec<Piece> = Vec::new();
                    for _ in 0..50 {
                        match pace.next(has.iter().copied()) {
                            Ok(length) => has.push(Piece {
                                length,
                                left: length,
                            }),
                            // Part of it is done meanwhile.
                            Err(_) => {
                                let done = has.remove(0);
                                let left = done.left / 2.0;
                                if left > 0.01 {
                                    has.insert(0, Piece { left, ..done });
                                }
                            }
                        }
                        let takes = pace.time(has.iter().copied());
                        assert!(
                            takes <= within + 1e-9,
                            "{joins:?} {velocity} {within}: {takes}"
                        );
                    }
                    assert!(pace.rates.velocity <= velocity && pace.rates.acceleration <= 400.0);
                }
            }
        }
    }

    #[test]
    fn a_usual_jog_keeps_its_speed() {
        for velocity in [7.5, 30.0, 50.0] {
            let pace = Pace::new(PieceEnd::Through, jog(velocity), CEILINGS, 0.29, LAW);
            assert_eq!(pace.rates.velocity, velocity);
            // Braking takes less than the queued pieces, by the time of two reads.
            let braking = velocity / pace.rates.acceleration / 2.0;
            assert!(pace.most / velocity - braking > 0.04, "{pace:?}");
        }
        let fast = Pace::new(PieceEnd::Through, jog(300.0), CEILINGS, 0.29, LAW);
        assert!(fast.rates.velocity > 50.0 && fast.rates.velocity < 60.0);
    }
}
