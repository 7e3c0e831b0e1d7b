//! Pieces of the gallery as data; the typed commands are defined only here.

use super::marks::Reader;

/// Piece of the gallery.
pub(super) struct Piece {
    /// Prefix of the names of its pictures.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) says: &'static str,
    pub(super) input: Input,
    /// Command as typed by a user, without the final options.
    pub(super) command: &'static str,
    /// Options for the run that the preview does not need.
    pub(super) run: &'static str,
    /// File for its standard input.
    pub(super) stdin: Option<&'static str>,
    pub(super) pictures: Kind,
}

/// Input of a piece.
pub(super) enum Input {
    /// None besides the command.
    None,
    /// The text in the command.
    Words,
    /// A picture, shown as it is.
    File(&'static str),
    /// Lines, which are also read by an independent reader.
    Lines(&'static str, Reader),
    /// A picture whose greys are burnt with this width and this distance of lines, mm.
    Tones(&'static str, [f64; 2]),
}

/// Pictures of a piece.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Svg,
    /// Raster image, because lines would be too large.
    Png,
    /// A preview only, since nothing is drawn.
    Way,
}

impl Piece {
    pub(super) fn leaves(&self) -> bool {
        self.pictures != Kind::Way
    }

    pub(super) fn preview(&self) -> String {
        self.named("preview")
    }

    pub(super) fn drawn(&self) -> String {
        self.named("result")
    }

    fn named(&self, what: &str) -> String {
        let end = match self.pictures {
            Kind::Svg | Kind::Way => "svg",
            Kind::Png => "png",
        };
        format!("{}-{what}.{end}", self.name)
    }

    /// Returns the command for the preview.
    pub(super) fn look(&self) -> String {
        self.look_at(&self.preview())
    }

    pub(super) fn look_at(&self, picture: &str) -> String {
        self.line(&format!(" --preview {picture}"))
    }

    /// Returns the command that makes the piece.
    pub(super) fn make(&self) -> String {
        match self.pictures {
            Kind::Way => self.line(" --port sim"),
            Kind::Svg | Kind::Png => self.make_as(&self.drawn()),
        }
    }

    pub(super) fn make_as(&self, picture: &str) -> String {
        self.line(&format!("{} --port sim --picture {picture}", self.run))
    }

    pub(super) fn estimate(&self) -> String {
        self.line(" --estimate --json")
    }

    fn line(&self, end: &str) -> String {
        let stdin = self.stdin.map(|file| format!(" < {file}"));
        format!("{}{end}{}", self.command, stdin.unwrap_or_default())
    }
}

/// Defaults of most pieces.
const PLAIN: Piece = Piece {
    name: "",
    title: "",
    says: "",
    input: Input::None,
    command: "",
    run: "",
    stdin: None,
    pictures: Kind::Svg,
};

pub(super) const PIECES: &[Piece] = &[
    Piece {
        name: "rosette",
        title: "A drawing with two pens",
        says: "Blue and black are two parts. Each pen has its own length and speed ([pens.toml](workshop/files/pens.toml)), and the arm waits \
               between them for you to change it; here nobody is there to do so (`--no-pause`). [Change pens](../recipes/pens.md).",
        input: Input::File("rosette.svg"),
        command: "magician draw rosette.svg --parts color --pens pens.toml",
        run: " --no-pause",
        ..PLAIN
    },
    Piece {
        name: "logo-hatch",
        title: "A logo, filled with hatches",
        says: "Neighbouring lines are joined along the edge. [Fill a logo](../recipes/logo.md).",
        input: Input::File("logo.svg"),
        command: "magician draw logo.svg --fill hatch",
        ..PLAIN
    },
    Piece {
        name: "logo-cross",
        title: "The logo with crossed hatches",
        says: "A second set of lines runs across the first.",
        input: Input::File("logo.svg"),
        command: "magician draw logo.svg --fill cross --fill-spacing 1.2",
        ..PLAIN
    },
    Piece {
        name: "logo-contour",
        title: "The logo with rings",
        says: "Rings from the edge inwards, one behind the other.",
        input: Input::File("logo.svg"),
        command: "magician draw logo.svg --fill contour",
        ..PLAIN
    },
    Piece {
        name: "poster",
        title: "A poster in words",
        says: "The words come from a file and are broken at a width; the letters are single lines. [A poster in words](../recipes/poster.md).",
        input: Input::Words,
        command: "magician write - --font script --size 7 --wrap 110 --align center --line-height 2.2",
        stdin: Some("notice.txt"),
        ..PLAIN
    },
    Piece {
        name: "name",
        title: "A name in a TrueType font",
        says: "The outlines of the letters, filled. Any `.ttf` or `.otf` will do.",
        input: Input::Words,
        command: "magician write Magician --font Roboto-Regular.ttf --size 16 --fill hatch --fill-spacing 0.5",
        ..PLAIN
    },
    Piece {
        name: "hanzi",
        title: "Chinese, stroke after stroke",
        says: "Characters in the order in which they are written, from a file in the form of hanzi-writer; KanjiVG works as well.",
        input: Input::Words,
        command: "magician write 山水中文 --font hanzi.json --size 20",
        ..PLAIN
    },
    Piece {
        name: "photo-outline",
        title: "A photo by pen: its outlines",
        says: "The edges of what is dark. [A photo four ways by pen](../recipes/photo.md).",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 90",
        ..PLAIN
    },
    Piece {
        name: "photo-halftone",
        title: "A photo by pen: halftone",
        says: "Dots, the larger the darker.",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 70 --image halftone --pen-width 0.5 --spacing 2.5",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "photo-squiggle",
        title: "A photo by pen: squiggle",
        says: "Lines that swing the more the darker it is; the pen is hardly lifted.",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 90 --image squiggle --spacing 3",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "photo-hatch",
        title: "A photo by pen: hatches",
        says: "Straight lines, crossed by others where it is darker.",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 90 --image hatch",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "letter",
        title: "A scanned letter, traced",
        says: "One stroke along the middle of each line. The scan is the picture of what a virtual arm once wrote.",
        input: Input::File("letter.png"),
        command: "magician draw letter.png --image centerline --pen-width 0.5 --width 66",
        ..PLAIN
    },
    Piece {
        name: "photo-laser",
        title: "A photo by laser",
        says: "Grey becomes power. [Engrave with the laser](../recipes/engrave.md).",
        input: Input::Tones("landscape.png", [48.0, 0.25]),
        command: "magician engrave landscape.png --width 48 --spacing 0.25",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "box",
        title: "A box, engraved and cut",
        says: "Two layers of one file: the lid's star and word burn at 30 %, the outlines at full power, slowly, three times \
               ([box.toml](workshop/files/box.toml)). [Cut and engrave a box](../recipes/box.md).",
        input: Input::File("box.svg"),
        command: "magician engrave box.svg --pens box.toml",
        ..PLAIN
    },
    Piece {
        name: "testgrid",
        title: "A test grid",
        says: "Powers across, speeds down. The virtual arm shows powers alone: it knows no material. [Read a test grid](../recipes/testgrid.md).",
        command: "magician testgrid --power 20:80:4 --speed 10:40:4",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "bracket",
        title: "A DXF with dimensions and texts",
        says: "As a CAD program hands it over; the file is in colours of layers, the arm has one pen.",
        input: Input::Lines("bracket.dxf", Reader::Dxf),
        command: "magician draw bracket.dxf",
        ..PLAIN
    },
    Piece {
        name: "surface",
        title: "An HPGL plot",
        says: "What pen plotters drew forty years ago, in units of 0.025 mm.",
        input: Input::Lines("surface.plt", Reader::Hpgl),
        command: "magician draw surface.plt",
        ..PLAIN
    },
    Piece {
        name: "lightburn",
        title: "A LightBurn job",
        says: "G-code in the form in which LightBurn saves it for GRBL, run as it is: the star is scanned at 30 %, the tag is cut at 90 %. With M4 \
               the power follows the speed, so the ends of short lines are lighter. [Files of LightBurn and Inkscape](../recipes/as-they-are.md).",
        input: Input::Lines("lightburn.gcode", Reader::Gcode),
        command: "magician engrave lightburn.gcode",
        ..PLAIN
    },
    Piece {
        name: "layers",
        title: "An Inkscape file with layers",
        says: "A layer named `%guides` is left out, and before `!2 sun, in red` the arm waits for the red pen. [Files of LightBurn and \
               Inkscape](../recipes/as-they-are.md).",
        input: Input::File("layers.svg"),
        command: "magician draw layers.svg",
        run: " --no-pause",
        ..PLAIN
    },
    Piece {
        name: "sphere",
        title: "An image as G-code",
        says: "Line by line, as LaserGRBL and its kin write images. The file does not say what full power is, so the person does.",
        input: Input::Lines("sphere.nc", Reader::Gcode),
        command: "magician engrave sphere.nc --s-max 255",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "house",
        title: "A plain SVG",
        says: "Lines, a circle and an ellipse, in true size.",
        input: Input::Lines("house.svg", Reader::Svg),
        command: "magician draw house.svg",
        ..PLAIN
    },
    Piece {
        name: "icon",
        title: "An icon made large",
        says: "An icon of 24 pixels, 6 mm, becomes 80 mm wide: its curves are followed in that size.",
        input: Input::Lines("icon.svg", Reader::Svg),
        command: "magician draw icon.svg --width 80",
        ..PLAIN
    },
    Piece {
        name: "curves",
        title: "Curves on a page",
        says: "Bézier curves, elliptical arcs and transforms, on a page measured in hundredths of a millimetre.",
        input: Input::Lines("curves.svg", Reader::Svg),
        command: "magician draw curves.svg",
        ..PLAIN
    },
    Piece {
        name: "star",
        title: "A shape of DobotStudio's kind",
        says: "HPGL, like the shapes that DobotStudio brings along.",
        input: Input::Lines("star.plt", Reader::Hpgl),
        command: "magician draw star.plt",
        ..PLAIN
    },
    Piece {
        name: "pen_outline",
        title: "G-code for a pen",
        says: "Lines and arcs; Z lifts the pen. The coordinates are the arm's own. [Run a G-code file](../recipes/gcode.md).",
        input: Input::Lines("pen_outline.gcode", Reader::Gcode),
        command: "magician run pen_outline.gcode",
        ..PLAIN
    },
    Piece {
        name: "laser_checker",
        title: "G-code for a laser",
        says: "Lines in both directions, with the laser's power by S.",
        input: Input::Lines("laser_checker.gcode", Reader::Gcode),
        command: "magician run laser_checker.gcode",
        ..PLAIN
    },
    Piece {
        name: "gradient",
        title: "Greys by laser",
        says: "A disc that fades from left to right, with lines 0.25 mm apart.",
        input: Input::Tones("engrave_gradient.png", [32.0, 0.25]),
        command: "magician engrave engrave_gradient.png --width 32 --spacing 0.25",
        pictures: Kind::Png,
        ..PLAIN
    },
    Piece {
        name: "jumps",
        title: "A DobotStudio playback file",
        says: "Jumps between named points, and the suction cup. [Play what DobotStudio saved](../recipes/playback.md).",
        command: "magician run jump_suction_named_v170.playback",
        pictures: Kind::Way,
        ..PLAIN
    },
];
