//! Endpoints in front of a virtual arm of this process.

use std::fmt;
use std::future::{Future, poll_fn};
use std::pin::{Pin, pin};
use std::task::{Context, Poll};

use magician_protocol::FrameBuf;
use magician_sim::LinkId;
use tokio::task::unconstrained;
use tokio::time::{Instant, Sleep, sleep_until};

use super::cable::Cable;
use super::service::device_id;
use super::spec::{self, Listeners};
use super::{Discovery, Endpoint, Endpoints, Notice, ServeError, Service};
use crate::VirtualArm;

/// Server for a [`VirtualArm`] of this process: other programs talk to the arm that this process
/// observes and connects to as well. A [`Server`](super::Server) has its own arm instead, with
/// files, line timing and speed.
///
/// It follows the arm's clock. It needs a tokio runtime with I/O and time enabled, and is one
/// future.
///
/// ```no_run
/// # async fn serve() -> Result<(), magician::serve::ServeError> {
/// use magician::VirtualArm;
/// use magician::serve::{Endpoints, ServedArm};
///
/// let arm = VirtualArm::default();
/// let served = ServedArm::open(arm.clone(), &Endpoints::new().tcp("127.0.0.1:9000"))?;
/// served.serve_until(tokio::time::sleep(std::time::Duration::from_secs(60))).await?;
/// println!("{:?}", arm.state().pose);
/// # Ok(())
/// # }
/// ```
pub struct ServedArm {
    // Dropped first, so that no endpoint accepts clients for lines that are gone.
    listeners: Listeners,
    clients: Clients,
    cable: Cable,
    alarm: Pin<Box<Sleep>>,
}

impl fmt::Debug for ServedArm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.endpoints()).finish()
    }
}

impl ServedArm {
    /// Opens the endpoints in front of this arm. UDP port 8899 includes discovery if its port is
    /// free ([`Discovery::Auto`]).
    ///
    /// # Errors
    /// [`ServeError`] if an endpoint cannot be opened; none then stays open.
    pub fn open(arm: VirtualArm, endpoints: &Endpoints) -> Result<Self, ServeError> {
        let mut clients = Clients {
            arm,
            links: Vec::new(),
        };
        let listeners = endpoints.listen(&Discovery::Auto, &mut clients)?;
        if let Some(place) = spec::place(&listeners) {
            clients.arm.with(|arm| arm.identify_at(&place, None));
        }
        Ok(Self {
            listeners,
            clients,
            cable: Cable::default(),
            alarm: Box::pin(sleep_until(Instant::now())),
        })
    }

    /// Returns the endpoints in the order of the request.
    #[must_use]
    pub fn endpoints(&self) -> Vec<Endpoint> {
        spec::endpoints(&self.listeners)
    }

    /// Serves until `end` is ready, and returns its output. Symlinks and sockets are removed when
    /// this returns or the future is dropped; the arm continues.
    ///
    /// # Errors
    /// [`ServeError`] if an endpoint fails.
    pub async fn serve_until<T>(mut self, end: impl Future<Output = T>) -> Result<T, ServeError> {
        let mut end = pin!(end);
        // The runtime's own budget would look like a full socket.
        unconstrained(poll_fn(|cx| {
            if let Poll::Ready(ended) = end.as_mut().poll(cx) {
                return Poll::Ready(Ok(ended));
            }
            match self.turn(cx) {
                Ok(()) => Poll::Pending,
                Err(error) => Poll::Ready(Err(error)),
            }
        }))
        .await
    }

    /// Does everything that is possible now, and registers to be woken for the rest.
    fn turn(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        let (pulls, plugged) = {
            let mut cell = self.clients.arm.lock();
            let now = cell.now();
            cell.runner.handle_timeout(now);
            (cell.runner.pulls(), cell.runner.plugged())
        };
        let listeners = &mut self.listeners;
        self.cable
            .follow(pulls, plugged, listeners, &mut self.clients)?;
        spec::poll_all(listeners, cx, &mut self.clients)?;
        let mut cell = self.clients.arm.lock();
        cell.watch(cx.waker());
        if self.cable.is_behind(cell.runner.pulls()) {
            // Pulled meanwhile; the endpoints follow in the next round.
            cx.waker().wake_by_ref();
        }
        let Some(at) = cell.runner.poll_change() else {
            return Ok(());
        };
        let now = cell.now();
        // Same as on the in-process line (`transport/sim.rs`): even a past instant is waited for
        // shortly, and a clock that stands wakes this task when it continues.
        match cell.comes(at.max(now.after_micros(1))) {
            Some(comes) => {
                self.alarm.as_mut().reset(comes);
                if self.alarm.as_mut().poll(cx).is_ready() {
                    // Due while the timer was set: poll again after the other tasks.
                    cx.waker().wake_by_ref();
                }
            }
            None if at <= now => cx.waker().wake_by_ref(),
            None => {}
        }
        Ok(())
    }
}

/// Lines of the clients.
struct Clients {
    arm: VirtualArm,
    links: Vec<LinkId>,
}

impl Service for Clients {
    fn open(&mut self, _: &str) -> LinkId {
        let link = self.arm.lock().expect_client();
        self.links.push(link);
        link
    }

    fn close(&mut self, link: LinkId) {
        self.links.retain(|known| *known != link);
        self.arm.lock().close(link);
    }

    fn room(&self, link: LinkId) -> usize {
        self.arm.lock().runner.room(link)
    }

    fn receive(&mut self, link: LinkId, bytes: &[u8]) {
        self.arm.lock().receive(link, bytes);
    }

    fn reply(&mut self, link: LinkId) -> Option<FrameBuf> {
        let mut cell = self.arm.lock();
        let now = cell.now();
        cell.runner.poll_transmit(now, link)
    }

    /// Ignores notices: there is no log.
    fn notice(&mut self, _: Notice) {}

    fn plugged(&self) -> bool {
        self.arm.lock().runner.plugged()
    }

    fn device_id(&mut self) -> [u32; 3] {
        let mut cell = self.arm.lock();
        let link = cell.expect_client();
        let id = device_id(cell.runner.controller_mut(), link);
        cell.close(link);
        id
    }
}

impl Drop for Clients {
    fn drop(&mut self) {
        let mut cell = self.arm.lock();
        self.links.drain(..).for_each(|link| cell.close(link));
    }
}
