use std::sync::Arc;
use std::task::{Context, Waker};

use super::bell::{Bell, House};
use super::door::{self, Ports};
use super::hub::Hub;
use super::timer::Timer;
use super::{Endpoint, OnReady, ServeError, Server};
use crate::Runner;

/// An arm that is being served: all its endpoints are open.
pub(super) struct Arm {
    // Dropped first: what leads to the arm is gone before the arm.
    ports: Ports,
    hub: Hub,
    timer: Timer,
    bell: Arc<Bell>,
    waker: Waker,
    on_ready: Option<OnReady>,
}

impl Arm {
    pub(super) fn open(server: Server, house: House) -> Result<Self, ServeError> {
        let runner = Runner::new(server.controller, server.speed, server.line);
        let mut hub = Hub::new(runner, server.on_notice);
        #[cfg(feature = "trace")]
        if let Some(writer) = server.trace {
            hub.trace(writer).map_err(ServeError::Trace)?;
        }
        let bell = Bell::new(house);
        Ok(Self {
            ports: door::open_all(&server.doors, &server.discovery, server.number, &mut hub)?,
            hub,
            timer: Timer::new().map_err(ServeError::Timer)?,
            waker: Waker::from(Arc::clone(&bell)),
            bell,
            on_ready: Some(server.on_ready),
        })
    }

    /// Every endpoint of every arm accepts.
    pub(super) fn ready(&mut self) {
        if let Some(call) = self.on_ready.take() {
            let endpoints: Vec<Endpoint> = self.ports.iter().map(|port| port.endpoint()).collect();
            call(&endpoints);
        }
    }

    /// Takes a turn if anything happened.
    pub(super) fn answer_bell(&mut self) -> Result<(), ServeError> {
        if !self.bell.answer() {
            return Ok(());
        }
        let waker = self.waker.clone();
        self.turn(&mut Context::from_waker(&waker))
    }

    /// Does all that can be done now and sees to being woken for the rest.
    fn turn(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        self.hub.tick();
        for port in &mut self.ports {
            if let Err(source) = port.turn(cx, &mut self.hub) {
                return Err(ServeError::at(port.endpoint(), "go on", source));
            }
        }
        self.hub.report();
        if let Some(wait) = self.hub.wait()
            && self.timer.poll(cx, wait).is_ready()
        {
            cx.waker().wake_by_ref();
        }
        Ok(())
    }
}
