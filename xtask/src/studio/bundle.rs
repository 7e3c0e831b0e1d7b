//! The page's bundle: built by Node, kept in the repository, embedded without Node.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::read::GzDecoder;
use flate2::{Compression, GzBuilder};
use sha2::{Digest, Sha256};

use crate::dist;

const KEPT: &str = "crates/magician-studio/packed";
/// The compiler whose modules are kept: another one makes other bytes.
const TOOLCHAIN: &str = "1.95.0";
/// Modules, and what each should have by gzip.
const MODULES: [(&str, usize); 2] = [("assets/arm.wasm", 450_000), ("assets/files.wasm", 700_000)];
const TARGETS: [&str; 2] = ["wasm32-wasip1", "wasm32-unknown-unknown"];
/// What all that a browser keeps may have, by gzip.
const KEPT_MOST: usize = 3_000_000;
/// What a browser loads first, and what it loads to show an arm: files, and bytes by gzip at most.
const SIZES: [(&str, &[&str], usize); 2] = [
    (
        "shell",
        &[
            "index.html",
            "assets/app.js",
            "assets/preact.js",
            "assets/shell.js",
            "assets/icon.svg",
            "manifest.webmanifest",
        ],
        50_000,
    ),
    (
        "live view",
        &[
            "index.html",
            "assets/app.js",
            "assets/preact.js",
            "assets/shell.js",
            "assets/icon.svg",
            "assets/scene.js",
            "assets/three.js",
            "assets/worker.js",
            "manifest.webmanifest",
        ],
        200_000,
    ),
];

type Files = BTreeMap<String, Vec<u8>>;

/// `studio [--check]`: builds the page anew; with `--check` only compares it with what is kept.
pub(crate) fn run(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let check = match words {
        [] => false,
        [word] if word == "--check" => true,
        _ => return Err("studio takes --check or nothing".into()),
    };
    super::api::write(words, root)?;
    let studio = root.join("studio");
    let made = root.join("target/studio");
    let npm = |words: &[&str]| {
        let mut npm = Command::new("npm");
        npm.args(words).current_dir(&studio);
        done(npm)
    };
    npm(&["ci", "--ignore-scripts", "--no-audit", "--no-fund"])?;
    npm(&["run", "--silent", "check"])?;
    let mut vite = Command::new("npm");
    vite.args([
        "run",
        "--silent",
        "build",
        "--",
        "--logLevel",
        "warn",
        "--outDir",
    ]);
    vite.arg(std::path::absolute(&made)?).current_dir(&studio);
    done(vite)?;
    let kept = root.join(KEPT);
    modules(root, &made, &kept)?;
    let mut built = files(&made)?;
    if !check {
        // The licences are looked up in files of the bundle, which may be new.
        write(&kept, &packed(&built)?)?;
    }
    // What both modules are made of, for the target that has more of it.
    let licences = dist::licences_of(&dist::Build {
        title: "the page of the studio",
        manifest: root.join("Cargo.toml"),
        packages: vec!["magician-studio".to_owned(), "magician-wasm".to_owned()],
        features: vec![
            "magician-wasm/module".to_owned(),
            "magician-wasm/files".to_owned(),
        ],
        target: Some("wasm32-wasip1".to_owned()),
    })?;
    built.insert("licences.txt".to_owned(), licences.into_bytes());
    let worker = fs::read_to_string(studio.join("sw.js"))?;
    built.insert("sw.js".to_owned(), service_worker(&worker, &built)?);
    plain(&built, root)?;
    let wanted = packed(&built)?;
    sizes(&wanted)?;
    if check {
        same(&files(&kept)?, &wanted)
    } else {
        Ok(write(&kept, &wanted)?)
    }
}

/// A bundle as it is kept: each file by gzip.
fn packed(files: &Files) -> std::io::Result<Files> {
    let packed = files.iter();
    let packed = packed.map(|(name, bytes)| Ok((format!("{name}.gz"), gzip(bytes)?)));
    packed.collect()
}

/// A bundle of what is kept.
fn unpacked(files: &Files) -> Result<Files, Box<dyn Error>> {
    let mut unpacked = Files::new();
    for (name, bytes) in files {
        let name = name
            .strip_suffix(".gz")
            .ok_or_else(|| format!("{name} is not packed"))?;
        let mut file = Vec::new();
        GzDecoder::new(bytes.as_slice()).read_to_end(&mut file)?;
        unpacked.insert(name.to_owned(), file);
    }
    Ok(unpacked)
}

/// Files as all that a folder holds.
fn write(folder: &Path, files: &Files) -> std::io::Result<()> {
    fs::remove_dir_all(folder).or_else(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Ok(()),
        _ => Err(error),
    })?;
    for (name, bytes) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap_or(folder))?;
        fs::write(path, bytes)?;
    }
    Ok(())
}

fn is_module(name: &str) -> bool {
    MODULES.iter().any(|(module, _)| *module == name)
}

/// Builds the modules into the bundle. Where this machine cannot make the same bytes, those that are kept stay, and it is said.
fn modules(root: &Path, made: &Path, kept: &Path) -> Result<(), Box<dyn Error>> {
    let said = |program: &str, words: &[&str]| -> Option<String> {
        let output = Command::new(program).args(words).output().ok()?;
        output
            .status
            .success()
            .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let compiler = said("rustc", &["--version"]).unwrap_or_default();
    let has_target = |target: &&str| {
        let folder = said("rustc", &["--print", "target-libdir", "--target", target]);
        folder.is_some_and(|folder| Path::new(folder.trim()).exists())
    };
    if TARGETS.iter().all(has_target) && compiler.starts_with(&format!("rustc {TOOLCHAIN} ")) {
        let mut build = Command::new(root.join("crates/magician-wasm/build"));
        build
            .arg("--out")
            .arg(std::path::absolute(made.join("assets"))?)
            .current_dir(root);
        return done(build);
    }
    println!(
        "arm.wasm and files.wasm are not built, those that are kept stay: they want rustc {TOOLCHAIN} with the targets {targets} (rustup \
            toolchain install {TOOLCHAIN} --target {targets}, then RUSTUP_TOOLCHAIN={TOOLCHAIN} cargo xtask studio)",
        targets = TARGETS.join(",")
    );
    let kept = unpacked(&files(kept)?)?;
    for (module, _) in MODULES {
        let bytes = kept
            .get(module)
            .ok_or_else(|| format!("{module} is missing"))?;
        fs::write(made.join(module), bytes)?;
    }
    Ok(())
}

/// The service worker with what it keeps, under a name that is another one for each build.
fn service_worker(source: &str, files: &Files) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut digest = Sha256::new();
    digest.update(source);
    for (name, bytes) in files {
        digest.update(name);
        digest.update(Sha256::digest(bytes));
    }
    let digest = digest.finalize();
    let build: String = digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let names: Vec<_> = files.keys().collect();
    let mut text = source.to_owned();
    for (empty, full) in [
        ("const BUILD = \"\";", format!("const BUILD = {build:?};")),
        (
            "const FILES = [];",
            format!("const FILES = {};", serde_json::to_string(&names)?),
        ),
    ] {
        if !text.contains(empty) {
            return Err(format!("studio/sw.js has no line {empty}").into());
        }
        text = text.replace(empty, &full);
    }
    Ok(text.into_bytes())
}

fn done(mut command: Command) -> Result<(), Box<dyn Error>> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?}: {status}").into()),
        Err(error) => Err(format!("{command:?}: {error}; the page is built by Node 20").into()),
    }
}

/// All files of a folder, by their path within it.
pub(super) fn files(folder: &Path) -> Result<Files, Box<dyn Error>> {
    let mut all = Files::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(within) = folders.pop() {
        let listed = folder.join(&within);
        for entry in
            fs::read_dir(&listed).map_err(|error| format!("{}: {error}", listed.display()))?
        {
            let entry = entry?;
            let path = within.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                folders.push(path);
            } else {
                let name = path.to_string_lossy().replace('\\', "/");
                all.insert(name, fs::read(entry.path())?);
            }
        }
    }
    Ok(all)
}

/// Nothing of this machine or day may be in a bundle that is compared byte for byte.
fn plain(files: &Files, root: &Path) -> Result<(), Box<dyn Error>> {
    let here = std::path::absolute(root)?;
    let here = here.to_string_lossy();
    // The modules are no text; their build looks for paths itself.
    for (name, bytes) in files.iter().filter(|(name, _)| !is_module(name)) {
        let text = String::from_utf8_lossy(bytes);
        for unwanted in ["sourceMappingURL", "\r", &*here] {
            if text.contains(unwanted) {
                return Err(format!("{name} has {unwanted:?} in it").into());
            }
        }
    }
    Ok(())
}

fn gzip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    // Without a name and a time.
    let mut gzip = GzBuilder::new().write(Vec::new(), Compression::best());
    gzip.write_all(bytes)?;
    gzip.finish()
}

/// What the files of a bundle have, packed.
fn sizes(packed: &Files) -> Result<(), Box<dyn Error>> {
    let mut too_large = Vec::new();
    for (what, names, most) in SIZES {
        let mut size = 0;
        for name in names {
            let file = packed.get(&format!("{name}.gz"));
            size += file.ok_or_else(|| format!("{name} is missing"))?.len();
        }
        println!("{what:<10} {size:>7} of {most} bytes (gzip)");
        if size > most {
            too_large.push(what);
        }
    }
    let all: usize = packed.values().map(Vec::len).sum();
    println!("{:<10} {all:>7} of {KEPT_MOST} bytes (gzip)", "offline");
    if all > KEPT_MOST {
        too_large.push("offline");
    }
    for (name, goal) in MODULES {
        if let Some(module) = packed.get(&format!("{name}.gz")) {
            let size = module.len();
            let name = name.trim_start_matches("assets/");
            println!("{name:<10} {size:>7}, the goal is {goal} bytes (gzip)");
        }
    }
    if too_large.is_empty() {
        Ok(())
    } else {
        Err(format!("too large: {}", too_large.join(", ")).into())
    }
}

fn same(kept: &Files, wanted: &Files) -> Result<(), Box<dyn Error>> {
    let names = kept.keys().chain(wanted.keys());
    let mut stale: Vec<_> = names
        .filter(|name| kept.get(*name) != wanted.get(*name))
        .collect();
    stale.sort();
    stale.dedup();
    if stale.is_empty() {
        return Ok(());
    }
    Err(format!("not what the sources make: {stale:?}; cargo xtask studio").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept() -> Files {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        files(&root.join(KEPT)).unwrap()
    }

    #[test]
    fn the_page_is_small() {
        sizes(&kept()).unwrap();
    }
}
