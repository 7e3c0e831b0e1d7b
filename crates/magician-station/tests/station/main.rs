//! Tests of a station with engines and virtual arms, in virtual time: time advances only while
//! everything waits.

mod anonymous_role;
mod bare;
mod bench;
mod class;
mod day;
mod ending;
mod examples;
mod fence;
mod history;
mod job_survival;
mod jobs;
mod jogs;
mod leases;
mod limits;
#[cfg(feature = "link")]
mod link;
mod lit_laser;
mod long_requests;
mod lost_line;
mod memory_library;
mod messages;
mod motors;
mod moves;
mod notice_rates;
mod notifications;
mod output_states;
mod presets;
mod programs;
mod recordings;
mod rights;
mod schema_check;
mod setups;
mod store;
mod stored_class;
mod surface;
mod teach;
mod tools;
mod unsaved_class;
mod watching;
mod world;
