//! Import libraries, with which programs for Windows are linked to load `DobotDll.dll`.
//!
//!
//! The compiler's own import library names the file that it wrote, which is not the vendor's name.

use std::error::Error;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use ar_archive_writer::{COFFShortExport, MachineTypes, write_import_library};
use magician_capi::{FUNCTIONS, Family};

/// Writes the import library of a family twice, under the names that the linkers of Microsoft and
/// MinGW look for.
pub(super) fn write(folder: &Path, family: Family, target: &str) -> Result<(), Box<dyn Error>> {
    let (machine, prefix) = machine(target)?;
    let exports: Vec<COFFShortExport> = FUNCTIONS
        .iter()
        .filter(|function| function.families.contains(&family))
        .map(|function| export(format!("{prefix}{}", function.name)))
        .collect();
    for (name, mingw) in [("DobotDll.lib", false), ("libDobotDll.dll.a", true)] {
        let mut library = Cursor::new(Vec::new());
        write_import_library(
            &mut library,
            "DobotDll.dll",
            &exports,
            machine,
            mingw,
            false,
            &[],
        )?;
        fs::write(folder.join(name), library.into_inner())?;
    }
    Ok(())
}

/// Returns the machine type of a target, and the prefix that its C compilers put before names.
fn machine(target: &str) -> Result<(MachineTypes, &'static str), Box<dyn Error>> {
    match target.split('-').next() {
        Some("x86_64") => Ok((MachineTypes::AMD64, "")),
        Some("aarch64") => Ok((MachineTypes::ARM64, "")),
        Some("i586" | "i686") => Ok((MachineTypes::I386, "_")),
        _ => Err(format!("import libraries for {target} are not supported").into()),
    }
}

fn export(name: String) -> COFFShortExport {
    COFFShortExport {
        name,
        ext_name: None,
        symbol_name: None,
        import_name: None,
        export_as: None,
        ordinal: 0,
        noname: false,
        data: false,
        private: false,
        constant: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn import_library_names_the_vendors_file_and_every_function() {
        let folder = std::env::temp_dir().join(format!("magician-import-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        for (target, symbol) in [
            ("x86_64-pc-windows-msvc", &b"\0__imp_GetPose\0"[..]),
            ("i686-pc-windows-gnu", &b"\0__imp__GetPose\0"[..]),
            ("aarch64-pc-windows-msvc", &b"\0__imp_GetPose\0"[..]),
        ] {
            write(&folder, Family::V1, target).expect(target);
            for name in ["DobotDll.lib", "libDobotDll.dll.a"] {
                let library = fs::read(folder.join(name)).expect(name);
                let has = |part: &[u8]| library.windows(part.len()).any(|bytes| bytes == part);
                assert!(has(b"DobotDll.dll\0") && has(symbol), "{target} {name}");
                assert!(!has(b"SetSeeedRgb"), "{target} {name}");
            }
        }
        assert!(write(&folder, Family::V1, "riscv64gc-unknown-linux-gnu").is_err());
        fs::remove_dir_all(&folder).expect("the folder again");
    }
}
