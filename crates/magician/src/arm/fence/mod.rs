//! The fence of an arm, below all doors: whatever is sent over a connection that has one is checked first, from where the arm
//! will be by then.
//!
//! One check at a time, and nothing that moves the arm is sent between a check and what it has passed. What the arm will do is
//! followed from command to command while its queue holds what this connection has put there; whenever that has ended, or may
//! have gone another way (a stop, an alarm, a motion outside of the queue, an answer that was lost), the arm is read again
//! while it stands.

mod check;

use std::collections::VecDeque;
use std::sync::{PoisonError, RwLock};

use magician_motion::Fence;
use magician_protocol::commands::{
    ClearAlarmsState, ClearAllAlarmsState, QueuedCmdClear, QueuedCmdForceStopExec,
    QueuedCmdStartDownload, QueuedCmdStartExec,
};
use magician_protocol::{Effect, Frame, FrameBuf, JogCommand, QueuedCmdIndex, Row, Set, Writable};
use tokio::sync::{Mutex, MutexGuard};

pub(super) use self::check::FenceCheck;
use super::Arm;
use super::disruptions::Disruptions;
use crate::Result;
use crate::preflight::{Preflight, governs_motion};

/// The fence of a connection, if it has one, and what it has let pass.
#[derive(Debug)]
pub(super) struct Held {
    fence: RwLock<Option<Fence>>,
    prediction: Mutex<QueuePrediction>,
}

/// Where the arm will be when what it has was carried out.
#[derive(Debug, Default)]
pub(super) struct QueuePrediction {
    end: Option<Preflight>,
    /// [`Disruptions::total`] of then.
    breaks: u64,
    /// The last index that was seen.
    last: u64,
    /// Where each command leads that waits, if that is known, and where the first begins.
    stations: VecDeque<(u64, Option<[f64; 4]>)>,
}

/// The right to send what was checked. Nothing else is checked meanwhile.
pub(super) struct Turn<'a> {
    disruptions: &'a Disruptions,
    prediction: MutexGuard<'a, QueuePrediction>,
    /// What is known after it, if it goes into the queue.
    then: Option<Preflight>,
    /// The queue is empty: its next index may be any.
    first: bool,
    breaks: u64,
}

impl QueuePrediction {
    /// How many commands wait, or run, that were followed.
    fn waiting(&self, current: u64) -> u64 {
        let stations = self.stations.iter();
        stations.filter(|(index, _)| *index > current).count() as u64
    }
}

/// What a frame is to a fence.
enum Sort {
    /// It moves nothing, and changes nothing that a motion depends on.
    Free,
    /// It ends motions, or what waits.
    Ends,
    /// It lets a queue run.
    Releases,
    /// A motion, or what one depends on.
    Governs(Box<Set>),
    /// Unknown.
    Unknown(&'static str),
}

impl Sort {
    fn of(frame: &Frame<'_>) -> Self {
        let ctrl = frame.ctrl();
        if !ctrl.write() && !ctrl.queued() {
            return Self::Free;
        }
        let Some(row) = Row::with_id(frame.id()) else {
            return Self::Unknown("the effect of this command is unknown");
        };
        match row.id {
            id if id == QueuedCmdForceStopExec::ROW.id || id == QueuedCmdClear::ROW.id => {
                return Self::Ends;
            }
            id if id == QueuedCmdStartExec::ROW.id
                || id == ClearAlarmsState::ROW.id
                || id == ClearAllAlarmsState::ROW.id =>
            {
                return Self::Releases;
            }
            id if id == QueuedCmdStartDownload::ROW.id => {
                return Self::Unknown("programs stored in the arm cannot be checked");
            }
            _ => {}
        }
        match Set::decode(row.id, frame.params()) {
            Ok(Set::JogCmd(jog)) if jog.cmd == JogCommand::Stop && !ctrl.queued() => Self::Ends,
            Ok(command) if row.effect.moves_arm() || governs_motion(&command) => {
                Self::Governs(Box::new(command))
            }
            Ok(_) => Self::Free,
            Err(_) if matches!(row.effect, Effect::Look | Effect::Consume | Effect::Queue) => {
                Self::Free
            }
            Err(_) => Self::Unknown("its parameters cannot be read"),
        }
    }
}

impl Held {
    pub(super) fn new(fence: Option<Fence>) -> Self {
        Self {
            fence: RwLock::new(fence.filter(|fence| !fence.is_empty())),
            prediction: Mutex::default(),
        }
    }

    pub(super) fn fence(&self) -> Option<Fence> {
        *self.fence.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Another fence takes its place: the one that was there before.
    fn replace(&self, fence: Option<Fence>) -> Option<Fence> {
        let fence = fence.filter(|fence| !fence.is_empty());
        let mut held = self.fence.write().unwrap_or_else(PoisonError::into_inner);
        std::mem::replace(&mut held, fence)
    }

    fn bounds_motion(&self) -> bool {
        self.fence().is_some_and(|fence| fence.bounds_motion())
    }
}

impl Turn<'_> {
    /// What was sent has been answered, or not.
    pub(super) fn ends(mut self, answer: &Result<FrameBuf>) {
        let Some(then) = self.then.take() else {
            return;
        };
        let index = answer.as_ref().ok().map(|answer| answer.frame());
        let index = index.filter(|answer| answer.ctrl().queued());
        let index = index.and_then(|answer| answer.read::<QueuedCmdIndex>().ok());
        match index {
            Some(QueuedCmdIndex(index)) => self.accepted(index, then),
            None => self.disruptions.depart(),
        }
    }

    fn accepted(&mut self, index: u64, then: Preflight) {
        let next = self.prediction.last.saturating_add(1);
        if !(index == next || self.first && index > next) {
            // Another program has queued a command in between.
            return self.disruptions.depart();
        }
        let end = then.arm().map(|end| end.pose.to_array());
        self.prediction.stations.push_back((index, end));
        // More than a queue holds.
        if self.prediction.stations.len() > 64 {
            self.prediction.stations.pop_front();
        }
        self.prediction.end = Some(then);
        self.prediction.last = index;
        self.prediction.breaks = self.breaks;
    }

    /// Where a run begins.
    pub(super) fn start(&mut self) -> Option<Preflight> {
        // A run that was dropped leaves an unknown position.
        self.prediction.end = None;
        self.then.take()
    }
}

impl Arm {
    /// The fence that everything over this connection keeps to: [`Options::fence`](super::Options::fence), or what
    /// [`set_fence`](Self::set_fence) has put in its place.
    #[must_use]
    pub fn fence(&self) -> Option<Fence> {
        self.inner.held.fence()
    }

    /// Gives the connection another fence, for all its handles; `None` removes it. It holds as soon as this returns. What was
    /// under way then was checked against the earlier one: the future stops the arm, unless the fence bounds nothing new.
    ///
    /// ```
    /// use magician::{Arm, Fence, build};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let arm = Arm::connect("sim").await?;
    /// arm.set_fence(Some(Fence::default().with_floor(-20.0)?)).await?;
    /// assert!(arm.run(&[build::line_to(220.0, 0.0, -30.0, 0.0)]).await.is_err());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`stop`](Self::stop). The fence holds all the same.
    pub fn set_fence(
        &self,
        fence: Option<Fence>,
    ) -> impl Future<Output = Result<()>> + Send + use<> {
        let held = &self.inner.held;
        let before = held.replace(fence);
        let now = held.fence();
        self.inner.shared.disruptions.depart();
        let arm = self.clone();
        async move {
            if now.is_none() || now == before {
                return Ok(());
            }
            arm.stop().await?;
            // What was checked before and handed over behind the stop.
            if arm.moving() {
                arm.stop().await?;
            }
            Ok(())
        }
    }

    /// The numbers by which its motions are planned: [`Options::model`](super::Options::model), or a virtual arm's own.
    #[must_use]
    pub fn model(&self) -> &magician_motion::ArmModel {
        &self.inner.options.model
    }

    /// The same check, with the fence of this connection.
    pub(super) fn fenced(&self, check: Preflight) -> Preflight {
        let check = check.laser_pins(self.inner.options.laser_pins);
        match self.fence() {
            Some(fence) => check.fence(fence),
            None => check,
        }
    }

    /// What the fence is held against.
    pub(super) fn fence_check(&self) -> FenceCheck<'_> {
        FenceCheck {
            arm: self,
            held: &self.inner.held,
        }
    }
}
