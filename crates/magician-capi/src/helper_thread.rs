//! Runs a call on another thread if the calling thread cannot block on the driver.
//!
//! Blocking uses thread-local state of tokio. A function that runs at the end of its thread
//! (`atexit`, a destructor) finds that state destroyed, and a signal handler finds it in use by the
//! call that it interrupted. Programs stop their arm in exactly these places, so such a call runs
//! on a helper thread while the calling thread waits for it.

use std::{io, panic, thread};

use tokio::runtime::Handle;

use crate::notice;

/// Runs `body` on this thread if it can block, otherwise on a helper thread.
///
/// # Errors
/// The helper thread cannot be started.
pub(crate) fn run<T: Send>(body: impl FnOnce() -> T + Send) -> io::Result<T> {
    match Handle::try_current() {
        Err(error) if error.is_missing_context() => Ok(body()),
        // Windows runs the end of a thread under the loader lock, which a new thread needs to
        // start: waiting for it would deadlock.
        Err(_) if cfg!(windows) => Err(io::ErrorKind::Unsupported.into()),
        Ok(_) | Err(_) => on_helper_thread(body),
    }
}

/// Runs `body` on a helper thread. The thread-local last fault is carried there and back.
fn on_helper_thread<T: Send>(body: impl FnOnce() -> T + Send) -> io::Result<T> {
    let before = notice::sentence();
    let there = || {
        notice::set_sentence(before);
        let result = body();
        (result, notice::sentence())
    };
    thread::scope(|scope| {
        let thread = thread::Builder::new().spawn_scoped(scope, there)?;
        let (result, after) = (thread.join()).unwrap_or_else(|why| panic::resume_unwind(why));
        notice::set_sentence(after);
        Ok(result)
    })
}

#[cfg(test)]
mod tests {
    use std::thread::current;

    use super::*;

    #[test]
    fn blocks_on_the_calling_thread_if_possible() {
        let here = current().id();
        assert_eq!(run(|| current().id()).unwrap(), here);
    }

    #[test]
    fn uses_a_helper_thread_inside_a_runtime() {
        let runtime = tokio::runtime::Builder::new_current_thread();
        let runtime = { runtime }.build().unwrap();
        let (here, _inside) = (current().id(), runtime.enter());
        notice::set_sentence("before".to_owned());
        let there = run(|| {
            let seen = notice::sentence();
            notice::set_sentence("after".to_owned());
            (current().id(), seen)
        });
        let (there, seen) = there.unwrap();
        assert_ne!(there, here);
        assert_eq!(
            (seen.as_str(), notice::sentence().as_str()),
            ("before", "after")
        );
    }
}
