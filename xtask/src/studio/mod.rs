//! Page of a station: its types, its scripts, and the WebAssembly modules of a page without a
//! server.

pub(crate) mod api;
#[cfg(test)]
mod lint;
pub(crate) mod modules;
pub(crate) mod page;
