//! The arm for programs without async: the same handle, each call waits for its answer.
//!
//! ```
//! use magician::{blocking, words};
//!
//! # fn main() -> magician::Result<()> {
//! let arm = blocking::Arm::connect(&"sim".parse()?)?;
//! arm.perform(&[words::move_to(220.0, 0.0, 50.0, 0.0)])?;
//! assert_eq!(arm.get::<magician::commands::Pose>()?.x, 220.0);
//! # Ok(())
//! # }
//! ```

use std::future::Future;

use magician_protocol::{AlarmSet, Ctrl, FrameBuf, NoArgs, Queueable, Readable, Set, Writable};
use tokio::runtime::{Builder, Handle, Runtime};

use crate::connection::Stats;
use crate::words::{Guards, Preflight};
use crate::{Error, ErrorKind, Options, Progress, QueueIndex, Ran, Result, RunOptions, Target};

/// An arm, for programs without async. What is true of [`crate::Arm`] is true of it: every call
/// ends by its deadline, and dropping it stops what it set going.
///
/// It must not be used inside an async runtime, where waiting would block everything else: there
/// every method returns [`ErrorKind::InvalidInput`] and sends nothing.
#[derive(Debug)]
pub struct Arm {
    /// `None` only while it is being dropped.
    runtime: Option<Runtime>,
    arm: Option<crate::Arm>,
}

/// Refuses to block an async runtime.
fn outside_async() -> Result<()> {
    match Handle::try_current() {
        Err(_) => Ok(()),
        Ok(_) => Err(Error::invalid(
            "magician::blocking is used inside an async runtime; use magician::Arm there",
        )),
    }
}

impl Arm {
    /// See [`crate::Arm::connect`].
    ///
    /// # Errors
    /// As there, and when it is called inside an async runtime.
    pub fn connect(target: &Target) -> Result<Self> {
        Self::connect_with(target, Options::default())
    }

    /// See [`crate::Arm::connect_with`].
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub fn connect_with(target: &Target, options: Options) -> Result<Self> {
        Self::begin(crate::Arm::connect_with(target, options))
    }

    /// See [`crate::Arm::simulated`].
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    #[cfg(feature = "sim")]
    pub fn simulated(arm: impl Into<crate::VirtualArm>, options: Options) -> Result<Self> {
        Self::begin(crate::Arm::simulated(arm, options))
    }

    fn begin(connecting: impl Future<Output = Result<crate::Arm>>) -> Result<Self> {
        outside_async()?;
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| {
            let message = format!("the system gives no timer or poller: {error}");
            Error::new(ErrorKind::Port, message)
        })?;
        let arm = runtime.block_on(connecting)?;
        Ok(Self {
            runtime: Some(runtime),
            arm: Some(arm),
        })
    }

    fn block<'a, T, F>(&'a self, call: impl FnOnce(&'a crate::Arm) -> F) -> Result<T>
    where
        F: Future<Output = Result<T>>,
    {
        outside_async()?;
        match (&self.runtime, &self.arm) {
            (Some(runtime), Some(arm)) => runtime.block_on(call(arm)),
            _ => Err(Error::closed()),
        }
    }

    /// Lets what this handle set going go on when it is dropped.
    pub fn detach(&self) {
        if let Some(arm) = &self.arm {
            arm.detach();
        }
    }

    /// Ends the connection as dropping it does.
    pub fn close(self) {}

    /// What the connection is called in messages.
    #[must_use]
    pub fn name(&self) -> &str {
        self.arm.as_ref().map_or("", crate::Arm::name)
    }

    /// See [`crate::Arm::get`].
    ///
    /// # Errors
    /// As there.
    pub fn get<T: Readable<Query = NoArgs>>(&self) -> Result<T> {
        self.block(|arm| arm.get())
    }

    /// See [`crate::Arm::get_with`].
    ///
    /// # Errors
    /// As there.
    pub fn get_with<T: Readable>(&self, query: &T::Query) -> Result<T> {
        self.block(|arm| async move { arm.get_with(query).await })
    }

    /// See [`crate::Arm::set`].
    ///
    /// # Errors
    /// As there.
    pub fn set<T: Writable>(&self, value: &T) -> Result<()> {
        self.block(|arm| async move { arm.set(value).await })
    }

    /// See [`crate::Arm::enqueue`].
    ///
    /// # Errors
    /// As there.
    pub fn enqueue<T: Queueable + Copy + Into<Set>>(&self, value: &T) -> Result<QueueIndex> {
        self.block(|arm| async move { arm.enqueue(value).await })
    }

    /// See [`crate::Arm::raw`].
    ///
    /// # Errors
    /// As there.
    pub fn raw(&self, id: u8, ctrl: Ctrl, params: &[u8]) -> Result<FrameBuf> {
        self.block(|arm| async move { arm.raw(id, ctrl, params).await })
    }

    /// See [`crate::Arm::perform`].
    ///
    /// # Errors
    /// As there.
    pub fn perform(&self, commands: &[Set]) -> Result<Ran> {
        self.block(|arm| async move { arm.perform(commands).await })
    }

    /// See [`crate::Arm::perform_with`].
    ///
    /// # Errors
    /// As there.
    pub fn perform_with(&self, commands: &[Set], guards: Guards) -> Result<Ran> {
        self.block(|arm| async move { arm.perform_with(commands, guards).await })
    }

    /// See [`crate::Arm::preflight_for`].
    ///
    /// # Errors
    /// As there.
    pub fn preflight_for(&self, commands: &[Set]) -> Result<Preflight> {
        self.block(|arm| async move { arm.preflight_for(commands).await })
    }

    /// See [`crate::Arm::run`].
    ///
    /// # Errors
    /// As there.
    pub fn run<C>(&self, commands: C, progress: impl FnMut(Progress)) -> Result<Ran>
    where
        C: IntoIterator<Item = Set>,
    {
        self.run_with(commands, RunOptions::default(), progress)
    }

    /// See [`crate::Arm::run_with`].
    ///
    /// # Errors
    /// As there.
    pub fn run_with<C>(
        &self,
        commands: C,
        options: RunOptions,
        progress: impl FnMut(Progress),
    ) -> Result<Ran>
    where
        C: IntoIterator<Item = Set>,
    {
        self.block(|arm| arm.run_with(commands, options, progress))
    }

    /// See [`crate::Arm::wait_with`].
    ///
    /// # Errors
    /// As there.
    pub fn wait_with(&self, index: QueueIndex, progress: impl FnMut(Progress)) -> Result<()> {
        self.block(|arm| arm.wait_with(index, progress))
    }
}

/// Methods that hand over what they are given and wait.
macro_rules! same {
    ($( $name:ident ( $( $arg:ident : $type:ty ),* ) -> $returns:ty; )+) => {
        impl Arm {
            $(
                #[doc = concat!("See [`crate::Arm::", stringify!($name), "`].")]
                ///
                /// # Errors
                /// As there.
                pub fn $name(&self $(, $arg: $type)*) -> Result<$returns> {
                    self.block(|arm| arm.$name($($arg),*))
                }
            )+
        }
    };
}

same! {
    enqueue_set(command: &Set) -> QueueIndex;
    wait(index: QueueIndex) -> ();
    wait_still() -> ();
    stop() -> ();
    stop_gentle() -> ();
    stop_jog() -> ();
    start_queue() -> ();
    clear_queue() -> ();
    home() -> ();
    alarms() -> AlarmSet;
    clear_alarms() -> ();
    current_index() -> QueueIndex;
    left_space() -> u32;
    preflight() -> Preflight;
    stats() -> (Stats, u32);
}

impl Drop for Arm {
    fn drop(&mut self) {
        let (Some(runtime), Some(arm)) = (self.runtime.take(), self.arm.take()) else {
            return;
        };
        if outside_async().is_ok() {
            runtime.block_on(arm.close());
        } else {
            // Blocking is not allowed here. The task writes what it can when the runtime drops it.
            drop(arm);
            runtime.shutdown_background();
        }
    }
}
