//! Generates those parts of the Python package that are not kept in git, before maturin packs it.

mod package;

use std::env;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Sources of generated files.
const SOURCES: [&str; 7] = [
    "build",
    "tools/blocking.py",
    "tools/dobotdll.py",
    "python/magician/aio.py",
    "python/magician/_aio_station.py",
    "../magician-capi/python/generate.py",
    "../magician-capi/python/source",
];

/// Generated files.
const RESULTS: [&str; 7] = [
    "python/magician/_blocking.py",
    "python/magician/station.py",
    "python/magician/commands.py",
    "python/magician/alarms.py",
    "python/magician/compat/dobotdll/v1.py",
    "python/magician/compat/dobotdll/v2.py",
    "python/magician/compat/dobotdll/v3.py",
];

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    if !root.join("python").exists() {
        return check_distribution(&root);
    }
    println!("cargo::rerun-if-env-changed=PYO3_PYTHON");
    let python = env::var("PYO3_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    package::write(&root, &python)?;
    // Watch the results too, so that a deleted one is generated again.
    for path in SOURCES.iter().chain(&RESULTS) {
        println!("cargo::rerun-if-changed={path}");
    }
    Ok(())
}

/// Checks that a source distribution contains the generated files. There the package lies beside
/// the crate.
fn check_distribution(root: &Path) -> Result<(), Box<dyn Error>> {
    let package = root.join("..");
    for path in RESULTS {
        println!("cargo::rerun-if-changed=../{path}");
        if !package.join(path).exists() {
            return Err(format!(
                "{path} is missing: make the source distribution after `cargo xtask generate python`"
            )
            .into());
        }
    }
    Ok(())
}
