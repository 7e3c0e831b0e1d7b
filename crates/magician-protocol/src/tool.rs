//! Tool bias of the end effector.

use crate::commands::EndEffectorParams;

impl EndEffectorParams {
    /// True if all biases are 0, the state of an arm whose tool was never set. Its poses are then
    /// those of the wrist.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        [self.x_bias, self.y_bias, self.z_bias] == [0.0; 3]
    }
}
