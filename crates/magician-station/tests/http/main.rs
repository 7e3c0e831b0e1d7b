//! Tests of the network interface: routes, admission, tokens, sockets.
#![cfg(feature = "http")]

mod bench;
mod single_requests;
mod floods;
mod hostile;
mod stored_jobs;
mod link;
mod pages;
mod pairing;
mod anonymous_role;
mod programs;
mod recordings;
mod remote;
mod routes;
mod sockets;
mod tls;
