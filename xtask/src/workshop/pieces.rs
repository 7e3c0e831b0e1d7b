//! Pieces of the gallery as data: the only definition of their command lines.

use super::marks::Reader;

/// Command shown in the gallery, with its input and the pictures made of it.
pub(super) struct Piece {
    /// Prefix of the names of its pictures.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) description: &'static str,
    pub(super) input: Input,
    /// Command as typed by a user, without the final options.
    pub(super) command: &'static str,
    /// Options for the run that the preview does not need.
    pub(super) run: &'static str,
    /// File for its standard input.
    pub(super) stdin: Option<&'static str>,
    pub(super) pictures: PictureKind,
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
    /// A picture whose greys are burnt: width of the result and distance of its lines, mm.
    Tones(&'static str, [f64; 2]),
}

/// Pictures of a piece.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PictureKind {
    Svg,
    /// Raster image, because a file of all lines would be too large.
    Png,
    /// A preview only, since nothing is drawn.
    PreviewOnly,
}

impl Piece {
    pub(super) fn makes_marks(&self) -> bool {
        self.pictures != PictureKind::PreviewOnly
    }

    pub(super) fn preview(&self) -> String {
        self.picture_name("preview")
    }

    pub(super) fn result(&self) -> String {
        self.picture_name("result")
    }

    fn picture_name(&self, what: &str) -> String {
        let end = match self.pictures {
            PictureKind::Svg | PictureKind::PreviewOnly => "svg",
            PictureKind::Png => "png",
        };
        format!("{}-{what}.{end}", self.name)
    }

    /// Returns the command for the preview.
    pub(super) fn preview_command(&self) -> String {
        self.preview_command_as(&self.preview())
    }

    pub(super) fn preview_command_as(&self, picture: &str) -> String {
        self.command_line(&format!(" --preview {picture}"))
    }

    /// Returns the command that makes the piece.
    pub(super) fn make_command(&self) -> String {
        match self.pictures {
            PictureKind::PreviewOnly => self.command_line(" --port sim"),
            PictureKind::Svg | PictureKind::Png => self.make_command_as(&self.result()),
        }
    }

    pub(super) fn make_command_as(&self, picture: &str) -> String {
        self.command_line(&format!("{} --port sim --picture {picture}", self.run))
    }

    pub(super) fn estimate_command(&self) -> String {
        self.command_line(" --estimate --json")
    }

    fn command_line(&self, end: &str) -> String {
        let stdin = self.stdin.map(|file| format!(" < {file}"));
        format!("{}{end}{}", self.command, stdin.unwrap_or_default())
    }
}

/// Defaults of most pieces.
const DEFAULT_PIECE: Piece = Piece {
    name: "",
    title: "",
    description: "",
    input: Input::None,
    command: "",
    run: "",
    stdin: None,
    pictures: PictureKind::Svg,
};

pub(super) const PIECES: &[Piece] = &[
    Piece {
        name: "rosette",
        title: "A drawing with two pens",
        description: "Blue and black are two parts. Each pen has its own length and speed ([pens.toml](workshop/files/pens.toml)), and the arm waits \
               between them for you to change it; here nobody is there to do so (`--no-pause`). [Change pens](../recipes/pens.md).",
        input: Input::File("rosette.svg"),
        command: "magician draw rosette.svg --parts color --pens pens.toml",
        run: " --no-pause",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "logo-hatch",
        title: "A logo, filled with hatches",
        description: "Neighbouring lines are joined along the edge. [Fill a logo](../recipes/logo.md).",
        input: Input::File("logo.svg"),
        command: "magician draw logo.svg --fill hatch",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "logo-cross",
        title: "The logo with crossed hatches",
        description: "A second set of lines runs across the first.",
        input: Input::File("logo.svg"),
        command: "magician draw logo.svg --fill cross --fill-spacing 1.2",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "logo-contour",
        title: "The logo with rings",
        description: "Rings from the edge inwards, one behind the other.",
        input: Input::File("logo.svg"),
        command: "magician draw logo.svg --fill contour",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "poster",
        title: "A poster in words",
        description: "The words come from a file and are broken at a width; the letters are single lines. [A poster in words](../recipes/poster.md).",
        input: Input::Words,
        command: "magician write - --font script --size 7 --wrap 110 --align center --line-height 2.2",
        stdin: Some("notice.txt"),
        ..DEFAULT_PIECE
    },
    Piece {
        name: "name",
        title: "A name in a TrueType font",
        description: "The outlines of the letters, filled. Any `.ttf` or `.otf` will do.",
        input: Input::Words,
        command: "magician write Magician --font Roboto-Regular.ttf --size 16 --fill hatch --fill-spacing 0.5",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "hanzi",
        title: "Chinese, stroke after stroke",
        description: "Characters in the order in which they are written, from a file in the form of hanzi-writer; KanjiVG works as well.",
        input: Input::Words,
        command: "magician write 山水中文 --font hanzi.json --size 20",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "photo-outline",
        title: "A photo by pen: its outlines",
        description: "The edges of what is dark. [A photo four ways by pen](../recipes/photo.md).",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 90",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "photo-halftone",
        title: "A photo by pen: halftone",
        description: "Dots, the larger the darker.",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 70 --image halftone --pen-width 0.5 --spacing 2.5",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "photo-squiggle",
        title: "A photo by pen: squiggle",
        description: "Lines that swing the more the darker it is; the pen is hardly lifted.",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 90 --image squiggle --spacing 3",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "photo-hatch",
        title: "A photo by pen: hatches",
        description: "Straight lines, crossed by others where it is darker.",
        input: Input::File("landscape.png"),
        command: "magician draw landscape.png --width 90 --image hatch",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "letter",
        title: "A scanned letter, traced",
        description: "One stroke along the middle of each line. The scan is the picture of what a virtual arm once wrote.",
        input: Input::File("letter.png"),
        command: "magician draw letter.png --image centerline --pen-width 0.5 --width 66",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "photo-laser",
        title: "A photo by laser",
        description: "Grey becomes power. [Engrave with the laser](../recipes/engrave.md).",
        input: Input::Tones("landscape.png", [48.0, 0.25]),
        command: "magician engrave landscape.png --width 48 --spacing 0.25",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "box",
        title: "A box, engraved and cut",
        description: "Two layers of one file: the lid's star and word burn at 30 %, the outlines at full power, slowly, three times \
               ([box.toml](workshop/files/box.toml)). [Cut and engrave a box](../recipes/box.md).",
        input: Input::File("box.svg"),
        command: "magician engrave box.svg --pens box.toml",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "testgrid",
        title: "A test grid",
        description: "Powers across, speeds down. The virtual arm shows powers alone: it knows no material. [Read a test grid](../recipes/testgrid.md).",
        command: "magician testgrid --power 20:80:4 --speed 10:40:4",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "bracket",
        title: "A DXF with dimensions and texts",
        description: "As a CAD program hands it over; the file is in colours of layers, the arm has one pen.",
        input: Input::Lines("bracket.dxf", Reader::Dxf),
        command: "magician draw bracket.dxf",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "surface",
        title: "An HPGL plot",
        description: "What pen plotters drew forty years ago, in units of 0.025 mm.",
        input: Input::Lines("surface.plt", Reader::Hpgl),
        command: "magician draw surface.plt",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "lightburn",
        title: "A LightBurn job",
        description: "G-code in the form in which LightBurn saves it for GRBL, run as it is: the star is scanned at 30 %, the tag is cut at 90 %. With M4 \
               the power follows the speed, so the ends of short lines are lighter. [Files of LightBurn and Inkscape](../recipes/as-they-are.md).",
        input: Input::Lines("lightburn.gcode", Reader::Gcode),
        command: "magician engrave lightburn.gcode",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "layers",
        title: "An Inkscape file with layers",
        description: "A layer named `%guides` is left out, and before `!2 sun, in red` the arm waits for the red pen. [Files of LightBurn and \
               Inkscape](../recipes/as-they-are.md).",
        input: Input::File("layers.svg"),
        command: "magician draw layers.svg",
        run: " --no-pause",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "sphere",
        title: "An image as G-code",
        description: "Line by line, as LaserGRBL and its kin write images. The file does not say what full power is, so the person does.",
        input: Input::Lines("sphere.nc", Reader::Gcode),
        command: "magician engrave sphere.nc --s-max 255",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "house",
        title: "A plain SVG",
        description: "Lines, a circle and an ellipse, in true size.",
        input: Input::Lines("house.svg", Reader::Svg),
        command: "magician draw house.svg",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "icon",
        title: "An icon made large",
        description: "An icon of 24 pixels, 6 mm, becomes 80 mm wide: its curves are followed in that size.",
        input: Input::Lines("icon.svg", Reader::Svg),
        command: "magician draw icon.svg --width 80",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "curves",
        title: "Curves on a page",
        description: "Bézier curves, elliptical arcs and transforms, on a page measured in hundredths of a millimetre.",
        input: Input::Lines("curves.svg", Reader::Svg),
        command: "magician draw curves.svg",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "star",
        title: "A shape of DobotStudio's kind",
        description: "HPGL, like the shapes that DobotStudio brings along.",
        input: Input::Lines("star.plt", Reader::Hpgl),
        command: "magician draw star.plt",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "pen_outline",
        title: "G-code for a pen",
        description: "Lines and arcs; Z lifts the pen. The coordinates are the arm's own. [Run a G-code file](../recipes/gcode.md).",
        input: Input::Lines("pen_outline.gcode", Reader::Gcode),
        command: "magician run pen_outline.gcode",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "laser_checker",
        title: "G-code for a laser",
        description: "Lines in both directions, with the laser's power by S.",
        input: Input::Lines("laser_checker.gcode", Reader::Gcode),
        command: "magician run laser_checker.gcode",
        ..DEFAULT_PIECE
    },
    Piece {
        name: "gradient",
        title: "Greys by laser",
        description: "A disc that fades from left to right, with lines 0.25 mm apart.",
        input: Input::Tones("engrave_gradient.png", [32.0, 0.25]),
        command: "magician engrave engrave_gradient.png --width 32 --spacing 0.25",
        pictures: PictureKind::Png,
        ..DEFAULT_PIECE
    },
    Piece {
        name: "jumps",
        title: "A DobotStudio playback file",
        description: "Jumps between named points, and the suction cup. [Play what DobotStudio saved](../recipes/playback.md).",
        command: "magician run jump_suction_named_v170.playback",
        pictures: PictureKind::PreviewOnly,
        ..DEFAULT_PIECE
    },
];
