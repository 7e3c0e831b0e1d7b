//! The `magician` command.

fn main() {}
