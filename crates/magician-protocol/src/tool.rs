use crate::commands::EndEffectorParams;

impl EndEffectorParams {
    /// Whether it is no tool at all: what an arm has that was never told of one. Its poses are then those of the wrist.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        [self.x_bias, self.y_bias, self.z_bias] == [0.0; 3]
    }
}
