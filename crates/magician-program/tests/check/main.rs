//! What a check says of a plan, held against the virtual arm that then does it.

mod bench;
mod programs;
mod report;
mod times;
