use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use magician::serve::BoundEndpoints;
use tokio::task::unconstrained;
use tokio::time::{Instant, Sleep, sleep, timeout};

use super::service::ProxyService;
use super::wire::Wire;
use crate::failure::Failure;

/// Rounds in one turn before the runtime looks at signals.
const ROUNDS: u32 = 32;
/// How long the end of a jog may take when this program ends.
const STAND_BY: Duration = Duration::from_secs(2);

/// Endpoints, proxy and line at work.
pub(super) struct Session {
    /// Dropped before the rest: what leads to the arm is gone before the arm.
    endpoints: Option<BoundEndpoints>,
    service: ProxyService,
    wire: Wire,
    timer: Pin<Box<Sleep>>,
}

impl Session {
    pub(super) fn new(service: ProxyService, endpoints: BoundEndpoints, wire: Wire) -> Self {
        Self {
            endpoints: Some(endpoints),
            service,
            wire,
            timer: Box::pin(sleep(Duration::ZERO)),
        }
    }

    /// Serves until a door breaks down.
    pub(super) async fn serve(&mut self) -> Failure {
        unconstrained(poll_fn(|cx| match self.turn(cx) {
            Ok(()) => Poll::Pending,
            Err(failure) => Poll::Ready(failure),
        }))
        .await
    }

    /// Closes the endpoints and ends the jogs that were begun through them.
    pub(super) async fn end(mut self) {
        self.endpoints = None;
        self.service.close_all();
        let stands = poll_fn(|cx| match self.turn(cx) {
            Ok(()) if self.service.proxy.is_letting_go() => Poll::Pending,
            _ => Poll::Ready(()),
        });
        if timeout(STAND_BY, stands).await.is_err() {
            self.service.say_unconfirmed();
        }
    }

    /// Does all that can be done now and sees to being woken for the rest.
    fn turn(&mut self, cx: &mut Context<'_>) -> Result<(), Failure> {
        let turned = self.rounds(cx);
        self.service.show();
        turned
    }

    fn rounds(&mut self, cx: &mut Context<'_>) -> Result<(), Failure> {
        for _ in 0..ROUNDS {
            // What has come comes first: it may be what a timeout is about to give up.
            let came = self.wire.read(cx, &mut self.service);
            if let Some(endpoints) = &mut self.endpoints {
                endpoints.poll(cx, &mut self.service)?;
            }
            self.service.tick();
            let went = self.wire.write(cx, &mut self.service);
            let idle = !came && !went && !self.service.proxy.is_answering();
            if idle && self.sleeps(cx) {
                return Ok(());
            }
        }
        cx.waker().wake_by_ref();
        Ok(())
    }

    /// Whether nothing is due; then the task is woken when something will be.
    fn sleeps(&mut self, cx: &mut Context<'_>) -> bool {
        let Some(at) = self.service.proxy.poll_timeout() else {
            return true;
        };
        let now = self.service.now();
        if at <= now {
            return false;
        }
        // Rounded up: an instant that has not quite come would be waited for in vain.
        let at = Instant::now() + Duration::from_micros(at - now) + Duration::from_micros(1);
        self.timer.as_mut().reset(at);
        self.timer.as_mut().poll(cx).is_pending()
    }
}
