//! Handle to a served virtual arm, for other tasks and threads.

use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll};

use tokio::sync::{mpsc, oneshot};

use magician_sim::Runner;

/// Operation on an arm's runner. The returned function is called once the endpoints have followed.
type Order = Box<dyn FnOnce(&mut Runner) -> Done + Send>;
type Done = Box<dyn FnOnce() + Send>;

/// Handle to an arm that is being served: a display, a scenario or a test observes and changes it
/// from another task or thread, while its clients are served. Returned by [`Server::handle`].
///
/// Operations run one by one, in order of submission, whether their [`PendingResult`] is awaited or
/// not. Those submitted before the server is ready wait for it.
///
/// [`Server::handle`]: super::Server::handle
#[derive(Clone)]
pub struct Handle {
    orders: mpsc::UnboundedSender<Order>,
}

impl fmt::Debug for Handle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Handle").finish_non_exhaustive()
    }
}

impl Handle {
    /// Runs a function on the arm's runner, which is brought to the present first. It should be
    /// quick, because the arm waits for it.
    ///
    /// ```no_run
    /// # use magician::serve::{Ended, Handle};
    /// # async fn look(handle: Handle) -> Result<(), Ended> {
    /// let state = handle.with(|runner| runner.controller().state()).await?;
    /// println!("{:?}", state.pose);
    /// # Ok(())
    /// # }
    /// ```
    pub fn with<T: Send + 'static>(
        &self,
        call: impl FnOnce(&mut Runner) -> T + Send + 'static,
    ) -> PendingResult<T> {
        let (sender, receiver) = oneshot::channel();
        let order = move |runner: &mut Runner| {
            let value = call(runner);
            // Receiving the result is optional.
            let done: Done = Box::new(move || drop(sender.send(value)));
            done
        };
        // If the server has ended, the result resolves to [`Ended`].
        let _ = self.orders.send(Box::new(order));
        PendingResult(receiver)
    }

    /// Pulls the cable at the arm's end ([`Runner::unplug`]).
    ///
    /// When this resolves, pseudo-terminals have disappeared like a USB adapter: the path is gone,
    /// and clients got a hang-up. TCP connections are closed, new ones too, and datagrams are not
    /// answered.
    pub fn unplug(&self) -> PendingResult<()> {
        self.with(Runner::unplug)
    }

    /// Plugs the cable in again. When this resolves, every endpoint accepts again: a
    /// pseudo-terminal is a new one at the same path.
    pub fn plug(&self) -> PendingResult<()> {
        self.with(Runner::plug)
    }
}

/// Error of an operation whose server ended before or during it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the arm is no longer served")]
pub struct Ended;

/// Result of an operation, as a future. When it resolves, the endpoints have followed the runner:
/// unplugged ones are gone, plugged ones accept.
#[derive(Debug)]
#[must_use = "it is carried out later; only the reply tells when"]
pub struct PendingResult<T>(oneshot::Receiver<T>);

impl<T> PendingResult<T> {
    /// Waits for the result in synchronous code.
    ///
    /// # Errors
    /// [`Ended`] if the arm is no longer served.
    ///
    /// # Panics
    /// Panics within an asynchronous task, where it would block the runtime.
    pub fn wait(self) -> Result<T, Ended> {
        self.0.blocking_recv().map_err(|_| Ended)
    }
}

impl<T> Future for PendingResult<T> {
    type Output = Result<T, Ended>;

    fn poll(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Self::Output> {
        let answer = Pin::new(&mut self.0).poll(cx);
        answer.map(|answer| answer.map_err(|_| Ended))
    }
}

/// Receiving end of all handles of an arm.
pub(super) struct Orders {
    sender: mpsc::UnboundedSender<Order>,
    receiver: mpsc::UnboundedReceiver<Order>,
}

impl Orders {
    pub(super) fn new() -> Self {
        let (sender, receiver) = mpsc::unbounded_channel();
        Self { sender, receiver }
    }

    pub(super) fn handle(&self) -> Handle {
        Handle {
            orders: self.sender.clone(),
        }
    }

    /// Runs the next operation, if any; the returned function is to be called once the endpoints
    /// have followed. Wakes the task for the one after it.
    pub(super) fn carry_out_one(
        &mut self,
        cx: &mut Context<'_>,
        runner: &mut Runner,
    ) -> Option<Done> {
        let Poll::Ready(Some(order)) = self.receiver.poll_recv(cx) else {
            return None;
        };
        // Only one operation per round: the endpoints follow each before the next runs.
        cx.waker().wake_by_ref();
        Some(order(runner))
    }
}
