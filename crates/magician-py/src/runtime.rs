use std::future::Future;
use std::sync::OnceLock;

use tokio::runtime::{Builder, Handle};
use tokio::task::AbortHandle;

/// The thread on which all connections of this process live, started with the first.
static HANDLE: OnceLock<Handle> = OnceLock::new();

fn handle() -> &'static Handle {
    HANDLE.get_or_init(|| {
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.expect("the system gives a timer and a poller");
        let handle = runtime.handle().clone();
        let serve = move || runtime.block_on(std::future::pending::<()>());
        let thread = std::thread::Builder::new().name("magician".to_owned());
        thread.spawn(serve).expect("the system gives a thread");
        handle
    })
}

/// Lets something run on that thread.
pub(crate) fn spawn(task: impl Future<Output = ()> + Send + 'static) -> AbortHandle {
    handle().spawn(task).abort_handle()
}
