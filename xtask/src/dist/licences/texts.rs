//! Licence texts: the files in the crates, the standard text for a crate without a file, and the
//! texts for the parts that the compiler adds.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use super::linked::Package;

const MIT: &str = include_str!("../../../../LICENSE-MIT");
const APACHE: &str = include_str!("../../../../LICENSE-APACHE");
const BOOST: &str = include_str!("../texts/BSL-1.0.txt");

/// Licence texts of a crate.
#[derive(Debug)]
pub(super) struct CrateTexts {
    /// Texts by file name, relative to the crate's folder.
    pub(super) files: Vec<(String, String)>,
    /// True if the crate contains no text, so that the standard one is used with its authors.
    pub(super) standard: bool,
}

/// Collects all texts in a crate: its own licence, and those of code it has incorporated.
pub(super) fn texts_of_crate(package: &Package) -> Result<CrateTexts, Box<dyn Error>> {
    let mut paths = Vec::new();
    collect(&package.folder, &mut paths)?;
    paths.sort();
    let mut files = Vec::new();
    let mut complete = false;
    for path in paths {
        let text = String::from_utf8_lossy(&fs::read(&path)?).replace("\r\n", "\n");
        if text.len() < MIN_TEXT_BYTES {
            continue;
        }
        let name = path.strip_prefix(&package.folder)?;
        complete |= name.components().count() == 1 && starts_with(&path, &LICENCE_FILES);
        files.push((name.to_string_lossy().replace('\\', "/"), text));
    }
    if !complete {
        files.push((String::new(), standard(package)?));
    }
    Ok(CrateTexts {
        files,
        standard: !complete,
    })
}

/// Shortest licence text, bytes. Packing turns a link into a file with the name of its target,
/// which is shorter.
const MIN_TEXT_BYTES: usize = 100;
const LICENCE_FILES: [&str; 4] = ["LICENSE", "LICENCE", "COPYING", "UNLICENSE"];
/// Files with copyright holders and other required notices.
const NOTICE_FILES: [&str; 3] = ["COPYRIGHT", "NOTICE", "AUTHORS"];
/// Folders of a crate that dependents do not compile.
const UNCOMPILED_FOLDERS: [&str; 4] = ["tests", "examples", "benches", "target"];
const SOURCE_EXTENSIONS: [&str; 6] = ["rs", "c", "h", "py", "toml", "json"];

fn collect(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (path, kind) = (entry.path(), entry.file_type()?);
        let name = entry.file_name();
        if kind.is_dir() {
            if !UNCOMPILED_FOLDERS.iter().any(|aside| name == *aside) {
                collect(&path, found)?;
            }
        } else if starts_with(&path, &LICENCE_FILES) || starts_with(&path, &NOTICE_FILES) {
            let extension = path.extension().unwrap_or_default();
            if !SOURCE_EXTENSIONS
                .iter()
                .any(|program| extension == *program)
            {
                found.push(path);
            }
        }
    }
    Ok(())
}

fn starts_with(path: &Path, heads: &[&str]) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_uppercase();
    heads.iter().any(|head| name.starts_with(head))
}

fn standard(package: &Package) -> Result<String, Box<dyn Error>> {
    let Package { name, licence, .. } = package;
    let offers = |wanted: &str| {
        let mut choices = licence.split('/').flat_map(|part| part.split(" OR "));
        choices.any(|choice| choice.trim() == wanted)
    };
    if offers("MIT") {
        let holders = match package.authors.as_slice() {
            [] => format!("the authors of {name}"),
            authors => authors.join(", "),
        };
        Ok(mit(&[&format!("Copyright (c) {holders}")]))
    } else if offers("Apache-2.0") {
        Ok(APACHE.to_owned())
    } else if offers("BSL-1.0") {
        Ok(BOOST.to_owned())
    } else {
        Err(format!("{name} comes without a text of its licence, {licence:?}").into())
    }
}

/// Returns the MIT licence with other copyright holders.
fn mit(copyright: &[&str]) -> String {
    let lines = MIT.lines().map(|line| match line {
        _ if line.starts_with("Copyright") => copyright.join("\n"),
        _ => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Part of every build that is in no manifest.
pub(super) struct Part {
    pub(super) name: &'static str,
    pub(super) licence: &'static str,
    pub(super) home: &'static str,
    pub(super) texts: Vec<String>,
}

/// Copyright holders of the parts of the standard library that end up in programs: the library
/// itself and its crates, from `library/Cargo.lock` and `COPYRIGHT-library.html` of Rust 1.95,
/// without those for other systems.
const STD_COPYRIGHT_HOLDERS: [&str; 13] = [
    "Copyright (c) The Rust Project Developers (see https://thanks.rust-lang.org)",
    "std::sync::mpmc: Copyright (c) 2019 The Crossbeam Project Developers",
    "backtrace, cfg-if, rustc-demangle: Copyright (c) 2014 Alex Crichton",
    "addr2line: Copyright (c) 2016-2018 The gimli Developers",
    "adler2: Copyright (C) Jonas Schievink <jonasschievink@gmail.com>",
    "gimli: Copyright (c) 2015 The Rust Project Developers",
    "hashbrown: Copyright (c) 2016 Amanieu d'Antras",
    "libc: Copyright (c) 2014-2020 The Rust Project Developers",
    "memchr: Copyright (c) 2015 Andrew Gallant",
    "miniz_oxide: Copyright 2013-2014 RAD Game Tools and Valve Software; Copyright 2010-2014 Rich Geldreich and",
    "    Tenacious Software LLC; Copyright (c) 2017 Frommi; Copyright (c) 2017-2024 oyvindln",
    "object: Copyright (c) 2015 The Gimli Developers",
    "windows-sys, windows-link, windows-targets, on Windows: Copyright (c) Microsoft Corporation.",
];

/// Returns the parts that the compiler adds for a target; for all targets if `None`.
pub(super) fn compiler_parts(target: Option<&str>) -> Vec<Part> {
    let mut parts = vec![Part {
        name: "Rust's standard library",
        licence: "MIT OR Apache-2.0, its tables of characters Unicode-3.0",
        home: "https://github.com/rust-lang/rust",
        texts: vec![
            mit(&STD_COPYRIGHT_HOLDERS),
            include_str!("../texts/Unicode-3.0.txt").to_owned(),
        ],
    }];
    if target.is_none_or(|target| target.ends_with("windows-gnu")) {
        parts.push(Part {
            name: "The start code of MinGW-w64, in what is made for Windows with its tools",
            licence: "ZPL-2.1",
            home: "https://www.mingw-w64.org",
            texts: vec![include_str!("../texts/MinGW-w64.txt").to_owned()],
        });
    }
    let by_zig = |target: &str| target.contains("-linux-") || target.contains("-apple-");
    if target.is_none_or(by_zig) {
        parts.push(Part {
            name: "What zig adds where it links for Linux and macOS, compiler_rt and LLVM's libunwind",
            licence: "MIT, and Apache-2.0 WITH LLVM-exception",
            home: "https://ziglang.org",
            texts: vec![
                mit(&["Copyright (c) Zig contributors"]),
                format!("{APACHE}\n{}", include_str!("../texts/LLVM-exception.txt")),
            ],
        });
    }
    parts
}
