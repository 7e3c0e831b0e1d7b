//! Several served arms in one future.

use std::ffi::OsString;
use std::future::{Future, poll_fn};
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::task::Poll;

use tokio::task::unconstrained;

use super::arm::Arm;
use super::wake::WakeSet;
use super::{ServeError, Server};

/// Serves several arms in one future, each with its own endpoints; see [`Server::number`], and
/// [`Identity::numbered`](magician_sim::Identity::numbered) for arms that differ only by number.
///
/// Once every endpoint of every arm accepts, each [`on_ready`](Server::on_ready) is called, in
/// order.
///
/// # Errors
/// Same as [`Server::serve_until`]. If an endpoint of one arm cannot be opened, none stays open and
/// no arm is ready; if one fails, all end. An incomplete recording is an error at the end.
pub async fn serve_all(
    servers: impl IntoIterator<Item = Server>,
    end: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let servers: Vec<Server> = servers.into_iter().collect();
    // Predictable errors are found before anything is changed.
    servers.iter().try_for_each(Server::check)?;
    let wake_set = WakeSet::new();
    let open = |server| Arm::open(server, wake_set.clone());
    let mut arms = (servers.into_iter().map(open)).collect::<Result<Vec<Arm>, _>>()?;
    arms.iter_mut().for_each(Arm::ready);
    let mut end = pin!(end);
    // The work per round is bounded here. The runtime's own budget would look like a full socket.
    let served = unconstrained(poll_fn(|cx| {
        if end.as_mut().poll(cx).is_ready() {
            return Poll::Ready(Ok(()));
        }
        wake_set.listen(cx.waker());
        match arms.iter_mut().try_for_each(Arm::answer_bell) {
            Ok(()) => Poll::Pending,
            Err(error) => Poll::Ready(Err(error)),
        }
    }))
    .await;
    // Each ends regardless of the others; the first error is returned.
    arms.into_iter().map(Arm::end).fold(served, Result::and)
}

/// Returns the path of one arm of several: `arm.3` for `arm` and 3.
#[must_use]
pub fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut path = OsString::from(path);
    path.push(format!(".{number}"));
    path.into()
}
