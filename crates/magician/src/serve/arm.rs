//! A served virtual arm with its endpoints, timer and handles.

use std::sync::Arc;
use std::task::{Context, Waker};

use super::cable::Cable;
use super::handle::Orders;
use super::shared_arm::SharedArm;
use super::spec::{self, Listeners};
use super::timer::Timer;
use super::wake::{WakeFlag, WakeSet};
use super::{Endpoint, OnReady, ServeError, Server};
use magician_sim::Runner;

/// Served arm whose endpoints are all open.
pub(super) struct Arm {
    // Dropped first, so that no endpoint accepts clients for an arm that is gone.
    listeners: Listeners,
    hub: SharedArm,
    timer: Timer,
    bell: Arc<WakeFlag>,
    waker: Waker,
    on_ready: Option<OnReady>,
    orders: Orders,
    cable: Cable,
}

impl Arm {
    pub(super) fn open(server: Server, wake_set: WakeSet) -> Result<Self, ServeError> {
        let runner = Runner::new(server.controller, server.speed, server.line);
        let mut hub = SharedArm::new(runner, server.on_notice);
        #[cfg(feature = "trace")]
        if let Some(writer) = server.trace {
            hub.trace(writer).map_err(ServeError::Trace)?;
        }
        if let Some(path) = server.flash {
            hub.keep_flash(path);
        }
        #[cfg(feature = "record")]
        if let Some(writer) = server.recording {
            hub.record(writer, server.speed)?;
        }
        // After the start of the trace, which records the clients from the first.
        let listeners = spec::open_all(&server.specs, &server.discovery, server.number, &mut hub)?;
        if let Some(place) = spec::place(&listeners) {
            let controller = hub.runner_mut().controller_mut();
            controller.identify_at(&place, server.number);
        }
        let bell = WakeFlag::new(wake_set);
        Ok(Self {
            listeners,
            hub,
            timer: Timer::new().map_err(ServeError::Timer)?,
            waker: Waker::from(Arc::clone(&bell)),
            bell,
            on_ready: Some(server.on_ready),
            orders: server.orders,
            cable: Cable::default(),
        })
    }

    /// Reports that every endpoint of every arm accepts.
    pub(super) fn ready(&mut self) {
        if let Some(call) = self.on_ready.take() {
            call(&self.endpoints());
        }
    }

    fn endpoints(&self) -> Vec<Endpoint> {
        spec::endpoints(&self.listeners)
    }

    /// Closes the endpoints and completes the files being written.
    pub(super) fn end(self) -> Result<(), ServeError> {
        drop(self.listeners);
        self.hub.end()
    }

    /// Polls the arm if it was woken.
    pub(super) fn answer_bell(&mut self) -> Result<(), ServeError> {
        if !self.bell.answer() {
            return Ok(());
        }
        let waker = self.waker.clone();
        self.poll(&mut Context::from_waker(&waker))
    }

    /// Does everything that is possible now, and registers to be woken for the rest.
    fn poll(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        self.hub.tick();
        let done = self.orders.carry_out_one(cx, self.hub.runner_mut());
        let (pulls, plugged) = (self.hub.runner().pulls(), self.hub.runner().plugged());
        let listeners = &mut self.listeners;
        self.cable
            .follow(pulls, plugged, listeners, &mut self.hub)?;
        spec::poll_all(&mut self.listeners, cx, &mut self.hub)?;
        self.hub.report();
        if let Some(done) = done {
            done();
        }
        if self.cable.is_behind(self.hub.runner().pulls()) {
            // The cable was pulled meanwhile; the endpoints follow in the next round.
            cx.waker().wake_by_ref();
        }
        if let Some(wait) = self.hub.wait()
            && self.timer.poll(cx, wait).is_ready()
        {
            // Already due: poll again after the other arms.
            cx.waker().wake_by_ref();
        }
        Ok(())
    }
}
