//! The module as a page uses it, natively: the same code but for its addresses, on a clock that the test puts forward.

mod bench;
mod files;
mod line;
mod sim;
