//! Builds releases: for each of five systems an archive with the command, its completions, manual
//! pages and licences, and the replacement for the vendor's C library; Debian packages; manifests
//! for Homebrew and winget. Everything is tested as far as this machine can.

mod archive;
mod debian;
mod desktop;
mod licences;
mod manifests;
mod metadata;
mod publish;
mod selection;
mod system;
mod verification;

use std::error::Error;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest, Sha256};

use manifests::BuiltArchive;
use selection::Selection;
use system::{Family, System};

use crate::studio::modules;

pub(crate) use licences::{Build, page as licences_of, run as licences};
pub(crate) use metadata::Metadata;
pub(crate) use publish::publish;
pub(crate) use system::{Builder, System as ReleaseSystem};

/// Cargo profile of releases; its folder in `target` has the same name.
pub(crate) const PROFILE: &str = "dist";

/// Line of the final table: a file, or the reason for its absence.
struct Row {
    name: String,
    /// Size in bytes, SHA-256 in hex, and how the file was tested.
    made: Result<(u64, String, String), String>,
}

/// `dist [--only TRIPLE].. [--skip TRIPLE].. [--profile NAME]`: builds a release in
/// `target/archive`, and prints a table of its files and how they were tested.
///
/// # Errors
/// Returns an error if a requested file could not be built or tested.
pub(crate) fn run_release(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let selection = Selection::read(words)?;
    modules::write(root)?;
    let builder = Builder::new(&root.canonicalize()?, &selection.profile)?;
    let archives = builder.metadata.target_directory.join("archive");
    if archives.exists() {
        fs::remove_dir_all(&archives)?;
    }
    fs::create_dir_all(&archives)?;
    let local_command = local_command(&builder, &selection)?;
    let (mut rows, mut made) = (Vec::new(), Vec::new());
    for system in &selection.systems {
        eprintln!("--- {}", system.triple);
        build_release(
            &builder,
            system,
            &local_command,
            &archives,
            &mut rows,
            &mut made,
        );
    }
    for name in manifests::write(&builder.metadata, &made, &archives)? {
        let how_tested = "names the archives above".to_owned();
        rows.push(row(&name, file(&archives.join(&name), how_tested)));
    }
    print!("{}", table(&rows));
    let sums = rows.iter().filter_map(|row| match &row.made {
        Ok((_, sum, _)) => Some(format!("{sum}  {}\n", row.name)),
        Err(_) => None,
    });
    fs::write(archives.join("SHA256SUMS"), sums.collect::<String>())?;
    println!("in {}", archives.display());
    if builder.metadata.unpublished() {
        println!(
            "!!! repository in Cargo.toml is not filled in: nothing can be fetched from where the formula and the manifests of winget say"
        );
    }
    match rows.iter().filter(|row| row.made.is_err()).count() {
        0 => Ok(()),
        failed => Err(format!(
            "{failed} of {} could not be made; see the table",
            rows.len()
        )
        .into()),
    }
}

/// Returns a command that runs on this machine, for its completions and manual pages.
fn local_command(builder: &Builder, selection: &Selection) -> Result<PathBuf, Box<dyn Error>> {
    let host = System::by_triple(&builder.metadata.host);
    let wanted = host.filter(|host| {
        selection.systems.contains(host) && builder.missing_requirement(host).is_none()
    });
    let built = match wanted {
        Some(host) => builder.release(&host, &["magician-cli"])?,
        None => builder.plain(None, &["magician-cli"])?,
    };
    Ok(built.join(format!("magician{}", std::env::consts::EXE_SUFFIX)))
}

/// Builds the archive of a system and its Debian package, each with its line of the table.
fn build_release(
    builder: &Builder,
    system: &System,
    local_command: &Path,
    archives: &Path,
    rows: &mut Vec<Row>,
    made: &mut Vec<BuiltArchive>,
) {
    let name = system.archive(&builder.metadata.version);
    let room = archives.join("try");
    let archive = || -> Result<_, Box<dyn Error>> {
        if let Some(lack) = builder.missing_requirement(system) {
            return Err(lack.into());
        }
        let archive = archive::write(builder, system, local_command, archives)?;
        let how = verification::verify_archive(builder, system, &archive, &room)?;
        file(&archive, how)
    };
    let archive = row(&format!("{name}.{}", system.ending()), archive());
    let sum = archive.made.as_ref().ok().map(|(_, sum, _)| sum.clone());
    rows.push(archive);
    let Some(sum) = sum else { return };
    made.push((*system, sum));
    if let Some(name) = desktop::name(builder, system) {
        let studio = || -> Result<_, Box<dyn Error>> {
            match system.family {
                Family::MacOs(oldest) => {
                    let made = desktop::application(builder, system, oldest, archives)?;
                    file(&made, "not run; the program is the archive's".to_owned())
                }
                _ => {
                    let made = desktop::installer(builder, system, archives)?;
                    file(&made, verification::verify_installer(builder, &made)?)
                }
            }
        };
        rows.push(row(&name, studio()));
    }
    if system.family == Family::Linux {
        let package = || -> Result<_, Box<dyn Error>> {
            let package = debian::write(builder, system, archives)?;
            let how = debian::with_installed(&package, &room, |program| {
                verification::verify_program(builder, system, program)
            })?;
            file(&package, format!("installed, {how}, removed"))
        };
        rows.push(row(&debian::name(builder, system), package()));
    }
    let _ = fs::remove_dir_all(archives.join(name));
}

fn row(name: &str, made: Result<(u64, String, String), Box<dyn Error>>) -> Row {
    Row {
        name: name.to_owned(),
        made: made.map_err(|error| error.to_string()),
    }
}

/// Returns the table's data of a file.
fn file(path: &Path, how_tested: String) -> Result<(u64, String, String), Box<dyn Error>> {
    let bytes = fs::read(path)?;
    let sum = Sha256::digest(&bytes)
        .iter()
        .fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        });
    Ok((bytes.len() as u64, sum, how_tested))
}

fn table(rows: &[Row]) -> String {
    let width = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for Row { name, made } in rows {
        let _ = match made {
            Ok((size, sum, how_tested)) => writeln!(
                text,
                "{name:width$} {:7.2} MB  {sum}  {how_tested}",
                *size as f64 / 1e6
            ),
            Err(why) => writeln!(text, "{name:width$} NOT MADE: {why}"),
        };
    }
    text
}

/// Returns the cargo that runs this program.
pub(crate) fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

pub(crate) fn run(command: &mut Command) -> Result<(), Box<dyn Error>> {
    let status = command
        .status()
        .map_err(|error| not_started(command, &error))?;
    status
        .success()
        .then_some(())
        .ok_or_else(|| format!("{command:?} ended with {status}").into())
}

pub(crate) fn output(command: &mut Command) -> Result<Vec<u8>, Box<dyn Error>> {
    let result = command
        .output()
        .map_err(|error| not_started(command, &error))?;
    if result.status.success() {
        Ok(result.stdout)
    } else {
        Err(format!("{command:?}: {}", String::from_utf8_lossy(&result.stderr)).into())
    }
}

fn not_started(command: &Command, error: &std::io::Error) -> String {
    format!("{}: {error}", command.get_program().display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_shows_sizes_and_reasons_of_missing_files() {
        let rows = [
            row(
                "a.tar.gz",
                Ok((1_234_567, "00ff".to_owned(), "run".to_owned())),
            ),
            row("magician.zip", Err("no x86_64-w64-mingw32-gcc".into())),
        ];
        assert_eq!(
            table(&rows),
            "a.tar.gz        1.23 MB  00ff  run\nmagician.zip NOT MADE: no x86_64-w64-mingw32-gcc\n"
        );
    }
}
