//! A release archive: the command with its completions, manual pages, udev rule and licences, and the drop-in for the
//! vendor's C library.

mod licences;
mod metadata;

use std::error::Error;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::library;

pub(crate) use licences::{Build, page as licences_of, run as licences};
pub(crate) use metadata::Metadata;

/// Cargo's profile of what is shipped; its folder in `target` has the same name.
pub(crate) const PROFILE: &str = "dist";

/// Shells that completions are made for, with the name of the file that each looks for.
const SHELLS: [(&str, &str); 5] = [
    ("bash", "magician.bash"),
    ("zsh", "_magician"),
    ("fish", "magician.fish"),
    ("elvish", "magician.elv"),
    ("powershell", "_magician.ps1"),
];

/// Builds the command and writes `target/archive/magician-VERSION-TRIPLE.tar.gz`, and its checksum beside it.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    let cargo = cargo();
    run(Command::new(&cargo).current_dir(root).args([
        "build",
        "--locked",
        "--profile",
        PROFILE,
        "--package",
        "magician-cli",
    ]))?;
    let metadata = Metadata::read(&cargo, root)?;
    let magician = (metadata.target_directory.join(PROFILE))
        .join(format!("magician{}", std::env::consts::EXE_SUFFIX));
    let name = format!("magician-{}-{}", metadata.version, metadata.host);
    let archives = metadata.target_directory.join("archive");
    let folder = archives.join(&name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    for part in ["bin", "completions", "man", "udev", "licenses"] {
        fs::create_dir_all(folder.join(part))?;
    }
    let file_name = magician.file_name().unwrap_or(OsStr::new("magician"));
    fs::copy(&magician, folder.join("bin").join(file_name))?;
    for (shell, file) in SHELLS {
        let told = output(Command::new(&magician).args(["completions", shell]))?;
        fs::write(folder.join("completions").join(file), told)?;
    }
    output(Command::new(&magician).arg("man").arg(folder.join("man")))?;
    let rules = "70-magician.rules";
    fs::copy(
        root.join("packaging").join(rules),
        folder.join("udev").join(rules),
    )?;
    fs::copy(root.join("packaging/README.txt"), folder.join("README.txt"))?;
    for file in ["LICENSE-MIT", "LICENSE-APACHE", "CHANGELOG.md"] {
        let room = if file.starts_with("LICENSE") {
            "licenses"
        } else {
            ""
        };
        fs::copy(root.join(file), folder.join(room).join(file))?;
    }
    fs::write(
        folder.join("licenses/THIRD-PARTY.txt"),
        licences_of(&Build {
            title: "the magician command",
            manifest: root.join("Cargo.toml"),
            packages: vec!["magician-cli".to_owned()],
            features: Vec::new(),
            target: Some(metadata.host),
        })?,
    )?;
    library::stage(root, None, Some(&folder.join("dobotdll")))?;
    let archive = pack(&archives, &name)?;
    println!("{}", archive.display());
    Ok(())
}

/// Packs a folder, the same bytes for the same files.
fn pack(archives: &Path, name: &str) -> Result<PathBuf, Box<dyn Error>> {
    let archive = archives.join(format!("{name}.tar.gz"));
    let mut builder = tar::Builder::new(GzEncoder::new(
        fs::File::create(&archive)?,
        Compression::best(),
    ));
    builder.mode(tar::HeaderMode::Deterministic);
    builder.follow_symlinks(false);
    let mut folders = vec![PathBuf::from(name)];
    while let Some(folder) = folders.pop() {
        let mut entries: Vec<_> =
            fs::read_dir(archives.join(&folder))?.collect::<Result<Vec<_>, _>>()?;
        entries.sort_by_key(fs::DirEntry::file_name);
        for entry in entries {
            let path = folder.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                folders.push(path);
            } else {
                builder.append_path_with_name(entry.path(), &path)?;
            }
        }
    }
    builder.into_inner()?.finish()?;
    Ok(archive)
}

/// The cargo that runs this.
pub(crate) fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

pub(crate) fn run(command: &mut Command) -> Result<(), Box<dyn Error>> {
    let status = command.status()?;
    status
        .success()
        .then_some(())
        .ok_or_else(|| format!("{command:?} ended with {status}").into())
}

pub(crate) fn output(command: &mut Command) -> Result<Vec<u8>, Box<dyn Error>> {
    let told = command.output()?;
    match told.status.success() {
        true => Ok(told.stdout),
        false => Err(format!("{command:?}: {}", String::from_utf8_lossy(&told.stderr)).into()),
    }
}

#[cfg(test)]
mod tests {
    use magician::{Port, Usb};

    #[test]
    fn the_udev_rule_is_for_the_adapters_of_arms() {
        let rules = include_str!("../../../packaging/70-magician.rules");
        let id = |line: &str, key: &str| {
            let (_, rest) = line.split_once(&format!("{key}}}==\""))?;
            u16::from_str_radix(rest.get(..4)?, 16).ok()
        };
        let mut adapters = rules
            .lines()
            .filter_map(|line| Some((id(line, "idVendor")?, id(line, "idProduct")?)))
            .peekable();
        assert!(adapters.peek().is_some());
        for (vendor, product) in adapters {
            let usb = Some(Usb {
                vendor,
                product,
                ..Usb::default()
            });
            let path = String::new();
            assert!(
                Port { path, usb }.likely_arm(),
                "{vendor:04x}:{product:04x}"
            );
        }
    }
}
