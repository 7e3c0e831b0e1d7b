//! A connected arm: checks before a command is sent, and consequences of its outcome.
//!
//! Every command passes `Session::send`: dangerous commands need permission, nothing that must not
//! be repeated is sent while an earlier command is in doubt (`doubt`), and a queue that has stopped
//! is explained (`standstill`).

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::commands::{
    ClearAlarmsState, JogCmd, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdStartExec,
};
use magician::protocol::{Layout, NoArgs, Queueable, Readable, Row, Writable};
use magician::{Ctrl, Error, ErrorKind, FrameBuf, QueueIndex, Set, blocking};

use super::danger::Allowed;
use super::doubt::Doubt;
use super::pool::Lease;
use super::registry::lock;
use super::standstill::Standstill;
use crate::code::{Code, Fault, Outcome};
use crate::notice;

/// Connected arm. Its methods are the driver's, and refuse commands that must not be sent.
#[derive(Debug)]
pub struct Session {
    arm: blocking::Arm,
    allowed: Arc<Allowed>,
    doubt: Doubt,
    standstill: Standstill,
    /// True once index and free space of the queue were read, so that the driver can resolve a lost
    /// reply to a queued command.
    queue_was_read: AtomicBool,
    /// True once this program has started the queue, or was warned that it has not.
    started: AtomicBool,
    /// True after `DisconnectDobot`.
    released: AtomicBool,
    /// Lease of a virtual arm. `None` for a real one.
    lease: Mutex<Option<Lease>>,
}

/// Form in which a command is sent.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Read,
    Set,
    Queued,
}

impl Session {
    /// Creates a session. `queue_was_read` is true if the queue was read since the connection began.
    /// `standing` is the time for which the queue may stand still before the program gets an
    /// explanation.
    pub(super) fn new(
        arm: blocking::Arm,
        allowed: Arc<Allowed>,
        lease: Option<Lease>,
        queue_was_read: bool,
        standing: Duration,
    ) -> Self {
        // Dropping must not stop the arm: with the vendor's library the arm continues after the
        // program has ended.
        arm.detach();
        Self {
            arm,
            allowed,
            doubt: Doubt::default(),
            standstill: Standstill::new(standing),
            queue_was_read: AtomicBool::new(queue_was_read),
            started: AtomicBool::new(false),
            released: AtomicBool::new(false),
            lease: Mutex::new(lease),
        }
    }

    /// Like [`magician::blocking::Arm::get`].
    ///
    /// # Errors
    /// Those of the driver.
    pub fn get<T: Readable<Query = NoArgs>>(&self) -> Result<T, Fault> {
        self.get_with(&NoArgs)
    }

    /// Like [`magician::blocking::Arm::get_with`].
    ///
    /// # Errors
    /// Those of the driver.
    pub fn get_with<T: Readable>(&self, query: &T::Query) -> Result<T, Fault> {
        notice::note(|| shown(query));
        let value: T = self.send(Some(T::ROW), Form::Read, |arm| arm.get_with(query))?;
        notice::note(|| shown(&value));
        Ok(value)
    }

    /// Like [`magician::blocking::Arm::set`].
    ///
    /// # Errors
    /// Those of the driver; a dangerous command that was not allowed; a command that must not be
    /// repeated while an earlier one is in doubt.
    pub fn set<T: Writable>(&self, value: &T) -> Outcome {
        notice::note(|| shown(value));
        self.send(Some(T::ROW), Form::Set, |arm| arm.set(value))
    }

    /// Like [`magician::blocking::Arm::enqueue`].
    ///
    /// # Errors
    /// Those of the driver; a dangerous command that was not allowed; any command while an earlier
    /// one is in doubt.
    pub fn enqueue<T>(&self, value: &T) -> Result<QueueIndex, Fault>
    where
        T: Queueable + Copy + Into<Set>,
    {
        notice::note(|| shown(value));
        let index = self.send(Some(T::ROW), Form::Queued, |arm| arm.enqueue(value))?;
        self.standstill.queued(index, T::ROW);
        notice::note(|| format!("index {}", index.0));
        Ok(index)
    }

    /// Reads the index of the command that finished last. If the queue stands still, the program
    /// gets an explanation.
    ///
    /// # Errors
    /// Those of [`get`](Self::get).
    pub fn current_index(&self) -> Result<u64, Fault> {
        let QueuedCmdCurrentIndex {
            queued_cmd_current_index,
        } = self.get()?;
        self.standstill
            .note_index(queued_cmd_current_index, &self.arm);
        Ok(queued_cmd_current_index)
    }

    /// Like [`magician::blocking::Arm::raw`].
    ///
    /// # Errors
    /// Those of [`get`](Self::get), [`set`](Self::set) or [`enqueue`](Self::enqueue), depending on
    /// Ctrl.
    pub fn raw(&self, id: u8, ctrl: Ctrl, params: &[u8]) -> Result<FrameBuf, Fault> {
        let row = Row::with_id(id);
        let form = match ctrl {
            ctrl if ctrl.queued() => Form::Queued,
            ctrl if ctrl.write() => Form::Set,
            // A command without a value has an effect even if Ctrl says read.
            _ if row.is_some_and(|row| row.value.is_none()) => Form::Set,
            _ => Form::Read,
        };
        self.send(row, form, |arm| arm.raw(id, ctrl, params))
    }

    /// Sends any command: permission, doubt, the call itself, and the consequences of its outcome.
    fn send<T>(
        &self,
        row: Option<&'static Row>,
        form: Form,
        call: impl FnOnce(&blocking::Arm) -> magician::Result<T>,
    ) -> Result<T, Fault> {
        if form != Form::Read
            && let Some(row) = row
        {
            self.allowed.check(row)?;
        }
        let once = form == Form::Queued || form == Form::Set && row.is_none_or(must_not_repeat);
        if once {
            self.doubt.check()?;
        }
        if form == Form::Queued {
            self.read_base().map_err(|error| self.fault(error, form))?;
        }
        match call(&self.arm) {
            Ok(value) => {
                self.note_success(row, form);
                Ok(value)
            }
            Err(error) => {
                if once && may_be_accepted(&error, form) {
                    self.doubt.raise(&error);
                }
                Err(self.fault(error, form))
            }
        }
    }

    /// Reads index and free space before the first command is queued. If a reply is lost later, the
    /// indices show whether the arm accepted the command.
    fn read_base(&self) -> magician::Result<()> {
        if !self.queue_was_read.load(Ordering::Relaxed) {
            self.arm.queue().current_index()?;
            self.arm.queue().left_space()?;
            self.queue_was_read.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn note_success(&self, row: Option<&'static Row>, form: Form) {
        match row {
            // Clearing the queue removes the command in doubt. A stop would leave it there.
            Some(row) if form == Form::Set && row.id == QueuedCmdClear::ROW.id => {
                self.doubt.clear();
                self.standstill.queue_cleared();
            }
            Some(row) if form == Form::Set && row.id == QueuedCmdStartExec::ROW.id => {
                self.started.store(true, Ordering::Relaxed);
                self.standstill.reset_measurement();
            }
            Some(row) if form == Form::Set && row.id == ClearAlarmsState::ROW.id => {
                self.standstill.reset_measurement();
            }
            // Other commands affect neither the doubt nor the watch on the queue.
            _ => {}
        }
    }

    fn fault(&self, error: Error, form: Form) -> Fault {
        if self.released.load(Ordering::SeqCst) {
            return Fault::new(Code::NoError, "DisconnectDobot was called meanwhile");
        }
        let full = error.kind() == ErrorKind::QueueFull && form == Form::Queued;
        if full && !self.started.swap(true, Ordering::Relaxed) {
            tracing::warn!(
                "{error}, and this program has not started the queue: if the arm stays at rest, \
                    call SetQueuedCmdStartExec"
            );
        }
        error.into()
    }

    pub(super) fn set_timeout(&self, timeout: Duration) {
        self.arm.set_timeout(timeout);
    }

    /// Ends the connection, even while calls wait on it. The arm is left as it is.
    pub(super) fn release(&self) {
        self.released.store(true, Ordering::SeqCst);
        self.arm.clone().close();
        lock(&self.lease).take();
    }
}

/// True if a command must not be executed twice. Starting a jog again continues the same jog, and
/// the end of a jog must always be sent.
fn must_not_repeat(row: &Row) -> bool {
    !row.resendable && row.id != JogCmd::ROW.id
}

/// True if the arm may have accepted the command despite the error. An unintelligible reply to a
/// queued command counts as none.
fn may_be_accepted(error: &Error, form: Form) -> bool {
    match error.kind() {
        ErrorKind::Uncertain => true,
        ErrorKind::Unexpected => form == Form::Queued,
        // The driver reports every other doubt as `Uncertain`.
        _ => false,
    }
}

/// Formats the fields of a value for the log.
fn shown(value: &impl Layout) -> String {
    let bytes = FrameBuf::encode(0, Ctrl::SET, value);
    let Ok(bytes) = bytes else {
        return String::new();
    };
    shown_as(value, bytes.frame().params())
}

fn shown_as<T: Layout>(_: &T, params: &[u8]) -> String {
    let fields = T::INFO.values(params).into_iter().flatten();
    let fields = fields.map(|(field, value)| match field.name {
        "password" => "password=...".to_owned(),
        name => format!("{name}={value}"),
    });
    fields.collect::<Vec<_>>().join(" ")
}
