//! Endpoints through real sockets, descriptors and files, as one test program:
//! `cargo test --test serve pty::` runs those of one file.

mod served;

mod discovery;
mod endpoints;
mod files;
mod handle;
#[cfg(unix)]
mod pty;
mod several;
mod shared;
