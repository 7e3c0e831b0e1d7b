//! Exports of the replacement for the vendor's C library: a page of all functions, a comparison of
//! the built libraries with the table, and a C program that calls every function.

mod calls;
mod page;
mod symbols;

use std::error::Error;
use std::path::Path;

use magician_capi::{FUNCTIONS, Family, Function};

/// Families with their names on the command line.
const FAMILIES: [(&str, Family); 3] = [("v1", Family::V1), ("v2", Family::V2), ("v3", Family::V3)];

/// Without arguments writes the page; otherwise `symbols FAMILY FILE...` or `calls FAMILY`.
pub(crate) fn run(words: &[String], docs: &Path) -> Result<(), Box<dyn Error>> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words.as_slice() {
        [] => page::write(docs),
        ["calls", family] => {
            print!("{}", calls::calls_of_family(family_by_name(family)?));
            Ok(())
        }
        ["symbols", family, files @ ..] if !files.is_empty() => {
            symbols::check(family_by_name(family)?, files)
        }
        _ => Err("vendor-functions [symbols FAMILY FILE... | calls FAMILY]".into()),
    }
}

fn family_by_name(name: &str) -> Result<Family, Box<dyn Error>> {
    (FAMILIES.iter())
        .find_map(|&(known, family)| (known == name).then_some(family))
        .ok_or_else(|| format!("no family `{name}`").into())
}

/// Returns the functions of a family, in the order of the table.
fn functions_of(family: Family) -> impl Iterator<Item = &'static Function> {
    (FUNCTIONS.iter()).filter(move |function| function.families.contains(&family))
}

/// Returns the declaration of an argument in C.
fn declaration(name: &str, ty: &str) -> String {
    let ty = ty.replace(' ', "");
    if let Some(of) = pointee(&ty, "In") {
        format!("const {} *{name}", c_type_name(of))
    } else if let Some(of) = pointee(&ty, "Out") {
        format!("{} *{name}", c_type_name(of))
    } else {
        match ty.as_str() {
            "Text" => format!("const char *{name}"),
            "Buffer" => format!("char *{name}"),
            ty => format!("{} {name}", c_type_name(ty)),
        }
    }
}

/// Returns the type to which a pointer of the table points.
fn pointee<'a>(ty: &'a str, pointer: &str) -> Option<&'a str> {
    ty.strip_prefix(pointer)?
        .strip_prefix('<')?
        .strip_suffix('>')
}

/// Returns the C name of a type; structures and enums have the same name in both.
fn c_type_name(ty: &str) -> &str {
    match ty {
        "Bool" => "bool",
        "u8" => "uint8_t",
        "u16" => "uint16_t",
        "u32" => "uint32_t",
        "u64" => "uint64_t",
        "i32" | "c_int" => "int",
        "f32" => "float",
        named => named,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_argument_has_a_c_declaration() {
        for function in FUNCTIONS {
            for (name, ty) in function.arguments {
                let declared = declaration(name, ty);
                assert!(
                    !declared.contains(['<', '>']),
                    "{}: {declared}",
                    function.name
                );
            }
        }
    }

    #[test]
    fn names_are_unique_within_a_family() {
        for (name, family) in FAMILIES {
            let mut names: Vec<&str> = functions_of(family).map(|function| function.name).collect();
            names.sort_unstable();
            let twice = names.windows(2).find(|pair| pair[0] == pair[1]);
            assert_eq!(twice, None, "{name}");
        }
    }
}
