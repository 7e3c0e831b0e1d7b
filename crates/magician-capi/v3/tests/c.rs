//! The header and the library, as a C compiler and a C program see them.
// Where there is no `cc`, on Windows, other checks stand in for these: docs/PLATFORMS.md.
#![cfg(unix)]

use magician_capi::Family;

// Builds the shared library.
use dobotdll_v3 as _;

#[path = "../../tests/c/mod.rs"]
mod c;

const SUBJECT: c::Subject = c::Subject {
    family: Family::V3,
    number: 3,
};

#[test]
fn layouts_are_the_vendors() {
    SUBJECT.layouts_are_the_vendors();
}

#[test]
fn prototypes_are_those_of_the_table() {
    SUBJECT.prototypes_are_those_of_the_table();
}

#[test]
fn a_program_has_its_session() {
    SUBJECT.a_program_has_its_session();
}

#[test]
fn a_program_leaves_its_arm_at_its_end() {
    SUBJECT.a_program_leaves_its_arm_at_its_end();
}
