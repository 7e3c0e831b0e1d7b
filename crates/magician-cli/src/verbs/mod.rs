//! The verbs, a file each.

pub(crate) mod alarms;
pub(crate) mod commands;
pub(crate) mod completions;
pub(crate) mod conform;
pub(crate) mod decode;
pub(crate) mod demo;
pub(crate) mod enqueue;
pub(crate) mod forward;
pub(crate) mod get;
pub(crate) mod help;
pub(crate) mod home;
pub(crate) mod info;
pub(crate) mod inverse;
pub(crate) mod io;
pub(crate) mod man;
pub(crate) mod ports;
pub(crate) mod pose;
pub(crate) mod proxy;
pub(crate) mod queue;
pub(crate) mod set;
pub(crate) mod shell;
pub(crate) mod sim;
pub(crate) mod stop;
pub(crate) mod tools;
pub(crate) mod travel;
pub(crate) mod version;
