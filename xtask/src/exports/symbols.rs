//! Checks that the built libraries export exactly the functions of their family and depend only on
//! libraries of every system.

use std::collections::BTreeSet;
use std::error::Error;
use std::process::Command;

use magician_capi::Family;

use super::of;

/// Libraries of every system that runs programs. The vendor's library needs Qt and therefore does
/// not load on most machines.
const ON_LINUX: [&str; 5] = [
    "libc.so",
    "libm.so",
    "libgcc_s.so",
    "ld-linux",
    "libpthread.so",
];
const ON_WINDOWS: [&str; 10] = [
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
    let wanted: BTreeSet<&str> = of(family).map(|function| function.name).collect();
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
        let needs: Vec<String> = (needed(file)?.into_iter())
            .filter(|name| !is_everywhere(name))
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
        Ok(windows(&output("objdump", &["-p", file])?))
    } else {
        let said = output("nm", &["-D", "--defined-only", "--no-sort", file])?;
        Ok((said.lines())
            .filter_map(|line| Some(line.split_whitespace().nth(2)?.to_owned()))
            .collect())
    }
}

/// Returns the libraries that a library depends on.
fn needed(file: &str) -> Result<Vec<String>, Box<dyn Error>> {
    let said = output("objdump", &["-p", file])?;
    Ok((said.lines())
        .filter_map(|line| {
            let line = line.trim();
            let name = line
                .strip_prefix("NEEDED")
                .or(line.strip_prefix("DLL Name:"))?;
            Some(name.trim().to_owned())
        })
        .collect())
}

fn is_everywhere(name: &str) -> bool {
    let name = name.to_lowercase();
    (ON_LINUX.iter().chain(&ON_WINDOWS)).any(|known| name.starts_with(known))
}

/// Parses the names of objdump's export table: `[ 12] +base[ 13] 000c GetPose`, or without the
/// middle part.
fn windows(said: &str) -> Vec<String> {
    (said.lines())
        .skip_while(|line| !line.starts_with("[Ordinal/Name Pointer] Table"))
        .skip(1)
        .take_while(|line| line.trim_start().starts_with('['))
        .filter_map(|line| Some(line.split_whitespace().last()?.to_owned()))
        .collect()
}

fn output(program: &str, words: &[&str]) -> Result<String, Box<dyn Error>> {
    let told = Command::new(program)
        .args(words)
        .output()
        .map_err(|error| format!("{program}: {error}"))?;
    if !told.status.success() {
        return Err(format!("{program}: {}", String::from_utf8_lossy(&told.stderr)).into());
    }
    Ok(String::from_utf8(told.stdout)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_that_not_everybody_has_is_seen() {
        assert!(is_everywhere("libc.so.6") && is_everywhere("KERNEL32.dll"));
        assert!(!is_everywhere("libQt5Core.so.5") && !is_everywhere("libgcc_s_dw2-1.dll"));
    }

    #[test]
    fn an_export_table_is_read_in_both_forms() {
        for between in ["", "+base[   1]  0000 "] {
            let said = format!(
                "DLL Name: x\n\n[Ordinal/Name Pointer] Table\n\t[   0] {between}GetPose\n\t[   1] {between}SetPTPCmd\n\nThe Function Table\n"
            );
            assert_eq!(windows(&said), ["GetPose", "SetPTPCmd"]);
        }
    }
}
