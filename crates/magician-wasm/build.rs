//! The module exports `free` of the C library that it is linked with.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // files.wasm has no C library.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "wasi") {
        println!("cargo::rustc-link-arg=--export=free");
    }
}
