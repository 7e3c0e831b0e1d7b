//! Generates the part of a C program that calls every function of a family;
//! `interop/vendor/every.c` includes it.
//!
//!
//! The C program decides about the arguments' values (`given`, `wanted`, `text`, `room`, ...); this
//! module only knows which function takes what.

use std::fmt::Write as _;

use magician_capi::{Family, Function, Ids};

use super::{c_type_name, functions_of, pointee};

/// Returns the part for a family.
pub(super) fn calls_of_family(family: Family) -> String {
    let mut part = String::from("/* Made by `cargo xtask vendor-functions calls`. */\n\n");
    for function in functions_of(family) {
        call(&mut part, function);
    }
    part += "static const struct call CALLS[] = {\n";
    for function in functions_of(family) {
        let name = function.name;
        let _ = writeln!(
            part,
            "    {{\"{name}\", {:?}, call_{name}}},",
            function.kind
        );
    }
    part + "};\n"
}

/// Writes the call of one function, with its arguments in the order of their dependencies.
fn call(part: &mut String, function: &Function) {
    let name = function.name;
    let _ = writeln!(part, "static int call_{name}(void) {{");
    let sized = |argument: &str| (function.arguments.iter()).any(|&(known, _)| known == argument);
    if sized("size") {
        part.push_str("    uint32_t size = new_room();\n");
    }
    if sized("count") {
        part.push_str("    int count = new_count();\n");
    }
    for &(argument, ty) in function.arguments {
        let ty = ty.replace(' ', "");
        let made = match (ty.as_str(), pointee(&ty, "In"), pointee(&ty, "Out")) {
            _ if argument == "size" || argument == "count" => continue,
            ("Text", ..) => "const char *{} = new_text()".to_owned(),
            ("Buffer", ..) if sized("size") => "char *{} = new_wanted(fits(size))".to_owned(),
            ("Buffer", ..) => "char *{} = new_wanted(64)".to_owned(),
            (_, Some(of), _) if sized("count") && argument == "outputs" => {
                format!(
                    "void *{{}} = new_listed(sizeof({}), count)",
                    c_type_name(of)
                )
            }
            (_, Some(of), _) => format!("void *{{}} = new_given(sizeof({}))", c_type_name(of)),
            (_, _, Some("u8")) if sized("size") => "void *{} = new_wanted(fits(size))".to_owned(),
            (_, _, Some("u64")) if argument == "index" => "void *{} = new_index()".to_owned(),
            // The struct for the answer also carries the question, such as a pin's address.
            (_, _, Some(of)) if of.starts_with("IO") => {
                format!("void *{{}} = new_asked(sizeof({}))", c_type_name(of))
            }
            (_, _, Some(of)) => format!("void *{{}} = new_wanted(sizeof({}))", c_type_name(of)),
            ("f32", ..) => "float {} = new_real()".to_owned(),
            (scalar, ..) => format!(
                "{} {{}} = (__typeof__({{}}))new_whole()",
                c_type_name(scalar)
            ),
        };
        let _ = writeln!(part, "    {};", made.replace("{}", argument));
    }
    let ids = match function.ids {
        Ids::None => "",
        Ids::Master => "MASTER(who)",
        Ids::Arm => "ARM(who)",
    };
    let only = match (function.ids, function.arguments) {
        (Ids::Master, []) => "ONLY_MASTER(who)".to_owned(),
        (Ids::Arm, []) => "ONLY(who)".to_owned(),
        (_, arguments) => {
            let names: Vec<&str> = arguments.iter().map(|&(argument, _)| argument).collect();
            format!("{ids} {}", names.join(", ")).trim().to_owned()
        }
    };
    let _ = writeln!(part, "    return OF(from, {name})({only});\n}}\n");
}
