//! Header and library of the family, checked with a C compiler and C programs.
// Systems without `cc`, such as Windows, have other checks instead: docs/guide/PLATFORMS.md.
#![cfg(unix)]

// Makes Cargo build the shared library.
use dobotdll_v3 as _;

#[path = "../../tests/c/mod.rs"]
mod c;

c::tests!(V3, 3);
