//! What a first program needs: connect, home, move, stop.

use magician_protocol::Set;
use magician_protocol::commands::Pose;

use super::{Arm, Options, Ran, RunOptions};
use crate::{IntoTarget, Result, build};

/// What a first program needs.
impl Arm {
    /// Connects to an arm and makes sure that it answers.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the port is not there, not allowed or in use, [`ErrorKind::Timeout`](crate::ErrorKind::Timeout)
    /// when nothing answers, [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) when something else does,
    /// [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) for Bluetooth in a build without it.
    pub async fn connect(target: impl IntoTarget) -> Result<Self> {
        Self::connect_with(target, Options::default()).await
    }

    /// Homes the arm, waits until it is done, and clears the alarms (document 1.6.2). It takes up to
    /// half a minute. A laser that is on goes out first.
    ///
    /// # Errors
    /// As [`Run::wait`](super::Run::wait).
    pub async fn home(&self) -> Result<()> {
        self.home_with(RunOptions::default()).await
    }

    /// Where the arm is: x, y, z of the tool's tip in mm and r in degrees, and the four joint angles in degrees
    /// ([`joint_angle`](Pose::joint_angle); document 1.4.1).
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn pose(&self) -> Result<Pose> {
        self.get().await
    }

    /// Moves to a pose (mm, degrees), all joints together, and waits until the arm is there.
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
    /// As [`run`](Self::run): it is checked before a byte of it is sent.
    pub async fn move_to(&self, x: f32, y: f32, z: f32, r: f32) -> Result<Ran> {
        self.run(&[build::move_to(x, y, z, r)]).await
    }

    /// Moves to a pose (mm, degrees) on a straight line, and waits until the arm is there.
    ///
    /// # Errors
    /// As [`move_to`](Self::move_to).
    pub async fn line_to(&self, x: f32, y: f32, z: f32, r: f32) -> Result<Ran> {
        self.run(&[build::line_to(x, y, z, r)]).await
    }

    /// Moves to a pose (mm, degrees) over obstacles, up, across and down, and waits until the arm is there. How high is a setting:
    /// `PTPJumpParams`.
    ///
    /// # Errors
    /// As [`move_to`](Self::move_to).
    pub async fn jump_to(&self, x: f32, y: f32, z: f32, r: f32) -> Result<Ran> {
        self.run(&[build::jump_to(x, y, z, r)]).await
    }

    /// Checks commands as the arm stands now, before any of them is sent, runs them through the queue, and returns when the last has
    /// finished.
    ///
    /// What is not to be checked, or comes while it runs, is [started](Self::start) instead.
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
    /// [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) with value and limit and
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) from the check, with the [step](crate::Error::step),
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) when one holds the queue already, else as
    /// [`Run::wait`](super::Run::wait).
    pub async fn run(&self, commands: &[Set]) -> Result<Ran> {
        self.run_with(commands, RunOptions::default(), |_| {}).await
    }

    /// Stops the motion, switches the laser off, drops what waits in the queue, switches both motor outputs off (a belt that
    /// anyone started stands then), and makes sure that
    /// the arm stands. It overtakes everything; commands that have not gone out
    /// end with [`ErrorKind::Closed`](crate::ErrorKind::Closed). Suction and gripper stay as they are. Any clone may call it while others wait;
    /// [`stopper`](Self::stopper) does it without a runtime.
    ///
    /// This is a convenience, not a safety function: the arm has a power switch.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) when the arm does not answer or does not come to a stand.
    pub async fn stop(&self) -> Result<()> {
        let deadline = self.deadline();
        let stops = self.inner.shared.stop();
        self.halted(deadline, stops).await?;
        self.come_to_rest().await
    }
}
