//! The world told by hand: courses are closures here.
