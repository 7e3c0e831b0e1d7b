#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![no_std]

/// File of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct File {
    /// Path at the server.
    pub path: &'static str,
    /// Media type, as in `Content-Type`.
    pub kind: &'static str,
    /// Content, compressed by gzip.
    pub gzip: &'static [u8],
}

/// All files of the page.
pub static FILES: &[File] = include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// WebAssembly modules of a page that has no server: the virtual arm with its station, and the
/// readers of files.
const MODULES: [&str; 2] = ["/assets/arm.wasm", "/assets/files.wasm"];

/// Returns the file at a path, or `None` if the page has no such file.
#[must_use]
pub fn file(path: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.path == path)
}

/// True if the page works without a server as well: the WebAssembly modules are among its files.
///
/// A checkout has no modules until `cargo xtask generate modules` builds them; releases and the
/// registry's package have them.
#[must_use]
pub fn works_without_server() -> bool {
    MODULES.iter().all(|path| file(path).is_some())
}
