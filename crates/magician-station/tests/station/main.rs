//! Tests of a station with engines and virtual arms, in virtual time: time advances only while
//! everything waits.

mod bare;
mod bench;
mod class;
mod day;
mod ending;
mod examples;
mod fence;
mod jobs;
mod jogs;
mod kept_class;
mod leases;
mod life;
mod limits;
#[cfg(feature = "link")]
mod link;
mod lit;
mod messages;
mod motors;
mod moves;
mod newest;
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
mod unkept;
mod watching;
mod world;
