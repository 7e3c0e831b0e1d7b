//! Fence of the arm that the options name.

use magician::Fence;

use crate::context::Context;

impl Context {
    /// Returns the fence of the named arm, from the open connection or the settings; `None` if it
    /// has none or it is unknown.
    pub(crate) fn fence(&mut self) -> Option<Fence> {
        if let Some(arm) = self.connected() {
            return arm.fence();
        }
        let target = self.target(None).ok()?;
        let config = self.config().ok()?;
        config.arm_at(&target)?.fence
    }
}
