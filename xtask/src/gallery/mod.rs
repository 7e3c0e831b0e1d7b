//! Pictures of all motion modes, as the virtual arm performs them when commanded over the wire.

mod modes;
mod plot;
mod run;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use modes::MODES;

const INTRODUCTION: &str = "\
# How the arm moves

Each picture is one run of the virtual arm: the commands below it were sent as frames, and the pose
was read every 2 ms. Left: the tool from above, x to the right, y up, J1's axis at the origin.
Middle: its height against the distance from that axis. Right: speeds of the four joints over time.
Dot: start; ring: end; grey: reach.

`cargo xtask gallery` draws them all again.
";

/// Draws every mode into `docs/evidence/gallery` and lists them in `docs/evidence/GALLERY.md`.
pub(crate) fn write(docs: &Path) -> Result<(), Box<dyn Error>> {
    let pictures = docs.join("evidence/gallery");
    fs::create_dir_all(&pictures)?;
    let mut page = INTRODUCTION.to_owned();
    for mode in MODES {
        let run = run::run(mode);
        let name = format!("{}.svg", mode.name);
        let picture = plot::draw(mode, &run)?;
        fs::write(pictures.join(&name), picture)?;
        let seconds = run.seconds();
        write!(
            page,
            "\n## {}\n\n{} It took {seconds:.3} s.\n\n![{}](gallery/{name})\n",
            mode.title, mode.description, mode.title
        )?;
        println!("docs/evidence/gallery/{name}: {seconds:.3} s");
    }
    fs::write(docs.join("evidence/GALLERY.md"), page)?;
    Ok(())
}
