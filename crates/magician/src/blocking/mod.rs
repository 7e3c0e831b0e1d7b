//! Blocking handle for programs without async: the methods of [`crate::Arm`], each waiting for its
//! answer.
//!
//! ```
//! use magician::{blocking, build};
//!
//! # fn main() -> magician::Result<()> {
//! let arm = blocking::Arm::connect("sim")?;
//! arm.run(&[build::move_to(220.0, 0.0, 50.0, 0.0)])?;
//! assert_eq!(arm.get::<magician::commands::Pose>()?.x, 220.0);
//! # Ok(())
//! # }
//! ```

// First, so that its methods come first on the documentation page of `Arm`.
mod first_program;

mod handles;
mod owner;
mod run;
mod watches;

use std::future::Future;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use magician_protocol::commands::Pose;
use magician_protocol::{AlarmSet, Ctrl, FrameBuf, NoArgs, Queueable, Readable, Set, Writable};
use tokio::io::{AsyncRead, AsyncWrite};

use crate::connection::Stats;
use crate::preflight::Preflight;
use crate::{
    IntoTarget, LiftResult, Link, Options, Progress, QueueIndex, Result, RunOptions, RunSummary,
    Stopper,
};
use first_program::same;
pub use handles::{FrontEnd, Homing, Laser, Motors, Pins, Queue};
use owner::Owner;
pub use run::Run;
pub use watches::{Events, Jog, StateWatch};

/// A connection to an arm, for programs without async.
///
/// It behaves like [`crate::Arm`]: clones share the connection and work from any thread, every call
/// returns by its deadline, and dropping the last clone stops the motion that this connection
/// started.
///
/// A background thread serves the connection, so that a stop, the end of a jog and a reconnect do
/// not wait for the next call. Inside an async runtime a blocking call would stop all other tasks,
/// so every method returns [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) there and
/// sends nothing.
#[derive(Clone, Debug)]
pub struct Arm {
    owner: Arc<Owner>,
}

impl Arm {
    /// See [`crate::Arm::connect_with`].
    ///
    /// # Errors
    /// Same as [`connect`](Self::connect).
    pub fn connect_with(target: impl IntoTarget, options: Options) -> Result<Self> {
        let target = target.into_target()?;
        Self::connecting(async move { crate::Arm::connect_with(&target, options).await })
    }

    /// See [`crate::Arm::simulated`].
    ///
    /// # Errors
    /// Same as [`connect`](Self::connect).
    #[cfg(feature = "sim")]
    pub fn simulated(arm: impl Into<crate::VirtualArm>, options: Options) -> Result<Self> {
        Self::connecting(crate::Arm::simulated(arm.into(), options))
    }

    /// See [`crate::Arm::over`].
    ///
    /// # Errors
    /// Same as [`connect`](Self::connect).
    pub fn over<T>(stream: T, options: Options) -> Result<Self>
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self::connecting(crate::Arm::over(stream, options))
    }

    /// See [`crate::Arm::over_with`]. The opener runs on the connection's thread, inside its tokio
    /// runtime.
    ///
    /// # Errors
    /// As there, and as [`connect`](Self::connect).
    pub fn over_with<F, O, T>(opener: F, options: Options) -> Result<Self>
    where
        F: FnMut() -> O + Send + 'static,
        O: Future<Output = io::Result<T>> + Send + 'static,
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self::connecting(crate::Arm::over_with(opener, options))
    }

    fn connecting(
        connecting: impl Future<Output = Result<crate::Arm>> + Send + 'static,
    ) -> Result<Self> {
        let owner = Arc::new(Owner::connecting(connecting)?);
        Ok(Self { owner })
    }

    fn block<'a, T, F>(&'a self, call: impl FnOnce(&'a crate::Arm) -> F) -> Result<T>
    where
        F: Future<Output = Result<T>>,
    {
        self.owner.block(call)
    }

    /// See [`crate::Arm::detach`].
    pub fn detach(&self) {
        self.owner.arm.detach();
    }

    /// See [`crate::Arm::close`]; it ends the connection for all clones.
    pub fn close(self) {
        // An error means that the connection has ended already, or that waiting is not allowed
        // here.
        let _ = self.block(|arm| async {
            arm.clone().close().await;
            Ok(())
        });
    }

    /// Returns the name of the connection in messages.
    #[must_use]
    pub fn name(&self) -> &str {
        self.owner.arm.name()
    }

    /// See [`crate::Arm::timeout`].
    #[must_use]
    pub fn timeout(&self) -> Duration {
        self.owner.arm.timeout()
    }

    /// See [`crate::Arm::set_timeout`].
    pub fn set_timeout(&self, timeout: Duration) {
        self.owner.arm.set_timeout(timeout);
    }

    /// See [`crate::Arm::link`].
    #[must_use]
    pub fn link(&self) -> Link {
        self.owner.arm.link()
    }

    /// See [`crate::Arm::moving`].
    #[must_use]
    pub fn moving(&self) -> bool {
        self.owner.arm.moving()
    }

    /// See [`crate::Arm::is_virtual`].
    #[must_use]
    pub fn is_virtual(&self) -> bool {
        self.owner.arm.is_virtual()
    }

    /// See [`crate::Arm::stopper`]. Allowed inside an async runtime.
    #[must_use]
    pub fn stopper(&self) -> Stopper {
        self.owner.arm.stopper()
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

    /// See [`crate::Arm::set_any`].
    ///
    /// # Errors
    /// As there.
    pub fn set_any(&self, command: &Set) -> Result<()> {
        self.block(|arm| arm.set_any(command))
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

    /// See [`crate::Arm::run_with`].
    ///
    /// # Errors
    /// As there.
    pub fn run_with(
        &self,
        commands: &[Set],
        options: RunOptions,
        progress: impl FnMut(Progress),
    ) -> Result<RunSummary> {
        self.block(|arm| async move { arm.run_with(commands, options, progress).await })
    }

    /// See [`crate::Arm::preflight_for`].
    ///
    /// # Errors
    /// As there.
    pub fn preflight_for(&self, commands: &[Set]) -> Result<Preflight> {
        self.block(|arm| async move { arm.preflight_for(commands).await })
    }

    /// See [`crate::Arm::start`].
    pub fn start<C>(&self, commands: C) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        self.start_with(commands, RunOptions::default())
    }

    /// See [`crate::Arm::start_with`].
    pub fn start_with<C>(&self, commands: C, options: RunOptions) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        Run::new(self.clone(), self.owner.arm.start_with(commands, options))
    }

    /// See [`crate::Arm::wait_with`].
    ///
    /// # Errors
    /// As there.
    pub fn wait_with(&self, index: QueueIndex, progress: impl FnMut(Progress)) -> Result<()> {
        self.block(|arm| arm.wait_with(index, progress))
    }
}

same! {
    enqueue_set(command: &Set) -> QueueIndex;
    wait(index: QueueIndex) -> ();
    wait_still() -> ();
    reconnected() -> ();
    stop_gentle() -> ();
    stop_jog() -> ();
    lift(height: f64) -> LiftResult;
    park(place: [f64; 3]) -> Pose;
    alarms() -> AlarmSet;
    clear_alarms() -> ();
    preflight() -> Preflight;
    stats() -> (Stats, u32);
}
