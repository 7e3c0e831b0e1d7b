//! What the controller keeps: settings until the next reset, and its flash without power (model section 6).

pub(crate) mod flash;
pub(crate) mod settings;
