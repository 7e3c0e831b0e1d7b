//! Release archive: the command with completions, manual pages and licences, and the replacement
//! for the vendor's C library.

use std::error::Error;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;
use zip::write::SimpleFileOptions;

use super::system::{Builder, Family, RELEASE_PACKAGE, System};
use super::{Build, desktop, licences_of, output};
use crate::library;

/// Shells with completions, and the file name that each expects.
const SHELLS: [(&str, &str); 5] = [
    ("bash", "magician.bash"),
    ("zsh", "_magician"),
    ("fish", "magician.fish"),
    ("elvish", "magician.elv"),
    ("powershell", "_magician.ps1"),
];

/// udev rules that let every user of a Linux computer open an arm.
pub(super) const UDEV_RULES: &str = "70-magician.rules";

/// systemd unit that starts a station when Linux boots, and the user that the station runs as.
pub(super) const SYSTEMD_FILES: [&str; 2] = ["magician.service", "magician.sysusers"];

/// Lays out a system's archive in a folder of the same name and packs it. `local_command` is a
/// `magician` built for this machine; it generates the completions and manual pages.
pub(super) fn write(
    builder: &Builder,
    system: &System,
    local_command: &Path,
    archives: &Path,
) -> Result<PathBuf, Box<dyn Error>> {
    let built = builder.release(system, &["magician-cli"])?;
    let name = system.archive(&builder.metadata.version);
    let folder = archives.join(&name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let subfolder = |part: &str| {
        let subfolder = folder.join(part);
        fs::create_dir_all(&subfolder).map(|()| subfolder)
    };
    fs::copy(
        built.join(system.program()),
        subfolder("bin")?.join(system.program()),
    )?;
    let completions = subfolder("completions")?;
    for (shell, file) in SHELLS {
        let printed = output(Command::new(local_command).args(["completions", shell]))?;
        fs::write(completions.join(file), printed)?;
    }
    output(
        Command::new(local_command)
            .arg("man")
            .arg(subfolder("man")?),
    )?;
    let packaging = builder.root.join("packaging");
    if system.family == Family::Linux {
        fs::copy(
            packaging.join(UDEV_RULES),
            subfolder("udev")?.join(UDEV_RULES),
        )?;
        desktop::add_entry(builder, &folder)?;
    }
    // Files that start a station with the computer.
    let services: &[&str] = match system.family {
        Family::Linux => &SYSTEMD_FILES,
        Family::MacOs(_) => &["local.magician.serve.plist"],
        Family::Windows => &[],
    };
    for file in services {
        fs::copy(
            packaging.join("service").join(file),
            subfolder("service")?.join(file),
        )?;
    }
    fs::copy(packaging.join("README.txt"), folder.join("README.txt"))?;
    fs::copy(
        builder.root.join("CHANGELOG.md"),
        folder.join("CHANGELOG.md"),
    )?;
    let licences = subfolder("licenses")?;
    for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(builder.root.join(file), licences.join(file))?;
    }
    fs::write(
        licences.join("THIRD-PARTY.txt"),
        licences_of(&Build {
            title: "the magician command",
            manifest: builder.root.join("Cargo.toml"),
            packages: vec![RELEASE_PACKAGE.0.to_owned()],
            features: vec![RELEASE_PACKAGE.1.to_owned()],
            target: Some(system.triple.to_owned()),
        })?,
    )?;
    library::stage_release(builder, system, &folder.join("dobotdll"))?;
    pack(archives, &name, system.ending())
}

/// Packs a folder reproducibly: equal files give equal bytes.
pub(super) fn pack(archives: &Path, name: &str, ending: &str) -> Result<PathBuf, Box<dyn Error>> {
    let archive = archives.join(format!("{name}.{ending}"));
    let file = File::create(&archive)?;
    match ending {
        "zip" => write_zip(archives, name, file)?,
        _ => write_tar(archives, name, file)?,
    }
    Ok(archive)
}

fn write_tar(archives: &Path, name: &str, file: File) -> Result<(), Box<dyn Error>> {
    let mut builder = tar::Builder::new(GzEncoder::new(file, Compression::best()));
    builder.mode(tar::HeaderMode::Deterministic);
    builder.follow_symlinks(false);
    for path in files(archives, name)? {
        builder.append_path_with_name(archives.join(&path), &path)?;
    }
    builder.into_inner()?.finish()?;
    Ok(())
}

fn write_zip(archives: &Path, name: &str, file: File) -> Result<(), Box<dyn Error>> {
    let mut writer = zip::ZipWriter::new(file);
    for path in files(archives, name)? {
        let bytes = fs::read(archives.join(&path))?;
        // Zip paths have slashes on every system. Zip requires a time, so the default is used, the
        // earliest that it can express.
        let inside: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
        writer.start_file(inside.join("/"), SimpleFileOptions::default())?;
        writer.write_all(&bytes)?;
    }
    writer.finish()?;
    Ok(())
}

/// Returns all files below a folder, sorted; links count as files.
pub(super) fn files(root: &Path, name: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let (mut all, mut folders) = (Vec::new(), vec![PathBuf::from(name)]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root.join(&folder))? {
            let entry = entry?;
            let path = folder.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                folders.push(path)
            } else {
                all.push(path)
            }
        }
    }
    all.sort();
    Ok(all)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::pack;

    fn folder() -> tempfile::TempDir {
        let home = tempfile::tempdir().expect("a folder");
        let inner = home.path().join("magician-1/bin");
        fs::create_dir_all(&inner).expect("a folder in it");
        fs::write(inner.join("magician.exe"), "MZ").expect("a file");
        fs::write(home.path().join("magician-1/README.txt"), "read me").expect("a file");
        home
    }

    #[test]
    fn equal_folders_pack_to_equal_bytes() {
        for ending in ["zip", "tar.gz"] {
            let packed = [folder(), folder()].map(|home| {
                let archive = pack(home.path(), "magician-1", ending).expect("packed");
                fs::read(archive).expect("an archive")
            });
            assert_eq!(packed[0], packed[1], "{ending}");
        }
    }

    #[test]
    fn zip_entries_are_below_one_folder_with_slashes() {
        let home = folder();
        let archive = pack(home.path(), "magician-1", "zip").expect("packed");
        let file = fs::File::open(archive).expect("a file");
        let mut archive = zip::ZipArchive::new(file).expect("an archive");
        let names = (0..archive.len()).map(|at| {
            let entry = archive.by_index(at).expect("an entry");
            entry.name().expect("UTF-8").into_owned()
        });
        assert_eq!(
            names.collect::<Vec<_>>(),
            ["magician-1/README.txt", "magician-1/bin/magician.exe"]
        );
    }
}
