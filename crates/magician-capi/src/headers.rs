//! Generates the C headers of the three families from a common source.
//!
//! A source line that begins with `@` and families (`@v1 v3 int ..`) belongs to these families
//! only. `{arm}` and `{master}` stand for the leading ids of a function.

use crate::Family;

const FAMILIES: [&str; 3] = ["v1", "v2", "v3"];

/// Name and source text of each header.
const SOURCES: [(&str, &str); 2] = [
    ("DobotDll.h", include_str!("../include/DobotDll.h.in")),
    ("DobotType.h", include_str!("../include/DobotType.h.in")),
];

/// Longest line of a prototype, columns. A choice for readable headers.
const WIDTH: usize = 110;

/// Returns the headers of a family, each with its name.
#[must_use]
pub fn headers(family: Family) -> [(&'static str, String); 2] {
    let family = FAMILIES[family as usize];
    SOURCES.map(|(name, source)| (name, header(source, family)))
}

/// Generates the header of a family.
fn header(source: &str, family: &str) -> String {
    let mut text = String::new();
    for line in source
        .lines()
        .filter_map(|line| strip_families(line, family))
    {
        if line.starts_with("int ") {
            push_prototype(&mut text, line, family);
        } else {
            text.push_str(line);
            text.push('\n');
        }
    }
    text
}

/// Strips the leading `@` and family names from a source line. Returns `None` if the line does not
/// belong to `family`.
fn strip_families<'l>(line: &'l str, family: &str) -> Option<&'l str> {
    let Some(mut rest) = line.strip_prefix('@') else {
        return Some(line);
    };
    let mut matches = false;
    while let Some(named) = FAMILIES.iter().find(|named| rest.starts_with(**named)) {
        matches |= *named == family;
        rest = &rest[named.len()..];
        rest = rest.strip_prefix(' ').unwrap_or(rest);
    }
    matches.then_some(rest)
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
    for (position, word) in line.split_inclusive(", ").enumerate() {
        if position > 0 && width + word.trim_end().len() > WIDTH {
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
    fn lines_are_kept_for_the_families_they_name() {
        assert_eq!(strip_families("int a;", "v2"), Some("int a;"));
        assert_eq!(strip_families("@v1 v3 int a;", "v3"), Some("int a;"));
        assert_eq!(
            strip_families("@v1 v3     int a;", "v1"),
            Some("    int a;")
        );
        assert_eq!(strip_families("@v1 v3 int a;", "v2"), None);
        assert_eq!(strip_families("@v3", "v3"), Some(""));
    }

    #[test]
    fn prototypes_begin_with_the_ids_of_their_family() {
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
