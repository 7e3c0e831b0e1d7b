//! Build script: exports `free` of the C library that the module is linked with.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // files.wasm is built for a target without a C library.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "wasi") {
        println!("cargo::rustc-link-arg=--export=free");
    }
}
