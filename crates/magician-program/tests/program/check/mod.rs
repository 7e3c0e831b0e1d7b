//! What a check says of a plan, held against the virtual arm that then does it.

mod bench;
mod from_step;
mod programs;
mod report;
mod times;
