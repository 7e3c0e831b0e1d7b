//! Settings that a verb changes for its own time and owes the arm back, however it ends.

use std::cell::RefCell;
use std::rc::Rc;

use magician::{Arm, Owed, Set};

use crate::failure::Failure;

/// What is owed. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Debts(Rc<RefCell<Owed>>);

impl Debts {
    /// Owes the arm this setting.
    pub(crate) fn owe(&self, setting: impl Into<Set>) {
        self.0.borrow_mut().owe(setting);
    }

    /// Owes the arm what a program changes.
    pub(crate) fn owe_all(&self, owed: Owed) {
        self.0.borrow_mut().append(owed);
    }

    /// The queue has paid.
    pub(crate) fn forget(&self) {
        self.0.take();
    }

    /// Gives the arm back what is owed.
    pub(crate) async fn pay(&self, arm: &Arm) -> Result<(), Failure> {
        Ok(self.0.take().give_back(arm).await?)
    }

    /// After a verb that ended badly: what it set going ends, so that nothing of it comes later,
    /// and the settings are given back as far as the arm takes them. The failure that is on its
    /// way to the user is the better story, so no other is told.
    pub(crate) async fn pay_after_failure(&self, arm: &Arm) {
        let mut owed = self.0.take();
        if !owed.is_empty() && arm.stop().await.is_ok() {
            let _ = owed.give_back(arm).await;
        }
    }
}
