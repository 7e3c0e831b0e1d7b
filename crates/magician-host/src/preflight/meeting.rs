//! Where and when an arm meets something that moves evenly: an object on a belt.

use std::time::Duration;

use magician_protocol::Set;

use super::Preflight;
use crate::message;
use crate::{Error, ErrorCode, ErrorKind, Result};

/// How far apart two instants are that are looked at, s.
const GRID: f64 = 0.02;
/// No meeting is looked for after this, s.
const LATEST: f64 = 600.0;
/// No tool reaches farther from the base axis than this, mm: what is beyond need not be checked.
const FARTHEST: f64 = 1000.0;

/// Something that moves evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingTarget {
    /// Where it is now: x, y, z, mm.
    pub position: [f64; 3],
    /// Where it goes, mm/s.
    pub velocity: [f64; 3],
}

impl MovingTarget {
    /// Where it will be after so many seconds.
    #[must_use]
    pub fn after(&self, seconds: f64) -> [f64; 3] {
        let mut place = self.position;
        for (place, speed) in place.iter_mut().zip(self.velocity) {
            *place += speed * seconds;
        }
        place
    }
}

/// Where and when a target is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// From now.
    pub after: Duration,
    /// Where the target is then: x, y, z, mm.
    pub position: [f64; 3],
    /// How long the commands take that lead there.
    pub takes: Duration,
}

impl Preflight {
    /// The earliest meeting with something that moves evenly. `way` makes the commands that lead to a place and end there;
    /// they begin `ready` from now at the earliest, and take the time that this check tells.
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
    /// let meeting = check.meet(&cube, Duration::ZERO, |[x, y, z]| {
    ///     let [x, y, z] = [x, y, z].map(|number| number as f32);
    ///     vec![build::move_to(x, y, z + 40.0, 0.0), build::line_to(x, y, z, 0.0)]
    /// })?;
    /// let [_, y, _] = cube.after(meeting.after.as_secs_f64());
    /// assert!((meeting.position[1] - y).abs() < 1e-6);
    /// assert!(meeting.after >= meeting.takes);
    /// # Ok::<(), magician_host::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Unreachable`] when no place of its way is within reach, or the arm is there too late; else as
    /// [`estimate`](Self::estimate).
    pub fn meet(
        &self,
        target: &MovingTarget,
        ready: Duration,
        way: impl Fn([f64; 3]) -> Vec<Set>,
    ) -> Result<Meeting> {
        let numbers = target.position.iter().chain(&target.velocity);
        if !numbers.into_iter().all(|number| number.is_finite()) {
            return Err(Error::invalid(message!(
                "the target's place and velocity are finite numbers"
            )));
        }
        let (mut at, mut reached, mut refusal) = (0.0, None, None);
        while at <= LATEST {
            let position = target.after(at);
            let mut step = GRID;
            if libm::hypot(position[0], position[1]) <= FARTHEST {
                match self.estimate(&way(position)) {
                    Ok(takes) => {
                        let late = (ready + takes).as_secs_f64() - at;
                        if late <= 0.0 {
                            let after = Duration::from_secs_f64(at);
                            return Ok(Meeting {
                                after,
                                position,
                                takes,
                            });
                        }
                        reached = Some((at, takes));
                        // Half of what it is late: the way there gets no shorter at once.
                        step = GRID.max(late / 2.0);
                    }
                    Err(error) if error.kind() == ErrorKind::Unreachable => {
                        refusal.get_or_insert(error);
                    }
                    Err(error) => return Err(error),
                }
            }
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

    fn meet(position: [f64; 3], velocity: [f64; 3]) -> Result<Meeting> {
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
            let meeting = meet(position, velocity).unwrap();
            let target = MovingTarget { position, velocity };
            let after = meeting.after.as_secs_f64();
            for (place, should) in meeting.position.iter().zip(target.after(after)) {
                assert!((place - should).abs() < 1e-3, "{meeting:?}");
            }
            assert_eq!(
                check().estimate(&way(meeting.position)).unwrap(),
                meeting.takes
            );
            let early = meeting.after.saturating_sub(meeting.takes);
            // In time for the arm to begin, and not much later.
            assert!(early >= Duration::from_millis(200), "{meeting:?}");
            assert!(early < Duration::from_millis(900), "{meeting:?}");
        }
    }

    #[test]
    fn what_comes_into_reach_later_is_waited_for() {
        let meeting = meet([220.0, -900.0, 0.0], [0.0, 20.0, 0.0]).unwrap();
        assert!(meeting.after > Duration::from_secs(30), "{meeting:?}");
        assert!(way_is_refused([220.0, meeting.position[1] - 1.0, 0.0]));
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
