//! What a person may say of how a file is drawn, engraved or run, as plain data: flags of the command, keywords of Python,
//! `setup` of a station. One option, one name, one meaning.

mod asked;
mod fields;
mod framed;
mod grid;
mod pens;

use magician_host::{Set, words};
use serde::{Deserialize, Serialize};

pub use asked::{AskedGroup, AskedKind, AskedOption, DefaultValue};
pub use fields::OptionError;
pub use grid::Grid;
pub use pens::{PenMatch, PenOptions};

use crate::artwork::{Marking, Sheet, Tidy};
use crate::fill::{FillMode, Filling};
use crate::formats::Dialect;
use crate::lettering::{Align, FontChoice, TextOptions};
use crate::raster::{Adjust, Engrave, ImageStyle, Size, Tone, Trace};
use crate::{
    Action, Depths, Ending, Fills, Frame, FrameShape, Framing, Page, Paper, PartMode, PartRule,
    Placement, Plan, Power, ReadOptions, Setup, Surface, SystemFonts, TextLines, Tool, White, Work,
};

/// Acceleration along paths when a speed is asked for, as at power-up, mm/s2.
const ACCELERATION: f32 = 100.0;

/// What is made of drawings and images, as far as that was said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WorkOption {
    /// All is drawn with a pen.
    Draw,
    /// All is burnt.
    Engrave,
    /// Drawings are drawn, images engraved, all else is done where its file says.
    #[serde(skip)]
    ByFile,
}

/// How grey levels become power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum ModeOption {
    /// More power where it is darker.
    Grey,
    /// Full power for dark pixels, none for the rest.
    Threshold,
    /// Dots of full power, denser where it is darker.
    Dither,
}

/// The options of drawing and engraving. What is not given is as the settings or the file say. Lengths are mm, angles degrees,
/// speeds mm/s.
///
/// As JSON each is a member of its own name: numbers as numbers, points as arrays, switches as booleans.
///
/// ```
/// use magician_program::{Setup, SetupDefaults, SetupOptions};
/// use serde_json::json;
///
/// let fields = json!({"at": [230, 0], "scale": 0.5, "order": false});
/// let options = SetupOptions::from_fields(fields.as_object().unwrap())?;
/// let setup: Setup = options.setup(&SetupDefaults::default());
/// assert_eq!((setup.placement.at, setup.order), (Some([230.0, 0.0]), false));
/// let wrong = json!({"scale": -1});
/// assert_eq!(SetupOptions::from_fields(wrong.as_object().unwrap()).unwrap_err().key, "scale");
/// # Ok::<(), magician_program::OptionError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct SetupOptions {
    /// What is made of drawings and images; by the tool if not given: the laser engraves, every other tool draws.
    pub work: Option<WorkOption>,
    /// Machine of a G-code file.
    #[serde(with = "fields::text")]
    pub dialect: Option<Dialect>,
    /// S of full laser power in a G-code file.
    pub s_max: Option<f64>,
    /// What becomes of white lines and shapes.
    #[serde(with = "fields::text")]
    pub white: Option<White>,
    /// Points of a recording that are closer than this to the line are left out.
    pub resample: Option<f64>,
    /// Full power, percent, or the range of all power above 0.
    #[serde(with = "fields::power")]
    pub power: Option<Power>,
    /// Tool on the arm.
    #[serde(with = "fields::tool")]
    pub tool: Option<Tool>,
    /// Height of the work surface.
    pub surface: Option<f64>,
    /// Where a G-code program begins.
    pub start: Option<[f64; 3]>,
    /// A file of coordinates is placed like a drawing.
    pub place: bool,
    /// The file's coordinates are the arm's.
    pub raw: bool,
    /// Z at which the pen of placed G-code touches.
    pub pen_z: Option<f64>,
    /// Treatment of depths below the surface; a pen draws them on it unless given.
    #[serde(with = "fields::text")]
    pub depths: Option<Depths>,
    /// Where its centre goes.
    pub at: Option<[f64; 2]>,
    /// The page of paper that it lies on: as on the page of its file if that is as large, else its centre on the centre.
    #[serde(with = "fields::text")]
    pub page: Option<Paper>,
    /// What is made to fit keeps so far from the edges of the page.
    pub margin: Option<f64>,
    /// Its size, 1 being the true one.
    pub scale: Option<f64>,
    /// Turned counter-clockwise.
    pub rotate: Option<f64>,
    /// Made smaller until it can be reached.
    pub fit: bool,
    /// True if it may be turned by 90 degrees to lie in front of the arm, or to be larger where it is made to fit; it may unless
    /// given.
    pub turn: Option<bool>,
    /// A drawing is cut at its page.
    pub clip_page: bool,
    /// Mirrored left to right.
    pub mirror: bool,
    /// Moved on from where it lies.
    #[serde(rename = "move")]
    pub by: Option<[f64; 3]>,
    /// Repeated at each position of a grid.
    #[serde(with = "fields::text")]
    pub grid: Option<Grid>,
    /// Speed along the lines that are drawn or burnt.
    pub speed: Option<f64>,
    /// Speed ratio of point-to-point moves, percent.
    pub speed_ratio: Option<f64>,
    /// The pen stays down at the end and after a stop.
    pub stay: bool,
    /// Where the tip of the tool is parked at the end.
    pub park: Option<[f64; 3]>,
    /// Pen lift between lines.
    pub lift: Option<f64>,
    /// Least pen lift between lines that are near each other.
    pub hop: Option<f64>,
    /// Speed between lines.
    pub travel_speed: Option<f64>,
    /// Whether lines are drawn in the order that travels least; they are unless given.
    pub order: Option<bool>,
    /// Largest distance of a line from its curve.
    pub tolerance: Option<f64>,
    /// What is darker than this is dark, 1 to 255.
    pub threshold: Option<u8>,
    /// How wide it becomes.
    pub width: Option<f64>,
    /// How high it becomes.
    pub height: Option<f64>,
    /// How grey levels become power.
    pub mode: Option<ModeOption>,
    /// What a pen makes of an image.
    #[serde(with = "fields::text")]
    pub image: Option<ImageStyle>,
    /// Sizes of dots, or hatchings laid over each other, of an image that a pen draws.
    pub levels: Option<u8>,
    /// Spots of an image that are smaller are not drawn; all are with 0.
    pub despeckle: Option<f64>,
    /// Width of the line that the pen draws, for an image.
    pub pen_width: Option<f64>,
    /// What is kept of an image, in its pixels: from the left, from the top, width, height.
    pub crop: Option<[u32; 4]>,
    /// How much lighter an image is made, -100 to 100.
    pub brightness: Option<f64>,
    /// How much more contrast an image is given, -100 to 100.
    pub contrast: Option<f64>,
    /// White is drawn or burnt, black is not.
    pub invert: bool,
    /// Distance between the lines or dots of an image.
    pub spacing: Option<f64>,
    /// All lines of an image are burnt in the same direction.
    pub one_way: bool,
    /// Run-up and run-out of the tool at the ends of a line.
    pub overscan: Option<f64>,
    /// Exponent of the darkness.
    pub gamma: Option<f64>,
    /// Ends of lines of a drawing that are no farther apart are joined; none with 0.
    pub merge: Option<f64>,
    /// Whether a line that is there twice is drawn once: of drawings it is unless given. Where it is on, the lines of a program (G-code,
    /// a plan, playback, points) are tidied as those of a drawing, but stay in their order.
    pub dedupe: Option<bool>,
    /// Points of a drawing that are no farther from the line without them are left out; none with 0.
    pub simplify: Option<f64>,
    /// Font of text.
    #[serde(with = "fields::text")]
    pub font: Option<FontChoice>,
    /// Height of a capital in text.
    pub size: Option<f64>,
    /// Width that lines of text are broken at.
    pub wrap: Option<f64>,
    /// Where shorter lines of text lie.
    #[serde(with = "fields::text")]
    pub align: Option<Align>,
    /// From one line of text to the next, in heights of a capital.
    pub line_height: Option<f64>,
    /// How the letters of texts in drawings are drawn.
    #[serde(with = "fields::text")]
    pub text: Option<TextLines>,
    /// Whether texts in drawings are written in the installed fonts that they name; on unless given.
    #[serde(with = "fields::text")]
    pub system_fonts: Option<SystemFonts>,
    /// How filled shapes are filled.
    #[serde(with = "fields::text")]
    pub fill: Option<FillMode>,
    /// Distance of the lines that fill a shape.
    pub fill_spacing: Option<f64>,
    /// Direction of the lines that fill a shape, counter-clockwise from x.
    pub fill_angle: Option<f64>,
    /// Distance of the lines that fill a shape from its edge.
    pub fill_inset: Option<f64>,
    /// What the parts of a drawing are; layers unless given, where a layer's name has a command to a plotter, or parts are chosen or
    /// have pens; else it has none.
    #[serde(with = "fields::text")]
    pub parts: Option<PartMode>,
    /// The parts that are drawn, each by its name, its colour or its number; all of them if none is given.
    pub only: Vec<String>,
    /// How often each part is drawn before the next.
    pub passes: Option<u32>,
    /// Pens of parts; the first that is for a part counts.
    pub pens: Vec<PenOptions>,
    /// The job never waits for a person, not between parts nor where the program says so.
    pub no_pause: bool,
    /// Text is refused of which the font lacks a character.
    pub strict_text: bool,
    /// What is gone round of what would be marked, instead of marking it.
    #[serde(with = "fields::text")]
    pub frame: Option<FrameShape>,
    /// Power of the laser on a frame, percent.
    pub frame_power: Option<f64>,
}

/// What settings say where an option is left open.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SetupDefaults {
    /// The tool that is on the arm as a rule.
    pub tool: Option<Tool>,
    /// The sheet that drawings lie on.
    pub sheet: Option<Sheet>,
    /// The surface that drawings and images lie on.
    pub surface: Option<Surface>,
    /// The surface that is assumed where none is known: the table of a virtual arm.
    pub assumed_surface: Option<Surface>,
    /// Speed of the pen.
    pub draw_speed: Option<f64>,
    /// Speed of the pen between lines.
    pub draw_travel_speed: Option<f64>,
    /// Pen lift between lines.
    pub draw_lift: Option<f64>,
    /// Speed of the laser on drawings and images.
    pub engrave_speed: Option<f64>,
    /// Full power.
    pub engrave_power: Option<Power>,
    /// Where the tip of the tool is parked at the end.
    pub park: Option<[f64; 3]>,
}

impl SetupOptions {
    /// Those of a file that is run as it is: nothing but the settings counts.
    #[must_use]
    pub fn by_file() -> Self {
        Self {
            work: Some(WorkOption::ByFile),
            ..Self::default()
        }
    }

    /// How the file is to be done.
    #[must_use]
    pub fn setup(&self, defaults: &SetupDefaults) -> Setup {
        let usual = Marking::pen();
        let placement = Placement {
            frame: match (self.place, self.raw) {
                (_, true) => Frame::Arm,
                (true, _) => Frame::Own,
                _ => Frame::Default,
            },
            pen_z: self.pen_z,
            at: self.at,
            page: self.placed_page(),
            grid: self.grid,
            scale: self.scale.unwrap_or(1.0),
            rotate: self.rotate.unwrap_or(0.0),
            fit: self.fit,
            turn: self.turn.unwrap_or(true),
            mirror: self.mirror,
            keeps_page: false,
            by: self.by.unwrap_or_default(),
        };
        let speed = |said: Option<f64>, usual| said.map_or(usual, |speed| speed as f32);
        Setup {
            tool: self.tool,
            default_tool: defaults.tool,
            surface: self.surface.map(Surface::level),
            default_surface: defaults.surface,
            assumed_surface: defaults.assumed_surface,
            sheet: defaults.sheet,
            placement,
            pen: Marking {
                lift: self.lift_over(defaults),
                hop: self.hop.or(usual.hop),
                speed: speed(defaults.draw_speed, usual.speed),
                travel: speed(
                    self.travel_speed.or(defaults.draw_travel_speed),
                    usual.travel,
                ),
                ..usual
            },
            tidy: self.tidy(),
            tidy_programs: self.dedupe == Some(true),
            order: self.order.unwrap_or(true),
            work: self.work(defaults),
            size: self.size(),
            adjust: self.adjust(defaults),
            speed: self.speed.map(|speed| speed as f32),
            laser_speed: defaults.engrave_speed,
            filling: self.filling(),
            power: self.power,
            default_power: defaults.engrave_power,
            parts: self.parts,
            only: self.only.clone(),
            passes: self.passes,
            pens: self.pens.iter().map(PartRule::from).collect(),
            no_pause: self.no_pause,
            fence: None,
            framing: self.frame.map(|shape| Framing {
                power: self.frame_power,
                ..Framing::of(shape)
            }),
            depths: self.depths.unwrap_or_default(),
        }
    }

    /// The page, with its margin.
    pub(super) fn placed_page(&self) -> Option<Page> {
        let mut page = Page::of(self.page?);
        page.margin = self.margin.unwrap_or(page.margin);
        Some(page)
    }

    /// How the file is read, to be done so.
    #[must_use]
    pub fn reading(&self, setup: &Setup) -> ReadOptions {
        let mut options = ReadOptions::default();
        options.tolerance = self.tolerance.unwrap_or(options.tolerance);
        options.scale = self.scale.unwrap_or(options.scale);
        options.white = self.white.unwrap_or_default();
        options.clip_page = self.clip_page;
        let fills = |pen: &PenOptions| pen.fill.is_some_and(|mode| mode != FillMode::None);
        if self.filling().mode != FillMode::None || self.pens.iter().any(fills) {
            options.fills = Fills::Areas;
        }
        options.resample = self.resample;
        options.crop = self.crop;
        options.text = self.text_options();
        options.text_lines = self.text.unwrap_or_default();
        options.system_fonts = self.system_fonts.unwrap_or(SystemFonts::On);
        options.strict_text = self.strict_text;
        setup.prepare(&mut options.gcode, setup.known_surface());
        // What has an S of full power is a laser's.
        let of_laser = self.s_max.map(|_| Dialect::Laser);
        options.gcode.dialect = self.dialect.or(of_laser).unwrap_or_default();
        options.gcode.burns = matches!(setup.work, Work::Engrave(_));
        options.gcode.s_max = self.s_max;
        options.gcode.laser_speed = setup.laser_speed.unwrap_or(options.gcode.laser_speed);
        options
    }

    /// How the lines of a drawing are tidied.
    fn tidy(&self) -> Tidy {
        let mut tidy = Tidy::default();
        tidy.merge = self.merge.unwrap_or(tidy.merge);
        tidy.dedupe = self.dedupe.unwrap_or(tidy.dedupe);
        tidy.simplify = self.simplify.unwrap_or(tidy.simplify);
        tidy
    }

    /// How shapes are filled.
    fn filling(&self) -> Filling {
        Filling {
            mode: self.fill.unwrap_or_default(),
            spacing: self.fill_spacing,
            angle: self.fill_angle,
            inset: self.fill_inset,
        }
    }

    /// How text is set.
    fn text_options(&self) -> TextOptions {
        let usual = TextOptions::default();
        TextOptions {
            font: self.font.clone().unwrap_or(usual.font),
            size: self.size.unwrap_or(usual.size),
            wrap: self.wrap,
            align: self.align.unwrap_or(usual.align),
            line_height: self.line_height.unwrap_or(usual.line_height),
        }
    }

    /// What becomes of the pen and the arm at the end; `drawing` as in [`Ending::drawing`].
    #[must_use]
    pub fn ending(&self, defaults: &SetupDefaults, drawing: bool) -> Ending {
        Ending {
            lift: self.lift_over(defaults),
            stay: self.stay,
            drawing,
            park: self.park.or(defaults.park).filter(|_| !self.stay),
            depths: self.depths.unwrap_or_default(),
        }
    }

    /// Which work it is.
    fn choice(&self, defaults: &SetupDefaults) -> WorkOption {
        self.work
            .unwrap_or_else(|| match self.tool.or(defaults.tool) {
                // What the pen makes of an image is asked for by name; a laser that is named burns it.
                _ if self.image.is_some() && self.tool != Some(Tool::Laser) => WorkOption::Draw,
                Some(Tool::Laser) => WorkOption::Engrave,
                _ => WorkOption::Draw,
            })
    }

    fn work(&self, defaults: &SetupDefaults) -> Work {
        match self.choice(defaults) {
            WorkOption::ByFile if self.image.is_none() => Work::Default,
            WorkOption::Draw | WorkOption::ByFile => {
                let mut trace = Trace::default();
                trace.level = self.threshold.unwrap_or(trace.level);
                trace.tolerance = self.tolerance.unwrap_or(trace.tolerance);
                trace.style = self.image.unwrap_or_default();
                trace.levels = self.levels;
                trace.despeckle = self.despeckle.unwrap_or(trace.despeckle);
                trace.spacing = self.spacing;
                trace.pen_width = self.pen_width.unwrap_or(trace.pen_width);
                Work::Draw(trace)
            }
            WorkOption::Engrave => Work::Engrave(self.engrave()),
        }
    }

    /// How the greys of an image are changed before anything else; those that are engraved are inverted and bent with the power.
    fn adjust(&self, defaults: &SetupDefaults) -> Adjust {
        let mut adjust = Adjust::default();
        adjust.brightness = self.brightness.unwrap_or(adjust.brightness);
        adjust.contrast = self.contrast.unwrap_or(adjust.contrast);
        if let Work::Draw(_) = self.work(defaults) {
            adjust.invert = self.invert;
            adjust.gamma = self.gamma.unwrap_or(adjust.gamma);
        }
        adjust
    }

    fn engrave(&self) -> Engrave {
        let usual = Engrave::default();
        Engrave {
            tone: match self.mode {
                None | Some(ModeOption::Grey) => Tone::Grey,
                Some(ModeOption::Threshold) => Tone::Threshold(self.threshold.unwrap_or(128)),
                Some(ModeOption::Dither) => Tone::Dither,
            },
            invert: self.invert,
            both_directions: !self.one_way,
            spacing: self.spacing.unwrap_or(usual.spacing),
            overscan: self.overscan.or(usual.overscan),
            gamma: self.gamma.unwrap_or(usual.gamma),
            ..usual
        }
    }

    fn size(&self) -> Size {
        match (self.width, self.height) {
            (Some(width), _) => Size::Width(width),
            (None, Some(height)) => Size::Height(height),
            (None, None) => Size::Natural,
        }
    }

    fn lift_over(&self, defaults: &SetupDefaults) -> f64 {
        let lift = self.lift.or(defaults.draw_lift);
        lift.unwrap_or(Marking::pen().lift)
    }

    /// What the arm is told first, besides what the plan says; `taught` is one in the arm's coordinates.
    pub(crate) fn settings(&self, plan: &mut Plan, taught: bool) -> Vec<Set> {
        let mut settings = Vec::new();
        if let Some(ratio) = self.speed_ratio {
            settings.push(plan.moves_at(ratio as f32));
        }
        let path = |action: &Action| matches!(action, Action::Path { .. } | Action::Burn { .. });
        if let Some(speed) = self.speed.filter(|_| taught)
            && plan.steps.iter().any(|step| path(&step.action))
        {
            settings.push(words::path_speed(speed as f32, ACCELERATION));
        }
        settings
    }
}
