//! The page of a station: its types, and its bundle.

pub(crate) mod api;
pub(crate) mod bundle;
#[cfg(test)]
mod lint;
