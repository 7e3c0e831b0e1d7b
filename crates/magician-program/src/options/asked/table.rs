//! The options as a table, in one file as long as it is: what each is, and for which formats it counts.

use super::{AskedGroup, AskedKind, AskedOption, DefaultValue};
use crate::fill::FillMode;
use crate::raster::{ImageStyle, Trace};
use crate::{
    Align, BundledFont, Depths, Format, FrameShape, Framing, PartMode, SystemFonts, TextLines,
    White,
};
use crate::{SetupOptions, WorkOption};

use AskedGroup::{Fill, Image, Laser, More, Parts, Pen, Place, Text};
use AskedKind as Kind;

const fn option(
    name: &'static str,
    kind: AskedKind,
    unit: &'static str,
    group: AskedGroup,
    about: &'static str,
) -> AskedOption {
    AskedOption {
        name,
        kind,
        unit,
        choices: &[],
        default: None,
        least: None,
        above: None,
        most: None,
        with: None,
        when: &[],
        group,
        usual: false,
        about,
    }
}

const fn number(
    name: &'static str,
    unit: &'static str,
    group: AskedGroup,
    about: &'static str,
) -> AskedOption {
    option(name, Kind::Number, unit, group, about)
}

const fn switch(name: &'static str, group: AskedGroup, about: &'static str) -> AskedOption {
    option(name, Kind::Switch, "", group, about).or(DefaultValue::Switch(false))
}

const fn choice(
    name: &'static str,
    choices: &'static [&'static str],
    group: AskedGroup,
    about: &'static str,
) -> AskedOption {
    AskedOption {
        choices,
        ..option(name, Kind::Choice, "", group, about)
    }
}

/// A choice of which the first is taken where none is given.
const fn first_of(
    name: &'static str,
    choices: &'static [&'static str],
    group: AskedGroup,
    about: &'static str,
) -> AskedOption {
    let option = choice(name, choices, group, about);
    match choices {
        [first, ..] => option.or(DefaultValue::Word(first)),
        [] => option,
    }
}

impl AskedOption {
    const fn or(self, default: DefaultValue) -> Self {
        Self {
            default: Some(default),
            ..self
        }
    }

    const fn above(self, number: f64) -> Self {
        Self {
            above: Some(number),
            ..self
        }
    }

    const fn from(self, least: f64) -> Self {
        Self {
            least: Some(least),
            ..self
        }
    }

    const fn to(self, most: f64) -> Self {
        Self {
            most: Some(most),
            ..self
        }
    }

    const fn with(self, other: &'static str, when: &'static [&'static str]) -> Self {
        Self {
            with: Some(other),
            when,
            ..self
        }
    }
}

use DefaultValue::{Number, Switch};

const TOOL: AskedOption = first_of("tool", &["pen", "laser"], Place, "Tool on the arm");
const SURFACE: AskedOption = number("surface", "mm", Place, "Height of the work surface");
const AT: AskedOption = option("at", Kind::Point, "mm", Place, "Where its centre goes");
const PAGE: [AskedOption; 2] = [
    choice(
        "page",
        crate::Paper::NAMES,
        Place,
        "Page of paper that it lies on; a size in mm, such as 200x150, is taken too",
    ),
    number(
        "margin",
        "mm",
        Place,
        "What is made to fit keeps so far from the edges of the page",
    )
    .from(0.0)
    .or(Number(crate::Page::MARGIN))
    .with("page", crate::Paper::NAMES),
];
const SCALE: AskedOption = number("scale", "", Place, "Its size, 1 being the true one")
    .above(0.0)
    .or(Number(1.0));
const WIDTH: AskedOption = number("width", "mm", Place, "How wide it becomes").above(0.0);
const HEIGHT: AskedOption = number(
    "height",
    "mm",
    Place,
    "How high it becomes, instead of how wide",
)
.above(0.0);
const ROTATE: AskedOption =
    number("rotate", "deg", Place, "Turned counter-clockwise").or(Number(0.0));
const FIT: AskedOption = switch("fit", Place, "Made smaller until it can be reached");
const TURN: AskedOption =
    switch("turn", Place, "Turned by 90 degrees where that fits better").or(Switch(true));
const MIRROR: AskedOption = switch("mirror", Place, "Mirrored left to right");
const MOVE: AskedOption = option(
    "move",
    Kind::Place,
    "mm",
    Place,
    "Moved on from where it lies",
);
const CLIP: AskedOption = switch("clip_page", Place, "Cut at its page");
const GRID: AskedOption = option(
    "grid",
    Kind::Text,
    "",
    Place,
    "Repeated at each position of a grid, such as 2x3:40x30",
);
const PLACE: AskedOption = switch(
    "place",
    Place,
    "A file of coordinates is placed like a drawing",
);
const RAW: AskedOption = switch("raw", More, "The file's coordinates are the arm's");

const FILL: AskedOption = first_of(
    "fill",
    FillMode::NAMES,
    Fill,
    "Lines that shapes are filled with",
);
const FILLED: &[&str] = &["hatch", "cross", "contour"];
const FILLS: [AskedOption; 4] = [
    number("fill_spacing", "mm", Fill, "Distance of these lines")
        .from(crate::fill::LEAST_SPACING)
        .with("fill", FILLED),
    number("fill_angle", "deg", Fill, "Direction of these lines")
        .or(Number(45.0))
        .with("fill", &["hatch", "cross"]),
    number(
        "fill_inset",
        "mm",
        Fill,
        "Distance of these lines from the edge",
    )
    .from(0.0)
    .with("fill", FILLED),
    first_of(
        "white",
        White::NAMES,
        Fill,
        "What becomes of white lines and shapes",
    ),
];

const FONT: AskedOption = first_of("font", BundledFont::NAMES, Text, "Font of text");
const SIZE: AskedOption = number("size", "mm", Text, "Height of a capital")
    .above(0.0)
    .or(Number(10.0));
const WRAP: AskedOption = number("wrap", "mm", Text, "Width that lines are broken at").above(0.0);
const SETTING: [AskedOption; 2] = [
    first_of("align", Align::NAMES, Text, "Where shorter lines lie"),
    number(
        "line_height",
        "",
        Text,
        "From one line to the next, in heights of a capital",
    )
    .above(0.0)
    .or(Number(1.8)),
];
const LETTERS: [AskedOption; 2] = [
    first_of(
        "text",
        TextLines::NAMES,
        Text,
        "How the letters of texts are drawn",
    ),
    first_of(
        "system_fonts",
        SystemFonts::NAMES,
        Text,
        "Whether texts are written in the installed fonts that they name",
    ),
];
const STRICT: AskedOption = switch(
    "strict_text",
    Text,
    "Refused where the font lacks a character",
);

const PASSES: AskedOption = option(
    "passes",
    Kind::Integer,
    "",
    Parts,
    "How often each part is drawn before the next",
)
.from(1.0)
.to(crate::setup::MOST_PASSES as f64)
.or(Number(1.0));
const NO_PAUSE: AskedOption = switch("no_pause", Parts, "Never waits for a person");
const DIVIDED: [AskedOption; 3] = [
    choice(
        "parts",
        PartMode::NAMES,
        Parts,
        "What the parts of the drawing are",
    ),
    option(
        "only",
        Kind::List,
        "",
        Parts,
        "The parts that are drawn: names, colours or numbers; all of them if none is given",
    ),
    option(
        "pens",
        Kind::Pens,
        "",
        Parts,
        "Pens of the parts; the first that is for a part counts",
    ),
];

const IMAGE: AskedOption = first_of(
    "image",
    ImageStyle::NAMES,
    Image,
    "What the pen makes of an image",
);
const PICTURE: [AskedOption; 10] = [
    option(
        "levels",
        Kind::Integer,
        "",
        Image,
        "Sizes of dots, or hatchings over each other",
    )
    .from(1.0)
    .to(64.0)
    .with("image", &["halftone", "hatch"]),
    number("despeckle", "mm", Image, "Smaller spots are not drawn")
        .from(0.0)
        .or(Number(0.3)),
    number("pen_width", "mm", Image, "Width of the pen's line")
        .above(0.0)
        .or(Number(Trace::PEN_WIDTH)),
    number(
        "spacing",
        "mm",
        Image,
        "Distance between the lines or dots of an image",
    )
    .above(0.0),
    option(
        "threshold",
        Kind::Integer,
        "",
        Image,
        "What is darker than this grey is dark",
    )
    .from(1.0)
    .to(255.0)
    .or(Number(128.0)),
    option(
        "crop",
        Kind::Area,
        "px",
        Image,
        "What is kept of the image: from the left, from the top, width, height",
    ),
    number("brightness", "", Image, "How much lighter it is made")
        .from(-100.0)
        .to(100.0)
        .or(Number(0.0)),
    number("contrast", "", Image, "How much more contrast it is given")
        .from(-100.0)
        .to(100.0)
        .or(Number(0.0)),
    number("gamma", "", Image, "Exponent of the darkness")
        .above(0.0)
        .or(Number(1.0)),
    switch("invert", Image, "White is drawn or burnt, black is not"),
];

const POWER: AskedOption = option(
    "power",
    Kind::Text,
    "%",
    Laser,
    "Full power, or the range of all power above 0, such as 5..80",
)
.with("tool", &["laser"]);
const SCANNED: [AskedOption; 3] = [
    first_of(
        "mode",
        &["grey", "threshold", "dither"],
        Laser,
        "How grey levels become power",
    ),
    switch(
        "one_way",
        Laser,
        "All lines are burnt in the same direction",
    ),
    number(
        "overscan",
        "mm",
        Laser,
        "Run-up and run-out of the tool at the ends of a line",
    )
    .above(0.0),
];
const FRAME: [AskedOption; 2] = [
    choice(
        "frame",
        FrameShape::NAMES,
        Laser,
        "Goes round what would be marked, instead of marking it",
    ),
    number("frame_power", "%", Laser, "Power of the laser on a frame")
        .above(0.0)
        .to(Framing::MOST_POWER)
        .with("frame", FrameShape::NAMES),
];

const PEN: [AskedOption; 5] = [
    number("lift", "mm", Pen, "Pen lift between lines").above(0.0),
    number("hop", "mm", Pen, "Least pen lift, on short ways").above(0.0),
    number("travel_speed", "mm/s", Pen, "Speed between lines").above(0.0),
    switch(
        "stay",
        Pen,
        "The pen stays down at the end and after a stop",
    ),
    first_of(
        "depths",
        Depths::NAMES,
        Pen,
        "What the pen makes of depths below the surface",
    ),
];
const LINES: [AskedOption; 4] = [
    switch(
        "order",
        Pen,
        "Lines are drawn in the order that travels least",
    )
    .or(Switch(true)),
    number(
        "merge",
        "mm",
        Pen,
        "Ends of lines that are no farther apart are joined",
    )
    .from(0.0)
    .or(Number(0.1)),
    switch("dedupe", Pen, "A line that is there twice is drawn once").or(Switch(true)),
    number(
        "simplify",
        "mm",
        Pen,
        "Points that are no farther from the line without them are left out",
    )
    .from(0.0)
    .or(Number(0.02)),
];
/// Hygiene of programs, which is never done unasked.
const DEDUPE: [AskedOption; 3] = [
    LINES[2].or(Switch(false)),
    LINES[1].with("dedupe", &[]),
    LINES[3].with("dedupe", &[]),
];

const fn tolerance(usual: f64) -> AskedOption {
    let about = "Largest distance of a line from its curve";
    number("tolerance", "mm", Pen, about)
        .above(0.0)
        .or(Number(usual))
}

const SPEED: AskedOption = number(
    "speed",
    "mm/s",
    More,
    "Speed along the lines that are drawn or burnt",
)
.above(0.0);
const RUN: [AskedOption; 2] = [
    number(
        "speed_ratio",
        "%",
        More,
        "Speed ratio of point-to-point moves",
    )
    .from(1.0)
    .to(100.0),
    option(
        "park",
        Kind::Place,
        "mm",
        More,
        "Where the tip of the tool is parked at the end",
    ),
];
const GCODE: [AskedOption; 4] = [
    choice(
        "dialect",
        &["pen", "laser", "servo"],
        More,
        "Machine of the file",
    ),
    number("s_max", "", Laser, "S of full laser power").above(0.0),
    number(
        "pen_z",
        "mm",
        Place,
        "Z at which the pen of placed G-code touches",
    )
    .with("place", &[]),
    option(
        "start",
        Kind::Place,
        "mm",
        More,
        "Where it begins, where it does not say so",
    ),
];
const RESAMPLE: AskedOption = number(
    "resample",
    "mm",
    More,
    "Points of a recording that are closer than this to the line are left out",
)
.above(0.0);

/// Those of a file that is placed only where that is asked for.
const fn placed(option: AskedOption) -> AskedOption {
    option.with("place", &[])
}

const PAGE_OF_PROGRAMS: [AskedOption; 2] = [placed(PAGE[0]), PAGE[1]];
const USUAL_OF_GCODE: [AskedOption; 6] = [
    PLACE,
    placed(TOOL),
    placed(SURFACE),
    placed(AT),
    placed(SCALE),
    placed(ROTATE),
];
const REST_OF_GCODE: [AskedOption; 7] = [
    placed(WIDTH),
    placed(HEIGHT),
    placed(FIT),
    MIRROR,
    MOVE,
    GRID,
    RAW,
];
const OF_PLANS: [AskedOption; 13] = [
    PLACE,
    placed(TOOL),
    placed(SURFACE),
    placed(AT),
    placed(WIDTH),
    placed(HEIGHT),
    placed(FIT),
    SCALE,
    ROTATE,
    MIRROR,
    MOVE,
    GRID,
    RAW,
];
const BURNT: [AskedOption; 2] = [SCANNED[1], SCANNED[2]];
const FINE: [AskedOption; 1] = [tolerance(0.05)];
const TRACED: [AskedOption; 1] = [tolerance(0.1)];

/// An option that counts for one kind of work alone: the other one refuses it.
#[derive(Clone, Copy)]
pub(in crate::options) struct OfWork {
    pub(in crate::options) key: &'static str,
    pub(in crate::options) work: WorkOption,
    /// True if it is given.
    pub(in crate::options) given: fn(&SetupOptions) -> bool,
}

const fn of_work(key: &'static str, work: WorkOption, given: fn(&SetupOptions) -> bool) -> OfWork {
    OfWork { key, work, given }
}

pub(in crate::options) const OF_WORK: [OfWork; 7] = [
    of_work("mode", WorkOption::Engrave, |said| said.mode.is_some()),
    of_work("one_way", WorkOption::Engrave, |said| said.one_way),
    of_work("overscan", WorkOption::Engrave, |said| {
        said.overscan.is_some()
    }),
    of_work("image", WorkOption::Draw, |said| said.image.is_some()),
    of_work("levels", WorkOption::Draw, |said| said.levels.is_some()),
    of_work("despeckle", WorkOption::Draw, |said| {
        said.despeckle.is_some()
    }),
    of_work("pen_width", WorkOption::Draw, |said| {
        said.pen_width.is_some()
    }),
];

/// The same option, which counts with its work alone. One that counts with another option is bound
/// by that one.
fn bound_to_work(option: AskedOption) -> AskedOption {
    let of_work = OF_WORK.iter().find(|of_work| of_work.key == option.name);
    match (of_work.map(|of_work| of_work.work), option.with) {
        (Some(WorkOption::Engrave), None) => option.with("work", &["engrave"]),
        (Some(_), None) => option.with("work", &["draw"]),
        _ => option,
    }
}

/// The options that count for a file of a format, those that are seldom left out first.
pub(super) fn of(format: Format) -> Vec<AskedOption> {
    let usual: &[AskedOption] = match format {
        Format::Svg => &[TOOL, FILL, SURFACE, AT, SCALE, ROTATE, FIT],
        Format::Dxf | Format::Hpgl => &[TOOL, SURFACE, AT, SCALE, ROTATE, FIT],
        Format::Image => &[TOOL, IMAGE, SURFACE, AT, WIDTH, ROTATE, FIT],
        Format::Text => &[FONT, SIZE, WRAP, TOOL, SURFACE, AT, ROTATE, FIT],
        Format::TestGrid => &[SURFACE, AT, SCALE, ROTATE, FIT],
        Format::Gcode => &USUAL_OF_GCODE,
        Format::Playback | Format::Blockly | Format::Points | Format::Plan => &[],
    };
    let usual = usual.iter().map(|option| AskedOption {
        usual: true,
        ..*option
    });
    let repeated: &[AskedOption] = &[PASSES, NO_PAUSE, POWER];
    let lies: &[AskedOption] = &[PAGE[0], PAGE[1], TURN, MIRROR, MOVE, GRID];
    let rest: &[&[AskedOption]] = match format {
        Format::Svg => &[
            &[WIDTH, HEIGHT, CLIP],
            lies,
            &FILLS,
            &LETTERS,
            &[STRICT],
            &DIVIDED,
            repeated,
            &FRAME,
            &PEN,
            &LINES,
            &FINE,
            &[SPEED],
            &RUN,
        ],
        Format::Dxf | Format::Hpgl => &[
            &[WIDTH, HEIGHT, CLIP],
            lies,
            &[FILL],
            &FILLS,
            &[STRICT],
            &DIVIDED,
            repeated,
            &FRAME,
            &PEN,
            &LINES,
            &FINE,
            &[SPEED],
            &RUN,
        ],
        Format::Text => &[
            &[SCALE, WIDTH, HEIGHT],
            lies,
            &[FILL],
            &FILLS,
            &SETTING,
            &[STRICT],
            repeated,
            &FRAME,
            &PEN,
            &LINES,
            &FINE,
            &[SPEED],
            &RUN,
        ],
        Format::Image => &[
            &[SCALE, HEIGHT],
            lies,
            &PICTURE,
            repeated,
            &SCANNED,
            &FRAME,
            &PEN,
            &LINES,
            &TRACED,
            &[SPEED],
            &RUN,
        ],
        Format::TestGrid => &[lies, &BURNT, &FRAME, &RUN],
        Format::Gcode => &[
            &PAGE_OF_PROGRAMS,
            &REST_OF_GCODE,
            &GCODE,
            &[DIVIDED[0]],
            repeated,
            &FRAME,
            &PEN,
            &DEDUPE,
            &FINE,
            &[SPEED],
            &RUN,
        ],
        Format::Points => &[
            &OF_PLANS,
            &PAGE_OF_PROGRAMS,
            &[RESAMPLE],
            repeated,
            &FRAME,
            &PEN,
            &DEDUPE,
            &[SPEED],
            &RUN,
        ],
        Format::Playback | Format::Blockly | Format::Plan => &[
            &OF_PLANS,
            &PAGE_OF_PROGRAMS,
            repeated,
            &FRAME,
            &PEN,
            &DEDUPE,
            &[SPEED],
            &RUN,
        ],
    };
    let rest = rest.iter().copied().flatten().copied();
    let all = usual.chain(rest);
    match format {
        // A test grid is burnt with any tool: there is one kind of work.
        Format::TestGrid => all.collect(),
        _ => all.map(bound_to_work).collect(),
    }
}
