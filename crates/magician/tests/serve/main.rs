//! Listening ends through real sockets, descriptors and files, one program: `cargo test --test serve pty::` does those of a file.

mod served;

mod discovery;
mod endpoints;
mod files;
mod handle;
#[cfg(unix)]
mod pty;
mod several;
mod shared;
