//! Plans as values: their commands, their files, what becomes of them.

mod actions;
mod file;
mod schema;
mod strategies;
mod transform;
