//! The Rust programs on the repository's pages, which are compiled and run with the tests: here, because what goes to the registry has no
//! pages beside it.
#![cfg(doctest)]

#[doc = include_str!("../../README.md")]
struct Readme;

#[doc = include_str!("../../docs/guide/SCENARIOS.md")]
struct Scenarios;

#[doc = include_str!("../../docs/recipes/rust.md")]
struct Recipe;
