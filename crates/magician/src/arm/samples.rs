//! Samples of a virtual arm at instants of the arm's clock, for recordings.
//!
//! In virtual time the clock leaps further than a reader could follow by polling, so the virtual
//! arm itself takes the samples during a leap.

use magician_protocol::AlarmSet;
use magician_protocol::commands::{EndEffectorParams, Pose};
use tokio::sync::mpsc;

use super::Arm;
#[cfg(feature = "sim")]
use crate::VirtualArm;

/// State of a virtual arm at an instant of its clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample {
    /// Seconds of its clock since [`Arm::samples`].
    pub t: f64,
    /// Pose as the arm reports it.
    pub pose: Pose,
    /// Tool bias contained in the pose.
    pub bias: EndEffectorParams,
    /// Index of the queued command that finished last.
    pub index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// Active alarms.
    pub alarms: AlarmSet,
}

/// Samples of a virtual arm in the order of its clock; see [`Arm::samples`].
#[derive(Debug)]
pub struct Samples {
    receiver: mpsc::UnboundedReceiver<Sample>,
    #[cfg(feature = "sim")]
    arm: VirtualArm,
    #[cfg(feature = "sim")]
    sampler: u64,
}

impl Samples {
    /// Waits for the next sample; `None` at the end.
    pub async fn next(&mut self) -> Option<Sample> {
        self.receiver.recv().await
    }

    /// Returns the next sample if there is one already.
    pub fn ready(&mut self) -> Option<Sample> {
        self.receiver.try_recv().ok()
    }

    /// Takes a sample of the present state. It comes after all earlier samples.
    pub fn take(&self) {
        #[cfg(feature = "sim")]
        self.arm.sample(self.sampler);
    }
}

#[cfg(feature = "sim")]
impl Drop for Samples {
    fn drop(&mut self) {
        // Otherwise the virtual arm would keep sampling without a receiver.
        self.arm.end_samples(self.sampler);
    }
}

impl Arm {
    /// Returns samples of a virtual arm in this process that runs in virtual time.
    ///
    /// The arm takes `rate` samples per second of its clock while it moves, and one whenever the
    /// caller changes its state from outside (`VirtualArm::with`). `None` for a real arm, and for a
    /// virtual arm on a wall clock, which can be polled.
    #[must_use]
    pub fn samples(&self, rate: f64) -> Option<Samples> {
        #[cfg(feature = "sim")]
        {
            let arm = self.inner.virtual_arm.as_ref()?;
            let (sampler, receiver) = arm.samples(rate)?;
            let arm = arm.clone();
            Some(Samples {
                receiver,
                arm,
                sampler,
            })
        }
        #[cfg(not(feature = "sim"))]
        {
            let _ = rate;
            None
        }
    }
}
