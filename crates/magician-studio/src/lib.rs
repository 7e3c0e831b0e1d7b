#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![no_std]

/// A file of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct File {
    /// Its path at the server.
    pub path: &'static str,
    /// Its type, as `Content-Type` says it.
    pub kind: &'static str,
    /// What it holds, compressed by gzip.
    pub gzip: &'static [u8],
}

/// All files of the page.
pub static FILES: &[File] = include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// The file at a path.
#[must_use]
pub fn file(path: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.path == path)
}
