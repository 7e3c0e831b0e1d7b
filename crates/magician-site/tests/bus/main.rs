//! Stations and a program that looks at them, over a network of this machine: with certificates of
//! the site, without, and with strangers on it.

mod bench;
mod presence;
mod revoked;
mod roster;
mod sessions;
mod stranger;
