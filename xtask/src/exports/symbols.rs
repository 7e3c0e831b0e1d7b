//! Checks that the built libraries export exactly the functions of their family and depend only on
//! libraries of every system.

use std::collections::BTreeSet;
use std::error::Error;
use std::process::Command;

use magician_capi::Family;

use super::functions_of;

/// Libraries of every system that runs programs. The vendor's library needs Qt and therefore does
/// not load on most machines.
const LINUX_LIBRARIES: [&str; 5] = [
    "libc.so",
    "libm.so",
    "libgcc_s.so",
    "ld-linux",
    "libpthread.so",
];
const WINDOWS_LIBRARIES: [&str; 10] = [
    "kernel32.dll",
    "ntdll.dll",
    "advapi32.dll",
    "ws2_32.dll",
    "bcrypt.dll",
    "bcryptprimitives.dll",
    "msvcrt.dll",
    "userenv.dll",
    "secur32.dll",
    "api-ms-win-core-",
];

/// Compares the exports of built libraries with the table. Uses `nm` and `objdump` of the binutils.
pub(super) fn check(family: Family, files: &[&str]) -> Result<(), Box<dyn Error>> {
    let wanted: BTreeSet<&str> = functions_of(family).map(|function| function.name).collect();
    let mut wrong = Vec::new();
    for file in files {
        let listing = listing(file)?;
        let found: BTreeSet<&str> = listing.iter().map(String::as_str).collect();
        let missing: Vec<&&str> = wanted.difference(&found).collect();
        let more: Vec<&&str> = found.difference(&wanted).collect();
        if !missing.is_empty() {
            wrong.push(format!("{file} does not export {missing:?}"));
        }
        if !more.is_empty() {
            wrong.push(format!("{file} exports {more:?}, which the table has not"));
        }
        let needs: Vec<String> = (dependencies(file)?.into_iter())
            .filter(|name| !is_system_library(name))
            .collect();
        if !needs.is_empty() {
            wrong.push(format!("{file} needs {needs:?}"));
        }
        println!("{} functions: {file}", found.len());
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n").into())
    }
}

/// Returns the names that a library exports.
fn listing(file: &str) -> Result<Vec<String>, Box<dyn Error>> {
    if file.ends_with(".dll") {
        Ok(parse_export_table(&output("objdump", &["-p", file])?))
    } else {
        let listing = output("nm", &["-D", "--defined-only", "--no-sort", file])?;
        Ok((listing.lines())
            .filter_map(|line| Some(line.split_whitespace().nth(2)?.to_owned()))
            .collect())
    }
}

/// Returns the libraries that a library depends on.
fn dependencies(file: &str) -> Result<Vec<String>, Box<dyn Error>> {
    let listing = output("objdump", &["-p", file])?;
    Ok((listing.lines())
        .filter_map(|line| {
            let line = line.trim();
            let name = line
                .strip_prefix("NEEDED")
                .or(line.strip_prefix("DLL Name:"))?;
            Some(name.trim().to_owned())
        })
        .collect())
}

fn is_system_library(name: &str) -> bool {
    let name = name.to_lowercase();
    (LINUX_LIBRARIES.iter().chain(&WINDOWS_LIBRARIES)).any(|known| name.starts_with(known))
}

/// Parses the names of objdump's export table: `[ 12] +base[ 13] 000c GetPose`, or without the
/// middle part.
fn parse_export_table(listing: &str) -> Vec<String> {
    (listing.lines())
        .skip_while(|line| !line.starts_with("[Ordinal/Name Pointer] Table"))
        .skip(1)
        .take_while(|line| line.trim_start().starts_with('['))
        .filter_map(|line| Some(line.split_whitespace().last()?.to_owned()))
        .collect()
}

fn output(program: &str, words: &[&str]) -> Result<String, Box<dyn Error>> {
    let result = Command::new(program)
        .args(words)
        .output()
        .map_err(|error| format!("{program}: {error}"))?;
    if !result.status.success() {
        return Err(format!("{program}: {}", String::from_utf8_lossy(&result.stderr)).into());
    }
    Ok(String::from_utf8(result.stdout)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependency_outside_of_the_system_is_reported() {
        assert!(is_system_library("libc.so.6") && is_system_library("KERNEL32.dll"));
        assert!(!is_system_library("libQt5Core.so.5") && !is_system_library("libgcc_s_dw2-1.dll"));
    }

    #[test]
    fn export_table_is_parsed_in_both_forms() {
        for between in ["", "+base[   1]  0000 "] {
            let listing = format!(
                "DLL Name: x\n\n[Ordinal/Name Pointer] Table\n\t[   0] {between}GetPose\n\t[   1] {between}SetPTPCmd\n\nThe Function Table\n"
            );
            assert_eq!(parse_export_table(&listing), ["GetPose", "SetPTPCmd"]);
        }
    }
}
