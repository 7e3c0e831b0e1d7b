//! Plans as values: their commands, files and transformations.

mod actions;
mod file;
mod schema;
mod strategies;
mod transform;
