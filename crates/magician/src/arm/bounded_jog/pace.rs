//! How fast a jog in pieces goes, how long its pieces are, and when the next one may follow.
//!
//! All of it keeps one promise: whatever the arm has when a piece arrives is done within a time, from wherever on its way it
//! may be by then. So it counts with the farthest that the arm may still have to go, by the pose that was read last.

use magician_motion::KinematicLimits;

/// How soon after a piece the next one may follow: a shorter one would be more frames than way, s.
const PIECE_S: f64 = 0.025;
/// A piece is not shorter, mm or degrees: more than what a pose is read to.
const SHORTEST: f64 = 0.01;
/// A jog is not slower, mm/s or deg/s: a shortest piece takes no longer than the shortest of times.
const SLOWEST: f64 = 0.5;

/// Whether the arm stands at the end of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Joins {
    /// Segments of a path: it runs through, and rests at the end of the last.
    Through,
    /// Moves: it rests at the end of each.
    AtRest,
}

/// A jog in pieces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    joins: Joins,
    /// Speed (mm/s or deg/s) and acceleration of the pieces.
    pub(super) rates: KinematicLimits,
    /// All that the arm has is to be done within this, s.
    within: f64,
    /// How long a piece is at most, and at least.
    most: f64,
    least: f64,
}

/// A piece that the arm may not have done.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) length: f64,
    /// What of it may be left.
    pub(super) left: f64,
}

impl Pace {
    /// A pace as near to these rates of a jog as the time allows, never faster; `ceilings` bound what the pieces are planned with.
    pub(super) fn new(
        joins: Joins,
        jog: KinematicLimits,
        ceilings: KinematicLimits,
        within: f64,
    ) -> Self {
        let wanted = jog.velocity.min(ceilings.velocity).max(SLOWEST);
        // What is left of that time when the next piece comes: looks and pieces have to be asked for and answered.
        let (short, long) = ((within / 4.0).min(0.06), (0.4 * within).min(0.12));
        let strongest = ceilings.acceleration;
        let (velocity, acceleration) = match joins {
            // From rest `within` holds a ramp up, one down, and the way between. Braking from full speed takes half a ramp.
            Joins::Through => {
                let least = jog.acceleration.min(strongest);
                let needed = 1.5 * wanted / (within - long);
                let velocity = wanted.min(strongest * (within - short) / 1.5);
                (velocity, needed.clamp(least, strongest))
            }
            // The end of one piece, and both ramps of the next.
            Joins::AtRest => (wanted.min(strongest * (within - short) / 2.0), strongest),
        };
        let ramp = velocity / acceleration;
        let most = match joins {
            Joins::Through => velocity * (within - ramp),
            Joins::AtRest => velocity * (within - short - ramp),
        };
        let least = match joins {
            Joins::Through => (velocity * PIECE_S).max(SHORTEST),
            // The same each time: a short one would be slow.
            Joins::AtRest => most,
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
        }
    }

    /// How long the arm takes for what it may have, from wherever it may be, s.
    fn time(&self, pieces: impl Iterator<Item = Piece>) -> f64 {
        match self.joins {
            Joins::Through => self.rest_to_rest(pieces.map(|piece| piece.left).sum()),
            Joins::AtRest => pieces.map(|piece| self.rest_of(piece)).sum(),
        }
    }

    /// How long a way takes from rest to rest, s.
    fn rest_to_rest(&self, length: f64) -> f64 {
        let KinematicLimits {
            velocity,
            acceleration,
        } = self.rates;
        let ramp = velocity / acceleration;
        match length >= velocity * ramp {
            true => length / velocity + ramp,
            false => 2.0 * (length / acceleration).sqrt(),
        }
    }

    /// How long the rest of a move takes. Where it may not have come to its speed it counts whole.
    fn rest_of(&self, piece: Piece) -> f64 {
        let KinematicLimits {
            velocity,
            acceleration,
        } = self.rates;
        let ramp = velocity / acceleration;
        let speeding_up = (velocity * ramp).min(piece.length) / 2.0;
        if piece.left > piece.length - speeding_up {
            self.rest_to_rest(piece.length)
        } else if piece.left > speeding_up {
            piece.left / velocity + ramp / 2.0
        } else {
            (2.0 * piece.left / acceleration).sqrt()
        }
    }

    /// How long the next piece may be, behind these; or after which time to look again, s.
    pub(super) fn next(&self, pieces: impl Iterator<Item = Piece> + Clone) -> Result<f64, f64> {
        let (room, needed) = match self.joins {
            Joins::Through => {
                let left: f64 = pieces.map(|piece| piece.left).sum();
                (self.most - left, self.least)
            }
            Joins::AtRest => {
                let free = self.within - self.time(pieces);
                let needed = self.rest_to_rest(self.least);
                match free >= needed {
                    true => (self.least, self.least),
                    false => (free * self.rates.velocity, needed * self.rates.velocity),
                }
            }
        };
        match room >= needed {
            true => Ok(room.min(self.most)),
            false => Err((needed - room) / self.rates.velocity),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CEILINGS: KinematicLimits = KinematicLimits {
        velocity: 300.0,
        acceleration: 400.0,
    };

    fn jog(velocity: f64) -> KinematicLimits {
        KinematicLimits {
            velocity,
            acceleration: 60.0,
        }
    }

    #[test]
    fn what_the_arm_has_is_never_longer_than_the_time() {
        for joins in [Joins::Through, Joins::AtRest] {
            for within in [0.06, 0.14, 0.29, 1.04, 2.04] {
                for velocity in [0.5, 3.0, 7.5, 30.0, 60.0, 300.0] {
                    let pace = Pace::new(joins, jog(velocity), CEILINGS, within);
                    let mut has: Vec<Piece> = Vec::new();
                    for _ in 0..50 {
                        match pace.next(has.iter().copied()) {
                            Ok(length) => has.push(Piece {
                                length,
                                left: length,
                            }),
                            // Some of it is done meanwhile.
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
        for velocity in [7.5, 30.0, 60.0] {
            let pace = Pace::new(Joins::Through, jog(velocity), CEILINGS, 0.29);
            assert_eq!(pace.rates.velocity, velocity);
            // Braking takes less than what the arm has, by the time of two looks.
            let braking = velocity / pace.rates.acceleration / 2.0;
            assert!(pace.most / velocity - braking > 0.05, "{pace:?}");
        }
        let fast = Pace::new(Joins::Through, jog(300.0), CEILINGS, 0.29);
        assert!(fast.rates.velocity > 60.0 && fast.rates.velocity < 65.0);
    }
}
