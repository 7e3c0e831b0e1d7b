//! Tests of the network interface: routes, admission, tokens, sockets.
#![cfg(feature = "http")]

mod anonymous_role;
mod bench;
mod floods;
mod hostile;
mod link;
mod pages;
mod pairing;
mod programs;
mod recordings;
mod remote;
mod routes;
mod single_requests;
mod sockets;
mod stored_jobs;
mod tls;
