//! Maintenance tasks of this repository. `cargo xtask` lists them.

mod alarms;
mod bench;
mod citations;
mod dissector;
mod dist;
mod exports;
mod fidelity;
mod gallery;
mod generate;
mod library;
mod options;
mod plan_schema;
mod protocol;
#[path = "../../crates/magician-py/build/package.rs"]
mod python;
mod recorded_jog;
#[cfg(test)]
mod sentences;
mod soak;
mod station;
mod studio;
#[cfg(test)]
mod translations;
mod voice;
mod workshop;

use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
Usage: cargo xtask CHORE

  alarms     list the alarms as conformance cases show them: docs/reference/ALARMS.md
  station    list the methods and routes of a station: docs/reference/STATION-API.md
  python     write the options of a program into the Python package: crates/magician-py/python/magician/programs.py
  studio [--check]
             build the page for browsers with Node: crates/magician-studio/page; compare it
  studio-api [--check]
             write the methods as types of the page: studio/src/api.ts
  fidelity   list what the virtual arm assumes, and the cases that hold it: docs/reference/FIDELITY.md; draws a recorded jog beside it
  protocol   list every command of the protocol: docs/reference/PROTOCOL.md
  dissector  write the Wireshark dissector: docs/reference/wireshark/magician.lua
  vendor-functions
             list every function of the drop-in for the vendor's library: docs/reference/VENDOR-FUNCTIONS.md
  generate [headers | python | modules]..
             write what is not kept in git: the C headers of the vendor's library, parts of the Python package,
             the WebAssembly modules of a page without a server; what is current stays as it is
  plan-schema
             write the commands into the schema of plan files: crates/magician-formats/plan.schema.json
  gallery    draw each motion mode on the virtual arm: docs/evidence/gallery/*.svg and docs/evidence/GALLERY.md
  workshop [PIECE..]
             make pieces of every kind with the command on the virtual arm: docs/evidence/workshop/* and docs/evidence/WORKSHOP.md;
             with names only make these and show how well they match
  vendor-library [--target TRIPLE] [DIR]
             build the drop-in and lay it out as it is installed: target/vendor-library/TRIPLE
  licences [--check | PACKAGE [--features LIST] [--target TRIPLE]]
             list the third-party work in the Python wheel: crates/magician-py/THIRD-PARTY-LICENSES.txt; check it;
             print the same of another package
  dist [--only TARGET].. [--skip TARGET].. [--profile NAME]
             make a release and try it: archives for five systems, Debian packages, manifests for Homebrew and winget: target/archive
  voice [--list]
             count symptoms of prose that needs a second reading, per crate; name the lines
  publish [--dry-run]
             publish the crates, once they name their repository
  bench [WHAT...] [--json]
             measure what the virtual arm costs
  soak [NAME [--cases N] [--seed S]] [--json]
             test the driver's promises for as long as you like; without a name list them";

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = root.join("docs");
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match words.split_first() {
        Some((chore, [])) if chore == "gallery" => gallery::write(&docs),
        Some((chore, rest)) if chore == "workshop" => workshop::write(rest, &root),
        Some((chore, [])) if chore == "protocol" => protocol::write(&docs),
        Some((chore, rest)) if chore == "generate" => generate::run(rest, &root),
        Some((chore, [])) if chore == "plan-schema" => plan_schema::write(&root),
        Some((chore, [])) if chore == "dissector" => dissector::write(&docs),
        Some((chore, [])) if chore == "fidelity" => {
            fidelity::write(&docs).and_then(|()| recorded_jog::write(&docs))
        }
        Some((chore, [])) if chore == "alarms" => alarms::write(&docs),
        Some((chore, [])) if chore == "python" => options::write_python(&root),
        Some((chore, [])) if chore == "station" => station::write(&root),
        Some((chore, rest)) if chore == "studio" => studio::page::run(rest, &root),
        Some((chore, rest)) if chore == "studio-api" => studio::api::write(rest, &root),
        Some((chore, rest)) if chore == "vendor-library" => library::run(rest, &root),
        Some((chore, rest)) if chore == "licences" => dist::licences(rest, &root),
        Some((chore, rest)) if chore == "dist" => dist::run_release(rest, &root),
        Some((chore, rest)) if chore == "voice" => voice::run(rest, &root),
        Some((chore, rest)) if chore == "publish" => dist::publish(rest, &root),
        Some((chore, rest)) if chore == "vendor-functions" => exports::run(rest, &docs),
        Some((chore, rest)) if chore == "bench" => bench::run(rest, &docs),
        Some((chore, rest)) if chore == "soak" => soak::run(rest),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error}");
            ExitCode::FAILURE
        }
    }
}
