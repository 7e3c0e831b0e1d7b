//! What is asked for most often, as methods: the same as a [builder](crate::build) given to [`Arm::run`].

use magician_protocol::commands::{GetIoDi, IoDi, Pose};

use super::{Arm, Ran};
use crate::{Result, build};

/// Builders as methods.
impl Arm {
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

    /// Whether a digital input (EIO address 1 to 20, document 1.15.4) is high. The pin has to be set up as an input before:
    /// [`build::multiplex`].
    ///
    /// # Errors
    /// As [`get`](Self::get); [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) where the arm has no such pin.
    pub async fn digital_input(&self, address: u8) -> Result<bool> {
        let address = Some(address);
        let read: IoDi = self.get_with(&GetIoDi { address }).await?;
        Ok(read.level.is_on())
    }

    /// Waits until a digital input (EIO address 1 to 20) has this level, in the arm's queue and for ever if need be (document
    /// 1.14.1): a [`stop`](Self::stop) ends it.
    ///
    /// # Errors
    /// As [`move_to`](Self::move_to).
    pub async fn wait_for_input(&self, address: u8, high: bool) -> Result<Ran> {
        self.run(&[build::wait_for_level(address, high)]).await
    }
}
