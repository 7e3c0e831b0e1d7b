//! Studio for users who double-click: a desktop entry for Linux, an application for macOS, an
//! installer for Windows.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use super::archive::{files, pack};
use super::output;
use super::system::{Builder, System, is_on_path};

/// Icon of the studio.
const ICON: &str = "studio/public/assets/icon.svg";
/// Desktop entry for Linux.
pub(super) const ENTRY: &str = "magician-studio.desktop";
/// Name of its icon.
pub(super) const ICON_NAME: &str = "magician-studio.svg";
/// Name and folder of the macOS application.
const APPLICATION: &str = "Magician Studio.app";
/// Folder for desktop files in an archive.
pub(super) const FOLDER: &str = "desktop";

/// Adds the desktop entry to the folder of an archive.
pub(super) fn add_entry(builder: &Builder, folder: &Path) -> Result<(), Box<dyn Error>> {
    let room = folder.join(FOLDER);
    fs::create_dir_all(&room)?;
    fs::copy(packaging(builder).join(ENTRY), room.join(ENTRY))?;
    fs::copy(builder.root.join(ICON), room.join(ICON_NAME))?;
    Ok(())
}

/// Returns the file name of the application or installer; `None` for systems without one.
pub(super) fn name(builder: &Builder, system: &System) -> Option<String> {
    let version = &builder.metadata.version;
    let triple = system.triple;
    match system.family {
        super::Family::Linux => None,
        super::Family::MacOs(_) => Some(format!("magician-studio-{version}-{triple}.tar.gz")),
        super::Family::Windows => Some(format!("magician-studio-{version}-x86_64-setup.exe")),
    }
}

/// Builds and packs the macOS application: the program, which opens its own window.
pub(super) fn application(
    builder: &Builder,
    system: &System,
    oldest: &str,
    archives: &Path,
) -> Result<PathBuf, Box<dyn Error>> {
    let from = archives.join(system.archive(&builder.metadata.version));
    let room = archives.join("application");
    if room.exists() {
        fs::remove_dir_all(&room)?;
    }
    let contents = room.join(APPLICATION).join("Contents");
    for part in ["MacOS", "Resources"] {
        fs::create_dir_all(contents.join(part))?;
    }
    let list = fs::read_to_string(packaging(builder).join("Info.plist.in"))?;
    let list = list.replace("@VERSION@", &builder.metadata.version);
    fs::write(
        contents.join("Info.plist"),
        list.replace("@OLDEST@", oldest),
    )?;
    fs::copy(from.join("bin/magician"), contents.join("MacOS/magician"))?;
    fs::copy(
        packaging(builder).join("studio.sh"),
        contents.join("MacOS/studio"),
    )?;
    let picture = fs::read_to_string(builder.root.join(ICON))?;
    fs::write(contents.join("Resources/studio.icns"), icns(&picture)?)?;
    for file in files(&from, "licenses")? {
        let to = contents.join("Resources").join(&file);
        fs::create_dir_all(to.parent().unwrap_or(&contents))?;
        fs::copy(from.join(&file), to)?;
    }
    let name = name(builder, system).unwrap_or_default();
    let packed = pack(&room, APPLICATION, "tar.gz")?;
    let to = archives.join(name);
    fs::rename(packed, &to)?;
    fs::remove_dir_all(room)?;
    Ok(to)
}

/// Builds the Windows installer from the folder of an archive.
pub(super) fn installer(
    builder: &Builder,
    system: &System,
    archives: &Path,
) -> Result<PathBuf, Box<dyn Error>> {
    if !is_on_path("makensis") {
        return Err("no makensis: install nsis".into());
    }
    let folder = system.archive(&builder.metadata.version);
    let from = archives.join(&folder);
    let room = archives.join("installer");
    fs::create_dir_all(&room)?;
    let icon = room.join("magician.ico");
    fs::write(&icon, ico(&fs::read_to_string(builder.root.join(ICON))?)?)?;
    let inside = files(archives, &folder)?.into_iter();
    let inside: Vec<_> = inside
        .map(|path| {
            path.strip_prefix(&folder)
                .map_or(path.clone(), Path::to_owned)
        })
        .collect();
    let (install, uninstall) = file_lists(&from, &icon, &inside);
    fs::write(room.join("install.nsh"), install)?;
    fs::write(room.join("uninstall.nsh"), uninstall)?;
    let to = archives.join(name(builder, system).unwrap_or_default());
    let mut make = Command::new("makensis");
    // Reproducible: the same bytes whenever it is built.
    make.env("SOURCE_DATE_EPOCH", "0").args(["-V2", "-WX"]);
    for (word, value) in [
        ("VERSION", builder.metadata.version.as_ref()),
        ("FROM", from.as_os_str()),
        ("LISTS", room.as_os_str()),
        ("ICON", icon.as_os_str()),
        ("OUT", to.as_os_str()),
    ] {
        let mut define = std::ffi::OsString::from(format!("-D{word}="));
        define.push(value);
        make.arg(define);
    }
    output(make.arg(packaging(builder).join("studio.nsi")))?;
    fs::remove_dir_all(room)?;
    Ok(to)
}

/// Returns the installer's lists of files to write and to delete. Folders are deleted last, and
/// only if they are empty.
fn file_lists(from: &Path, icon: &Path, inside: &[PathBuf]) -> (String, String) {
    let windows = |path: &Path| {
        let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
        parts.join("\\")
    };
    let (mut install, mut uninstall) = (String::new(), String::new());
    let mut folders = Vec::new();
    let _ = writeln!(
        install,
        "SetOutPath \"$INSTDIR\"\nFile \"{}\"",
        icon.display()
    );
    let _ = writeln!(uninstall, "Delete \"$INSTDIR\\magician.ico\"");
    for path in inside {
        let folder = path.parent().unwrap_or(Path::new(""));
        for folder in folder
            .ancestors()
            .filter(|folder| folder.iter().next().is_some())
        {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        let to = match windows(folder).as_str() {
            "" => "$INSTDIR".to_owned(),
            folder => format!("$INSTDIR\\{folder}"),
        };
        let _ = writeln!(
            install,
            "SetOutPath \"{to}\"\nFile \"{}\"",
            from.join(path).display()
        );
        let _ = writeln!(uninstall, "Delete \"$INSTDIR\\{}\"", windows(path));
    }
    // Deeper folders first, so that they are empty before their parents.
    folders.sort_by_key(|folder| std::cmp::Reverse(folder.iter().count()));
    for folder in folders {
        let _ = writeln!(uninstall, "RMDir \"$INSTDIR\\{}\"", windows(folder));
    }
    (install, uninstall)
}

fn packaging(builder: &Builder) -> PathBuf {
    builder.root.join("packaging").join(FOLDER)
}

/// Renders an SVG as PNG of this width in pixels.
fn png(svg: &str, pixels: u16) -> Result<Vec<u8>, Box<dyn Error>> {
    let tree = Tree::from_str(svg, &Options::default())?;
    let scale = f32::from(pixels) / tree.size().width();
    let mut map = Pixmap::new(pixels.into(), pixels.into()).ok_or("no pixels")?;
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut map.as_mut(),
    );
    Ok(map.encode_png()?)
}

/// Converts an icon into the macOS format: entries of a four-letter type, a length that includes
/// the header, and a PNG.
fn icns(svg: &str) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut all = Vec::new();
    for (kind, pixels) in [
        (b"ic11", 32),
        (b"ic12", 64),
        (b"ic07", 128),
        (b"ic08", 256),
        (b"ic09", 512),
    ] {
        let png = png(svg, pixels)?;
        all.extend_from_slice(kind);
        all.extend_from_slice(&u32::try_from(png.len() + 8)?.to_be_bytes());
        all.extend(png);
    }
    let mut file = b"icns".to_vec();
    file.extend_from_slice(&u32::try_from(all.len() + 8)?.to_be_bytes());
    file.extend(all);
    Ok(file)
}

/// Converts an icon into the Windows format: a directory of sizes and offsets, then the PNGs.
fn ico(svg: &str) -> Result<Vec<u8>, Box<dyn Error>> {
    let sizes = [16_u16, 32, 48, 256];
    let pictures: Result<Vec<_>, _> = sizes.iter().map(|size| png(svg, *size)).collect();
    let pictures = pictures?;
    let mut file = vec![0, 0, 1, 0];
    file.extend_from_slice(&u16::try_from(sizes.len())?.to_le_bytes());
    let mut at = 6 + 16 * sizes.len();
    for (size, picture) in sizes.iter().zip(&pictures) {
        // The format writes 256 as 0.
        let side = u8::try_from(*size).unwrap_or(0);
        file.extend_from_slice(&[side, side, 0, 0, 1, 0, 32, 0]);
        file.extend_from_slice(&u32::try_from(picture.len())?.to_le_bytes());
        file.extend_from_slice(&u32::try_from(at)?.to_le_bytes());
        at += picture.len();
    }
    file.extend(pictures.into_iter().flatten());
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uninstaller_deletes_exactly_the_installed_files() {
        let inside = ["README.txt", "bin/magician.exe", "licenses/a/b.txt"].map(PathBuf::from);
        let (install, uninstall) =
            file_lists(Path::new("/from"), Path::new("/magician.ico"), &inside);
        assert!(
            install.contains("SetOutPath \"$INSTDIR\\bin\"\nFile \"/from/bin/magician.exe\"\n")
        );
        let deleted: Vec<_> = uninstall.lines().collect();
        assert_eq!(
            deleted,
            [
                r#"Delete "$INSTDIR\magician.ico""#,
                r#"Delete "$INSTDIR\README.txt""#,
                r#"Delete "$INSTDIR\bin\magician.exe""#,
                r#"Delete "$INSTDIR\licenses\a\b.txt""#,
                r#"RMDir "$INSTDIR\licenses\a""#,
                r#"RMDir "$INSTDIR\bin""#,
                r#"RMDir "$INSTDIR\licenses""#,
            ]
        );
    }

    #[test]
    fn icon_directories_point_at_their_pictures() {
        let svg = include_str!("../../../studio/public/assets/icon.svg");
        let icon = ico(svg).expect("an icon");
        let number = |at: usize| {
            let bytes = icon[at..at + 4].try_into().expect("four bytes");
            u32::from_le_bytes(bytes) as usize
        };
        for entry in 0..4 {
            let (length, at) = (number(6 + 16 * entry + 8), number(6 + 16 * entry + 12));
            assert_eq!(&icon[at + 1..at + 4], b"PNG");
            assert!(at + length <= icon.len());
        }
        let icon = icns(svg).expect("an icon");
        let whole = u32::from_be_bytes(icon[4..8].try_into().expect("four bytes"));
        assert_eq!((&icon[..4], whole as usize), (&b"icns"[..], icon.len()));
    }
}
