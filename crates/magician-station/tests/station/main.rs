//! A station, its engines and virtual arms, in virtual time: the clients are tests, time passes when nothing else is to be done.

mod bare;
mod bench;
mod class;
mod day;
mod ending;
mod examples;
mod fence;
mod jobs;
mod jogs;
mod leases;
mod life;
mod limits;
#[cfg(feature = "link")]
mod link;
mod messages;
mod motors;
mod moves;
mod notifications;
mod place;
mod presets;
mod programs;
mod recordings;
mod rights;
mod ring;
mod setups;
mod shelf;
mod stale;
mod store;
mod surface;
mod teach;
mod told;
mod tools;
mod turns;
mod typed;
mod watching;
mod world;
