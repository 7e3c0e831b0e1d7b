//! State shared by the handles of a connection and its driver task.
//!
//! Every part has its own lock or atomic, and no lock is held across an await. The picture and the
//! gate are the state machines of `magician-host`; the task feeds them with frames, handles query
//! them.

use magician_host::ArmPicture;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{broadcast, watch};
use tokio::time::Instant;

use super::SettingsBackup;
use super::bounded_jog::BoundedJogs;
use super::disruptions::Disruptions;
use super::events::Event;
use super::halt::Halts;
use super::homing::{HomingRecord, Homings, IdentityCache};
use super::link::Link;
use super::state::{Status, Watches};
use crate::connection::Micros;
use crate::gate::{Gate, JogId};
use crate::transport::Line;
use crate::{Error, Result};

/// Attempts of one request that fit into a call over datagrams. Choice: if a tenth of all attempts
/// is lost, all five fail once in 100,000 calls.
const ATTEMPTS: u32 = 5;

#[derive(Debug)]
pub(super) struct Shared {
    /// Name of the connection in messages.
    pub(super) name: String,
    /// True if the line delivers frames in order.
    pub(super) ordered: bool,
    /// True if motion continues when the connection ends.
    pub(super) detached: AtomicBool,
    pub(super) disruptions: Disruptions,
    /// Knowledge of the arm from the frames seen.
    picture: Mutex<ArmPicture>,
    gate: Mutex<Gate>,
    /// Number of jogs requested so far.
    jogs: AtomicU64,
    pub(super) homings: Homings,
    queue_fault: Mutex<Option<LastFault>>,
    pub(super) halts: Mutex<Halts>,
    pub(super) bounded: watch::Sender<BoundedJogs>,
    /// Settings that a bounded jog has changed and not restored yet.
    pub(super) owed: Mutex<SettingsBackup>,
    pub(super) link: watch::Sender<Link>,
    pub(super) status: watch::Sender<Option<Status>>,
    pub(super) watches: Mutex<Watches>,
    pub(super) events: broadcast::WeakSender<Event>,
    pub(super) begun: Instant,
    /// Total time for which this process was suspended, us.
    suspended: AtomicU64,
    /// Measured lifetime of a datagram, us; 0 on an ordered line.
    lifetime: AtomicU64,
}

/// Queue changes that this connection did not cause.
#[derive(Clone, Copy, Debug)]
pub(super) enum QueueFault {
    /// The arm was reset; these indices had not finished.
    Reset(Option<(u64, u64)>),
    /// The arm gave these indices to commands that this connection did not send, or sent only once.
    Unaccounted { from: u64, to: u64 },
}

/// The last fault of the queue, and which calls have to report it.
#[derive(Clone, Copy, Debug)]
struct LastFault {
    queue_fault: QueueFault,
    /// A fault counts as a stop; this is its number. Calls that began before it must report the
    /// fault.
    stop: u64,
    /// True once reported: later calls do not report it again.
    reported: bool,
}

impl Shared {
    pub(super) fn new(
        line: &Line,
        events: &broadcast::Sender<Event>,
        homings: Option<Arc<dyn HomingRecord>>,
        laser_pins: bool,
    ) -> Self {
        let picture = ArmPicture::default()
            .on_shared_line(line.is_shared)
            .laser_pins(laser_pins);
        Self {
            name: line.name.clone(),
            ordered: line.settings.ordered,
            detached: AtomicBool::new(false),
            disruptions: Disruptions::default(),
            picture: Mutex::new(picture),
            gate: Mutex::default(),
            jogs: AtomicU64::new(0),
            homings: Homings::new(homings),
            queue_fault: Mutex::default(),
            halts: Mutex::default(),
            bounded: watch::Sender::default(),
            owed: Mutex::default(),
            link: watch::Sender::new(Link::Up),
            status: watch::Sender::new(None),
            watches: Mutex::default(),
            events: events.downgrade(),
            begun: Instant::now(),
            suspended: AtomicU64::new(0),
            lifetime: AtomicU64::new(0),
        }
    }

    /// Adds a time of suspension (stopped process, computer asleep): deadlines move on by it.
    pub(super) fn note_suspension(&self, time: Micros) {
        self.suspended.fetch_add(time, Ordering::SeqCst);
    }

    /// Returns the total time of suspension.
    pub(super) fn suspended(&self) -> Duration {
        Duration::from_micros(self.suspended.load(Ordering::SeqCst))
    }

    /// Notes the measured lifetime of a datagram.
    pub(super) fn note_lifetime(&self, lifetime: Micros) {
        self.lifetime.store(lifetime, Ordering::Relaxed);
    }

    /// Returns the minimum time of a call over datagrams: room for several attempts.
    pub(super) fn min_datagram_timeout(&self) -> Duration {
        ATTEMPTS * Duration::from_micros(self.lifetime.load(Ordering::Relaxed))
    }

    /// Returns the number of stops so far.
    pub(super) fn stops(&self) -> u64 {
        self.disruptions.stops()
    }

    /// Notes that the queue was cleared and the laser switched off on a reconnected line.
    pub(super) fn cleared(&self) {
        self.disruptions.clear();
        self.picture().cleared();
    }

    /// Ends the work in progress and returns the number of this stop.
    pub(super) fn stop(&self) -> u64 {
        self.disruptions.stop()
    }

    /// Ends the work in progress as a stop does; the next wait or run reports the fault.
    pub(super) fn note_fault(&self, queue_fault: QueueFault) {
        match queue_fault {
            QueueFault::Reset(_) => self.identity_cache().forget(),
            QueueFault::Unaccounted { .. } => self.picture().forget(),
        }
        // The lock is taken before the stop is counted, so that a call which sees the stop also
        // finds its fault.
        let mut last = lock(&self.queue_fault);
        let stop = self.stop();
        *last = Some(LastFault {
            queue_fault,
            stop,
            reported: false,
        });
    }

    /// Returns the last fault of the queue if it ended the caller's work, which began when there
    /// had been `since` stops, or if the fault was not reported yet.
    pub(super) fn queue_fault(&self, since: Option<u64>) -> Option<QueueFault> {
        let mut last = lock(&self.queue_fault);
        let last_fault = last.as_mut()?;
        let ended_caller = since.is_some_and(|stops| stops < last_fault.stop);
        // Reported to every call that the fault ended. If there is none, the next call reports it,
        // so that no fault is missed.
        let unreported = !std::mem::replace(&mut last_fault.reported, true);
        (ended_caller || unreported).then_some(last_fault.queue_fault)
    }

    /// Returns the picture of the arm. The guard must not outlive the statement that uses it:
    /// methods of [`Shared`] and [`Arm`](super::Arm) take the same lock.
    pub(super) fn picture(&self) -> MutexGuard<'_, ArmPicture> {
        lock(&self.picture)
    }

    /// Returns the readings that identify the arm in the record of homings.
    pub(super) fn identity_cache(&self) -> MutexGuard<'_, IdentityCache> {
        self.homings.identity_cache()
    }

    /// Returns the gate, which tracks jogs and motors.
    pub(super) fn gate(&self) -> MutexGuard<'_, Gate> {
        lock(&self.gate)
    }

    /// Returns the id of the next jog.
    pub(super) fn next_jog(&self) -> JogId {
        JogId(self.jogs.fetch_add(1, Ordering::SeqCst))
    }

    /// Notes two equal poses, read after this many forced stops: the arm is at rest.
    pub(super) fn stood_after(&self, stops: u64) {
        self.picture().stood_after(stops);
        self.gate().note_rest();
    }
}

/// Locks a mutex, also after a panic of its holder: no holder leaves a value half changed.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl QueueFault {
    pub(super) fn into_result<T>(self) -> Result<T> {
        Err(match self {
            Self::Reset(gone) => Error::reset(gone),
            Self::Unaccounted { from, to } => Error::unaccounted(from, to),
        })
    }
}
