//! Options of a connection, with a builder method for each.

use std::sync::Arc;
use std::time::Duration;

use magician_motion::{ArmModel, Fence};

use super::{EndNotice, HomingRecord};
use crate::Result;
#[cfg(feature = "faults")]
use crate::faults::Faults;
#[cfg(feature = "trace")]
use crate::transport::Tracer;

/// Options of a connection.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Timeout of every single call to the arm, 3 s by default.
    ///
    /// Waiting for a motion has its own deadlines, and a run has its
    /// [patience](crate::RunOptions::patience). Over UDP a call may take at least the time of five
    /// attempts, so its timeout is longer if round trips are slow. The timeout does not run while
    /// this process is suspended or the computer sleeps.
    pub timeout: Duration,
    /// Maximum requests in flight, 1 to 8; 1 by default.
    ///
    /// Use more than 1 only for arms that are known to take requests back to back;
    /// `magician doctor` measures how many an arm takes. With a window of 1, a serial port still
    /// carries one read beside a queued command, until one of the two is lost.
    pub window: usize,
    /// True (default) if connecting checks that an arm answers.
    pub probe: bool,
    /// True (default) if the driver reopens a broken line, on the same port, until the same arm
    /// answers there or the connection ends.
    ///
    /// To recognise the arm, the driver reads its serial number and its clock once soon after
    /// connecting, if [`probe`](Self::probe) is true. An arm without a serial number, or whose
    /// serial number was not read yet, cannot be distinguished from another. A stream passed to
    /// [`Arm::over`](crate::Arm::over) cannot be reopened; one of
    /// [`Arm::over_with`](crate::Arm::over_with) can.
    pub reconnect: bool,
    /// Time after a datagram in which a UDP network may still deliver a duplicate of it; 0.1 s by
    /// default, and longer if round trips are slow.
    ///
    /// Queued commands are sent this far apart: a late duplicate of a command could take the place
    /// of the next command if that one is lost, and no index would show it. Zero, for a network
    /// that duplicates nothing, sends each command as soon as the previous one is answered.
    pub echo: Duration,
    /// True if this connection may light the laser of a real arm; false by default.
    ///
    /// Without it, commands that [burn](crate::burns) are refused before they are sent. So is
    /// starting a queue in which commands of another program wait, because they cannot be read
    /// back. [`Arm::allowing_laser`](crate::Arm::allowing_laser) allows single calls. A virtual arm
    /// in this process burns nothing and is never refused.
    pub allow_laser: bool,
    /// True if a [`JogCmd`](crate::commands::JogCmd) is sent unchanged; false by default.
    ///
    /// For front ends that relay programs written for other libraries. The arm then behaves as with
    /// those libraries: the jog continues to the end of its axis, and a change of axis first moves
    /// the new one the wrong way. Without it, only the end of a jog is sent and everything else is
    /// refused: use [`Arm::jog`](crate::Arm::jog).
    pub raw_jogs: bool,
    /// True if the arm at the far end is virtual, as reported by the program that owns it (a
    /// station).
    ///
    /// A virtual arm burns nothing, and its positions are right without homing. Any arm in another
    /// process counts as real unless this is set.
    pub virtual_arm: bool,
    /// True (default) if a laser may be wired to the pins EIO 2 and 4. Set it to false if there is
    /// none and the pins drive something else.
    pub laser_pins: bool,
    /// Firmware constants used to check commands; by default those of the known firmware. A virtual
    /// arm passed to [`Arm::simulated`](crate::Arm::simulated) brings its own.
    pub model: ArmModel,
    /// Fence of the arm: everything sent over this connection is checked against it first.
    ///
    /// The check is that of [`Preflight::fence`](crate::preflight::Preflight::fence), starting
    /// where the arm will be by then. Motion that cannot be checked is refused: commands of other
    /// programs in the queue, and programs downloaded into the arm. A fence costs additional reads
    /// before each motion.
    ///
    /// It covers only what this connection sends: not other programs, not hands and keys on the
    /// arm, and not the braking distance of a stop. This is a convenience, not a safety function.
    pub fence: Option<Fence>,
    /// True if jogs are sent as short moves that end by themselves ([`Arm::jog`](crate::Arm::jog));
    /// false by default.
    ///
    /// For a line that nothing outside this process watches: whatever happens to the process, the
    /// arm is at rest at most 50 ms after the hold time of a jog ends. Such jogs are slower and
    /// less even than the arm's own ([`JogCmd`](crate::commands::JogCmd)), which is refused then,
    /// even with [`raw_jogs`](Self::raw_jogs). Along y, r turns with joint 1.
    pub bounded_jogs: bool,
    /// Record of homings that outlives the connection
    /// ([`Homing::is_homed`](crate::Homing::is_homed)).
    ///
    /// Without a record only homings over this connection count. It costs a read of the serial
    /// number and of the arm's clock at each homing and each query.
    pub homings: Option<Arc<dyn HomingRecord>>,
    /// Notice from the program at the other end of the line (a station) that the line will end.
    /// Jobs over this connection then stop, with the pen up and settings restored.
    pub end_notice: EndNotice,
    /// Faults injected on the line, for tests. Not available over a stream that the caller opens.
    #[cfg(feature = "faults")]
    pub faults: Faults,
    /// Tracer that records all bytes sent and received.
    #[cfg(feature = "trace")]
    pub trace: Option<Tracer>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            // Choice: room for several retransmissions, and a person at a prompt still waits this
            // long.
            timeout: Duration::from_secs(3),
            // A choice: it is not known whether a real controller takes several queued commands
            // back to back (goal H2).
            window: 1,
            probe: true,
            reconnect: true,
            echo: Duration::from_millis(100),
            allow_laser: false,
            raw_jogs: false,
            virtual_arm: false,
            laser_pins: true,
            model: ArmModel::MAGICIAN,
            fence: None,
            bounded_jogs: false,
            homings: None,
            end_notice: EndNotice::default(),
            #[cfg(feature = "faults")]
            faults: Faults::default(),
            #[cfg(feature = "trace")]
            trace: None,
        }
    }
}

impl Options {
    /// Sets [`timeout`](Self::timeout).
    #[must_use]
    pub fn timeout(mut self, timeout: Duration) -> Self {
        self.timeout = timeout;
        self
    }

    /// Sets [`window`](Self::window).
    #[must_use]
    pub fn window(mut self, window: usize) -> Self {
        self.window = window;
        self
    }

    /// Sets [`probe`](Self::probe).
    #[must_use]
    pub fn probe(mut self, probe: bool) -> Self {
        self.probe = probe;
        self
    }

    /// Sets [`reconnect`](Self::reconnect).
    #[must_use]
    pub fn reconnect(mut self, reconnect: bool) -> Self {
        self.reconnect = reconnect;
        self
    }

    /// Sets [`echo`](Self::echo).
    #[must_use]
    pub fn echo(mut self, echo: Duration) -> Self {
        self.echo = echo;
        self
    }

    /// Sets [`allow_laser`](Self::allow_laser).
    #[must_use]
    pub fn allow_laser(mut self, allow: bool) -> Self {
        self.allow_laser = allow;
        self
    }

    /// Sets [`raw_jogs`](Self::raw_jogs).
    #[must_use]
    pub fn raw_jogs(mut self, raw: bool) -> Self {
        self.raw_jogs = raw;
        self
    }

    /// Sets [`virtual_arm`](Self::virtual_arm).
    #[must_use]
    pub fn virtual_arm(mut self, is_virtual: bool) -> Self {
        self.virtual_arm = is_virtual;
        self
    }

    /// Sets [`laser_pins`](Self::laser_pins).
    #[must_use]
    pub fn laser_pins(mut self, laser: bool) -> Self {
        self.laser_pins = laser;
        self
    }

    /// Sets [`model`](Self::model).
    #[must_use]
    pub fn model(mut self, model: ArmModel) -> Self {
        self.model = model;
        self
    }

    /// Sets [`fence`](Self::fence). A fence without bounds counts as no fence.
    #[must_use]
    pub fn fence(mut self, fence: impl Into<Option<Fence>>) -> Self {
        self.fence = fence.into();
        self
    }

    /// Sets [`bounded_jogs`](Self::bounded_jogs).
    #[must_use]
    pub fn bounded_jogs(mut self, bounded: bool) -> Self {
        self.bounded_jogs = bounded;
        self
    }

    /// Sets [`homings`](Self::homings).
    #[must_use]
    pub fn homings(mut self, homings: impl Into<Option<Arc<dyn HomingRecord>>>) -> Self {
        self.homings = homings.into();
        self
    }

    /// Sets [`end_notice`](Self::end_notice).
    #[must_use]
    pub fn end_notice(mut self, notice: EndNotice) -> Self {
        self.end_notice = notice;
        self
    }

    /// Sets [`faults`](Self::faults).
    #[cfg(feature = "faults")]
    #[must_use]
    pub fn faults(mut self, faults: Faults) -> Self {
        self.faults = faults;
        self
    }

    /// Sets [`trace`](Self::trace).
    #[cfg(feature = "trace")]
    #[must_use]
    pub fn trace(mut self, trace: Tracer) -> Self {
        self.trace = Some(trace);
        self
    }

    /// True if the line to a virtual arm in this process may break.
    pub(crate) fn may_unplug(&self) -> bool {
        #[cfg(feature = "faults")]
        return self.faults.unplug > 0.0;
        #[cfg(not(feature = "faults"))]
        false
    }

    /// Checks that no faults are requested, for a line that cannot inject them.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) if the options ask for faults.
    pub(crate) fn without_faults(&self) -> Result<()> {
        #[cfg(feature = "faults")]
        if !self.faults.is_none() {
            return Err(crate::Error::invalid(crate::message!(
                "faults need a line that this library opens, not the caller's stream"
            )));
        }
        Ok(())
    }
}
