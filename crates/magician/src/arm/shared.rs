//! What the handles of a connection and its task both know.

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
use super::homing::{HomingRecord, Homings, Remembered};
use super::link::Link;
use super::state::{Status, Watches};
use crate::connection::Micros;
use crate::gate::{Gate, JogId};
use crate::transport::Line;
use crate::{Error, Result};

/// So often what a call sends may be lost.
const ATTEMPTS: u32 = 5;

#[derive(Debug)]
pub(super) struct Shared {
    /// What the connection is called in messages.
    pub(super) name: String,
    /// The line keeps the order of what it carries.
    pub(super) ordered: bool,
    /// What was set going goes on when the connection ends.
    pub(super) detached: AtomicBool,
    pub(super) disruptions: Disruptions,
    /// What is known of the arm without asking it.
    picture: Mutex<ArmPicture>,
    gate: Mutex<Gate>,
    /// Jogs that were asked for.
    jogs: AtomicU64,
    pub(super) homings: Homings,
    queue_fault: Mutex<Option<LastFault>>,
    pub(super) halts: Mutex<Halts>,
    /// The jogs in pieces, and what such a jog has changed of the arm's settings and not given back.
    pub(super) bounded: watch::Sender<BoundedJogs>,
    pub(super) owed: Mutex<SettingsBackup>,
    pub(super) link: watch::Sender<Link>,
    pub(super) status: watch::Sender<Option<Status>>,
    pub(super) watches: Mutex<Watches>,
    pub(super) events: broadcast::WeakSender<Event>,
    pub(super) begun: Instant,
    /// How long this program was held up so far, us.
    slept: AtomicU64,
    /// How long a datagram may be under way, as measured, us; 0 on a line that keeps its order.
    lifetime: AtomicU64,
}

/// Queue changes that this connection did not cause.
#[derive(Clone, Copy, Debug)]
pub(super) enum QueueFault {
    /// The arm was reset; these indices had not finished.
    Reset(Option<(u64, u64)>),
    /// The arm gave these indices to commands that this connection did not send, or sent once.
    Unaccounted { from: u64, to: u64 },
}

/// The last fault of the queue, and which calls have to report it.
#[derive(Clone, Copy, Debug)]
struct LastFault {
    queue_fault: QueueFault,
    /// The stop as which it counts: what was begun before has to hear of it.
    stop: u64,
    /// It was reported: later calls do not report it.
    told: bool,
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
            slept: AtomicU64::new(0),
            lifetime: AtomicU64::new(0),
        }
    }

    /// The process was stopped, or the computer slept: deadlines move on by that time.
    pub(super) fn note_sleep(&self, time: Micros) {
        self.slept.fetch_add(time, Ordering::SeqCst);
    }

    /// How long it was held up so far.
    pub(super) fn slept(&self) -> Duration {
        Duration::from_micros(self.slept.load(Ordering::SeqCst))
    }

    /// A datagram may be under way for so long.
    pub(super) fn note_lifetime(&self, lifetime: Micros) {
        self.lifetime.store(lifetime, Ordering::Relaxed);
    }

    /// The least that a call may take over datagrams: several attempts have room in it.
    pub(super) fn attempts(&self) -> Duration {
        ATTEMPTS * Duration::from_micros(self.lifetime.load(Ordering::Relaxed))
    }

    /// Stops so far.
    pub(super) fn stops(&self) -> u64 {
        self.disruptions.stops()
    }

    /// The queue was emptied, and the laser put out, on a line that was found again.
    pub(super) fn cleared(&self) {
        self.disruptions.clear();
        self.picture().cleared();
    }

    /// Ends what is going on; the number of the stop.
    pub(super) fn stop(&self) -> u64 {
        self.disruptions.stop()
    }

    /// Ends what is going on as a stop does; the next wait or run tells why.
    pub(super) fn note_fault(&self, queue_fault: QueueFault) {
        match queue_fault {
            QueueFault::Reset(_) => self.remembered().forget(),
            QueueFault::Unaccounted { .. } => self.picture().forget(),
        }
        let mut last = held(&self.queue_fault);
        let stop = self.stop();
        *last = Some(LastFault {
            queue_fault,
            stop,
            told: false,
        });
    }

    /// The last queue change that this connection did not cause, if it has to be reported to a caller that began after
    /// `since` stops, or was not reported yet.
    pub(super) fn queue_fault(&self, since: Option<u64>) -> Option<QueueFault> {
        let mut last = held(&self.queue_fault);
        let last_fault = last.as_mut()?;
        let mine = since.is_some_and(|stops| stops < last_fault.stop);
        let first = !std::mem::replace(&mut last_fault.told, true);
        (mine || first).then_some(last_fault.queue_fault)
    }

    /// What is known of the arm without asking it. The guard must not outlive the statement that uses it: the methods of
    /// [`Shared`] and [`Arm`](super::Arm) take it too.
    pub(super) fn picture(&self) -> MutexGuard<'_, ArmPicture> {
        held(&self.picture)
    }

    /// Readings of the arm for the record of its homings.
    pub(super) fn remembered(&self) -> MutexGuard<'_, Remembered> {
        self.homings.remembered()
    }

    /// What moves without an end of its own.
    pub(super) fn gate(&self) -> MutexGuard<'_, Gate> {
        held(&self.gate)
    }

    /// The number of a jog that is asked for.
    pub(super) fn next_jog(&self) -> JogId {
        JogId(self.jogs.fetch_add(1, Ordering::SeqCst))
    }

    /// The arm was seen at rest by two equal poses, read after this many forced stops.
    pub(super) fn stood_after(&self, stops: u64) {
        self.picture().stood_after(stops);
        self.gate().stands_still();
    }
}

/// A lock whose holder has panicked is still good: no holder leaves a value half changed.
pub(super) fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl QueueFault {
    pub(super) fn told<T>(self) -> Result<T> {
        Err(match self {
            Self::Reset(gone) => Error::reset(gone),
            Self::Unaccounted { from, to } => Error::unaccounted(from, to),
        })
    }
}
