//! The verbs, a file each.

pub(crate) mod commands;
pub(crate) mod completions;
pub(crate) mod decode;
pub(crate) mod demo;
pub(crate) mod forward;
pub(crate) mod help;
pub(crate) mod inverse;
pub(crate) mod man;
pub(crate) mod sim;
pub(crate) mod version;
