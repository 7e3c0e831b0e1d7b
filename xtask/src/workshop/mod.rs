//! Gallery of the workshop: pieces made by commands as users type them. Each shows its input, the
//! preview and the virtual arm's drawing, with the deviations between them.

mod marks;
mod page;
mod pictures;
mod pieces;
mod run;
mod sheet;
mod source;

use std::error::Error;
use std::fs;
use std::path::Path;

use pieces::PIECES;
use run::CommandFolder;

const DOCS: &str = "docs/evidence";
/// Folder of the pictures below [`DOCS`]; files made for this page are in a subfolder.
const PICTURES: &str = "workshop";
const PAGE: &str = "WORKSHOP.md";

/// Runs every piece, draws it into `docs/evidence/workshop` and lists it in `docs/evidence/WORKSHOP.md`. With names
/// it only runs these and prints their figures.
pub(crate) fn write(names: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let folder = CommandFolder::new(root)?;
    let pictures = root.join(DOCS).join(PICTURES);
    let mut page = page::INTRODUCTION.to_owned();
    let mut all_good = true;
    for piece in PIECES {
        if !names.is_empty() && !names.iter().any(|name| name == piece.name) {
            continue;
        }
        let made = folder
            .make(piece)
            .map_err(|why| format!("{}: {why}", piece.name))?;
        for (name, bytes) in &made.pictures {
            fs::write(pictures.join(name), bytes)?;
        }
        let mark = if made.is_good { "" } else { " NOT GOOD" };
        println!("{}:{mark} {}", piece.name, made.figures);
        all_good &= made.is_good;
        page.push_str(&page::entry(piece, &made));
    }
    if names.is_empty() {
        fs::write(root.join(DOCS).join(PAGE), page)?;
    }
    if !all_good {
        return Err("not every piece is what it should be".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Largest total size of the pictures, bytes, since every checkout contains them.
    const MAX_PICTURE_BYTES: u64 = 1_500_000;

    fn docs() -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(DOCS)
    }

    #[test]
    fn page_lists_exactly_the_pieces() {
        let page = fs::read_to_string(docs().join(PAGE)).unwrap();
        for piece in PIECES {
            assert!(
                page.contains(&page::head(piece)),
                "{}: run cargo xtask workshop",
                piece.name
            );
        }
        assert!(page.starts_with(page::INTRODUCTION));
        assert_eq!(page.matches("\n## ").count(), PIECES.len());
    }

    #[test]
    fn pictures_are_exactly_those_of_the_page_and_small() {
        let page = fs::read_to_string(docs().join(PAGE)).unwrap();
        let shown: BTreeSet<&str> = page
            .split(&format!("src=\"{PICTURES}/"))
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .filter(|name| !name.contains('/'))
            .collect();
        let (mut there, mut size) = (BTreeSet::new(), 0);
        for entry in fs::read_dir(docs().join(PICTURES)).unwrap() {
            let entry = entry.unwrap();
            if entry.file_type().unwrap().is_file() {
                size += entry.metadata().unwrap().len();
                there.insert(entry.file_name().into_string().unwrap());
            }
        }
        let there: BTreeSet<&str> = there.iter().map(String::as_str).collect();
        assert_eq!(there, shown);
        assert!(size < MAX_PICTURE_BYTES, "{size} bytes");
    }
}
