//! Generates the parts of the Python package that are not kept in git, before maturin packs it.

mod package;

use std::env;
use std::error::Error;
use std::path::PathBuf;

/// Sources and results: a result that was deleted is generated again.
const WATCHED: [&str; 14] = [
    "build",
    "tools/blocking.py",
    "tools/dobotdll.py",
    "python/magician/aio.py",
    "python/magician/_aio_station.py",
    "../magician-capi/python/generate.py",
    "../magician-capi/python/source",
    "python/magician/_blocking.py",
    "python/magician/station.py",
    "python/magician/commands.py",
    "python/magician/alarms.py",
    "python/magician/compat/dobotdll/v1.py",
    "python/magician/compat/dobotdll/v2.py",
    "python/magician/compat/dobotdll/v3.py",
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-env-changed=PYO3_PYTHON");
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let python = env::var("PYO3_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    package::write(&root, &python)?;
    // A source distribution has no C library beside it. Cargo would take what does not exist for
    // changed, at every build.
    for path in WATCHED.iter().filter(|path| root.join(path).exists()) {
        println!("cargo::rerun-if-changed={path}");
    }
    Ok(())
}
