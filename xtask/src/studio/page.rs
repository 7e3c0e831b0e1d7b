//! The page's scripts, styles and texts: built by Node, kept in git, and embedded without Node.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::modules;
use crate::dist;

const PAGE_FOLDER: &str = "crates/magician-studio/page";
const SHELL_FILES: &[&str] = &[
    "index.html",
    "assets/app.js",
    "assets/preact.js",
    "assets/shell.js",
    "assets/icon.svg",
    "manifest.webmanifest",
];
const VIEW_FILES: &[&str] = &[
    "assets/scene.js",
    "assets/body.js",
    "assets/three.js",
    "assets/worker.js",
];

type Files = BTreeMap<String, Vec<u8>>;

/// `studio [--check]`: builds the page; with `--check` compares it with the one kept.
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
        run_command(npm)
    };
    npm(&["ci", "--ignore-scripts", "--no-audit", "--no-fund"])?;
    npm(&["run", "--silent", "check"])?;
    if check {
        npm(&["test", "--silent"])?;
    }
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
    run_command(vite)?;
    let mut built = files(&made)?;
    let worker = fs::read(studio.join("sw.js"))?;
    built.insert("sw.js".to_owned(), worker);
    let kept = root.join(PAGE_FOLDER);
    if !check {
        // The licences are read from files of the page, which may be new.
        write(&kept, &built)?;
    }
    // The page with its modules, for the target with more dependencies.
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
    check_machine_traces(&built, root)?;
    sizes(&built)?;
    if check {
        compare(&files(&kept)?, &built)
    } else {
        Ok(write(&kept, &built)?)
    }
}

/// Replaces the content of a folder by these files.
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

pub(super) fn run_command(mut command: Command) -> Result<(), Box<dyn Error>> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?}: {status}").into()),
        Err(error) => Err(format!("{command:?}: {error}").into()),
    }
}

/// Returns all files of a folder, by their relative path.
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

/// Fails if a file contains traces of this machine, because the page is compared byte by byte.
fn check_machine_traces(files: &Files, root: &Path) -> Result<(), Box<dyn Error>> {
    let here = std::path::absolute(root)?;
    let here = here.to_string_lossy();
    for (name, bytes) in files {
        // Pictures are not text.
        let Ok(text) = std::str::from_utf8(bytes) else {
            continue;
        };
        for unwanted in ["sourceMappingURL", "\r", &*here] {
            if text.contains(unwanted) {
                return Err(format!("{name} has {unwanted:?} in it").into());
            }
        }
    }
    Ok(())
}

/// Prints the sizes of what a browser loads first, and of what it loads to show an arm, beside the
/// goals.
fn sizes(files: &Files) -> Result<(), Box<dyn Error>> {
    let view = [SHELL_FILES, VIEW_FILES].concat();
    for (what, names, goal) in [
        ("shell", SHELL_FILES, 50_000),
        ("live view", view.as_slice(), 200_000),
    ] {
        let mut size = 0;
        for name in names {
            let file = files.get(*name);
            size += modules::gzip(file.ok_or_else(|| format!("{name} is missing"))?)?.len();
        }
        modules::print_size(what, size, goal);
    }
    Ok(())
}

fn compare(kept: &Files, wanted: &Files) -> Result<(), Box<dyn Error>> {
    let names = kept.keys().chain(wanted.keys());
    let mut stale: Vec<_> = names
        .filter(|name| kept.get(*name) != wanted.get(*name))
        .collect();
    stale.sort();
    stale.dedup();
    if stale.is_empty() {
        return Ok(());
    }
    Err(format!("not what the sources make: {stale:?}; run cargo xtask studio").into())
}
