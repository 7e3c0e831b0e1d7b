//! The header and the library, as a C compiler and a C program see them.
// Where there is no `cc`, on Windows, other checks stand in for these: docs/guide/PLATFORMS.md.
#![cfg(unix)]

// Builds the shared library.
use dobotdll_v3 as _;

#[path = "../../tests/c/mod.rs"]
mod c;

c::tests!(V3, 3);
