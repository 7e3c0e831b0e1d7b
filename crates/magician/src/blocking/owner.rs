//! Background thread of a blocking connection.

use std::future::Future;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use tokio::runtime::{Builder, Handle};
use tokio::sync::oneshot;
use tokio::time::timeout;

use crate::arm::SHUTDOWN;
use crate::{Arm, Error, ErrorCode, Result};

/// Returns an error inside an async runtime, which must not be blocked.
pub(super) fn outside_async() -> Result<()> {
    match Handle::try_current() {
        Err(_) => Ok(()),
        Ok(_) => Err(Error::new(
            ErrorCode::InsideRuntime,
            "magician::blocking was called inside an async runtime; use magician::Arm there",
        )),
    }
}

/// Background thread that serves a connection between calls. Everything that must not wait for the
/// next call happens there: a stop from another thread, the end of a jog without renewal, a
/// reconnect.
///
/// It lives as long as anything that may wait on it, and then until the shutdown is done. Dropping
/// the last handle waits for its end, so that a library can be unloaded afterwards.
#[derive(Debug)]
pub(super) struct Server {
    handle: Handle,
    until: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts the thread with a connection.
    fn connecting(
        connecting: impl Future<Output = Result<Arm>> + Send + 'static,
    ) -> Result<(Self, Arm)> {
        let failed = |error| {
            let message = format!("the system cannot create a timer, poller or thread: {error}");
            Error::new(ErrorCode::PortFailed, message)
        };
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(failed)?;
        let handle = runtime.handle().clone();
        let (until, over) = oneshot::channel();
        let (tell, told) = std::sync::mpsc::sync_channel(1);
        let serve = move || {
            runtime.block_on(async {
                let connected = connecting.await;
                let ended = connected.as_ref().ok().map(Arm::ended);
                let _ = tell.send(connected);
                // The sender is dropped with the last handle, which ends this wait with an error.
                let _ = over.await;
                if let Some(ended) = ended {
                    ended.await;
                }
            });
            // A pending name lookup must not delay the end of the thread.
            runtime.shutdown_background();
        };
        let thread = thread::Builder::new().name("magician".to_owned());
        let server = Self {
            handle,
            until: Some(until),
            thread: Some(thread.spawn(serve).map_err(failed)?),
        };
        let arm = told.recv().map_err(|_| Error::closed())??;
        Ok((server, arm))
    }

    pub(super) fn block<T>(&self, call: impl Future<Output = Result<T>>) -> Result<T> {
        outside_async()?;
        self.handle.block_on(call)
    }
}

impl Drop for Server {
    /// Waits for the thread, except inside a runtime, where it ends by itself.
    fn drop(&mut self) {
        drop(self.until.take());
        if let (Ok(()), Some(thread)) = (outside_async(), self.thread.take()) {
            // A panic of the thread has been reported by its hook.
            let _ = thread.join();
        }
    }
}

/// State shared by the clones of a blocking handle.
#[derive(Debug)]
pub(super) struct Owner {
    pub(super) arm: Arm,
    pub(super) server: Arc<Server>,
}

impl Owner {
    pub(super) fn connecting(
        connecting: impl Future<Output = Result<Arm>> + Send + 'static,
    ) -> Result<Self> {
        outside_async()?;
        let (server, arm) = Server::connecting(connecting)?;
        Ok(Self {
            arm,
            server: Arc::new(server),
        })
    }

    pub(super) fn block<'a, T, F>(&'a self, call: impl FnOnce(&'a Arm) -> F) -> Result<T>
    where
        F: Future<Output = Result<T>>,
    {
        self.server.block(call(&self.arm))
    }
}

impl Drop for Owner {
    /// The last handle waits for the shutdown, except inside a runtime, where the thread completes
    /// it.
    fn drop(&mut self) {
        let arm = self.arm.clone();
        let _ = self.server.block(async {
            // Once for the stop, once for its confirmation; the driver itself waits one
            // [`SHUTDOWN`].
            let _ = timeout(2 * SHUTDOWN, arm.close()).await;
            Ok(())
        });
    }
}
