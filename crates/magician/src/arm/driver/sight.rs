//! What passes anyway says something about the arm.

use magician_protocol::commands::DeviceSn;
use magician_protocol::{Frame, Readable};

use super::Driver;
use super::greeting::serial_number;

impl Driver {
    /// A request was answered.
    pub(super) fn observe(&mut self, request: &Frame<'_>, reply: &Frame<'_>) {
        if request.id() == <DeviceSn as Readable>::ROW.id {
            self.serial = match request.ctrl().write() {
                true => serial_number(request.params()),
                false => serial_number(reply.params()),
            };
        }
    }
}
