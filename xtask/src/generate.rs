//! Generated files, kept out of git because other files of the repository determine them
//! completely.

use std::error::Error;
use std::path::Path;

use crate::studio::modules;
use crate::{library, python};

const PARTS: [&str; 3] = ["headers", "python", "modules"];

/// `generate [headers | python | modules]..`: writes the named parts, or all of them, where they
/// are not current.
pub(crate) fn run(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    if let Some(unknown) = { words.iter() }.find(|word| !PARTS.contains(&word.as_str())) {
        return Err(format!(
            "generate: no part is called {unknown}: {}",
            PARTS.join(", ")
        )
        .into());
    }
    let wanted = |part: &str| words.is_empty() || words.iter().any(|word| word == part);
    if wanted("headers") {
        library::write_headers(&root.join("crates/magician-capi/include"))?;
    }
    if wanted("python") {
        let package = root.join("crates/magician-py");
        python::write(&package, library::PYTHON)?;
        library::write_python(root, &root.join("crates/magician-capi/python"))?;
    }
    if wanted("modules") {
        modules::write(root)?;
    }
    Ok(())
}
