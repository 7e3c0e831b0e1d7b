//! Route to an arm: how to open its line, for the first time or again.

use std::fmt;
#[cfg(feature = "sim")]
use std::io;
#[cfg(feature = "sim")]
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(all(feature = "sim", feature = "faults"))]
use magician_sim::ExternalEvent;

#[cfg(feature = "sim")]
use super::Sim;
#[cfg(feature = "ble")]
use super::ble;
#[cfg(all(feature = "sim", feature = "faults"))]
use super::faulty::InjectedFault;
#[cfg(feature = "faults")]
use super::faulty::{FaultLayer, Restart};
#[cfg(feature = "lines")]
use super::lines::Lines;
#[cfg(feature = "trace")]
use super::traced::{Traced, Tracer};
use super::{Line, Transport};
#[cfg(any(feature = "sim", not(all(feature = "ble", feature = "lines"))))]
use crate::Error;
#[cfg(not(all(feature = "sim", feature = "ble", feature = "lines")))]
use crate::ErrorCode;
#[cfg(feature = "sim")]
use crate::VirtualArm;
use crate::connection::Settings;
#[cfg(feature = "faults")]
use crate::faults::Faults;
use crate::{Options, Result, Target, message};

/// Route to an arm, which can be opened again after its line was lost.
///
/// Reopening leads to the same adapter under any name, and to the same virtual arm in this process;
/// never silently to another one.
pub(crate) struct Route {
    target: Target,
    #[cfg(feature = "lines")]
    lines: Lines,
    #[cfg(feature = "sim")]
    arm: Mutex<Option<VirtualArm>>,
    /// True if the caller has the virtual arm, too.
    shows_arm: bool,
    #[cfg(feature = "faults")]
    spoiler: Option<FaultLayer>,
    #[cfg(feature = "trace")]
    tracer: Option<Tracer>,
}

impl Route {
    pub(crate) fn to(target: &Target) -> Self {
        Self {
            target: target.clone(),
            #[cfg(feature = "lines")]
            lines: Lines::default(),
            #[cfg(feature = "sim")]
            arm: Mutex::default(),
            shows_arm: false,
            #[cfg(feature = "faults")]
            spoiler: None,
            #[cfg(feature = "trace")]
            tracer: None,
        }
    }

    /// Creates a route to an existing virtual arm.
    #[cfg(feature = "sim")]
    pub(crate) fn to_virtual(arm: VirtualArm) -> Self {
        let mut way = Self::to(&Target::Sim(crate::SimSpeed::Max));
        way.shows_arm = true;
        *lock(&way.arm) = Some(arm);
        way
    }

    /// Adds the faults and the trace of the options.
    #[cfg_attr(
        not(any(feature = "faults", feature = "trace")),
        allow(unused_variables)
    )]
    pub(crate) fn fitted(self, options: &Options) -> Result<Self> {
        let way = self;
        #[cfg(feature = "faults")]
        let way = way.with_faults(options.faults)?;
        #[cfg(feature = "trace")]
        let way = match &options.trace {
            Some(tracer) => way.with_trace(tracer.clone()),
            None => way,
        };
        Ok(way)
    }

    /// Injects faults in both directions, seeded by [`Faults::seed`]. Reopening continues the same
    /// sequence.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) for invalid rates.
    #[cfg(feature = "faults")]
    pub(crate) fn with_faults(mut self, faults: Faults) -> Result<Self> {
        faults.check()?;
        self.spoiler = Some(FaultLayer::new(faults)).filter(|_| !faults.is_none());
        Ok(self)
    }

    /// Records the bytes in a trace, as this program sends and receives them: requests before and
    /// replies after the faults.
    #[cfg(feature = "trace")]
    pub(crate) fn with_trace(mut self, tracer: Tracer) -> Self {
        self.tracer = Some(tracer);
        self
    }

    /// Opens the line. A previous line must have been dropped, since it holds the port. A port that
    /// has just reappeared may be forbidden for a moment, until the system has set its permissions;
    /// a reconnect retries.
    pub(crate) async fn open(&self) -> Result<Line> {
        let name = self.target.to_string();
        #[cfg(feature = "faults")]
        if let Some(spoiler) = &self.spoiler {
            spoiler.reachable(&name)?;
        }
        let (transport, settings, tried) = self.plain().await.map_err(|error| self.named(error))?;
        #[cfg(any(feature = "faults", feature = "trace"))]
        let mut transport = transport;
        #[cfg(feature = "faults")]
        if let Some(spoiler) = &self.spoiler {
            transport = Box::new(spoiler.around(transport, self.restart(), &name)?);
        }
        #[cfg(feature = "trace")]
        if let Some(tracer) = &self.tracer {
            // Outside the faults, so that the trace shows what this program sent and received.
            transport = Box::new(Traced::new(transport, tracer.clone(), &name));
        }
        Ok(Line {
            transport,
            settings,
            name,
            tried,
            in_process: matches!(self.target, Target::Sim(_)),
            #[cfg(feature = "sim")]
            arm: lock(&self.arm).clone(),
            is_shared: self.is_shared(),
        })
    }

    /// Adds the station of this machine that has the target to an error, if any.
    pub(crate) fn named(&self, error: crate::Error) -> crate::Error {
        #[cfg(feature = "stations")]
        let error = crate::stations::named(error, &self.target);
        error
    }

    /// True if others may talk to the arm as well: on all lines except an open serial port and a
    /// private virtual arm. Behind a pseudo-terminal is a program, which may have other clients.
    fn is_shared(&self) -> bool {
        match &self.target {
            Target::Sim(_) => self.shows_arm,
            Target::Serial(path) => is_pseudo_terminal(path),
            // USB ids and serial numbers name a real port, which the lock of `serial.rs` makes
            // exclusive.
            Target::Usb { .. } | Target::Arm(_) => false,
            Target::Udp { .. } | Target::Tcp { .. } | Target::Ble(_) => true,
        }
    }

    async fn plain(&self) -> Result<(Box<dyn Transport>, Settings, &'static str)> {
        match &self.target {
            #[cfg(feature = "sim")]
            Target::Sim(speed) => {
                let powered_up = || VirtualArm::powered_up(*speed);
                let arm = lock(&self.arm).get_or_insert_with(powered_up).clone();
                // A block, so that the lock is released before the message is built.
                let gone = { arm.lock() }.is_gone();
                if gone {
                    let message = message!("the cable of the virtual arm is not plugged in");
                    return Err(Error::port(message, io::ErrorKind::NotConnected.into()));
                }
                let settings = Settings {
                    free_clock: arm.lock().can_be_led(),
                    ..Settings::ORDERED
                };
                Ok((Box::new(Sim::new(arm)), settings, "a virtual arm"))
            }
            #[cfg(not(feature = "sim"))]
            Target::Sim(_) => Err(Error::new(
                ErrorCode::NotBuiltIn,
                message!("this build has no virtual arm: it lacks the feature sim"),
            )),
            #[cfg(feature = "lines")]
            Target::Serial(_)
            | Target::Usb { .. }
            | Target::Arm(_)
            | Target::Udp { .. }
            | Target::Tcp { .. } => self.lines.open(&self.target).await,
            #[cfg(not(feature = "lines"))]
            Target::Serial(_)
            | Target::Usb { .. }
            | Target::Arm(_)
            | Target::Udp { .. }
            | Target::Tcp { .. } => Err(Error::new(
                ErrorCode::NotBuiltIn,
                message!("this build cannot connect to real arms: it lacks the feature lines"),
            )),
            #[cfg(feature = "ble")]
            Target::Ble(device) => {
                let link = ble::open(device).await?;
                Ok((Box::new(link), ble::SETTINGS, "Bluetooth"))
            }
            #[cfg(not(feature = "ble"))]
            Target::Ble(_) => Err(Error::new(
                ErrorCode::NotBuiltIn,
                message!("this build has no Bluetooth: it lacks the feature ble; use USB or Wi-Fi"),
            )),
        }
    }

    /// Returns a function that restarts the controller; only a virtual arm has one.
    #[cfg(feature = "faults")]
    fn restart(&self) -> Option<Restart> {
        #[cfg(feature = "sim")]
        if let Some(arm) = lock(&self.arm).clone() {
            return Some(Box::new(move |blow| apply_fault(&arm, blow)));
        }
        None
    }
}

fn is_pseudo_terminal(path: &str) -> bool {
    // Without lines no path is opened, and a WebAssembly module for a page must not access files.
    if !cfg!(feature = "lines") {
        return false;
    }
    let real = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let real = real.to_string_lossy();
    // Linux, macOS and Windows, in this order.
    let pipes = ["/dev/pts/", "/dev/ttys", r"\\.\pipe\"];
    pipes.iter().any(|pipe| real.starts_with(pipe))
}

impl fmt::Debug for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Route")
            .field("target", &self.target)
            .finish_non_exhaustive()
    }
}

/// Applies a fault to a virtual arm.
#[cfg(all(feature = "sim", feature = "faults"))]
fn apply_fault(arm: &VirtualArm, blow: InjectedFault) {
    match blow {
        InjectedFault::Reset => arm.with(|controller| controller.inject(ExternalEvent::Reset)),
        InjectedFault::Replugged => {
            let mut cell = arm.lock();
            cell.runner.unplug();
            cell.runner.plug();
        }
    }
}

#[cfg(feature = "sim")]
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
