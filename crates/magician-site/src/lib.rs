//! Many stations shown as one site: a list of all arms, their states, and commands to any of them.
//!
//! A *site* is a set of stations on one network. There is no central server: each station keeps its
//! own arms, leases and jobs, so if one computer goes down the others keep working.
//!
//! [`Site`] is the interface that programs use, independent of the transport. A [`Channel`] is a
//! session with one station. A [`hub`] is a gateway: it shows all arms of a site to ordinary
//! clients as if one station had them. The only transport here is zenoh, behind the feature of that
//! name: `carrier` announces arms on a bus and dials stations by TLS, and `certificates` lets the
//! members of a site recognise each other.
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
mod throttle;
mod view;

pub use channel::{Channel, Closed, FromStation, StationEnd, ToStation, WINDOW, carry, channel};
pub use magician_station::Roster;
pub use site::{
    ArmAt, ArmReport, BoxFuture, Caller, Site, SiteError, SiteEvent, SiteEventSender, SiteEvents,
    StationId, event_channel,
};
pub use throttle::StateThrottle;
pub use view::SiteView;

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
