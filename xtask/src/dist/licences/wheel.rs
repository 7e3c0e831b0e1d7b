//! Writes the licence page of the Python wheel, and prints pages of builds with other features.

use std::error::Error;
use std::fs;
use std::path::Path;

use super::{Build, page};

/// Included in the wheel's `dist-info/licenses`. Kept in the repository, so that a wheel can be
/// built without xtask.
const FILE: &str = "crates/magician-py/THIRD-PARTY-LICENSES.txt";

/// `[--check]` for the wheel's page, `PACKAGE [--features LIST] [--target TRIPLE]` to print
/// another.
pub(crate) fn run(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words.as_slice() {
        [] => Ok(fs::write(root.join(FILE), page(&wheel_build(root))?)?),
        ["--check"] => check(root),
        [package, options @ ..] if !package.starts_with('-') => {
            print!("{}", page(&package_build(root, package, options)?)?);
            Ok(())
        }
        _ => Err("licences takes --check, or PACKAGE [--features LIST] [--target TRIPLE]".into()),
    }
}

fn check(root: &Path) -> Result<(), Box<dyn Error>> {
    let kept = fs::read_to_string(root.join(FILE)).unwrap_or_default();
    if kept.replace("\r\n", "\n") == page(&wheel_build(root))? {
        return Ok(());
    }
    Err(format!("{FILE} is not what is in the wheel: cargo xtask licences").into())
}

/// All platforms, because one source distribution is built for many.
pub(super) fn wheel_build(root: &Path) -> Build {
    Build {
        title: "the Python package dobot-magician",
        manifest: root.join("crates/magician-py/Cargo.toml"),
        packages: vec!["magician-py".to_owned()],
        features: Vec::new(),
        target: None,
    }
}

fn package_build(root: &Path, package: &str, options: &[&str]) -> Result<Build, Box<dyn Error>> {
    let mut build = Build {
        title: "magician",
        manifest: root.join("Cargo.toml"),
        packages: vec![package.to_owned()],
        features: Vec::new(),
        target: None,
    };
    for option in options.chunks(2) {
        match option {
            ["--features", list] => {
                let features = list.split(',').map(|name| format!("{package}/{name}"));
                build.features.extend(features);
            }
            ["--target", target] => build.target = Some((*target).to_owned()),
            _ => return Err(format!("not understood: {}", option.join(" ")).into()),
        }
    }
    Ok(build)
}
