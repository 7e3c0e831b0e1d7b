//! Fence of an arm, below all front ends: every frame of a connection with a fence is checked
//! first, from where the arm will be by then.
//!
//! Only one check runs at a time, and no motion is sent between a check and the command that passed
//! it. While the queue holds commands of this connection, their end is predicted from command to
//! command. The prediction ends with the queue, and becomes invalid when the path may have changed
//! (a stop, an alarm, an immediate motion, a lost answer). Then the arm is read again at rest.

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

/// Fence of a connection, if any, and the prediction for the commands that passed it.
#[derive(Debug)]
pub(super) struct FenceState {
    fence: RwLock<Option<Fence>>,
    prediction: Mutex<QueuePrediction>,
}

/// Predicted position after all queued commands.
#[derive(Debug, Default)]
pub(super) struct QueuePrediction {
    end: Option<Preflight>,
    /// Value of [`Disruptions::total`] at the prediction.
    breaks: u64,
    /// Last index seen.
    last: u64,
    /// End of each waiting command, if known, preceded by the start of the first.
    stations: VecDeque<(u64, Option<[f64; 4]>)>,
}

/// Exclusive right to send the checked command.
pub(super) struct SendPermit<'a> {
    disruptions: &'a Disruptions,
    prediction: MutexGuard<'a, QueuePrediction>,
    /// Prediction after the command, if it is queued.
    then: Option<Preflight>,
    /// True if the queue is empty: the next index may have any value.
    first: bool,
    breaks: u64,
}

impl QueuePrediction {
    /// Returns the number of predicted commands that wait or run.
    fn waiting(&self, current: u64) -> u64 {
        let stations = self.stations.iter();
        stations.filter(|(index, _)| *index > current).count() as u64
    }
}

/// Class of a frame with regard to the fence.
enum FrameClass {
    /// Neither moves the arm nor changes anything a motion depends on.
    Free,
    /// Ends motions, or clears the queue.
    Ends,
    /// Starts the queue.
    Releases,
    /// A motion, or a setting that affects motion.
    Governs(Box<Set>),
    /// Cannot be checked, for this reason.
    Unknown(&'static str),
}

impl FrameClass {
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
            // Motions and settings are distinguished below, by their effect.
            _ => {}
        }
        match Set::decode(row.id, frame.params()) {
            Ok(Set::JogCmd(jog)) if jog.cmd == JogCommand::Stop && !ctrl.queued() => Self::Ends,
            Ok(command) if row.effect.moves_arm() || governs_motion(&command) => {
                Self::Governs(Box::new(command))
            }
            Ok(_) => Self::Free,
            // Undecodable parameters do not matter to commands that never move the arm.
            Err(_) if matches!(row.effect, Effect::Look | Effect::Consume | Effect::Queue) => {
                Self::Free
            }
            // A motion whose target is unreadable cannot be checked, so it is refused.
            Err(_) => Self::Unknown("its parameters cannot be read"),
        }
    }
}

impl FenceState {
    pub(super) fn new(fence: Option<Fence>) -> Self {
        Self {
            fence: RwLock::new(fence.filter(|fence| !fence.is_empty())),
            prediction: Mutex::default(),
        }
    }

    pub(super) fn fence(&self) -> Option<Fence> {
        *self.fence.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the fence and returns the previous one.
    fn replace(&self, fence: Option<Fence>) -> Option<Fence> {
        let fence = fence.filter(|fence| !fence.is_empty());
        let mut held = self.fence.write().unwrap_or_else(PoisonError::into_inner);
        std::mem::replace(&mut held, fence)
    }

    fn bounds_motion(&self) -> bool {
        self.fence().is_some_and(|fence| fence.bounds_motion())
    }
}

impl SendPermit<'_> {
    /// Updates the prediction with the answer to the sent command.
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
        // The arm counts queued commands one by one, so any other index reveals a foreign command.
        let next = self.prediction.last.saturating_add(1);
        if !(index == next || self.first && index > next) {
            // Another program has queued a command in between.
            return self.disruptions.depart();
        }
        let end = then.arm().map(|end| end.pose.to_array());
        self.prediction.stations.push_back((index, end));
        // More than a queue holds; older positions are no longer needed.
        if self.prediction.stations.len() > 64 {
            self.prediction.stations.pop_front();
        }
        self.prediction.end = Some(then);
        self.prediction.last = index;
        self.prediction.breaks = self.breaks;
    }

    /// Returns the start of a run.
    pub(super) fn start(&mut self) -> Option<Preflight> {
        // A run dropped halfway leaves an unknown position.
        self.prediction.end = None;
        self.then.take()
    }
}

impl Arm {
    /// Returns the fence of this connection: [`Options::fence`](super::Options::fence), or the
    /// replacement by [`set_fence`](Self::set_fence).
    #[must_use]
    pub fn fence(&self) -> Option<Fence> {
        self.inner.held.fence()
    }

    /// Replaces the fence of the connection for all its handles; `None` removes it.
    ///
    /// The new fence is in effect when this returns. Motion in progress was checked against the
    /// previous one: the returned future stops the arm, unless there is no new bound.
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
    /// Same as [`stop`](Self::stop). The new fence is in effect even then.
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
            // A command that passed the previous fence may have been submitted behind the stop.
            if arm.moving() {
                arm.stop().await?;
            }
            Ok(())
        }
    }

    /// Returns the model used to plan motions: [`Options::model`](super::Options::model), or that
    /// of the virtual arm.
    #[must_use]
    pub fn model(&self) -> &magician_motion::ArmModel {
        &self.inner.options.model
    }

    /// Adds the fence of this connection to a check.
    pub(super) fn fenced(&self, check: Preflight) -> Preflight {
        let check = check.laser_pins(self.inner.options.laser_pins);
        match self.fence() {
            Some(fence) => check.fence(fence),
            None => check,
        }
    }

    /// Returns the fence check of this connection.
    pub(super) fn fence_check(&self) -> FenceCheck<'_> {
        FenceCheck {
            arm: self,
            held: &self.inner.held,
        }
    }
}
