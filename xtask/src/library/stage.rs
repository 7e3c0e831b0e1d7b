//! Lays out the replacement library as it is installed, in a folder that serves as a prefix.
//!
//! ```text
//! include/dobotdll/v1/DobotDll.h, DobotType.h
//! lib/dobotdll/v1/libDobotDll.so -> .so.1 -> .so.1.0 -> .so.1.0.0     libDobotDll.dylib     DobotDll.dll
//! lib/dobotdll/v1/DobotDllType.py
//! lib/dobotdll/studio.py
//! lib/pkgconfig/dobotdll.pc, dobotdll-v2.pc, dobotdll-v3.pc
//! share/dobotdll/examples, licenses
//! install-dobotdll
//! ```

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use magician_capi::Family;
use magician_capi::headers::headers;

use super::import;
use crate::dist::{self, Builder, ReleaseSystem};

const PACKAGES: [&str; 3] = ["magician-capi-v1", "magician-capi-v2", "magician-capi-v3"];
const FAMILIES: [(&str, Family); 3] = [("v1", Family::V1), ("v2", Family::V2), ("v3", Family::V3)];

/// Interpreter that runs the generators of Python files.
pub(crate) const PYTHON: &str = "python3";
/// Script that installs the folder at its final place.
const INSTALLER: &str = "install-dobotdll";

/// Builds the libraries for a target, by default this machine, and lays everything out. Returns the
/// folder.
pub(crate) fn stage(
    root: &Path,
    target: Option<&str>,
    folder: Option<&Path>,
) -> Result<PathBuf, Box<dyn Error>> {
    let builder = Builder::new(root, dist::PROFILE)?;
    let built = builder.plain(target, &PACKAGES)?;
    let target = target.unwrap_or(&builder.metadata.host);
    let folder = folder.map_or_else(
        || {
            let libraries = builder.metadata.target_directory.join("vendor-library");
            libraries.join(target)
        },
        Path::to_path_buf,
    );
    finish(&builder, &built, target, &folder)?;
    Ok(folder)
}

/// Builds the libraries with the settings of a release, and lays everything out in a folder.
pub(crate) fn stage_release(
    builder: &Builder,
    system: &ReleaseSystem,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    let built = builder.release(system, &PACKAGES)?;
    finish(builder, &built, system.triple, folder)
}

fn finish(
    builder: &Builder,
    built: &Path,
    target: &str,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    let root = &builder.root;
    lay_out(root, built, target, &builder.metadata.version, folder)?;
    let page = dist::licences_of(&dist::Build {
        title: "the drop-in for the vendor's library DobotDll",
        manifest: root.join("Cargo.toml"),
        packages: PACKAGES.map(str::to_owned).into(),
        features: Vec::new(),
        target: Some(target.to_owned()),
    })?;
    fs::write(folder.join("share/dobotdll/licenses/THIRD-PARTY.txt"), page)?;
    Ok(())
}

fn lay_out(
    root: &Path,
    built: &Path,
    target: &str,
    version: &str,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    for part in ["include/dobotdll", "lib/dobotdll", "share/dobotdll"] {
        let part = folder.join(part);
        if part.exists() {
            fs::remove_dir_all(part)?;
        }
    }
    let door = root.join("crates/magician-capi");
    let packages = folder.join("lib/pkgconfig");
    fs::create_dir_all(&packages)?;
    for (name, family) in FAMILIES {
        let library = folder.join("lib/dobotdll").join(name);
        fs::create_dir_all(&library)?;
        copy_library(built, name, target, &library)?;
        if target.contains("windows") {
            import::write(&library, family, target)?;
        }
        let (package, text) = package(name, target, version);
        fs::write(packages.join(package), text)?;
    }
    write_headers(&folder.join("include/dobotdll"))?;
    if let Err(error) = write_python(root, &folder.join("lib/dobotdll")) {
        // Programs in C need no Python.
        println!("DobotDllType.py is left out: {error}");
    }
    // The module looks for the families in its own folder.
    fs::copy(
        door.join("python/studio.py"),
        folder.join("lib/dobotdll/studio.py"),
    )?;
    let share = folder.join("share/dobotdll");
    fs::create_dir_all(share.join("licenses"))?;
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(root.join(licence), share.join("licenses").join(licence))?;
    }
    let examples = share.join("examples");
    fs::create_dir_all(&examples)?;
    for ending in ["c", "cpp", ""] {
        copy_files(&door.join("examples"), &examples, ending)?;
    }
    fs::copy(
        root.join("packaging").join(INSTALLER),
        folder.join(INSTALLER),
    )?;
    Ok(())
}

/// Writes the C headers, one folder per family.
pub(crate) fn write_headers(folder: &Path) -> std::io::Result<()> {
    for (name, family) in FAMILIES {
        let folder = folder.join(name);
        fs::create_dir_all(&folder)?;
        for (header, text) in headers(family) {
            fs::write(folder.join(header), text)?;
        }
    }
    Ok(())
}

/// Writes `DobotDllType.py`, one folder per family.
pub(crate) fn write_python(root: &Path, folder: &Path) -> Result<(), Box<dyn Error>> {
    let generator = root.join("crates/magician-capi/python/generate.py");
    let mut command = Command::new(PYTHON);
    let status = command.arg("-B").arg(generator).arg(folder).status();
    match status.map_err(|error| format!("{PYTHON}: {error}"))? {
        status if status.success() => Ok(()),
        status => Err(format!("generate.py: {status}").into()),
    }
}

/// Writes the import libraries of a target, one folder per family.
pub(super) fn imports(target: &str, folder: &Path) -> Result<(), Box<dyn Error>> {
    for (name, family) in FAMILIES {
        let folder = folder.join(name);
        fs::create_dir_all(&folder)?;
        import::write(&folder, family, target)?;
    }
    Ok(())
}

/// Copies the library under the vendor's names.
fn copy_library(built: &Path, family: &str, target: &str, to: &Path) -> Result<(), Box<dyn Error>> {
    if target.contains("windows") {
        fs::copy(
            built.join(format!("dobotdll_{family}.dll")),
            to.join("DobotDll.dll"),
        )?;
        return Ok(());
    }
    let (suffix, names): (_, &[&str]) = if target.contains("apple") {
        ("dylib", &["libDobotDll.1.0.0.dylib", "libDobotDll.dylib"])
    } else {
        (
            "so",
            &[
                "libDobotDll.so.1.0.0",
                "libDobotDll.so.1.0",
                "libDobotDll.so.1",
                "libDobotDll.so",
            ],
        )
    };
    let from = built.join(format!("libdobotdll_{family}.{suffix}"));
    fs::copy(from, to.join(names[0]))?;
    for link in &names[1..] {
        symbolic_link(names[0], &to.join(link))?;
    }
    Ok(())
}

#[cfg(unix)]
fn symbolic_link(name: &str, link: &Path) -> std::io::Result<()> {
    std::os::unix::fs::symlink(name, link)
}

/// Creating links on Windows needs a privilege, and this library is for another system, so the file
/// is copied.
#[cfg(not(unix))]
fn symbolic_link(name: &str, link: &Path) -> std::io::Result<()> {
    fs::copy(link.with_file_name(name), link).map(drop)
}

/// Returns name and text of a family's pkg-config file; `v1` has the plain name. It works in place;
/// the installer makes its prefix absolute. Quotes allow blanks in the prefix.
fn package(family: &str, target: &str, version: &str) -> (String, String) {
    let name = match family {
        "v1" => "dobotdll".to_owned(),
        other => format!("dobotdll-{other}"),
    };
    let ids = match family {
        "v1" => "functions without ids",
        "v2" => "functions with a dobotId",
        _ => "functions with master and slave ids",
    };
    // The library is in a separate folder, where the loader does not search.
    let path = if target.contains("windows") {
        ""
    } else {
        " -Wl,-rpath,\"${libdir}\""
    };
    let text = format!(
        "prefix=${{pcfiledir}}/../..\n\
         libdir=${{prefix}}/lib/dobotdll/{family}\n\
         includedir=${{prefix}}/include/dobotdll/{family}\n\
         \n\
         Name: DobotDll\n\
         Description: The vendor's C interface to the Dobot Magician arm, {ids}\n\
         Version: {version}\n\
         Cflags: -I\"${{includedir}}\"\n\
         Libs: -L\"${{libdir}}\" -lDobotDll{path}\n"
    );
    (format!("{name}.pc"), text)
}

/// Copies the files with an extension, sorted by name.
fn copy_files(from: &Path, to: &Path, ending: &str) -> Result<(), Box<dyn Error>> {
    let entries = fs::read_dir(from).map_err(|error| format!("{}: {error}", from.display()))?;
    for entry in entries {
        let path = entry?.path();
        let Some(name) = path.file_name().filter(|_| path.is_file()) else {
            continue;
        };
        if path.extension().unwrap_or_default() == ending {
            fs::copy(&path, to.join(name))?;
        }
    }
    Ok(())
}
