use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll};

use tokio::sync::{mpsc, oneshot};

use magician_sim::Runner;

/// Something to do on an arm's runner. What it returns is to be called when the endpoints have
/// followed.
type Order = Box<dyn FnOnce(&mut Runner) -> Done + Send>;
type Done = Box<dyn FnOnce() + Send>;

/// A hand on an arm that is being served: a display, a scenario or a test looks at it and changes
/// it from another task or thread, while its clients are served. [`Server::handle`] gives it.
///
/// Orders are carried out one by one, in the order in which they were given, whether their
/// [`PendingResult`] is waited for or not; orders given before the server is ready wait for that.
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
    /// Has something done on the arm's runner, which has been brought up to the present. It should
    /// be quick: the arm waits for it.
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
            // Waiting for it is optional.
            let done: Done = Box::new(move || drop(sender.send(value)));
            done
        };
        // If the server has ended, so has the answer.
        let _ = self.orders.send(Box::new(order));
        PendingResult(receiver)
    }

    /// Pulls the cable at the arm's end ([`Runner::unplug`]). When this is answered, pseudo-terminals
    /// have vanished as a USB adapter does: the path is gone, and clients have been hung up on. TCP
    /// connections are closed and new ones too, datagrams are not answered.
    pub fn unplug(&self) -> PendingResult<()> {
        self.with(Runner::unplug)
    }

    /// Puts the cable back. When this is answered, every endpoint accepts again: a pseudo-terminal
    /// is a new one, at the same path.
    pub fn plug(&self) -> PendingResult<()> {
        self.with(Runner::plug)
    }
}

/// The server ended before it came to an order, or broke down over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the arm is no longer served")]
pub struct Ended;

/// What an order came to; a future. The endpoints have followed the runner by then: what was
/// unplugged is gone, what was plugged in is there.
#[derive(Debug)]
#[must_use = "it is carried out later; only the reply tells when"]
pub struct PendingResult<T>(oneshot::Receiver<T>);

impl<T> PendingResult<T> {
    /// Waits where nothing can be awaited.
    ///
    /// # Errors
    /// [`Ended`] when the arm is no longer served.
    ///
    /// # Panics
    /// Within an asynchronous task, where it would block the runtime.
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

/// The server's end of all handles of an arm.
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

    /// Carries out the next order, if there is one; what it returns is to be called when the
    /// endpoints have followed. Wakes the task for the one after it.
    pub(super) fn carry_out_one(
        &mut self,
        cx: &mut Context<'_>,
        runner: &mut Runner,
    ) -> Option<Done> {
        let Poll::Ready(Some(order)) = self.receiver.poll_recv(cx) else {
            return None;
        };
        cx.waker().wake_by_ref();
        Some(order(runner))
    }
}
