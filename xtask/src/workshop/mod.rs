//! Programs as people have them, run on the virtual arm: the input beside what the arm left, and how well both match.

mod sheet;
mod source;
mod trial;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use magician_program::Format;
use trial::Trial;

/// Where the programs are.
const SAMPLES: &str = "crates/magician-program/samples";

/// A program of the gallery.
pub(crate) struct Program {
    pub(crate) file: &'static str,
    pub(crate) format: Format,
    title: &'static str,
    says: &'static str,
}

const PROGRAMS: [Program; 7] = [
    Program {
        file: "house.svg",
        format: Format::Svg,
        title: "An SVG drawing",
        says: "Lines, a circle and an ellipse, drawn with the pen in true size.",
    },
    Program {
        file: "curves.svg",
        format: Format::Svg,
        title: "Curves on a page",
        says: "Bézier curves, elliptical arcs and transforms, on a page measured in hundredths of a millimetre.",
    },
    Program {
        file: "star.plt",
        format: Format::Hpgl,
        title: "An HPGL plot",
        says: "One of the shapes that DobotStudio brings along, in plotter units of 0.025 mm.",
    },
    Program {
        file: "pen_outline.gcode",
        format: Format::Gcode,
        title: "G-code for a pen",
        says: "Lines and arcs; Z lifts the pen. The coordinates are the arm's own.",
    },
    Program {
        file: "laser_checker.gcode",
        format: Format::Gcode,
        title: "G-code for a laser",
        says: "Lines in both directions, with the laser's power by S.",
    },
    Program {
        file: "engrave_gradient.png",
        format: Format::Image,
        title: "An image",
        says: "Grey becomes laser power, 32 mm wide, lines 0.25 mm apart, in both directions.",
    },
    Program {
        file: "jump_suction_named_v170.playback",
        format: Format::Playback,
        title: "A DobotStudio playback file",
        says: "Jumps between named points, and the suction cup. The input shows its points and the path of the tool.",
    },
];

const INTRODUCTION: &str = "\
# Programs on the virtual arm

Each of these files is read, turned into commands and run on a virtual arm, which replies byte for byte and moves like the
real one: pen and laser leave the same lines. The left picture is the input, the right one the result, at the same scale.

Both are rasterised and compared: the figures say how far each pixel of one is from the nearest pixel of the other.
The input is drawn by code that shares nothing with our readers except the SVG parser. For an image the figure is the
difference in darkness, in cells of one millimetre.

`cargo xtask programs` runs and draws them all again. The files are in `crates/magician-program/samples`.
";

/// Runs every program, draws it into `docs/programs` and lists them in `docs/PROGRAMS.md`.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    let docs = root.join("docs");
    let pictures = docs.join("programs");
    fs::create_dir_all(&pictures)?;
    let mut page = INTRODUCTION.to_owned();
    for program in &PROGRAMS {
        let bytes = fs::read(root.join(SAMPLES).join(program.file))?;
        let trial =
            trial::run(program, &bytes).map_err(|why| format!("{}: {why}", program.file))?;
        let name = program.name();
        let (input, drawn) = (
            format!("{name}-input.{}", trial.input_is),
            format!("{name}-drawn.svg"),
        );
        fs::write(pictures.join(&input), &trial.input)?;
        fs::write(pictures.join(&drawn), &trial.drawn)?;
        entry(&mut page, program, &trial, [&input, &drawn])?;
        println!("{}: {}", program.file, trial.figures);
        if !trial.is_good {
            return Err(format!("{}: not what it should be", program.file).into());
        }
    }
    fs::write(docs.join("PROGRAMS.md"), page)?;
    Ok(())
}

fn entry(
    page: &mut String,
    program: &Program,
    trial: &Trial,
    [input, drawn]: [&str; 2],
) -> Result<(), std::fmt::Error> {
    let Program {
        file, title, says, ..
    } = program;
    let picture = |name: &str, what: &str| {
        format!("<img src=\"programs/{name}\" width=\"380\" alt=\"{what} of {file}\">")
    };
    write!(
        page,
        "\n## {title}\n\n{says}\n\n| `{file}` | what the arm left |\n|---|---|\n| {} | {} |\n\n{}\n",
        picture(input, "input"),
        picture(drawn, "result"),
        trial.figures
    )
}

impl Program {
    fn name(&self) -> &str {
        self.file.split('.').next().unwrap_or(self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the page says is true: every program runs to its end and leaves what it should.
    #[test]
    fn every_program_leaves_what_it_should() {
        let samples = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .join(SAMPLES);
        for program in &PROGRAMS {
            let bytes = fs::read(samples.join(program.file)).unwrap();
            let trial = trial::run(program, &bytes).unwrap();
            assert!(trial.is_good, "{}: {}", program.file, trial.figures);
        }
    }
}
