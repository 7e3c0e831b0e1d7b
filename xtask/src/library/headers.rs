//! The C headers of the three families, from one source.
//!
//! A line of the source that begins with `@` and families (`@v1 v3 int ..`) is theirs only; `{arm}` and `{master}` are
//! the ids that a function begins with.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

pub(super) const FAMILIES: [&str; 3] = ["v1", "v2", "v3"];

/// The headers by name.
pub(super) const HEADERS: [&str; 2] = ["DobotDll.h", "DobotType.h"];

const WIDTH: usize = 110;

/// Writes `include/v1/DobotDll.h` and its five relatives.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    for (path, text) in all(root)? {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(&path, text)?;
        println!("{}", path.display());
    }
    Ok(())
}

fn all(root: &Path) -> Result<Vec<(PathBuf, String)>, Box<dyn Error>> {
    let folder = root.join("crates/magician-capi/include");
    let mut all = Vec::new();
    for name in HEADERS {
        let source = fs::read_to_string(folder.join(format!("{name}.in")))?;
        for family in FAMILIES {
            all.push((folder.join(family).join(name), header(&source, family)));
        }
    }
    Ok(all)
}

/// What a family makes of the source.
fn header(source: &str, family: &str) -> String {
    let mut text = String::new();
    for line in source.lines().filter_map(|line| theirs(line, family)) {
        if line.starts_with("int ") {
            push_prototype(&mut text, line, family);
        } else {
            text.push_str(line);
            text.push('\n');
        }
    }
    text
}

/// The line without its families, if the family is one of them.
fn theirs<'l>(line: &'l str, family: &str) -> Option<&'l str> {
    let Some(mut rest) = line.strip_prefix('@') else {
        return Some(line);
    };
    let mut theirs = false;
    while let Some(named) = FAMILIES.iter().find(|named| rest.starts_with(**named)) {
        theirs |= *named == family;
        rest = &rest[named.len()..];
        rest = rest.strip_prefix(' ').unwrap_or(rest);
    }
    theirs.then_some(rest)
}

fn push_prototype(text: &mut String, line: &str, family: &str) {
    let (arm, master) = match family {
        "v1" => ("", ""),
        "v2" => ("int dobotId, ", "int dobotId, "),
        _ => ("int masterId, int slaveId, ", "int masterId, "),
    };
    let line = line.replace("{arm}", arm).replace("{master}", master);
    let line = format!("DOBOTDLLSHARED_EXPORT {line}").replace(", void)", ")");
    let mut width = 0;
    for (place, word) in line.split_inclusive(", ").enumerate() {
        if place > 0 && width + word.trim_end().len() > WIDTH {
            text.truncate(text.trim_end().len());
            text.push_str("\n    ");
            width = 4;
        }
        text.push_str(word);
        width += word.len();
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_headers_are_current() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        for (path, text) in all(&root).expect("the sources of the headers") {
            let written = fs::read_to_string(&path).unwrap_or_default();
            assert_eq!(
                written,
                text,
                "{}: `cargo xtask vendor-headers` writes it",
                path.display()
            );
        }
    }

    #[test]
    fn a_line_is_that_of_its_families() {
        assert_eq!(theirs("int a;", "v2"), Some("int a;"));
        assert_eq!(theirs("@v1 v3 int a;", "v3"), Some("int a;"));
        assert_eq!(theirs("@v1 v3     int a;", "v1"), Some("    int a;"));
        assert_eq!(theirs("@v1 v3 int a;", "v2"), None);
        assert_eq!(theirs("@v3", "v3"), Some(""));
    }

    #[test]
    fn ids_come_first() {
        let source =
            "int GetPose({arm}Pose *pose);\nint Stop({arm}void);\nint Leave({master}void);\n";
        assert_eq!(
            header(source, "v1"),
            "DOBOTDLLSHARED_EXPORT int GetPose(Pose *pose);\n\
             DOBOTDLLSHARED_EXPORT int Stop(void);\n\
             DOBOTDLLSHARED_EXPORT int Leave(void);\n"
        );
        assert_eq!(
            header(source, "v3"),
            "DOBOTDLLSHARED_EXPORT int GetPose(int masterId, int slaveId, Pose *pose);\n\
             DOBOTDLLSHARED_EXPORT int Stop(int masterId, int slaveId);\n\
             DOBOTDLLSHARED_EXPORT int Leave(int masterId);\n"
        );
    }
}
