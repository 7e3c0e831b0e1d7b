//! Methods that a first program needs: connect, home, move, stop.

use magician_protocol::Set;
use magician_protocol::commands::Pose;

use super::{Arm, Options, RunOptions, RunSummary};
use crate::{IntoTarget, Result, build};

/// Methods for a first program.
impl Arm {
    /// Connects to an arm and checks that it answers.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if the port is missing, not permitted or in use,
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) if nothing answers,
    /// [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) if another device answers,
    /// [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) for Bluetooth in a build without
    /// it.
    pub async fn connect(target: impl IntoTarget) -> Result<Self> {
        Self::connect_with(target, Options::default()).await
    }

    /// Homes the arm, waits until it is done, and clears the alarms (document 1.6.2). This takes up
    /// to half a minute. A laser that is on is switched off first.
    ///
    /// # Errors
    /// Same as [`Run::wait`](super::Run::wait).
    pub async fn home(&self) -> Result<()> {
        self.home_with(RunOptions::default()).await
    }

    /// Reads the pose: x, y, z of the tool tip in mm, r in degrees, and the four joint angles in
    /// degrees ([`joint_angle`](Pose::joint_angle); document 1.4.1).
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn pose(&self) -> Result<Pose> {
        self.get().await
    }

    /// Moves to a pose (mm, degrees) with all joints at once, and waits until the arm is there. The
    /// tool's path is not a straight line.
    ///
    /// ```
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// let arm = magician::Arm::connect("sim").await?;
    /// arm.move_to(220.0, 40.0, 30.0, 0.0).await?;
    /// arm.line_to(220.0, -40.0, 30.0, 0.0).await?;
    /// let pose = arm.pose().await?;
    /// assert_eq!((pose.x, pose.y, pose.z), (220.0, -40.0, 30.0));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Same as [`run`](Self::run); the move is checked before it is sent.
    pub async fn move_to(&self, x: f32, y: f32, z: f32, r: f32) -> Result<RunSummary> {
        self.run(&[build::move_to(x, y, z, r)]).await
    }

    /// Moves to a pose (mm, degrees) in a straight line, and waits until the arm is there.
    ///
    /// # Errors
    /// Same as [`move_to`](Self::move_to).
    pub async fn line_to(&self, x: f32, y: f32, z: f32, r: f32) -> Result<RunSummary> {
        self.run(&[build::line_to(x, y, z, r)]).await
    }

    /// Moves to a pose (mm, degrees) over obstacles: up, across and down, and waits until the arm
    /// is there. The height is a setting, `PTPJumpParams`.
    ///
    /// # Errors
    /// Same as [`move_to`](Self::move_to).
    pub async fn jump_to(&self, x: f32, y: f32, z: f32, r: f32) -> Result<RunSummary> {
        self.run(&[build::jump_to(x, y, z, r)]).await
    }

    /// Checks all commands from where the arm stands, then runs them through the queue, and returns
    /// when the last has finished.
    ///
    /// Nothing is sent unless every command passes. For commands without a check, or commands that
    /// are computed while the run goes on, use [`start`](Self::start).
    ///
    /// ```
    /// use magician::{Arm, ErrorKind, build};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// # let arm = Arm::connect("sim").await?;
    /// let (near, far) = (build::move_to(220.0, 40.0, 30.0, 0.0), build::move_to(900.0, 0.0, 0.0, 0.0));
    /// let ran = arm.run(&[near, build::suction(true)]).await?;
    /// assert_eq!(ran.commands, 2);
    /// let error = arm.run(&[near, far]).await.unwrap_err(); // nothing was sent
    /// assert_eq!((error.kind(), error.step()), (ErrorKind::Unreachable, Some(1)));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) (with value and limit) and
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) from the check, with the
    /// [step](crate::Error::step); [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) if an alarm
    /// already holds the queue; else as [`Run::wait`](super::Run::wait).
    pub async fn run(&self, commands: &[Set]) -> Result<RunSummary> {
        self.run_with(commands, RunOptions::default(), |_| {}).await
    }

    /// Stops the arm and waits until it is at rest.
    ///
    /// A stop ends the motion, switches the laser off, drops the commands in the queue, and
    /// switches off both motor outputs, including a belt that another program started. Suction and
    /// gripper stay as they are. It overtakes all requests; commands that have not been sent yet
    /// fail with [`ErrorKind::Closed`](crate::ErrorKind::Closed). Any clone may call it while
    /// others wait; [`stopper`](Self::stopper) does the same without a runtime.
    ///
    /// This is a convenience, not a safety function: the arm has a power switch.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) if the arm does not answer or does not
    /// come to rest.
    pub async fn stop(&self) -> Result<()> {
        let deadline = self.deadline();
        let stops = self.inner.shared.stop();
        self.halted(deadline, stops).await?;
        self.come_to_rest().await
    }
}
