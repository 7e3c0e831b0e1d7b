//! Tests of the module as a page uses it, compiled natively: the code is the same except for
//! addresses, and the test advances the clock.

mod bench;
mod files;
mod line;
mod sim;
