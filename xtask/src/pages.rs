//! Rust programs on the repository's pages, compiled and run as doctests. They are here because
//! published crates do not include the pages.
#![cfg(doctest)]

#[doc = include_str!("../../README.md")]
struct Readme;

#[doc = include_str!("../../docs/guide/SCENARIOS.md")]
struct Scenarios;

#[doc = include_str!("../../docs/recipes/rust.md")]
struct Recipe;
