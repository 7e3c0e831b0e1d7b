//! The arms by their ids.

use std::collections::BTreeMap;
use std::ffi::c_int;
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant};

use magician::{Options, Tracer};

use super::danger::Allowed;
use super::pool::Pool;
use super::{Session, Surroundings};
use crate::code::{Code, Fault, Outcome};
use crate::{Family, notice};

/// Default of `SetCmdTimeout` (interface section 2).
const TIMEOUT: Duration = Duration::from_secs(3);
/// Most ids for which a timeout is remembered that is not asked for any more.
const MOST_TIMEOUTS: usize = 256;

/// The arms of a process by their ids. `v1` has one, with the id 0.
#[derive(Debug)]
pub struct Registry {
    pub(super) surroundings: Surroundings,
    pub(super) patience: Patience,
    pub(super) pool: Pool,
    /// `ConnectDobot` of `v1` closes the arm that was there and opens it again; two at a time take turns.
    pub(super) turn: Mutex<()>,
    allowed: Arc<Allowed>,
    slots: RwLock<BTreeMap<c_int, Slot>>,
    timeouts: Mutex<BTreeMap<c_int, Duration>>,
    /// The process that has connected; 0 before that.
    process: AtomicU32,
    tracer: OnceLock<Option<Tracer>>,
}

/// How long `ConnectDobot` waits for an answer.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// From an arm at a serial port.
    pub serial: Duration,
    /// From an arm in a network.
    pub network: Duration,
    /// From another firmware, to text.
    pub text: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            serial: Duration::from_millis(300),
            network: Duration::from_secs(1),
            text: Duration::from_millis(500),
        }
    }
}

/// What an id stands for.
#[derive(Debug)]
pub(super) enum Slot {
    /// An arm.
    Arm(Arc<Session>),
    /// Something else answered, and its port was closed again: what it was.
    Other(String),
}

impl Default for Registry {
    fn default() -> Self {
        Self::new(Surroundings::default(), Patience::default())
    }
}

impl Registry {
    /// One without arms.
    #[must_use]
    pub fn new(surroundings: Surroundings, patience: Patience) -> Self {
        Self {
            surroundings,
            patience,
            pool: Pool::default(),
            turn: Mutex::default(),
            allowed: Arc::new(Allowed::new(surroundings)),
            slots: RwLock::default(),
            timeouts: Mutex::default(),
            process: AtomicU32::new(0),
            tracer: OnceLock::new(),
        }
    }

    /// Runs the body of a function that is about a connected arm, and says what C gets.
    pub fn run(
        &self,
        family: Family,
        name: &'static str,
        id: c_int,
        body: impl FnOnce(&Session) -> Outcome,
    ) -> c_int {
        if let Err(fault) = self.own_process() {
            return notice::quietly(name, &fault);
        }
        let begun = Instant::now();
        notice::begin();
        let outcome = self.find(family, id).and_then(|arm| body(&arm));
        notice::ended(name, &outcome, begun.elapsed())
    }

    /// The arm with an id.
    ///
    /// # Errors
    /// [`Code::Timeout`] when it is not connected, at once; `v3` says [`Code::InvalidDevice`]. (The vendor's `v1` waits
    /// for a connection for ever; its `v2` says 0 to an id that it never gave out.)
    pub fn find(&self, family: Family, id: c_int) -> Result<Arc<Session>, Fault> {
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        let code = match family {
            Family::V1 | Family::V2 => Code::Timeout,
            Family::V3 => Code::InvalidDevice,
        };
        match slots.get(&id) {
            Some(Slot::Arm(arm)) => Ok(Arc::clone(arm)),
            Some(Slot::Other(what)) => Err(Fault::new(code, what)),
            None if family == Family::V1 => Err(Fault::new(
                code,
                "no arm is connected; ConnectDobot comes first",
            )),
            None => {
                let message =
                    format!("no arm with the id {id} is connected; ConnectDobot gives ids");
                Err(Fault::new(code, message))
            }
        }
    }

    /// `DisconnectDobot`: 0, whatever was. The arm goes on with what it has; calls that wait for it return 0 at once and
    /// leave their results untouched, as the vendor's.
    pub fn disconnect(&self, id: c_int) -> c_int {
        if self.own_process().is_ok() {
            let slot = self.slots_mut().remove(&id);
            if let Some(Slot::Arm(arm)) = slot {
                arm.release();
            }
        }
        Code::NoError as c_int
    }

    /// `SetCmdTimeout`: how long calls may take, in ms; for the arm that has the id, and the next one that gets it.
    pub fn set_timeout(&self, id: c_int, milliseconds: u32) -> c_int {
        if self.own_process().is_err() {
            return Code::NoError as c_int;
        }
        let timeout = Duration::from_millis(u64::from(milliseconds.max(1)));
        {
            let mut timeouts = lock(&self.timeouts);
            if timeouts.len() < MOST_TIMEOUTS || timeouts.contains_key(&id) {
                timeouts.insert(id, timeout);
            }
        }
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(Slot::Arm(arm)) = slots.get(&id) {
            arm.set_timeout(timeout);
        }
        Code::NoError as c_int
    }

    /// What dangerous commands are allowed.
    pub(super) fn allowed(&self) -> &Arc<Allowed> {
        &self.allowed
    }

    /// Gives something its id: this one, or the smallest that is free.
    pub(super) fn give_id(&self, id: Option<c_int>, slot: Slot) -> c_int {
        let mut slots = self.slots_mut();
        let free = || {
            (0..)
                .find(|id| !slots.contains_key(id))
                .unwrap_or(c_int::MAX)
        };
        let id = id.unwrap_or_else(free);
        if let Slot::Arm(arm) = &slot {
            let timeouts = lock(&self.timeouts);
            arm.set_timeout(timeouts.get(&id).copied().unwrap_or(TIMEOUT));
        }
        slots.insert(id, slot);
        id
    }

    /// A process that has forked leaves its threads behind: whatever its child asked would never be answered.
    pub(super) fn own_process(&self) -> Outcome {
        let owner = self.process.load(Ordering::Relaxed);
        if owner == 0 || owner == process::id() {
            return Ok(());
        }
        let message = "this process was forked from the one that has connected, and the connection stayed there; \
                       connect in the child alone, or begin it anew (multiprocessing: the method `spawn`)";
        Err(Fault::new(Code::Timeout, message))
    }

    /// From now on only this process may call.
    pub(super) fn claim(&self) {
        self.process.store(process::id(), Ordering::Relaxed);
    }

    /// How connections behave, as `MAGICIAN_TRACE` wants it.
    pub(super) fn options(&self) -> Options {
        let tracer = self.tracer.get_or_init(|| self.surroundings.tracer());
        match tracer {
            Some(tracer) => Options::default().trace(tracer.clone()),
            None => Options::default(),
        }
    }

    fn slots_mut(&self) -> std::sync::RwLockWriteGuard<'_, BTreeMap<c_int, Slot>> {
        self.slots.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A lock whose holder has panicked is still good: no holder leaves a value half changed.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
