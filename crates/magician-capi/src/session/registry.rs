//! Registry of connected arms by id.
//!
//! It also protects forked children. A fork copies the memory but not the threads, so a call in the
//! child would wait forever for the driver's task or for a lock. The registry stores the id of the
//! process that connects, and calls in any other process fail at once.

use std::collections::BTreeMap;
use std::ffi::c_int;
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant};

use magician::{Options, Tracer};

use super::danger::Allowed;
use super::pool::Pool;
use super::{Environment, Session};
use crate::code::{Code, Fault, Outcome};
use crate::{Family, notice};

/// Default of `SetCmdTimeout`, as in the vendor's library: 3000 ms.
const TIMEOUT: Duration = Duration::from_secs(3);
/// Most ids with a remembered timeout, because a program may use arbitrary ids.
const MAX_TIMEOUTS: usize = 256;

/// Connected arms of a process by id. `v1` has one arm, with id 0.
#[derive(Debug)]
pub struct Registry {
    pub(super) environment: Environment,
    pub(super) timeouts: Timeouts,
    pub(super) pool: Pool,
    /// Held by `ConnectDobot` of `v1`, which closes the existing connection and opens it again.
    pub(super) turn: Mutex<()>,
    allowed: Arc<Allowed>,
    slots: RwLock<BTreeMap<c_int, Slot>>,
    call_timeouts: Mutex<BTreeMap<c_int, Duration>>,
    /// Process that has connected or is connecting. 0 if no process has.
    process: AtomicU32,
    /// Running calls of `ConnectDobot`. Accessed only while `slots` is locked, as is the change of
    /// `process` to 0.
    connecting: AtomicU32,
    tracer: OnceLock<Option<Tracer>>,
}

/// Timeouts of `ConnectDobot`, and of the queue.
#[derive(Clone, Copy, Debug)]
pub struct Timeouts {
    /// For the reply of an arm at a serial port.
    pub serial: Duration,
    /// For the reply of an arm on a network.
    pub network: Duration,
    /// For the reply of another firmware to text.
    pub text: Duration,
    /// Time for which the queue may stand still before the program gets an explanation.
    pub standing: Duration,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self {
            serial: Duration::from_millis(300),
            network: Duration::from_secs(1),
            text: Duration::from_millis(500),
            standing: Duration::from_secs(1),
        }
    }
}

/// Content of an id.
#[derive(Debug)]
pub(super) enum Slot {
    /// Connected arm.
    Arm(Arc<Session>),
    /// Something else answered, and its port was closed again. Describes it.
    Other(String),
}

impl Default for Registry {
    fn default() -> Self {
        Self::new(Environment::default(), Timeouts::default())
    }
}

impl Registry {
    /// Creates an empty registry.
    #[must_use]
    pub fn new(environment: Environment, timeouts: Timeouts) -> Self {
        Self {
            environment,
            timeouts,
            pool: Pool::default(),
            turn: Mutex::default(),
            allowed: Arc::new(Allowed::new(environment)),
            slots: RwLock::default(),
            call_timeouts: Mutex::default(),
            process: AtomicU32::new(0),
            connecting: AtomicU32::new(0),
            tracer: OnceLock::new(),
        }
    }

    /// Runs the body of a function on a connected arm, and returns the code for C.
    pub fn run(
        &self,
        family: Family,
        name: &'static str,
        id: c_int,
        body: impl FnOnce(&Session) -> Outcome,
    ) -> c_int {
        if let Err(fault) = self.check_process() {
            return notice::remember_unlogged(name, &fault);
        }
        let begun = Instant::now();
        notice::begin();
        let outcome = self.find(family, id).and_then(|arm| body(&arm));
        notice::finish((name, id), &outcome, begun.elapsed())
    }

    /// Finds the arm with this id.
    ///
    /// # Errors
    /// [`Code::Timeout`] for an unknown id, in `v3` [`Code::InvalidDevice`]. Never waits.
    /// (The vendor's `v1` waits for a connection forever; its `v2` returns 0 for an id that it
    /// never assigned.)
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

    /// `DisconnectDobot`. Always returns 0. The arm continues with its queue. Calls that wait for
    /// it return 0 at once and leave their results unchanged, as with the vendor's library.
    pub fn disconnect(&self, id: c_int) -> c_int {
        notice::host(
            "DisconnectDobot",
            || format!("id={id}"),
            || {
                self.remove(id);
                Code::NoError as c_int
            },
        )
    }

    /// Removes an id and closes its connection.
    pub(super) fn remove(&self, id: c_int) {
        if self.check_process().is_err() {
            return;
        }
        let slot = {
            let mut slots = self.slots_mut();
            let slot = slots.remove(&id);
            self.reset_process(&slots);
            slot
        };
        if let Some(Slot::Arm(arm)) = slot {
            arm.release();
        }
    }

    /// `SetCmdTimeout`: sets the timeout of calls, ms, for the arm with this id and the next one
    /// that gets the id.
    pub fn set_timeout(&self, id: c_int, milliseconds: u32) -> c_int {
        let arguments = || format!("id={id} milliseconds={milliseconds}");
        notice::host("SetCmdTimeout", arguments, || {
            if self.check_process().is_ok() {
                self.remember_timeout(id, milliseconds);
            }
            Code::NoError as c_int
        })
    }

    fn remember_timeout(&self, id: c_int, milliseconds: u32) {
        // A timeout of 0 would make every call fail.
        let timeout = Duration::from_millis(u64::from(milliseconds.max(1)));
        {
            let mut timeouts = lock(&self.call_timeouts);
            if timeouts.len() < MAX_TIMEOUTS || timeouts.contains_key(&id) {
                timeouts.insert(id, timeout);
            }
        }
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(Slot::Arm(arm)) = slots.get(&id) {
            arm.set_timeout(timeout);
        }
    }

    /// Permission for dangerous commands.
    pub(super) fn allowed(&self) -> &Arc<Allowed> {
        &self.allowed
    }

    /// Stores a slot under the given id, or under the smallest free one. Returns the id.
    pub(super) fn assign_id(&self, id: Option<c_int>, slot: Slot) -> c_int {
        let mut slots = self.slots_mut();
        let free = || {
            (0..)
                .find(|id| !slots.contains_key(id))
                .unwrap_or(c_int::MAX)
        };
        let id = id.unwrap_or_else(free);
        if let Slot::Arm(arm) = &slot {
            let timeouts = lock(&self.call_timeouts);
            arm.set_timeout(timeouts.get(&id).copied().unwrap_or(TIMEOUT));
        }
        slots.insert(id, slot);
        self.process.store(process::id(), Ordering::Relaxed);
        id
    }

    /// Allows forked children to connect, if this process has no connection and is not connecting.
    fn reset_process(&self, slots: &BTreeMap<c_int, Slot>) {
        if slots.is_empty() && self.connecting.load(Ordering::Relaxed) == 0 {
            self.process.store(0, Ordering::Relaxed);
        }
    }

    /// Marks the start of `ConnectDobot`. From here on a child that is forked must not connect,
    /// because it may find the locks of the registry held.
    ///
    /// # Errors
    /// This process is such a child.
    pub(super) fn claim(&self) -> Result<Claim<'_>, Fault> {
        self.check_process()?;
        let _slots = self.slots_mut();
        self.connecting.fetch_add(1, Ordering::Relaxed);
        self.process.store(process::id(), Ordering::Relaxed);
        Ok(Claim(self))
    }

    /// Fails in a forked child: a fork does not copy the threads of the driver, so a call would
    /// never be answered.
    pub(super) fn check_process(&self) -> Outcome {
        let owner = self.process.load(Ordering::Relaxed);
        if owner == 0 || owner == process::id() {
            return Ok(());
        }
        let message = "this process was forked from the one that is connected, which keeps the \
            connection; connect in the child only, or start it by `spawn` (multiprocessing)";
        Err(Fault::new(Code::Timeout, message))
    }

    /// Options of the driver, with the trace of `MAGICIAN_TRACE`.
    pub(super) fn options(&self) -> Options {
        let tracer = self.tracer.get_or_init(|| self.environment.tracer());
        // Programs for the vendor's library expect every command to be sent. Its interface has
        // neither a permission for the laser nor a holder for jogs.
        let options = Options::default().allow_laser(true).raw_jogs(true);
        match tracer {
            Some(tracer) => options.trace(tracer.clone()),
            None => options,
        }
    }

    fn slots_mut(&self) -> std::sync::RwLockWriteGuard<'_, BTreeMap<c_int, Slot>> {
        self.slots.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Marks a running call of `ConnectDobot`.
#[derive(Debug)]
pub(super) struct Claim<'a>(&'a Registry);

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        let slots = self.0.slots_mut();
        self.0.connecting.fetch_sub(1, Ordering::Relaxed);
        self.0.reset_process(&slots);
    }
}

/// Locks a mutex and ignores poisoning: no holder leaves a value half changed.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::ptr;

    use super::*;
    use crate::pointer::{Buffer, Text};

    /// A registry as a child of a fork finds it.
    fn forked() -> Registry {
        let registry = Registry::default();
        registry.process.store(1, Ordering::Relaxed);
        registry
    }

    #[test]
    fn forked_child_gets_an_error_without_waiting() {
        let registry = forked();
        // As if the parent had been about to connect.
        let _held = registry.slots.write().unwrap();
        assert_eq!(registry.run(Family::V1, "GetPose", 0, |_| Ok(())), 2);
        assert!(notice::sentence().contains("forked"));
        assert_eq!(registry.disconnect(0), 0);
        assert_eq!(registry.set_timeout(0, 5), 0);
    }

    #[test]
    #[allow(unsafe_code)]
    fn child_may_connect_if_nothing_is_connected() {
        use std::ffi::CString;

        let name = CString::new("sim").unwrap();
        let registry = Registry::default();
        // SAFETY: the one outlives the call, the other is null.
        let (name, null) = unsafe { (Text::new(name.as_ptr()), Buffer::new(ptr::null_mut())) };
        assert_eq!(registry.connect_v1(name, 115_200, null, null), 0);
        assert_ne!(registry.process.load(Ordering::Relaxed), 0);
        registry.disconnect(0);
        assert_eq!(registry.process.load(Ordering::Relaxed), 0);
    }

    #[test]
    #[allow(unsafe_code)]
    fn child_sees_a_waiting_connect_call() {
        use std::ffi::CString;

        let name = CString::new("sim").unwrap();
        let registry = Registry::default();
        std::thread::scope(|scope| {
            let turn = registry.turn.lock().unwrap();
            scope.spawn(|| {
                // SAFETY: the one outlives the call, the other is null.
                let (name, null) =
                    unsafe { (Text::new(name.as_ptr()), Buffer::new(ptr::null_mut())) };
                assert_eq!(registry.connect_v1(name, 115_200, null, null), 0);
                registry.disconnect(0);
            });
            let deadline = Instant::now() + Duration::from_secs(20);
            while registry.process.load(Ordering::Relaxed) == 0 {
                assert!(Instant::now() < deadline, "a child would wait for its turn");
                std::thread::yield_now();
            }
            drop(turn);
        });
        assert_eq!(registry.process.load(Ordering::Relaxed), 0);
        assert_eq!(registry.connecting.load(Ordering::Relaxed), 0);
    }

    #[test]
    #[allow(unsafe_code)]
    fn forked_child_cannot_connect() {
        // SAFETY: they are null.
        let (name, null) = unsafe { (Text::new(ptr::null()), Buffer::new(ptr::null_mut())) };
        let registry = forked();
        let _held = registry.turn.lock().unwrap();
        assert_eq!(registry.connect_v1(name, 115_200, null, null), 2);
    }
}
