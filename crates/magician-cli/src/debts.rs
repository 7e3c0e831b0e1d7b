//! Settings that a verb changes for its own time and owes the arm back, however it ends.

use std::cell::RefCell;
use std::rc::Rc;

use magician::{Arm, Ctrl, FrameBuf, Set};

use crate::failure::Failure;

/// What is owed. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Debts(Rc<RefCell<Vec<Set>>>);

impl Debts {
    /// Owes the arm this setting.
    pub(crate) fn owe(&self, setting: impl Into<Set>) {
        self.0.borrow_mut().push(setting.into());
    }

    /// The queue has paid.
    pub(crate) fn forget(&self) {
        self.0.borrow_mut().clear();
    }

    /// Gives the arm back what is owed.
    pub(crate) async fn pay(&self, arm: &Arm) -> Result<(), Failure> {
        let owed = self.0.take();
        for setting in &owed {
            at_once(arm, setting).await?;
        }
        Ok(())
    }

    /// After a verb that ended badly: what it set going ends, so that nothing of it comes later,
    /// and the settings are given back as far as the arm takes them. The failure that is on its
    /// way to the user is the better story, so no other is told.
    pub(crate) async fn pay_after_failure(&self, arm: &Arm) {
        if !self.0.borrow().is_empty() && arm.stop().await.is_ok() {
            let _ = self.pay(arm).await;
        }
        self.forget();
    }
}

/// Sends a command past the queue.
pub(crate) async fn at_once(arm: &Arm, command: &Set) -> Result<(), Failure> {
    let order = FrameBuf::set(command, Ctrl::SET).map_err(magician::Error::from)?;
    let order = order.frame();
    arm.raw(order.id(), order.ctrl(), order.params()).await?;
    Ok(())
}
