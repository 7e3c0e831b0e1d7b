//! Remedies of errors and notes, as data. Front ends (the command, Python, JSON) put them into
//! their own words by implementing [`Voice`].

use std::borrow::Cow;
use std::fmt;

/// An act with its effect: `magician stop` **drops what waits**.
///
/// ```
/// use magician_host::{Act, Action, Remedy};
///
/// let remedy = Remedy::new(Action::Stop, "drops what waits");
/// assert_eq!(remedy.act, Act::Do(Action::Stop));
/// assert_eq!(remedy.act.to_string(), "stop");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Remedy {
    /// The act.
    pub act: Act,
    /// Effect, as a predicate without a full stop that follows the name of the act. Empty if the
    /// act is self-explanatory.
    pub effect: Cow<'static, str>,
}

impl Remedy {
    /// Creates a remedy from an act and its effect.
    pub fn new(act: impl Into<Act>, effect: impl Into<Cow<'static, str>>) -> Self {
        Self {
            act: act.into(),
            effect: effect.into(),
        }
    }

    /// Creates the remedy of leaving an option out.
    #[must_use]
    pub const fn without(setting: Setting) -> Self {
        Self {
            act: Act::Omit(setting),
            effect: Cow::Borrowed(""),
        }
    }
}

/// An act recommended to the user.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Act {
    /// Perform an action on the arm, or a query.
    Do(Action),
    /// Give an option with this value.
    Give(Setting, SettingValue),
    /// Leave an option out.
    Omit(Setting),
    /// Run a command of the operating system, as typed.
    System(Cow<'static, str>),
    /// Assign a function to a pin, given by its EIO address.
    SetPin(u8, PinUse),
    /// Use the arm through the station at this address.
    UseStation(Cow<'static, str>),
}

/// Function of an output pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PinUse {
    /// Digital level.
    DigitalOutput,
    /// Pulse-width modulation.
    Pwm,
}

impl PinUse {
    /// Name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::DigitalOutput => "digital-output",
            Self::Pwm => "pwm",
        }
    }
}

impl From<Action> for Act {
    fn from(action: Action) -> Self {
        Self::Do(action)
    }
}

impl From<(Setting, SettingValue)> for Act {
    fn from((setting, given): (Setting, SettingValue)) -> Self {
        Self::Give(setting, given)
    }
}

/// Formats the name as in JSON: `home`, `scale 0.5`, `without raw`.
impl fmt::Display for Act {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Do(action) => f.write_str(action.name()),
            Self::Give(setting, SettingValue::On) => f.write_str(setting.name()),
            Self::Give(setting, given) => write!(f, "{} {given}", setting.name()),
            Self::Omit(setting) => write!(f, "without {}", setting.name()),
            Self::System(line) => f.write_str(line),
            Self::SetPin(pin, function) => write!(f, "{SET_PIN} {pin} {}", function.name()),
            Self::UseStation(url) => write!(f, "use-station {url}"),
        }
    }
}

/// Name of [`Act::SetPin`] in JSON.
pub const SET_PIN: &str = "set-pin";

/// Value of an option.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum SettingValue {
    /// On, for an option that is on or off.
    On,
    /// Off.
    Off,
    /// A number.
    Number(f64),
    /// A point, mm.
    Point(f64, f64),
    /// A position in space, mm, with three decimals.
    Position([f64; 3]),
    /// A word that the option takes.
    Word(&'static str),
    /// Placeholder for a value that a person chooses: `Z`, `NAME`, `X,Y`.
    Any(&'static str),
}

impl fmt::Display for SettingValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::On => f.write_str("on"),
            Self::Off => f.write_str("off"),
            Self::Number(number) => number.fmt(f),
            Self::Point(x, y) => write!(f, "{x},{y}"),
            Self::Position([x, y, z]) => write!(f, "{x:.3},{y:.3},{z:.3}"),
            Self::Word(word) | Self::Any(word) => f.write_str(word),
        }
    }
}

macro_rules! named {
    ($(#[$doc:meta])* $kind:ident { $($(#[$about:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $kind {
            $($(#[$about])* $variant,)*
        }

        impl $kind {
            /// All values.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Name in JSON.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }

        impl fmt::Display for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

pub(crate) use named;

named! {
    /// An action on the arm, or a query, without further arguments.
    Action {
        /// Clear the alarms, so that the queue goes on.
        ClearAlarms = "clear-alarms",
        /// Look at the alarms.
        ListAlarms = "list-alarms",
        /// Start the queue.
        StartQueue = "start-queue",
        /// Stop the arm and drop what waits in its queue.
        Stop = "stop",
        /// Stop a jog.
        StopJog = "stop-jog",
        /// Jog the arm.
        Jog = "jog",
        /// Home the arm.
        Home = "home",
        /// Switch the laser off.
        LaserOff = "laser-off",
        /// Switch the suction cup off.
        SuctionOff = "suction-off",
        /// Switch the gripper's pump off.
        GripperOff = "gripper-off",
        /// Look for arms.
        ListPorts = "list-ports",
        /// Look at the commands of the protocol.
        ListCommands = "list-commands",
        /// Tell the arm that it stands on a rail.
        UseRail = "use-rail",
        /// Measure where the work surface is.
        CalibrateSurface = "calibrate-surface",
        /// Take the height of the work surface from where the tool touches it now.
        TouchOff = "touch-off",
        /// Burn the file with the laser instead of drawing it.
        Engrave = "engrave",
    }
}

named! {
    /// An option of the caller, by its name in `snake_case`: a flag of the command, an argument in
    /// Python, a field of a job.
    Setting {
        /// Let the laser burn.
        AllowLaser = "allow_laser",
        /// Position of the centre, mm.
        At = "at",
        /// Clip a drawing to its page.
        ClipPage = "clip_page",
        /// Area of an image to keep, pixels.
        Crop = "crop",
        /// Draw duplicate lines only once.
        Dedupe = "dedupe",
        /// Treatment of depths below the surface.
        Depths = "depths",
        /// Largest size of spots in an image to remove, mm.
        Despeckle = "despeckle",
        /// Dialect of G-code.
        Dialect = "dialect",
        /// Shrink the artwork until it is within the arm's reach and on the page.
        Fit = "fit",
        /// Pattern of the lines that fill shapes.
        Fill = "fill",
        /// Spacing of the fill lines, mm.
        FillSpacing = "fill_spacing",
        /// The parts that are drawn.
        Only = "only",
        /// Division of a drawing into parts.
        Parts = "parts",
        /// Number of passes of each part.
        Passes = "passes",
        /// The pens of the parts.
        Pens = "pens",
        /// The font of text.
        Font = "font",
        /// Laser power while tracing a frame, percent.
        FramePower = "frame_power",
        /// Draw or burn the white areas of an image instead of the black ones.
        Invert = "invert",
        /// Run the commands waiting in the queue first.
        Keep = "keep",
        /// Number of repetitions.
        Loops = "loops",
        /// Reorder lines for the shortest travel.
        Order = "order",
        /// Run-up and run-out of the tool at the ends of a line, mm.
        Overscan = "overscan",
        /// Width of the line that the pen draws, mm.
        PenWidth = "pen_width",
        /// Z at which the pen touches the surface in placed G-code, mm.
        PenZ = "pen_z",
        /// Place a program, such as G-code, like a drawing.
        Place = "place",
        /// Port of the arm.
        Port = "port",
        /// Full laser power, percent.
        Power = "power",
        /// Use the coordinates of the file as arm coordinates.
        Raw = "raw",
        /// Tolerance of simplifying a recording, mm.
        Resample = "resample",
        /// Continue where an earlier run ended.
        Resume = "resume",
        /// Counter-clockwise rotation, degrees.
        Rotate = "rotate",
        /// Value of S for full laser power in G-code.
        SMax = "s_max",
        /// Scale factor.
        Scale = "scale",
        /// Height of a capital, mm.
        Size = "size",
        /// Spacing of the lines or dots of an image, mm.
        Spacing = "spacing",
        /// Speed while drawing or burning, mm/s.
        Speed = "speed",
        /// Speed ratio of point-to-point moves, percent.
        SpeedRatio = "speed_ratio",
        /// Position of the tool at the beginning of the program, mm.
        Start = "start",
        /// The height of the work surface, mm.
        Surface = "surface",
        /// Grey below which an image is dark, 1 to 255.
        Threshold = "threshold",
        /// Largest distance of a line from its curve, mm.
        Tolerance = "tolerance",
        /// The mounted tool.
        Tool = "tool",
        /// Test the indices and free places that the arm's queue reports.
        TryQueue = "try_queue",
        /// Rotate the artwork by 90 degrees if it fits better.
        Turn = "turn",
        /// Continue although the arm was not homed.
        Unhomed = "unhomed",
        /// Treatment of white strokes.
        White = "white",
        /// Width of the result, mm.
        Width = "width",
        /// Largest number of requests in flight.
        Window = "window",
        /// Width at which text wraps, mm.
        Wrap = "wrap",
    }
}

/// Wording of acts by a front end.
pub trait Voice {
    /// Call for an action: `magician stop`, `arm.stop()`.
    fn action(&self, action: Action) -> String;

    /// Option with a value: `--scale 0.5`, `scale=0.5`.
    fn give(&self, setting: Setting, given: &SettingValue) -> String;

    /// Command of the operating system: `sudo systemctl start bluetooth`.
    fn system(&self, line: &str) -> String {
        line.to_owned()
    }

    /// Option without a value: `--raw`, `raw`.
    fn setting(&self, setting: Setting) -> String;

    /// True if the caller can follow the act in the present situation; other acts are omitted.
    fn can_follow(&self, act: &Act) -> bool {
        // By default a front end can do everything.
        let _ = act;
        true
    }

    /// Call that assigns a function to a pin: `magician io mux 6 pwm`, `arm.multiplex(6, "pwm")`.
    fn set_pin(&self, pin: u8, function: PinUse) -> String {
        Act::SetPin(pin, function).to_string()
    }

    /// Way to use an arm through the station at this address: `magician --station URL VERB`,
    /// `magician.Station("URL")`.
    fn use_station(&self, url: &str) -> String {
        format!("the station {url}")
    }

    /// Words for an act.
    fn act(&self, act: &Act) -> String {
        match act {
            Act::Do(action) => self.action(*action),
            Act::Give(setting, given) => self.give(*setting, given),
            Act::Omit(setting) => format!("leave out {}", self.setting(*setting)),
            Act::System(line) => self.system(line),
            Act::SetPin(pin, function) => self.set_pin(*pin, *function),
            Act::UseStation(url) => self.use_station(url),
        }
    }

    /// Joins remedies to one sentence: `--fit shrinks it; --scale 0.5 fits there`. `None` if the
    /// list is empty. Acts with the same words appear once.
    fn remedies(&self, remedies: &[Remedy]) -> Option<String> {
        let mut acts: Vec<String> = Vec::new();
        let mut all = Vec::new();
        for remedy in remedies
            .iter()
            .filter(|remedy| self.can_follow(&remedy.act))
        {
            let act = self.act(&remedy.act);
            // Two acts may have the same words in a front end that lacks one of them.
            if acts.contains(&act) {
                continue;
            }
            all.push(if remedy.effect.is_empty() {
                act.clone()
            } else {
                format!("{act} {}", remedy.effect)
            });
            acts.push(act);
        }
        (!all.is_empty()).then(|| all.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Shouts;

    impl Voice for Shouts {
        fn action(&self, action: Action) -> String {
            action.name().to_uppercase()
        }

        fn give(&self, setting: Setting, given: &SettingValue) -> String {
            format!("{}={given}", self.setting(setting))
        }

        fn setting(&self, setting: Setting) -> String {
            setting.name().to_uppercase()
        }
    }

    #[test]
    fn a_voice_says_all_of_them_in_one_sentence() {
        let remedies = [
            Remedy::new((Setting::Scale, SettingValue::Number(0.5)), "fits there"),
            Remedy::new(Action::Home, "homes it"),
            Remedy::without(Setting::Raw),
        ];
        let said = "SCALE=0.5 fits there; HOME homes it; leave out RAW";
        assert_eq!(Shouts.remedies(&remedies).as_deref(), Some(said));
        assert_eq!(Shouts.remedies(&[]), None);
    }

    #[test]
    fn an_act_has_a_name_in_json() {
        let names = [
            (Act::Do(Action::ClearAlarms), "clear-alarms"),
            (Act::Give(Setting::Fit, SettingValue::On), "fit"),
            (Act::Give(Setting::Order, SettingValue::Off), "order off"),
            (
                Act::Give(Setting::At, SettingValue::Point(200.0, -5.5)),
                "at 200,-5.5",
            ),
            (Act::Omit(Setting::PenZ), "without pen_z"),
            (
                Act::UseStation("http://127.0.0.1:8910/".into()),
                "use-station http://127.0.0.1:8910/",
            ),
        ];
        for (act, name) in names {
            assert_eq!(act.to_string(), name);
        }
    }
}
