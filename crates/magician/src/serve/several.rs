use std::ffi::OsString;
use std::future::{Future, poll_fn};
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::task::Poll;

use tokio::task::unconstrained;

use super::arm::Arm;
use super::wake::WakeSet;
use super::{ServeError, Server};

/// Serves several arms in one future, each with its own endpoints; see [`Server::number`] and
/// [`Identity::numbered`](magician_sim::Identity::numbered) for arms that differ by their number alone. Every
/// [`on_ready`](Server::on_ready) is called, in order, when every endpoint of every arm accepts.
///
/// # Errors
/// As [`Server::serve_until`]: if one arm's endpoint cannot be opened, none stays open and nothing
/// is ready; if one breaks down, all end. A recording that is not whole is an error at the end.
pub async fn serve_all(
    servers: impl IntoIterator<Item = Server>,
    end: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let servers: Vec<Server> = servers.into_iter().collect();
    // What is certain to fail does so before anything is touched.
    servers.iter().try_for_each(Server::check)?;
    let house = WakeSet::new();
    let open = |server| Arm::open(server, house.clone());
    let mut arms = (servers.into_iter().map(open)).collect::<Result<Vec<Arm>, _>>()?;
    arms.iter_mut().for_each(Arm::ready);
    let mut end = pin!(end);
    // Turns are bounded here. The runtime's own bound would look like a full socket.
    let served = unconstrained(poll_fn(|cx| {
        if end.as_mut().poll(cx).is_ready() {
            return Poll::Ready(Ok(()));
        }
        house.listen(cx.waker());
        match arms.iter_mut().try_for_each(Arm::answer_bell) {
            Ok(()) => Poll::Pending,
            Err(error) => Poll::Ready(Err(error)),
        }
    }))
    .await;
    // Each in its turn, whatever becomes of the others; the first error is the one to tell.
    arms.into_iter().map(Arm::end).fold(served, Result::and)
}

/// The path of one arm of several: `arm.3` for `arm` and 3.
#[must_use]
pub fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut path = OsString::from(path);
    path.push(format!(".{number}"));
    path.into()
}
