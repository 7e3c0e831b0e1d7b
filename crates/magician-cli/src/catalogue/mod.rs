//! The commands of the protocol as people look them up: by name, with help made from the table.

mod example;
mod explain;
mod find;
mod record;

pub(crate) use explain::explain;
pub(crate) use find::{find, letters};
pub(crate) use record::{Entry, chapter_name};
