//! Tests programs for other systems on this machine: they run, under Wine or an emulated processor
//! if necessary. For macOS, whose programs nothing here can run, their load commands are checked.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::archive::files;
use super::output;
use super::system::{Builder, Family, GLIBC, System, is_on_path};

/// Drawing for the test of a program.
const TEST_DRAWING: &str = "crates/magician-program/samples/rabbit.svg";

/// Libraries of every macOS.
const MACOS_LIBRARIES: [&str; 3] = [
    "/usr/lib/libSystem.B.dylib",
    "/usr/lib/libiconv.2.dylib",
    "/usr/lib/libcharset.1.dylib",
];

/// Tests the unpacked archive of a system. Returns how it was tested.
pub(super) fn verify_archive(
    builder: &Builder,
    system: &System,
    archive: &Path,
    room: &Path,
) -> Result<String, Box<dyn Error>> {
    if room.exists() {
        fs::remove_dir_all(room)?;
    }
    fs::create_dir_all(room)?;
    // Python unpacks zip files on every machine that builds releases; `unzip` may be missing.
    let mut unpack = match system.ending() {
        "zip" => Command::new("python3"),
        _ => Command::new("tar"),
    };
    match system.ending() {
        "zip" => unpack.args(["-m", "zipfile", "-e"]).arg(archive).arg(room),
        _ => unpack.arg("-xzf").arg(archive).arg("-C").arg(room),
    };
    output(&mut unpack)?;
    let name = system.archive(&builder.metadata.version);
    let folder = room.join(&name);
    let binaries = binaries(room, &name)?;
    for file in &binaries {
        check_binary(builder, system, file)?;
    }
    let program = folder.join("bin").join(system.program());
    let how = match system.family {
        Family::MacOs(oldest) => {
            for file in &binaries {
                check_mach_o(builder, system, file, oldest)?;
            }
            format!("not run; load commands: macOS {oldest}, its own libraries only, signed")
        }
        _ if system.triple == builder.metadata.host => {
            verify_vendor_library(builder, &folder)?;
            verify_program(builder, system, &program)? + ", a program for the vendor's library"
        }
        _ => verify_program(builder, system, &program)?,
    };
    fs::remove_dir_all(room)?;
    Ok(how)
}

/// Runs a program: its version, and a drawing on the virtual arm.
pub(super) fn verify_program(
    builder: &Builder,
    system: &System,
    program: &Path,
) -> Result<String, Box<dyn Error>> {
    let (how, runner) = runner(builder, system)?;
    let start = |words: &[&str]| -> Result<String, Box<dyn Error>> {
        let mut command = match runner.split_first() {
            Some((first, rest)) => {
                let mut command = Command::new(first);
                command.args(rest).arg(program);
                command
            }
            None => Command::new(program),
        };
        Ok(String::from_utf8(output(command.args(words))?)?)
    };
    let version = start(&["--version"])?;
    if version.trim() != format!("magician {}", builder.metadata.version) {
        return Err(format!("{}: --version says {version}", program.display()).into());
    }
    let drawing = builder.root.join(TEST_DRAWING);
    start(&["run", &drawing.display().to_string(), "--port", "sim"])?;
    Ok(format!("{how}: --version, run rabbit.svg --port sim"))
}

/// Installs the studio under Wine, uses it, and uninstalls it.
pub(super) fn verify_installer(
    builder: &Builder,
    installer: &Path,
) -> Result<String, Box<dyn Error>> {
    let script = builder.root.join("interop/installer");
    output(Command::new("python3").arg("-B").arg(script).arg(installer))?;
    Ok("Wine: installed, a house drawn, the page served, removed".to_owned())
}

/// Lets a program for the vendor's library load the one in an archive.
fn verify_vendor_library(builder: &Builder, folder: &Path) -> Result<(), Box<dyn Error>> {
    // Our Python module in place of the vendor's, on a virtual arm.
    let mut program = Command::new("python3");
    program.env("PYTHONPATH", folder.join("dobotdll/lib/dobotdll/v1"));
    program.env("MAGICIAN_PORT", "sim").arg("-B");
    let sample = "crates/magician-capi/samples/pick_and_place.py";
    output(program.arg(builder.root.join(sample))).map(drop)
}

/// Returns the command that runs programs for a system, and its name.
fn runner(
    builder: &Builder,
    system: &System,
) -> Result<(&'static str, Vec<String>), Box<dyn Error>> {
    if system.triple == builder.metadata.host {
        return Ok(("run", Vec::new()));
    }
    match system.family {
        Family::Windows => {
            let script = builder.root.join("interop/wine.py");
            let words = ["python3", "-B", &script.display().to_string()];
            Ok(("Wine", words.map(str::to_owned).into()))
        }
        _ => {
            let processor = system.triple.split('-').next().unwrap_or_default();
            let emulator = format!("qemu-{processor}-static");
            if !is_on_path(&emulator) {
                return Err(format!("no {emulator}: install qemu-user-static").into());
            }
            let root = format!("/usr/{processor}-linux-gnu");
            Ok(("qemu-user", vec![emulator, "-L".to_owned(), root]))
        }
    }
}

/// Returns the programs and libraries of an archive.
fn binaries(room: &Path, name: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let all = files(room, name)?;
    let binary = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let file = fs::symlink_metadata(path).is_ok_and(|file| file.is_file());
        file && (name.contains(".so.") || name.ends_with(".dylib") || name.ends_with(".dll"))
            || path.parent().is_some_and(|parent| parent.ends_with("bin"))
    };
    let all = all.into_iter().map(|path| room.join(path));
    Ok(all.filter(binary).collect())
}

/// Fails if a file contains a path of this machine, or if a Linux file needs a newer C library than
/// declared.
fn check_binary(builder: &Builder, system: &System, file: &Path) -> Result<(), Box<dyn Error>> {
    let bytes = fs::read(file)?;
    for place in builder.source_folders()? {
        let place = place.display().to_string();
        if find(&bytes, place.as_bytes()).next().is_some() {
            return Err(format!("{}: has {place} in it", file.display()).into());
        }
    }
    if system.family == Family::Linux
        && let Some(newest) = newest_glibc(&bytes)
        && newest > GLIBC
    {
        return Err(format!("{}: needs glibc {newest:?}", file.display()).into());
    }
    Ok(())
}

fn find<'a>(bytes: &'a [u8], words: &'a [u8]) -> impl Iterator<Item = usize> + 'a {
    let places = bytes.windows(words.len()).enumerate();
    places.filter_map(move |(at, part)| (part == words).then_some(at))
}

/// Returns the newest glibc version among the symbols in a file.
fn newest_glibc(bytes: &[u8]) -> Option<(u32, u32)> {
    const HEAD: &[u8] = b"GLIBC_";
    let versions = find(bytes, HEAD).filter_map(|at| {
        let rest = bytes.get(at + HEAD.len()..)?;
        let end = rest
            .iter()
            .position(|byte| !byte.is_ascii_digit() && *byte != b'.')?;
        let mut numbers = str::from_utf8(rest.get(..end)?).ok()?.split('.');
        Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
    });
    versions.max()
}

/// Checks the load commands of a macOS file: only system libraries, no search paths, and the
/// declared oldest macOS.
fn check_mach_o(
    builder: &Builder,
    system: &System,
    file: &Path,
    oldest: &str,
) -> Result<(), Box<dyn Error>> {
    let mut look = Command::new("python3");
    look.arg("-B").arg(builder.root.join("packaging/mach.py"));
    let printed: Value = serde_json::from_slice(&output(look.arg(file))?)?;
    let wrong = |words: String| Err(format!("{}: {words}", file.display()).into());
    for library in printed["libraries"].as_array().into_iter().flatten() {
        let library = library.as_str().unwrap_or_default();
        if !MACOS_LIBRARIES.contains(&library) {
            return wrong(format!("needs {library}, which not every Mac has"));
        }
    }
    let processor = system.triple.split('-').next().unwrap_or_default();
    if printed["processor"] != processor {
        return wrong(format!("is for {}", printed["processor"]));
    }
    if printed["oldest"] != oldest {
        return wrong(format!("asks for macOS {}", printed["oldest"]));
    }
    if printed["paths"] != Value::Array(Vec::new()) {
        return wrong(format!("looks for libraries in {}", printed["paths"]));
    }
    // Macs with Intel processors need no signature.
    if processor == "aarch64" && printed["signature"] != "" {
        return wrong(format!("its signature: {}", printed["signature"]));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::newest_glibc;

    #[test]
    fn newest_glibc_is_compared_by_number() {
        let bytes = b"\0GLIBC_2.2.5\0GLIBC_2.17\0GLIBC_2.9\0GLIBC_PRIVATE\0";
        assert_eq!(newest_glibc(bytes), Some((2, 17)));
        assert_eq!(newest_glibc(b"GCC_3.0\0"), None);
    }
}
