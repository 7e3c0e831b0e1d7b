//! A thread that cannot wait for an arm, and the one that waits in its place.
//!
//! What a thread waits with is its own. A function that runs at the end of its thread (`atexit`, a destructor) finds it gone,
//! and a signal handler finds it in use by the very call that it interrupted. Programs stop and leave their arm just there.

use std::{io, panic, thread};

use tokio::runtime::Handle;

use crate::notice;

/// Runs a body on this thread, or on another one while this one waits.
///
/// # Errors
/// There can be no other thread.
pub(crate) fn run<T: Send>(body: impl FnOnce() -> T + Send) -> io::Result<T> {
    match Handle::try_current() {
        Err(error) if error.is_missing_context() => Ok(body()),
        // Windows ends threads under a lock that a new one needs to begin.
        Err(_) if cfg!(windows) => Err(io::ErrorKind::Unsupported.into()),
        Ok(_) | Err(_) => elsewhere(body),
    }
}

/// The sentence of the last fault goes there and back.
fn elsewhere<T: Send>(body: impl FnOnce() -> T + Send) -> io::Result<T> {
    let before = notice::sentence();
    let there = || {
        notice::recall(before);
        let result = body();
        (result, notice::sentence())
    };
    thread::scope(|scope| {
        let thread = thread::Builder::new().spawn_scoped(scope, there)?;
        let (result, after) = (thread.join()).unwrap_or_else(|why| panic::resume_unwind(why));
        notice::recall(after);
        Ok(result)
    })
}

#[cfg(test)]
mod tests {
    use std::thread::current;

    use super::*;

    #[test]
    fn who_can_wait_does() {
        let here = current().id();
        assert_eq!(run(|| current().id()).unwrap(), here);
    }

    #[test]
    fn who_is_waiting_already_has_another_one_wait() {
        let runtime = tokio::runtime::Builder::new_current_thread();
        let runtime = { runtime }.build().unwrap();
        let (here, _inside) = (current().id(), runtime.enter());
        notice::recall("before".to_owned());
        let there = run(|| {
            let seen = notice::sentence();
            notice::recall("after".to_owned());
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
