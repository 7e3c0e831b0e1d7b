//! What every call to an arm goes through.

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

/// A connected arm. Its verbs are the driver's, and refuse what must not be sent.
#[derive(Debug)]
pub struct Session {
    arm: blocking::Arm,
    allowed: Arc<Allowed>,
    doubt: Doubt,
    standstill: Standstill,
    /// Index and left space were read: a lost answer can be made up for.
    based: AtomicBool,
    /// This program has let the queue run.
    started: AtomicBool,
    /// `DisconnectDobot` was called.
    released: AtomicBool,
    /// The virtual arm that this is.
    lease: Mutex<Option<Lease>>,
}

/// How a command goes out.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Read,
    Set,
    Queued,
}

impl Session {
    /// `based`: the queue has been read since the connection began. `standing`: how long a queue stands that is waited
    /// for before the program is told why.
    pub(super) fn new(
        arm: blocking::Arm,
        allowed: Arc<Allowed>,
        lease: Option<Lease>,
        based: bool,
        standing: Duration,
    ) -> Self {
        // However it ends: what the arm does is the program's.
        arm.detach();
        Self {
            arm,
            allowed,
            doubt: Doubt::default(),
            standstill: Standstill::new(standing),
            based: AtomicBool::new(based),
            started: AtomicBool::new(false),
            released: AtomicBool::new(false),
            lease: Mutex::new(lease),
        }
    }

    /// As [`magician::blocking::Arm::get`].
    ///
    /// # Errors
    /// As there.
    pub fn get<T: Readable<Query = NoArgs>>(&self) -> Result<T, Fault> {
        self.get_with(&NoArgs)
    }

    /// As [`magician::blocking::Arm::get_with`].
    ///
    /// # Errors
    /// As there.
    pub fn get_with<T: Readable>(&self, query: &T::Query) -> Result<T, Fault> {
        notice::note(|| shown(query));
        let value: T = self.send(Some(T::ROW), Form::Read, |arm| arm.get_with(query))?;
        notice::note(|| shown(&value));
        Ok(value)
    }

    /// As [`magician::blocking::Arm::set`].
    ///
    /// # Errors
    /// As there; a dangerous command that was not allowed, and one that must not be repeated while an earlier one is in
    /// doubt.
    pub fn set<T: Writable>(&self, value: &T) -> Outcome {
        notice::note(|| shown(value));
        self.send(Some(T::ROW), Form::Set, |arm| arm.set(value))
    }

    /// As [`magician::blocking::Arm::enqueue`].
    ///
    /// # Errors
    /// As there; a dangerous command that was not allowed, and any while an earlier one is in doubt.
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

    /// The index of the command that ended last. A program that waits for more is told why it does not come.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub fn current_index(&self) -> Result<u64, Fault> {
        let QueuedCmdCurrentIndex {
            queued_cmd_current_index,
        } = self.get()?;
        self.standstill.saw(queued_cmd_current_index, &self.arm);
        Ok(queued_cmd_current_index)
    }

    /// As [`magician::blocking::Arm::raw`].
    ///
    /// # Errors
    /// As [`get`](Self::get), [`set`](Self::set) and [`enqueue`](Self::enqueue), by what Ctrl says.
    pub fn raw(&self, id: u8, ctrl: Ctrl, params: &[u8]) -> Result<FrameBuf, Fault> {
        let row = Row::with_id(id);
        let form = match ctrl {
            ctrl if ctrl.queued() => Form::Queued,
            ctrl if ctrl.write() => Form::Set,
            // A command that nothing comes back from does something, whatever Ctrl says.
            _ if row.is_some_and(|row| row.value.is_none()) => Form::Set,
            _ => Form::Read,
        };
        self.send(row, form, |arm| arm.raw(id, ctrl, params))
    }

    /// The journey of every command: whether it may go, what became of it, and what follows from that.
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
        let once = form == Form::Queued || form == Form::Set && row.is_none_or(is_once);
        if once {
            self.doubt.check()?;
        }
        if form == Form::Queued {
            self.read_base().map_err(|error| self.fault(error, form))?;
        }
        match call(&self.arm) {
            Ok(value) => {
                self.done(row, form);
                Ok(value)
            }
            Err(error) => {
                if once && leaves_doubt(&error, form) {
                    self.doubt.arise(&error);
                }
                Err(self.fault(error, form))
            }
        }
    }

    /// Reads the queue before this connection puts anything into it, so that the fate of a command whose answer is lost
    /// can be told from the indices.
    fn read_base(&self) -> magician::Result<()> {
        if !self.based.load(Ordering::Relaxed) {
            self.arm.queue().current_index()?;
            self.arm.queue().left_space()?;
            self.based.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn done(&self, row: Option<&'static Row>, form: Form) {
        match row {
            // What was in doubt waits no more. A stop would leave it in the queue.
            Some(row) if form == Form::Set && row.id == QueuedCmdClear::ROW.id => {
                self.doubt.lift();
                self.standstill.dropped();
            }
            Some(row) if form == Form::Set && row.id == QueuedCmdStartExec::ROW.id => {
                self.started.store(true, Ordering::Relaxed);
                self.standstill.begin_anew();
            }
            Some(row) if form == Form::Set && row.id == ClearAlarmsState::ROW.id => {
                self.standstill.begin_anew();
            }
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

/// Whether a command must not be done twice. A jog that is begun again is the same jog, and its end must always go out.
fn is_once(row: &Row) -> bool {
    !row.resendable && row.id != JogCmd::ROW.id
}

/// Whether the arm may have taken the command all the same. An answer that cannot be understood is none.
fn leaves_doubt(error: &Error, form: Form) -> bool {
    match error.kind() {
        ErrorKind::Uncertain => true,
        ErrorKind::Unexpected => form == Form::Queued,
        _ => false,
    }
}

/// The fields of a value, for the log.
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
