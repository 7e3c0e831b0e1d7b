//! WebAssembly modules of a page without a server, built by Cargo and not kept in git.

use std::env;
use std::error::Error;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::{Compression, GzBuilder};

use super::page::run_command;

const FOLDER: &str = "crates/magician-studio/modules";
/// Separator of flags in `CARGO_ENCODED_RUSTFLAGS`.
const FLAG_SEPARATOR: &str = "\x1f";

struct Module {
    /// Name of the file.
    name: &'static str,
    /// Feature of `magician-wasm` that the module is built with.
    feature: &'static str,
    target: &'static str,
    /// Goal for its size, bytes of gzip.
    goal: usize,
}

const MODULES: [Module; 2] = [
    Module {
        name: "arm.wasm",
        feature: "module",
        target: "wasm32-wasip1",
        goal: 600_000,
    },
    Module {
        name: "files.wasm",
        feature: "files",
        target: "wasm32-unknown-unknown",
        goal: 1_000_000,
    },
];

/// Builds outdated modules into the package of the page, and prints their sizes.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    let root = fs::canonicalize(root)?;
    let missing: Vec<_> = { MODULES.iter() }
        .map(|module| module.target)
        .filter(|target| !has_target(target))
        .collect();
    if !missing.is_empty() {
        let missing = missing.join(" ");
        return Err(format!("the modules need: rustup target add {missing}").into());
    }
    let flags = flags(&root)?;
    for module in &MODULES {
        let bytes = fs::read(build(module, &root, &flags)?)?;
        let packed = gzip(&bytes)?;
        print_size(module.name, packed.len(), module.goal);
        let path = root.join(FOLDER).join(format!("{}.gz", module.name));
        // Unchanged files are not rewritten: Cargo would rebuild everything that embeds them.
        if !fs::read(&path).is_ok_and(|current| current == packed) {
            fs::write(path, packed)?;
        }
    }
    Ok(())
}

/// Prints a size beside its goal. A missed goal is not an error.
pub(super) fn print_size(what: &str, size: usize, goal: usize) {
    let verdict = if size > goal { "MISSED" } else { "met" };
    println!("{what:<10} {size:>9} bytes (gzip), goal {goal}: {verdict}");
}

/// Compresses without name and time, so that equal bytes give equal files.
pub(super) fn gzip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut gzip = GzBuilder::new().write(Vec::new(), Compression::best());
    gzip.write_all(bytes)?;
    gzip.finish()
}

/// Builds one module. Returns the path of Cargo's output.
fn build(module: &Module, root: &Path, flags: &str) -> Result<PathBuf, Box<dyn Error>> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args(["rustc", "--locked", "--quiet", "--package", "magician-wasm"])
        .args(["--profile", "small", "--lib", "--features", module.feature])
        .args(["--target", module.target])
        // With other crate types there would be no optimisation across crates.
        .args(["--crate-type", "cdylib"])
        .env("CARGO_ENCODED_RUSTFLAGS", flags)
        .current_dir(root);
    run_command(command)?;
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    // The library has the same name for all features.
    Ok(target.join(module.target).join("small/arm.wasm"))
}

/// Returns compiler flags that keep paths of this machine out of a module.
fn flags(root: &Path) -> Result<String, Box<dyn Error>> {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(env::home_dir()?.join(".cargo")));
    let sysroot = rustc(&["--print", "sysroot"]).ok_or("rustc names no sysroot")?;
    let mut flags = vec![
        format!("--remap-path-prefix={}=/magician", root.display()),
        format!("--remap-path-prefix={}=/rust", sysroot.trim()),
    ];
    if let Some(home) = home {
        let registry = home.join("registry/src");
        flags.push(format!(
            "--remap-path-prefix={}=/registry",
            registry.display()
        ));
    }
    Ok(flags.join(FLAG_SEPARATOR))
}

fn has_target(target: &str) -> bool {
    let folder = rustc(&["--print", "target-libdir", "--target", target]);
    folder.is_some_and(|folder| Path::new(folder.trim()).exists())
}

/// Returns the output of the compiler, or `None` if it fails.
fn rustc(words: &[&str]) -> Option<String> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).args(words).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then_some(text)
}
