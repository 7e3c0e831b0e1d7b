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
mod stored_class;
mod leases;
mod job_survival;
mod limits;
#[cfg(feature = "link")]
mod link;
mod lit_laser;
mod messages;
mod motors;
mod moves;
mod notice_rates;
mod notifications;
mod anonymous_role;
mod presets;
mod programs;
mod recordings;
mod rights;
mod history;
mod setups;
mod memory_library;
mod lost_line;
mod store;
mod surface;
mod teach;
mod output_states;
mod tools;
mod long_requests;
mod schema_check;
mod unsaved_class;
mod watching;
mod world;
