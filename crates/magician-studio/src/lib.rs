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
    /// What it holds.
    pub bytes: &'static [u8],
    /// The same, compressed by gzip; empty for what is only kept as it is.
    pub gzip: &'static [u8],
}

macro_rules! files {
    (@gzip $file:literal) => { include_bytes!(concat!("../packed/", $file, ".gz")) };
    // Large, and seldom asked for: once in the program is enough.
    (@gzip $file:literal plain) => { &[] };
    ($($path:literal $file:literal $kind:literal $($plain:ident)?),* $(,)?) => {
        /// All files of the page.
        pub static FILES: &[File] = &[$(File {
            path: $path,
            kind: $kind,
            bytes: include_bytes!(concat!("../dist/", $file)),
            gzip: files!(@gzip $file $($plain)?),
        }),*];
    };
}

files! {
    "/" "index.html" "text/html; charset=utf-8",
    "/assets/app.js" "assets/app.js" "text/javascript; charset=utf-8",
    "/assets/arm.wasm" "assets/arm.wasm" "application/wasm" plain,
    "/assets/arms.css" "assets/arms.css" "text/css; charset=utf-8",
    "/assets/arms.js" "assets/arms.js" "text/javascript; charset=utf-8",
    "/assets/files.wasm" "assets/files.wasm" "application/wasm" plain,
    "/assets/first.json" "assets/first.json" "application/json",
    "/assets/fleet.js" "assets/fleet.js" "text/javascript; charset=utf-8",
    "/assets/icon.svg" "assets/icon.svg" "image/svg+xml",
    "/assets/io.css" "assets/io.css" "text/css; charset=utf-8",
    "/assets/io.js" "assets/io.js" "text/javascript; charset=utf-8",
    "/assets/jobs.css" "assets/jobs.css" "text/css; charset=utf-8",
    "/assets/jobs.js" "assets/jobs.js" "text/javascript; charset=utf-8",
    "/assets/plot.css" "assets/plot.css" "text/css; charset=utf-8",
    "/assets/plot.js" "assets/plot.js" "text/javascript; charset=utf-8",
    "/assets/preact.js" "assets/preact.js" "text/javascript; charset=utf-8",
    "/assets/reader.js" "assets/reader.js" "text/javascript; charset=utf-8",
    "/assets/run.js" "assets/run.js" "text/javascript; charset=utf-8",
    "/assets/scene.js" "assets/scene.js" "text/javascript; charset=utf-8",
    "/assets/settings.js" "assets/settings.js" "text/javascript; charset=utf-8",
    "/assets/shell.js" "assets/shell.js" "text/javascript; charset=utf-8",
    "/assets/teach.css" "assets/teach.css" "text/css; charset=utf-8",
    "/assets/teach.js" "assets/teach.js" "text/javascript; charset=utf-8",
    "/assets/three.js" "assets/three.js" "text/javascript; charset=utf-8",
    "/assets/worker.js" "assets/worker.js" "text/javascript; charset=utf-8",
    "/assets/world.css" "assets/world.css" "text/css; charset=utf-8",
    "/assets/world.js" "assets/world.js" "text/javascript; charset=utf-8",
    "/assets/zh.js" "assets/zh.js" "text/javascript; charset=utf-8",
    "/licences.txt" "licences.txt" "text/plain; charset=utf-8",
    "/manifest.webmanifest" "manifest.webmanifest" "application/manifest+json",
    "/sw.js" "sw.js" "text/javascript; charset=utf-8",
}

/// The file at a path.
#[must_use]
pub fn file(path: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.path == path)
}
