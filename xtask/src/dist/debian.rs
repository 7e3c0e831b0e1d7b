//! Debian package of the command, for Debian, Ubuntu and Raspberry Pi OS.

use std::error::Error;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::{Compression, GzBuilder};

use super::archive::{SYSTEMD_FILES, UDEV_RULES};
use super::desktop::{ENTRY, FOLDER, ICON_NAME};
use super::output;
use super::system::{Builder, GLIBC, System};

/// Places in Debian for the files of the archive.
const INSTALLED_PATHS: [(&str, &str); 5] = [
    ("bin/magician", "usr/bin/magician"),
    (
        "completions/magician.bash",
        "usr/share/bash-completion/completions/magician",
    ),
    (
        "completions/_magician",
        "usr/share/zsh/vendor-completions/_magician",
    ),
    (
        "completions/magician.fish",
        "usr/share/fish/vendor_completions.d/magician.fish",
    ),
    (
        "licenses/THIRD-PARTY.txt",
        "usr/share/doc/magician/THIRD-PARTY.txt",
    ),
];

/// Returns the package's file name by Debian's convention.
pub(super) fn name(builder: &Builder, system: &System) -> String {
    format!(
        "magician_{}_{}.deb",
        builder.metadata.version, system.debian
    )
}

/// Builds the package from an archive's folder with `dpkg-deb`. The vendor's library is left out,
/// since its users choose its place themselves.
pub(super) fn write(
    builder: &Builder,
    system: &System,
    archives: &Path,
) -> Result<PathBuf, Box<dyn Error>> {
    let metadata = &builder.metadata;
    let from = archives.join(system.archive(&metadata.version));
    let package = archives.join(name(builder, system));
    let name = format!("debian-{}", system.debian);
    let folder = archives.join(&name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let mut places: Vec<(PathBuf, PathBuf)> = INSTALLED_PATHS
        .map(|(inside, place)| (from.join(inside), folder.join(place)))
        .into();
    places.push((
        from.join("udev").join(UDEV_RULES),
        folder.join("usr/lib/udev/rules.d").join(UDEV_RULES),
    ));
    let pictures = "usr/share/icons/hicolor/scalable/apps";
    for (file, place) in [(ENTRY, "usr/share/applications"), (ICON_NAME, pictures)] {
        places.push((from.join(FOLDER).join(file), folder.join(place).join(file)));
    }
    let [service, users] = SYSTEMD_FILES.map(|file| from.join("service").join(file));
    places.push((
        service,
        folder.join("usr/lib/systemd/system/magician.service"),
    ));
    places.push((users, folder.join("usr/lib/sysusers.d/magician.conf")));
    for (inside, place) in places {
        fs::create_dir_all(place.parent().unwrap_or(&folder))?;
        fs::copy(inside, place)?;
    }
    let pages = folder.join("usr/share/man/man1");
    fs::create_dir_all(&pages)?;
    for page in fs::read_dir(from.join("man"))? {
        let page = page?;
        let name = page.file_name().to_string_lossy().into_owned() + ".gz";
        write_gzip(&pages.join(name), &fs::read(page.path())?)?;
    }
    let docs = folder.join("usr/share/doc/magician");
    write_gzip(
        &docs.join("changelog.gz"),
        &fs::read(from.join("CHANGELOG.md"))?,
    )?;
    let licences = ["LICENSE-MIT", "LICENSE-APACHE"]
        .map(|file| fs::read_to_string(from.join("licenses").join(file)));
    let [mit, apache] = licences;
    let rule = "-".repeat(80);
    fs::write(
        docs.join("copyright"),
        format!(
            "magician, {}\n{}: either of the two licences below, at your choice.\nWhat is in it by others: THIRD-PARTY.txt\n\n\
             {rule}\n\n{}\n{rule}\n\n{}",
            metadata.repository, metadata.licence, mit?, apache?
        ),
    )?;
    let size = super::archive::files(archives, &name)?
        .iter()
        .map(|path| fs::metadata(archives.join(path)).map(|file| file.len()))
        .sum::<Result<u64, _>>()?;
    fs::create_dir_all(folder.join("DEBIAN"))?;
    fs::write(
        folder.join("DEBIAN/control"),
        control(builder, system, size.div_ceil(1024)),
    )?;
    let mut pack = Command::new("dpkg-deb");
    // Reproducible: the same bytes whenever and by whomever it is built.
    pack.env("SOURCE_DATE_EPOCH", "0");
    pack.args(["--root-owner-group", "-Zxz", "--build"]);
    output(pack.arg(&folder).arg(&package))?;
    fs::remove_dir_all(folder)?;
    Ok(package)
}

fn write_gzip(file: &Path, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let file = fs::File::create(file)?;
    let mut writer = GzBuilder::new().write(file, Compression::best());
    writer.write_all(bytes)?;
    writer.finish()?;
    Ok(())
}

fn control(builder: &Builder, system: &System, kilobytes: u64) -> String {
    let metadata = &builder.metadata;
    format!(
        "Package: magician\nVersion: {}\nArchitecture: {}\nSection: electronics\nPriority: optional\n\
         Maintainer: The magician contributors\nHomepage: {}\nInstalled-Size: {kilobytes}\nDepends: libc6 (>= {}.{}), libgcc-s1\n\
         Description: {}\n \
         Draws, engraves, teaches and runs programs on a Dobot Magician desktop arm,\n \
         or on a virtual one that answers and moves like it.\n",
        metadata.version,
        system.debian,
        metadata.repository,
        GLIBC.0,
        GLIBC.1,
        metadata.description,
    )
}

/// Installs a package into a separate root and removes it again. `meanwhile` receives the path of
/// the installed program.
pub(super) fn with_installed<T>(
    package: &Path,
    root: &Path,
    meanwhile: impl FnOnce(&Path) -> Result<T, Box<dyn Error>>,
) -> Result<T, Box<dyn Error>> {
    if root.exists() {
        fs::remove_dir_all(root)?;
    }
    // dpkg refuses a root without these parts of its database.
    for part in ["info", "updates", "triggers"] {
        fs::create_dir_all(root.join("var/lib/dpkg").join(part))?;
    }
    for file in ["status", "available"] {
        fs::write(root.join("var/lib/dpkg").join(file), "")?;
    }
    output(Command::new("dpkg-deb").arg("--info").arg(package))?;
    let dpkg = || {
        let mut dpkg = Command::new("dpkg");
        // The separate root contains no C library and may be for another processor.
        dpkg.args([
            "--force-depends,architecture,not-root,bad-path",
            "--log=/dev/null",
        ]);
        dpkg.arg(format!("--root={}", root.display()));
        dpkg
    };
    output(dpkg().arg("--install").arg(package))?;
    let done = meanwhile(&root.join("usr/bin/magician"))?;
    output(dpkg().args(["--purge", "magician"]))?;
    // Purging must remove everything below `usr`.
    let left = root.join("usr");
    if left.exists() {
        let left = super::archive::files(root, "usr")?;
        return Err(format!("left behind when the package was removed: {left:?}").into());
    }
    fs::remove_dir_all(root)?;
    Ok(done)
}
