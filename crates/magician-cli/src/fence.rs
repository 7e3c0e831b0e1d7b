//! The fence of the arm that is meant.

use magician::Fence;

use crate::context::Context;

impl Context {
    /// The fence of the arm that is meant, as far as that is known without one.
    pub(crate) fn fence(&mut self) -> Option<Fence> {
        if let Some(arm) = self.connected() {
            return arm.fence();
        }
        let target = self.target(None).ok()?;
        let config = self.config().ok()?;
        config.arm_at(&target)?.fence
    }
}
