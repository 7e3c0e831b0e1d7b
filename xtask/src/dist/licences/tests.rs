//! Tests that the licence pages are complete and correct.

use std::fs;
use std::path::{Path, PathBuf};

use super::linked::{self, Build, Package};
use super::{UniqueTexts, page, texts};

const TARGET: &str = "x86_64-unknown-linux-gnu";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn build(package: &str) -> Build {
    Build {
        title: "magician",
        manifest: root().join("Cargo.toml"),
        packages: vec![package.to_owned()],
        features: Vec::new(),
        target: Some(TARGET.to_owned()),
    }
}

/// Creates a crate with its sources in a temporary folder.
fn package(folder: &tempfile::TempDir, licence: &str, authors: &[&str]) -> Package {
    Package {
        name: "sample".to_owned(),
        version: "1.2.3".to_owned(),
        licence: licence.to_owned(),
        authors: authors.iter().map(|author| (*author).to_owned()).collect(),
        home: String::new(),
        folder: folder.path().to_owned(),
    }
}

#[test]
fn page_of_the_command_lists_its_crates_and_the_font() {
    let page = page(&build("magician-cli")).unwrap();
    for line in [
        "\ntokio 1.",
        "\nclap 4.",
        "\nRoboto Regular, the font: Apache-2.0, https://github.com/google/roboto\n",
        "Copyright 2011 Google Inc.",
        "Copyright (c) Tokio Contributors",
        "\nRust's standard library: ",
        "Copyright (c) The Rust Project Developers",
        "                                 Apache License",
        "UNICODE LICENSE V3",
    ] {
        assert!(page.contains(line), "{line}");
    }
    let (code, macros) = page.split_once("\nMacros that wrote").unwrap();
    assert!(!code.contains("\nsyn 2.") && macros.contains("\nsyn 2."));
    assert!(!page.contains("\nproptest ") && !page.contains("\nmagician-sim "));
    assert!(!page.contains("\nwindows-sys ") && !page.contains("ZPL-2.1"));
}

#[test]
fn page_leaves_out_crates_that_the_build_does_not_link() {
    let page = page(&build("magician-capi-v1")).unwrap();
    assert!(page.contains("\nserial2 0."));
    for other in ["mcap ", "tiny-skia ", "clap ", "Roboto"] {
        assert!(!page.contains(&format!("\n{other}")), "{other}");
    }
}

#[test]
fn page_lists_c_code_inside_linked_crates() {
    let mut build = build("magician-cli");
    let without = page(&build).unwrap();
    assert!(!without.contains("libdbus"));
    build.features = vec!["magician-cli/ble-vendored".to_owned()];
    let with = page(&build).unwrap();
    assert!(with.contains("vendor/dbus/COPYING"));
    assert!(with.contains("Academic Free License"));
}

#[test]
fn every_crate_has_a_licence_text() {
    let linked = linked::read(&build("magician-cli")).unwrap();
    assert!(linked.crates.len() > 100, "{}", linked.crates.len());
    for package in linked.crates.iter().chain(&linked.macros) {
        let texts = texts::texts_of_crate(package).unwrap();
        assert!(!texts.files.is_empty(), "{package:?}");
        assert!(!package.licence.is_empty(), "{package:?}");
    }
}

/// Third-party bytes that are embedded must be declared in the crate's manifest. Embedded texts and
/// sources are ours.
#[test]
fn every_embedded_file_is_declared() {
    let declared = linked::read(&build("magician-cli")).unwrap().embedded;
    let declared: Vec<_> = (declared.iter())
        .map(|data| data.file.canonicalize().unwrap())
        .collect();
    let mut sources = Vec::new();
    collect_rust_sources(&root().join("crates"), &mut sources);
    let mut seen = 0;
    for source in sources {
        let text = fs::read_to_string(&source).unwrap();
        for (_, rest) in text
            .match_indices("include_bytes!(\"")
            .map(|(at, head)| text.split_at(at + head.len()))
        {
            let name = rest.split('"').next().unwrap();
            if name.ends_with(".rs") {
                continue;
            }
            let file = source.parent().unwrap().join(name).canonicalize().unwrap();
            assert!(
                declared.contains(&file),
                "{} builds in {name}",
                source.display()
            );
            seen += 1;
        }
    }
    assert!(seen > 0, "the font is found");
}

fn collect_rust_sources(folder: &Path, sources: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !["target", "tests", "examples", "benches"].contains(&&*name) {
            collect_rust_sources(&path, sources);
        } else if name.ends_with(".rs") && name != "tests.rs" {
            sources.push(path);
        }
    }
}

#[test]
fn crate_without_a_text_gets_the_standard_text_with_its_authors() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("LICENSE"), "../LICENSE").unwrap();
    fs::write(folder.path().join("AUTHORS"), "somebody\n".repeat(30)).unwrap();
    let of = |licence, authors: &[&str]| texts::texts_of_crate(&package(&folder, licence, authors));
    let texts = of("Zlib OR MIT", &["Ada <a@b.c>", "Grace"]).unwrap();
    assert!(texts.standard);
    let (_, text) = texts.files.last().unwrap();
    assert!(text.contains("Copyright (c) Ada <a@b.c>, Grace\n"));
    assert!(text.contains("Permission is hereby granted") && !text.contains("magician"));
    let nameless = of("MIT", &[]).unwrap();
    let (_, text) = nameless.files.last().unwrap();
    assert!(text.contains("Copyright (c) the authors of sample\n"));
    let apache = of("Apache-2.0/BSL-1.0", &[]).unwrap();
    assert!(apache.files.last().unwrap().1.contains("Apache License"));
    let error = of("MIT AND BSD-3-Clause", &[]).unwrap_err().to_string();
    assert!(error.contains("sample") && error.contains("BSD-3-Clause"));
}

#[test]
fn incorporated_code_is_found_and_test_code_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let text = "Permission is hereby granted. ".repeat(10);
    for file in [
        "LICENSE-MIT",
        "src/tables/LICENSE-UNICODE",
        "vendor/c/COPYING",
        "tests/fonts/LICENSE.txt",
        "src/notice.rs",
    ] {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("{text}{file}")).unwrap();
    }
    let texts = texts::texts_of_crate(&package(&folder, "MIT", &[])).unwrap();
    let files: Vec<_> = texts.files.iter().map(|(file, _)| file.as_str()).collect();
    assert_eq!(
        files,
        [
            "LICENSE-MIT",
            "src/tables/LICENSE-UNICODE",
            "vendor/c/COPYING"
        ]
    );
    assert!(!texts.standard);
}

#[test]
fn equal_texts_with_other_line_breaks_appear_once() {
    let mut texts = UniqueTexts::default();
    texts.add("one", "Copyright A\n\nDo what\nyou want.\n");
    texts.add("two", "Copyright A Do what you want.");
    texts.add("three", "Copyright B Do what you want.");
    let mut page = String::new();
    texts.write(&mut page).unwrap();
    assert_eq!(page.matches("Copyright A").count(), 1);
    assert!(page.contains("Of one, two:") && page.contains("Of three:"));
}

#[test]
fn parts_that_linkers_add_are_listed() {
    let parts = |target| texts::compiler_parts(target).len();
    assert_eq!(parts(Some("x86_64-pc-windows-gnu")), 2);
    assert_eq!(parts(Some("x86_64-pc-windows-msvc")), 1);
    assert_eq!(parts(Some("aarch64-unknown-linux-gnu")), 2);
    assert_eq!(parts(Some("aarch64-apple-darwin")), 2);
    assert_eq!(parts(None), 3);
}

/// The package of a single crate contains nothing of the workspace's root.
#[test]
fn every_published_crate_has_our_licences() {
    let mut seen = 0;
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        if manifest.contains("publish = false") && !folder.join("pyproject.toml").exists() {
            continue;
        }
        for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let ours = fs::read_to_string(root().join(file)).unwrap();
            let there = fs::read_to_string(folder.join(file)).unwrap_or_default();
            assert!(there == ours, "{} is not ours", folder.join(file).display());
        }
        seen += 1;
    }
    assert_eq!(seen, 19);
}
