use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use magician_protocol::BAUD_RATE;
#[cfg(feature = "sim")]
use magician_sim::Happening;

#[cfg(feature = "ble")]
use super::ble;
use super::faulty::{Restart, Spoiler};
#[cfg(feature = "trace")]
use super::traced::{Traced, Tracer};
use super::{Line, Transport, search, serial, stream, udp};
#[cfg(feature = "sim")]
use super::{Sim, faulty::Blow};
#[cfg(feature = "sim")]
use crate::VirtualArm;
use crate::connection::Settings;
use crate::faults::Faults;
use crate::ports::{self, Port, Remembered};
#[cfg(not(all(feature = "sim", feature = "ble")))]
use crate::{Error, ErrorKind};
use crate::{Options, Result, Target};

/// The way to an arm, to be gone again when its line was lost.
///
/// Going it again leads to the same adapter under whatever name it has now, never to another one
/// without a word; to the same virtual arm, for one in this process.
pub(crate) struct Way {
    target: Target,
    adapter: Mutex<Option<Remembered>>,
    #[cfg(feature = "sim")]
    arm: Mutex<Option<VirtualArm>>,
    spoiler: Option<Spoiler>,
    #[cfg(feature = "trace")]
    tracer: Option<Tracer>,
}

impl Way {
    pub(crate) fn to(target: &Target) -> Self {
        Self {
            target: target.clone(),
            adapter: Mutex::default(),
            #[cfg(feature = "sim")]
            arm: Mutex::default(),
            spoiler: None,
            #[cfg(feature = "trace")]
            tracer: None,
        }
    }

    /// The way to a virtual arm that is there already.
    #[cfg(feature = "sim")]
    pub(crate) fn to_virtual(arm: VirtualArm) -> Self {
        let way = Self::to(&Target::Sim(crate::SimSpeed::Max));
        *lock(&way.arm) = Some(arm);
        way
    }

    /// With the faults and the trace that the options ask for.
    pub(crate) fn fitted(self, options: &Options) -> Result<Self> {
        options.faults.check()?;
        let way = self.with_faults(options.faults);
        #[cfg(feature = "trace")]
        let way = match &options.trace {
            Some(tracer) => way.with_trace(tracer.clone()),
            None => way,
        };
        Ok(way)
    }

    /// Spoils what passes in both directions, from [`Faults::seed`]. Opening the line again goes on
    /// with the same chances.
    pub(crate) fn with_faults(mut self, faults: Faults) -> Self {
        self.spoiler = Some(Spoiler::new(faults)).filter(|_| !faults.is_none());
        self
    }

    /// Writes what passes to a trace file, as this program sends and receives it: requests before
    /// and replies after the [faults](Self::with_faults).
    #[cfg(feature = "trace")]
    pub(crate) fn with_trace(mut self, tracer: Tracer) -> Self {
        self.tracer = Some(tracer);
        self
    }

    /// Opens a line, for the first time or again. The line before must have been dropped, since it
    /// holds the port. A port that has just come back may not be allowed for a moment, until the
    /// system has set its rights; whoever opens again tries for a while.
    pub(crate) async fn open(&self) -> Result<Line> {
        let name = self.target.to_string();
        if let Some(spoiler) = &self.spoiler {
            spoiler.reachable(&name)?;
        }
        let (mut transport, settings, tried) = self.plain().await?;
        if let Some(spoiler) = &self.spoiler {
            transport = Box::new(spoiler.around(transport, self.restart(), &name)?);
        }
        #[cfg(feature = "trace")]
        if let Some(tracer) = &self.tracer {
            transport = Box::new(Traced::new(transport, tracer.clone(), &name));
        }
        Ok(Line {
            transport,
            settings,
            name,
            tried,
            in_process: matches!(self.target, Target::Sim(_)),
        })
    }

    async fn plain(&self) -> Result<(Box<dyn Transport>, Settings, &'static str)> {
        match &self.target {
            #[cfg(feature = "sim")]
            Target::Sim(speed) => {
                let powered_up = || VirtualArm::powered_up(*speed);
                let arm = lock(&self.arm).get_or_insert_with(powered_up).clone();
                let settings = Settings {
                    free_clock: arm.lock().can_be_led(),
                    ..Settings::ORDERED
                };
                Ok((Box::new(Sim::new(arm)), settings, "a virtual arm"))
            }
            #[cfg(not(feature = "sim"))]
            Target::Sim(_) => Err(Error::new(
                ErrorKind::Unsupported,
                "this build has no virtual arm: it was made without the feature `sim`",
            )),
            Target::Serial(_) | Target::Usb { .. } | Target::Arm(_) => {
                let settings = Settings {
                    baud: Some(BAUD_RATE),
                    ..Settings::ORDERED
                };
                Ok((Box::new(self.serial().await?), settings, "115200 baud"))
            }
            Target::Udp { host, port } => {
                let socket = udp::open(host, *port).await?;
                Ok((Box::new(socket), Settings::DATAGRAMS, "UDP"))
            }
            Target::Tcp { host, port } => {
                let stream = stream::connect(host, *port).await?;
                Ok((Box::new(stream), Settings::ORDERED, "TCP"))
            }
            #[cfg(feature = "ble")]
            Target::Ble(device) => {
                let link = ble::open(device).await?;
                Ok((Box::new(link), ble::SETTINGS, "Bluetooth"))
            }
            #[cfg(not(feature = "ble"))]
            Target::Ble(_) => Err(Error::new(
                ErrorKind::Unsupported,
                "this build has no Bluetooth: it was made without the feature `ble`; use USB or Wi-Fi",
            )),
        }
    }

    /// A serial port, and what it takes to find its adapter again.
    async fn serial(&self) -> Result<serial::Serial> {
        let adapter = lock(&self.adapter).clone();
        let present = match (&adapter, &self.target) {
            // The name is enough, so a system that does not tell is no hindrance.
            (None, Target::Serial(_)) => ports::ports().unwrap_or_default(),
            _ => ports::ports()?,
        };
        let (path, port) = match (&self.target, &adapter) {
            (Target::Arm(serial), _) => search::arm(serial, &in_turn(&present, &adapter)).await?,
            (_, Some(adapter)) => open_at(adapter.find(&present)?)?,
            (Target::Usb { .. }, None) => open_at(search::adapter(&self.target, &present)?)?,
            (target, None) => open_at(target.to_string())?,
        };
        if adapter.is_none() {
            *lock(&self.adapter) = Some(Remembered::new(&path, &present));
        }
        tracing::debug!(target = %self.target, path, "serial port opened");
        Ok(port)
    }

    /// How to restart the controller at the end of this way; only a virtual one can be.
    fn restart(&self) -> Option<Restart> {
        #[cfg(feature = "sim")]
        if let Some(arm) = lock(&self.arm).clone() {
            return Some(Box::new(move |blow| deal(&arm, blow)));
        }
        None
    }
}

impl fmt::Debug for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Way")
            .field("target", &self.target)
            .finish_non_exhaustive()
    }
}

/// Does it to a virtual arm.
#[cfg(feature = "sim")]
fn deal(arm: &VirtualArm, blow: Blow) {
    match blow {
        Blow::Reset => arm.with(|controller| controller.inject(Happening::Reset)),
        Blow::Replugged => {
            let mut cell = arm.lock();
            cell.runner.unplug();
            cell.runner.plug();
        }
    }
}

fn open_at(path: String) -> Result<(String, serial::Serial)> {
    let port = serial::open(&path)?;
    Ok((path, port))
}

/// Where an arm may be, the adapter that had it last before the others.
fn in_turn(present: &[Port], adapter: &Option<Remembered>) -> Vec<Port> {
    let last = adapter.as_ref().and_then(|one| one.find(present).ok());
    let mut likely: Vec<Port> = (present.iter())
        .filter(|port| port.likely_arm())
        .cloned()
        .collect();
    likely.sort_by_key(|port| last.as_ref() != Some(&port.path));
    likely
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
