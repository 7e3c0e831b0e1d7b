//! Where a virtual arm is at instants of its own clock, for what records it: that clock leaps ahead of any reader.

use magician_protocol::AlarmSet;
use magician_protocol::commands::{EndEffectorParams, Pose};
use tokio::sync::mpsc;

use super::Arm;
#[cfg(feature = "sim")]
use crate::VirtualArm;

/// A virtual arm at an instant of its clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample {
    /// Seconds of its clock since [`Arm::samples`].
    pub t: f64,
    /// Where the tool is, as the arm tells it.
    pub pose: Pose,
    /// The tool that this is counted for.
    pub bias: EndEffectorParams,
    /// Index of the queued command that finished last.
    pub index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// The alarms that stand.
    pub alarms: AlarmSet,
}

/// Samples of a virtual arm, in the order of its clock; see [`Arm::samples`].
#[derive(Debug)]
pub struct Samples {
    coming: mpsc::UnboundedReceiver<Sample>,
    #[cfg(feature = "sim")]
    arm: VirtualArm,
    #[cfg(feature = "sim")]
    number: u64,
}

impl Samples {
    /// The next one.
    pub async fn next(&mut self) -> Option<Sample> {
        self.coming.recv().await
    }

    /// The next one, if there is one already.
    pub fn ready(&mut self) -> Option<Sample> {
        self.coming.try_recv().ok()
    }

    /// Takes one of the present, behind all others.
    pub fn take(&self) {
        #[cfg(feature = "sim")]
        self.arm.sample(self.number);
    }
}

#[cfg(feature = "sim")]
impl Drop for Samples {
    fn drop(&mut self) {
        self.arm.end_samples(self.number);
    }
}

impl Arm {
    /// Samples of a virtual arm in this process whose clock leaps, `rate` a second of that clock while it moves, and
    /// whenever it was touched from outside. A real arm, and a virtual one with a speed, has none: it is read as time passes.
    #[must_use]
    pub fn samples(&self, rate: f64) -> Option<Samples> {
        #[cfg(feature = "sim")]
        {
            let arm = self.inner.virtual_arm.as_ref()?;
            let (number, coming) = arm.samples(rate)?;
            let arm = arm.clone();
            Some(Samples {
                coming,
                arm,
                number,
            })
        }
        #[cfg(not(feature = "sim"))]
        {
            let _ = rate;
            None
        }
    }
}
