//! Lists the files of the page as they lie in `packed`, for `src/lib.rs`.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=packed");
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join("packed");
    let mut names = Vec::new();
    list(&root, "", &mut names)?;
    names.sort();
    let mut list = String::from("&[\n");
    for name in names {
        let path = match &*name {
            "index.html" => "",
            name => name,
        };
        let (path, kind) = (format!("/{path}"), kind(&name)?);
        let packed = root.join(name + ".gz");
        writeln!(
            list,
            "File {{ path: {path:?}, kind: {kind:?}, gzip: include_bytes!({packed:?}) }},"
        )?;
    }
    list.push(']');
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("files.rs"), list)?;
    Ok(())
}

/// The names of all files in a folder, without the `.gz` that each of them ends in.
fn list(folder: &Path, within: &str, names: &mut Vec<String>) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_str().ok_or("a name that is no text")?;
        let inner = format!("{within}{name}");
        if entry.file_type()?.is_dir() {
            list(&entry.path(), &format!("{inner}/"), names)?;
        } else {
            let plain = inner.strip_suffix(".gz");
            names.push(
                plain
                    .ok_or_else(|| format!("{inner} is not packed"))?
                    .to_owned(),
            );
        }
    }
    Ok(())
}

fn kind(name: &str) -> Result<&'static str, String> {
    let end = name.rsplit_once('.').map_or("", |(_, end)| end);
    Ok(match end {
        "css" => "text/css; charset=utf-8",
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "json" => "application/json",
        "svg" => "image/svg+xml",
        "txt" => "text/plain; charset=utf-8",
        "wasm" => "application/wasm",
        "webmanifest" => "application/manifest+json",
        _ => return Err(format!("{name}: no type is known for such a file")),
    })
}
