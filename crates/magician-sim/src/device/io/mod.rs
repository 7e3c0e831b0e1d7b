//! What the connectors carry: pins, tools and motors (model section 13).

pub(crate) mod pins;
pub(crate) mod steppers;
pub(crate) mod tools;
