//! Rendezvous of the arm with an object that moves at constant velocity, such as one on a conveyor.

use std::time::Duration;

use magician_protocol::Set;

use super::Preflight;
use crate::message;
use crate::{Error, ErrorCode, ErrorKind, Result};

/// Time step of the search, s. At 100 mm/s an object moves 2 mm within it.
const TIME_STEP: f64 = 0.02;
/// Latest rendezvous considered, s.
// Ten minutes: longer than any object is waited for, short enough to end the search of an
// unreachable one.
const MAX_TIME: f64 = 600.0;
/// Distance from the base axis beyond which no position needs a check, mm: no tool reaches that
/// far.
const MAX_RADIUS: f64 = 1000.0;

/// An object moving at constant velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingTarget {
    /// Present position x, y, z, mm.
    pub position: [f64; 3],
    /// Velocity, mm/s.
    pub velocity: [f64; 3],
}

impl MovingTarget {
    /// Position after `seconds`.
    #[must_use]
    pub fn after(&self, seconds: f64) -> [f64; 3] {
        let mut place = self.position;
        for (place, speed) in place.iter_mut().zip(self.velocity) {
            *place += speed * seconds;
        }
        place
    }
}

/// Place and time of a rendezvous.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendezvous {
    /// Time from now.
    pub after: Duration,
    /// Position of the target at that time: x, y, z, mm.
    pub position: [f64; 3],
    /// Duration of the commands that lead there.
    pub takes: Duration,
}

impl Preflight {
    /// Finds the earliest rendezvous with a moving target.
    ///
    /// `way` makes the commands that lead to a position and end there. They begin `ready` from now
    /// at the earliest, and take the time that this check calculates.
    ///
    /// ```
    /// use std::time::Duration;
    ///
    /// use magician_host::build;
    /// use magician_host::preflight::{MovingTarget, Preflight};
    /// use magician_host::{JointAngles, ToolBias};
    ///
    /// let check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
    /// let cube = MovingTarget { position: [220.0, -150.0, 0.0], velocity: [0.0, 40.0, 0.0] };
    /// let rendezvous = check.meet(&cube, Duration::ZERO, |[x, y, z]| {
    ///     let [x, y, z] = [x, y, z].map(|number| number as f32);
    ///     vec![build::move_to(x, y, z + 40.0, 0.0), build::line_to(x, y, z, 0.0)]
    /// })?;
    /// let [_, y, _] = cube.after(rendezvous.after.as_secs_f64());
    /// assert!((rendezvous.position[1] - y).abs() < 1e-6);
    /// assert!(rendezvous.after >= rendezvous.takes);
    /// # Ok::<(), magician_host::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Unreachable`] if no position on its way is in reach, or the arm would be too
    /// late everywhere; otherwise as [`estimate`](Self::estimate).
    pub fn meet(
        &self,
        target: &MovingTarget,
        ready: Duration,
        way: impl Fn([f64; 3]) -> Vec<Set>,
    ) -> Result<Rendezvous> {
        let numbers = target.position.iter().chain(&target.velocity);
        // Comparisons with NaN would let the search run to its end.
        if !numbers.into_iter().all(|number| number.is_finite()) {
            return Err(Error::invalid(message!(
                "the target's place and velocity are finite numbers"
            )));
        }
        let (mut at, mut reached, mut refusal) = (0.0, None, None);
        while at <= MAX_TIME {
            let position = target.after(at);
            let mut step = TIME_STEP;
            if libm::hypot(position[0], position[1]) <= MAX_RADIUS {
                match self.estimate(&way(position)) {
                    Ok(takes) => {
                        let late = (ready + takes).as_secs_f64() - at;
                        if late <= 0.0 {
                            let after = Duration::from_secs_f64(at);
                            return Ok(Rendezvous {
                                after,
                                position,
                                takes,
                            });
                        }
                        reached = Some((at, takes));
                        // Half of the delay: the path shortens gradually as the target moves, so no
                        // rendezvous is skipped.
                        step = TIME_STEP.max(late / 2.0);
                    }
                    Err(error) if error.kind() == ErrorKind::Unreachable => {
                        refusal.get_or_insert(error);
                    }
                    Err(error) => return Err(error),
                }
            }
            // A target at rest does not come into reach later.
            if target.velocity == [0.0; 3] && reached.is_none() {
                break;
            }
            at += step;
        }
        Err(missed(target, reached, refusal))
    }
}

fn missed(
    target: &MovingTarget,
    reached: Option<(f64, Duration)>,
    refusal: Option<Error>,
) -> Error {
    let [x, y, z] = target.position;
    let remedies = refusal
        .as_ref()
        .map_or(Vec::new(), |refusal| refusal.remedies().to_vec());
    let why = match (reached, refusal) {
        (Some((until, takes)), _) => message!(
            "it is within reach until {until:.2} s from now, and the arm needs {takes:.2} s to be there",
            until,
            takes = takes.as_secs_f64()
        ),
        (None, Some(refusal)) => message!(
            "no place on its way is within reach: {cause}",
            cause = refusal.sentence()
        ),
        (None, None) => message!("no place on its way is within reach"),
    };
    let message = message!(
        "the target at {x:.1}, {y:.1}, {z:.1} cannot be met: {why}",
        x,
        y,
        z,
        why
    );
    let error = Error::new(ErrorCode::OutOfReach, message);
    let remedies = remedies.into_iter();
    remedies.fold(error, |error, remedy| {
        error.remedy(remedy.act, remedy.effect)
    })
}

#[cfg(test)]
mod tests {
    use magician_motion::{JointAngles, ToolBias};

    use super::*;
    use crate::build;

    fn check() -> Preflight {
        Preflight::at(JointAngles::HOME, ToolBias::SUCTION)
    }

    fn way(place: [f64; 3]) -> Vec<Set> {
        let [x, y, z] = place.map(|number| number as f32);
        vec![
            build::move_to(x, y, z + 40.0, 0.0),
            build::line_to(x, y, z, 0.0),
        ]
    }

    fn meet(position: [f64; 3], velocity: [f64; 3]) -> Result<Rendezvous> {
        let target = MovingTarget { position, velocity };
        check().meet(&target, Duration::from_millis(200), way)
    }

    #[test]
    fn the_arm_is_there_when_the_target_is() {
        for velocity in [
            [0.0; 3],
            [0.0, 40.0, 0.0],
            [30.0, 60.0, 0.0],
            [0.0, 5.0, 0.0],
        ] {
            let position = [200.0, -120.0, 0.0];
            let rendezvous = meet(position, velocity).unwrap();
            let target = MovingTarget { position, velocity };
            let after = rendezvous.after.as_secs_f64();
            for (place, should) in rendezvous.position.iter().zip(target.after(after)) {
                assert!((place - should).abs() < 1e-3, "{rendezvous:?}");
            }
            assert_eq!(
                check().estimate(&way(rendezvous.position)).unwrap(),
                rendezvous.takes
            );
            let early = rendezvous.after.saturating_sub(rendezvous.takes);
            // In time for the arm to begin, and not much later.
            assert!(early >= Duration::from_millis(200), "{rendezvous:?}");
            assert!(early < Duration::from_millis(900), "{rendezvous:?}");
        }
    }

    #[test]
    fn what_comes_into_reach_later_is_waited_for() {
        let rendezvous = meet([220.0, -900.0, 0.0], [0.0, 20.0, 0.0]).unwrap();
        assert!(rendezvous.after > Duration::from_secs(30), "{rendezvous:?}");
        assert!(way_is_refused([220.0, rendezvous.position[1] - 1.0, 0.0]));
    }

    fn way_is_refused(place: [f64; 3]) -> bool {
        check().estimate(&way(place)).is_err()
    }

    #[test]
    fn what_cannot_be_met_is_said() {
        for (position, velocity, why) in [
            ([220.0, -900.0, 0.0], [0.0, -20.0, 0.0], "within reach"),
            (
                [500.0, 0.0, 0.0],
                [0.0; 3],
                "no place on its way is within reach: ",
            ),
            ([220.0, 240.0, 0.0], [0.0, 400.0, 0.0], "and the arm needs "),
        ] {
            let error = meet(position, velocity).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Unreachable);
            assert!(error.message().contains(why), "{error}");
        }
        let error = meet([f64::NAN, 0.0, 0.0], [0.0; 3]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
    }
}
