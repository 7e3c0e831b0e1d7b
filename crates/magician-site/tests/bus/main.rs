//! Stations and an observer on a network within this machine: with certificates, without them, and
//! with strangers on the network.

mod bench;
mod presence;
mod revoked;
mod roster;
mod sessions;
mod stranger;
