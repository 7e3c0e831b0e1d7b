//! Many stations as one site: who is there, what all arms do, and commands to any of them.
//!
//! Nothing on a site has to live for the others to work: every station keeps its arms, their leases and their jobs.
//!
//! [`Site`] is what a program sees of it, whatever carries it; a [`Channel`] is a session with one of its stations. A
//! [`hub`] shows all arms of a site as the arms of one station.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "zenoh")]
pub mod carrier;
#[cfg(feature = "zenoh")]
pub mod certificates;
mod channel;
pub mod hub;
pub mod keys;
#[cfg(feature = "zenoh")]
pub mod message;
mod site;
mod telling;
mod view;

pub use channel::{Channel, Closed, FromStation, StationEnd, ToStation, WINDOW, carry, channel};
pub use magician_station::Roster;
pub use site::{
    ArmAt, ArmNews, Caller, Later, Site, SiteError, SiteEvent, SiteEvents, SiteTeller, StationId,
    watcher,
};
pub use telling::StateTelling;
pub use view::SiteView;

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
