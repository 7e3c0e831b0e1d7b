//! Retracting a tool after its work: up, or to its parking position.

use std::fmt;

use magician_protocol::Set;
use magician_protocol::commands::Pose;

use super::{Arm, RunOptions, SettingsBackup};
use crate::build::{line_to, move_to};
use crate::message;
use crate::preflight::Preflight;
use crate::{Error, ErrorCode, Result};

/// Result of a [`lift`](Arm::lift).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LiftResult {
    /// Requested height, mm.
    pub asked: f64,
    /// Actual height, mm: less at the end of the arm's reach, 0 if it cannot move up.
    pub by: f64,
    /// Pose after the lift.
    pub pose: Pose,
}

impl Arm {
    /// Raises the tool straight up by `height` (mm), or as far as the arm reaches, and waits until
    /// it is there.
    ///
    /// For a pen when a drawing ends, pauses or was stopped. It is a normal move: it is checked
    /// from where the arm stands, goes through the queue, and a [`stop`](Self::stop) ends it. It
    /// takes less than 1.5 s for heights up to 150 mm. If the current speeds are too low for that,
    /// it changes and restores them.
    ///
    /// ```
    /// use magician::{Arm, build};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// # let arm = Arm::connect("sim").await?;
    /// arm.run(&[build::line_to(220.0, 0.0, -40.0, 0.0)]).await?;
    /// let lifted = arm.lift(10.0).await?;
    /// assert_eq!((lifted.by, lifted.pose.z), (10.0, -30.0));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The arm does not move if an alarm holds it ([`ErrorKind::Alarm`](crate::ErrorKind::Alarm)),
    /// if its position is unknown because it moves or has commands in its queue
    /// ([`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput)), or after a stop since the
    /// call ([`ErrorKind::Closed`](crate::ErrorKind::Closed)); else as [`run`](Self::run).
    pub async fn lift(&self, height: f64) -> Result<LiftResult> {
        let stops = self.stops();
        // The target does not matter: only the kind of move decides which settings are read.
        let course = course_from_here(self, &[line_to(0.0, 0.0, 0.0, 0.0)]).await?;
        let lift = course.lift(height)?;
        retract(self, course, &lift.commands, stops).await?;
        Ok(LiftResult {
            asked: height,
            by: lift.by,
            pose: self.get().await?,
        })
    }

    /// Moves the tool tip to its parking position (x, y, z), and waits until it is there.
    ///
    /// The horizontal part is no lower than the higher end, if that is within reach:
    /// [`Preflight::way_to_park`]. A tool that touches its work is [lifted](Self::lift) first.
    ///
    /// # Errors
    /// Same as [`lift`](Self::lift); [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) if
    /// the position is out of reach.
    pub async fn park(&self, place: [f64; 3]) -> Result<Pose> {
        let stops = self.stops();
        let moves = [line_to(0.0, 0.0, 0.0, 0.0), move_to(0.0, 0.0, 0.0, 0.0)];
        let course = course_from_here(self, &moves).await?;
        let way = course.way_to_park(place)?;
        retract(self, course, &way, stops).await?;
        self.get().await
    }
}

/// Reads the start of a retracting move. Fails while an alarm holds the arm.
async fn course_from_here(arm: &Arm, moves: &[Set]) -> Result<Preflight> {
    let alarms = arm.alarms().await?;
    if alarms.blocking() {
        return Err(arm.stopped_by(alarms).await);
    }
    let course = arm.preflight_for(moves).await?;
    // A relative move from an unknown position could go anywhere.
    if course.arm().is_none() {
        return Err(Error::new(
            ErrorCode::PositionUnknown,
            message!("the arm's position is unknown: it moves, or commands wait in its queue"),
        ));
    }
    Ok(course)
}

/// Runs commands that were checked from `course`, and restores the speeds that they change.
async fn retract(arm: &Arm, course: Preflight, commands: &[Set], stops: u64) -> Result<()> {
    let mut saved = SettingsBackup::read(arm, commands).await?;
    let options = RunOptions::default().unless_stopped_since(stops);
    let run = arm.start_with(commands.iter().copied(), options);
    let mut run = run.along(course);
    // No `?` here: the speeds are restored after a failed run as well.
    let ran = run.wait(|_| {}).await;
    let restored = saved.restore(arm).await;
    ran?;
    restored
}

/// Describes the lift as a sentence.
impl fmt::Display for LiftResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { asked, by, .. } = self;
        if *by <= 0.0 {
            write!(f, "the pen was not lifted: the arm cannot go up from there")
        } else if by < asked {
            write!(
                f,
                "the pen is up by {by:.1} of {asked:.1} mm, the limit of the arm"
            )
        } else {
            write!(f, "the pen is up by {by:.1} mm")
        }
    }
}
