//! Third-party code and data in our releases with their licences: a page for the command's archive,
//! one for the replacement library, and one for the Python wheel, which is kept in the repository.

mod linked;
mod texts;
mod wheel;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use linked::{Embedded, Linked, Package};

pub(crate) use linked::Build;
pub(crate) use wheel::run;

/// Returns the page of a build: its crates, and each licence text once.
pub(crate) fn page(build: &Build) -> Result<String, Box<dyn Error>> {
    let Linked {
        crates,
        macros,
        embedded,
    } = linked::read(build)?;
    let mut texts = UniqueTexts::default();
    let mut page = format!(
        "What is in {}, written by others, and its licences.\n\n\
         magician itself is under MIT or Apache-2.0, at your choice: LICENSE-MIT and LICENSE-APACHE.\n",
        build.title
    );
    if build.target.is_none() {
        page += "This page is for every platform; what is for one of them only is listed too.\n";
    }
    add_heading(&mut page, "Linked into it");
    for package in &crates {
        add_package(&mut page, &mut texts, package)?;
    }
    add_heading(&mut page, "Macros that wrote some of its code");
    for package in &macros {
        add_package(&mut page, &mut texts, package)?;
    }
    if !embedded.is_empty() {
        add_heading(&mut page, "Data in it");
    }
    for data in &embedded {
        let Embedded {
            name,
            licence,
            copyright,
            source,
            text,
            ..
        } = data;
        writeln!(page, "{name}: {licence}, {source}\n    {copyright}")?;
        texts.add(name, text);
    }
    add_heading(&mut page, "What the compiler adds");
    for part in texts::compiler_parts(build.target.as_deref()) {
        writeln!(page, "{}: {}, {}", part.name, part.licence, part.home)?;
        for text in part.texts {
            texts.add(part.name, &text);
        }
    }
    texts.write(&mut page)?;
    Ok(page)
}

fn add_heading(page: &mut String, words: &str) {
    let _ = write!(page, "\n{words}\n{}\n\n", "-".repeat(words.len()));
}

fn add_package(
    page: &mut String,
    texts: &mut UniqueTexts,
    package: &Package,
) -> Result<(), Box<dyn Error>> {
    let (name, version) = (&package.name, &package.version);
    writeln!(
        page,
        "{name} {version}: {}, {}",
        package.licence, package.home
    )?;
    if !package.authors.is_empty() {
        writeln!(page, "    by {}", package.authors.join(", "))?;
    }
    let own = texts::texts_of_crate(package)?;
    if own.standard {
        writeln!(
            page,
            "    comes without its licence's text; the standard one is below"
        )?;
    }
    for (file, text) in own.files {
        let label = match Path::new(&file).components().count() {
            0 | 1 => format!("{name} {version}"),
            _ => format!("{name} {version} ({file})"),
        };
        texts.add(&label, &text);
    }
    Ok(())
}

/// Licence texts without duplicates, each with the names it applies to.
#[derive(Default)]
struct UniqueTexts {
    /// Keyed by the words of the text, so that line breaks do not matter.
    all: BTreeMap<String, (String, Vec<String>)>,
}

impl UniqueTexts {
    fn add(&mut self, of: &str, text: &str) {
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let entry = || (text.trim_end().to_owned(), Vec::new());
        let (_, names) = self.all.entry(words).or_insert_with(entry);
        // A file deep inside a crate with the crate's own licence adds nothing.
        let owner = of.split(" (").next().unwrap_or(of);
        if !names.iter().any(|known| known == of || known == owner) {
            names.push(of.to_owned());
        }
    }

    fn write(&self, page: &mut String) -> Result<(), Box<dyn Error>> {
        let line = "-".repeat(80);
        for (text, names) in self.all.values() {
            let text = text.trim_start_matches(['\u{feff}', '\n']);
            write!(page, "\n{line}\n{}:\n\n{text}\n", wrap_names("Of", names))?;
        }
        Ok(())
    }
}

/// Joins names with commas and wraps the lines.
fn wrap_names(head: &str, names: &[String]) -> String {
    let (mut all, mut column) = (head.to_owned(), head.len());
    for (at, name) in names.iter().enumerate() {
        if at > 0 {
            all.push(',');
        }
        column += name.len() + 2;
        if column > 100 {
            all.push('\n');
            column = name.len();
        } else {
            all.push(' ');
        }
        all += name;
    }
    all
}

#[cfg(test)]
mod tests;
