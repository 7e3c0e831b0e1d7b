//! Compresses the files of the page and lists them for `src/lib.rs`.
//!
//! `page` contains the files that `cargo xtask studio` builds from the page's sources. `modules`
//! contains the WebAssembly modules that only a page without a server loads, already compressed; it
//! may be empty.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use flate2::{Compression, GzBuilder};
use sha2::{Digest, Sha256};

const SERVICE_WORKER: &str = "sw.js";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=page");
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?);

    let mut plain = BTreeMap::new();
    read(&root.join("page"), "", &mut plain)?;
    // A package that was built without modules lacks the folder. Cargo treats a missing path in
    // `rerun-if-changed` as changed, and would run this script at every build.
    let folder = root.join("modules");
    let mut packed = BTreeMap::new();
    if folder.exists() {
        println!("cargo::rerun-if-changed=modules");
        packed = modules(&folder)?;
    }
    let template = plain
        .remove(SERVICE_WORKER)
        .ok_or("page/sw.js is missing")?;
    let worker = service_worker(std::str::from_utf8(&template)?, &plain, &packed)?;
    plain.insert(SERVICE_WORKER.to_owned(), worker);
    for (name, bytes) in &plain {
        packed.insert(name.clone(), gzip(bytes)?);
    }

    let mut list = String::from("&[\n");
    for (number, (name, bytes)) in packed.iter().enumerate() {
        let path = match &**name {
            "index.html" => "",
            name => name,
        };
        let (path, kind) = (format!("/{path}"), kind(name)?);
        let file = out.join(format!("{number}.gz"));
        fs::write(&file, bytes)?;
        writeln!(
            list,
            "File {{ path: {path:?}, kind: {kind:?}, gzip: include_bytes!({file:?}) }},"
        )?;
    }
    list.push(']');
    fs::write(out.join("files.rs"), list)?;
    Ok(())
}

/// Reads all files below a folder, by their path within it.
fn read(
    folder: &Path,
    within: &str,
    files: &mut BTreeMap<String, Vec<u8>>,
) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_str().ok_or("a file name is not UTF-8")?;
        let inner = format!("{within}{name}");
        if entry.file_type()?.is_dir() {
            read(&entry.path(), &format!("{inner}/"), files)?;
        } else {
            files.insert(inner, fs::read(entry.path())?);
        }
    }
    Ok(())
}

/// Reads the compressed modules, by the path at which the page asks for them.
fn modules(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, Box<dyn Error>> {
    let mut files = BTreeMap::new();
    read(folder, "assets/", &mut files)?;
    let packed = files
        .into_iter()
        .filter_map(|(name, bytes)| Some((name.strip_suffix(".gz")?.to_owned(), bytes)));
    Ok(packed.collect())
}

/// Fills in the list of files that the service worker caches, and a build id that changes with any
/// of them.
fn service_worker(
    template: &str,
    plain: &BTreeMap<String, Vec<u8>>,
    modules: &BTreeMap<String, Vec<u8>>,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut files: BTreeMap<&str, &[u8]> = BTreeMap::new();
    for (name, bytes) in plain.iter().chain(modules) {
        files.insert(name, bytes);
    }
    let mut digest = Sha256::new();
    // Include the template: a changed worker must replace the worker that browsers have installed.
    digest.update(template);
    for (name, bytes) in &files {
        digest.update(name);
        digest.update(Sha256::digest(bytes));
    }
    let mut build = String::new();
    for byte in &digest.finalize()[..8] {
        write!(build, "{byte:02x}")?;
    }
    let names: Vec<_> = files.keys().collect();
    let mut text = template.to_owned();
    for (empty, full) in [
        ("const BUILD = \"\";", format!("const BUILD = {build:?};")),
        ("const FILES = [];", format!("const FILES = {names:?};")),
    ] {
        if !text.contains(empty) {
            return Err(format!("page/sw.js has no line {empty}").into());
        }
        text = text.replace(empty, &full);
    }
    Ok(text.into_bytes())
}

/// Compresses without file name and time, so that equal input gives equal output.
fn gzip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut gzip = GzBuilder::new().write(Vec::new(), Compression::best());
    gzip.write_all(bytes)?;
    gzip.finish()
}

/// Returns the media type of a file, from its extension.
fn kind(name: &str) -> Result<&'static str, String> {
    let end = name.rsplit_once('.').map_or("", |(_, end)| end);
    Ok(match end {
        "css" => "text/css; charset=utf-8",
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "json" => "application/json",
        "png" => "image/png",
        "svg" => "image/svg+xml",
        "txt" => "text/plain; charset=utf-8",
        "wasm" => "application/wasm",
        "webmanifest" => "application/manifest+json",
        "webp" => "image/webp",
        // A wrong media type would make browsers refuse the file, so a new one must be listed.
        _ => {
            return Err(format!(
                "{name}: the media type of such a file is not listed"
            ));
        }
    })
}
