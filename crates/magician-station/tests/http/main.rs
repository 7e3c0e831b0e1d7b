//! Tests of the network interface: routes, admission, tokens, sockets.
#![cfg(feature = "http")]

mod bench;
mod calls;
mod floods;
mod hostile;
mod kept;
mod link;
mod pages;
mod pairing;
mod place;
mod programs;
mod recordings;
mod remote;
mod routes;
mod sockets;
mod tls;
