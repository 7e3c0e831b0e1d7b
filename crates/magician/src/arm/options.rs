use std::sync::Arc;
use std::time::Duration;

use magician_motion::{ArmModel, Fence};

use super::{EndNotice, HomingRecord};
use crate::Result;
#[cfg(feature = "faults")]
use crate::faults::Faults;
#[cfg(feature = "trace")]
use crate::transport::Tracer;

/// How a connection behaves.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Every single call to the arm ends after this time at the latest. Waiting for a motion has
    /// deadlines of its own, and a run its [patience](crate::RunOptions::patience). Over UDP a call has room for five
    /// attempts, which is more where round trips are long. While this program is stopped or the computer sleeps, no time
    /// runs.
    pub timeout: Duration,
    /// Most requests in flight, 1 to 8. More than 1 is for arms of which it is known that they take
    /// requests back to back; `magician doctor` can measure it. At 1 a read still travels beside a queued command on a
    /// serial port, until one of the two is lost.
    pub window: usize,
    /// Whether to make sure at the start that an arm answers.
    pub probe: bool,
    /// Whether a line that breaks is looked for again until the connection ends: the same port, and the same arm at
    /// it. Its serial number (and its clock) are read once for that, soon after the start, if it was probed; an arm
    /// that says none, or was not asked yet, cannot be told from another. A stream that was handed over with
    /// [`Arm::over`](crate::Arm::over) cannot be opened again, [`Arm::over_with`](crate::Arm::over_with) can.
    pub reconnect: bool,
    /// Over UDP: how long after a datagram the network may still deliver a second copy of it. Queued commands go out so
    /// far apart, because a second copy of one that takes the place of a lost next one would show in no index. 0.1 s at
    /// first, and longer where round trips are; zero, for a network that doubles nothing, sends them as fast as they are answered.
    pub echo: Duration,
    /// Whether the laser of a real arm may be lit over this connection. Without it what [burns](crate::burns) is refused
    /// before it is sent, and so is what lets a queue run in which commands of another program wait: those cannot be read.
    /// [`Arm::allowing_laser`](crate::Arm::allowing_laser) allows it for single calls. A virtual arm in this process burns
    /// nothing and is never refused.
    pub allow_laser: bool,
    /// True if a [`JogCmd`](crate::commands::JogCmd) is sent as it is: for doors that carry what programs for other libraries say. The
    /// arm then does what that library's programs have it do: the jog goes on to the end of its axis, a change of axis first
    /// moves the new one the wrong way. Without it only the end of a jog is sent so, and anything else is refused: use
    /// [`Arm::jog`](crate::Arm::jog). Off at first.
    pub raw_jogs: bool,
    /// Whether the arm at the far end is a virtual one, as the program says that has it: a station. Nothing of it burns, and it
    /// stands where it believes. Without that word an arm in another process counts as real.
    pub virtual_arm: bool,
    /// Whether a laser may be wired to the arm's pins EIO 2 and 4: `false` for an arm that has none, so that these pins may
    /// drive something else. On at first.
    pub laser_pins: bool,
    /// The firmware's numbers, by which commands are checked: those of the known one at first. A virtual arm of the caller's
    /// own ([`Arm::simulated`](crate::Arm::simulated)) brings its own.
    pub model: ArmModel,
    /// The fence of the arm: everything over this connection is checked against it before it is sent, as
    /// [`Preflight::fence`](crate::preflight::Preflight::fence) does, from where the arm will be by then. What cannot be checked is
    /// refused: commands of other programs in the queue, what is downloaded into the arm. It costs reads before
    /// each motion; without a fence there are none.
    ///
    /// It holds for what this connection sends, not for other programs, for hands and keys on the arm, nor for the way on
    /// which a stop brakes. This is a convenience, not a safety function.
    pub fence: Option<Fence>,
    /// Jogs are pieces that end by themselves ([`Arm::jog`](crate::Arm::jog)), for a line that nothing outside of this program
    /// watches: whatever becomes of the program, the arm stands when a jog was not kept, or at the latest 50 ms later. They are not
    /// as fast and even as a jog of the arm's own ([`JogCmd`](crate::commands::JogCmd)), which is refused then, also with
    /// [`raw_jogs`](Self::raw_jogs); along y, r goes with joint 1. Off at first.
    pub bounded_jogs: bool,
    /// Memory of homings beyond this connection ([`Homing::is_homed`](crate::Homing::is_homed)). Without one only homings that this connection
    /// sees count. It costs a read of the serial number and of the arm's clock at each homing and each look.
    pub homings: Option<Arc<dyn HomingRecord>>,
    /// Notice of the end of the line by the program at its other end, where that gives one: a
    /// station. Jobs over this connection stop then, pen up and settings restored.
    pub end_notice: EndNotice,
    /// What is done to what passes on the line, for tests: not over a stream that the caller opens.
    #[cfg(feature = "faults")]
    pub faults: Faults,
    /// Where what passes on the line is written to, as this program says and hears it.
    #[cfg(feature = "trace")]
    pub trace: Option<Tracer>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(3),
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

    /// Sets [`fence`](Self::fence); one that bounds nothing is none.
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

    /// Whether a line to a virtual arm in this process may break.
    pub(crate) fn unplugs(&self) -> bool {
        #[cfg(feature = "faults")]
        return self.faults.unplug > 0.0;
        #[cfg(not(feature = "faults"))]
        false
    }

    /// For a line that cannot have them: [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) if faults are asked for.
    pub(crate) fn without_faults(&self) -> Result<()> {
        #[cfg(feature = "faults")]
        if !self.faults.is_none() {
            return Err(crate::Error::invalid(
                "faults need a line that this library opens, not the caller's stream",
            ));
        }
        Ok(())
    }
}
