//! Scenarios: text files that put a world around the arm and script events in it.
//!
//! A scenario is a TOML file. Lengths are in mm, angles in degrees, times in seconds of the arm's
//! clock since power-up. Positions are in the frame of the arm's base. A height is the z that the
//! arm reports when its tool touches there (model section 1), about -60 to -75 for a table.
//! `scenario.schema.json` beside the examples in `scenarios/` describes every field for editors.
//!
//! | section | content |
//! |---|---|
//! | `title` | title of the scenario |
//! | `[arm]` | true angle of the base at power-up; whether the arm is homed |
//! | `[tool]` | mounted tool, also known to the controller at power-up; how far it gives way |
//! | `[table]` | a level table; the pen writes on it |
//! | `[conveyor]` | a belt driven by a stepper output |
//! | `[[object]]` | a box to pick: size, position, colour, support |
//! | `[[sensor]]` | a colour or infrared sensor, its connector and its direction |
//! | `[[input]]` | value of an input from an instant on |
//! | `[[hand]]` | a hand unlocks the arm, guides it, releases it |
//! | `[[key]]` | a press of the base key |
//! | `[[fault]]` | a slip, a pulled cable, a reset, slow answers, an alarm: at a time or at a command's index |
//!
//! Simplifications: objects do not push, tilt or stop one another, a knock from the side moves
//! nothing, the belt pushes nothing against a tool at rest, objects fall straight and at once, and
//! the laser is in focus at every height.
//!
//! ```
//! use magician_sim::{World, scenario::Scenario};
//!
//! let text = r#"
//! [tool]
//! kind = "suction"
//!
//! [table]
//! height = -70
//!
//! [[object]]
//! name = "red cube"
//! size = [20, 20, 20]
//! at = [220, 50]
//! color = "red"
//!
//! [[input]]
//! address = 5
//! level = 1
//! at = 3.2
//! "#;
//! let scenario = Scenario::from_toml(text)?;
//! let world = World::from_scenario(&scenario);
//!
//! let wrong = Scenario::from_toml("[table]\nheigth = -70").unwrap_err();
//! assert_eq!((wrong.line, wrong.column), (2, 1));
//! # Ok::<(), magician_sim::scenario::ScenarioError>(())
//! ```

mod check;
mod color;
mod error;
mod file;
mod script;
mod setting;

pub use color::Color;
pub use error::ScenarioError;
pub(crate) use script::{Action, Script};
pub(crate) use setting::footprint;
pub use setting::{Arm, Beam, Conveyor, Object, On, Sensor, SensorKind, Table, Tool, ToolKind};

/// A validated scenario: the surroundings of the arm, and scripted events.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scenario {
    title: Option<String>,
    arm: Arm,
    /// Tool in the file; `None` if it has no such section.
    tool: Option<Tool>,
    table: Option<Table>,
    conveyor: Option<Conveyor>,
    objects: Vec<Object>,
    sensors: Vec<Sensor>,
    script: Script,
}

impl Scenario {
    /// JSON Schema of scenario files, for editors.
    pub const SCHEMA: &str = include_str!("../../scenarios/scenario.schema.json");

    /// A cell for trying programs: a belt brings cubes, and sensors report their presence and
    /// colour.
    ///
    /// ```
    /// use magician_sim::Scenario;
    ///
    /// let cell = Scenario::from_toml(Scenario::PICK_AND_SORT)?;
    /// assert!(cell.conveyor().is_some());
    /// # Ok::<(), magician_sim::ScenarioError>(())
    /// ```
    pub const PICK_AND_SORT: &str = include_str!("../../scenarios/pick_and_sort.toml");

    /// Built-in example scenarios, by short names.
    ///
    /// ```
    /// use magician_sim::Scenario;
    ///
    /// for (name, text) in Scenario::BUILT_IN {
    ///     assert!(Scenario::from_toml(text)?.title().is_some(), "{name}");
    /// }
    /// # Ok::<(), magician_sim::ScenarioError>(())
    /// ```
    pub const BUILT_IN: [(&str, &str); 5] = [
        ("cubes", include_str!("../../scenarios/cubes.toml")),
        ("drawing", include_str!("../../scenarios/drawing.toml")),
        ("pick_and_sort", Self::PICK_AND_SORT),
        ("faults", include_str!("../../scenarios/faults.toml")),
        ("engraving", include_str!("../../scenarios/engraving.toml")),
    ];

    /// Parses a scenario.
    ///
    /// # Errors
    /// [`ScenarioError`] with line and column if the text is not valid TOML, has unknown keys, or
    /// contains values that are out of range or contradict each other.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        let syntax = |error: toml::de::Error| ScenarioError::syntax(text, &error);
        let shape = toml::de::DeTable::parse(text).map_err(syntax)?;
        if let Some(error) = ScenarioError::shape(text, &shape) {
            return Err(error);
        }
        let file = toml::from_str(text).map_err(syntax)?;
        check::scenario(file).map_err(|diagnostic| ScenarioError::locate(text, diagnostic))
    }

    /// Title of the scenario.
    #[must_use]
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// State of the arm at power-up.
    #[must_use]
    pub fn arm(&self) -> &Arm {
        &self.arm
    }

    /// Mounted tool; the suction cup if the file has none.
    #[must_use]
    pub fn tool(&self) -> Tool {
        self.tool.unwrap_or_default()
    }

    /// Mounted tool given by the file, whose bias is in force at power-up; `None` if it has none.
    #[must_use]
    pub fn chosen_tool(&self) -> Option<Tool> {
        self.tool
    }

    /// Table; `None` if absent.
    #[must_use]
    pub fn table(&self) -> Option<&Table> {
        self.table.as_ref()
    }

    /// Conveyor; `None` if absent.
    #[must_use]
    pub fn conveyor(&self) -> Option<&Conveyor> {
        self.conveyor.as_ref()
    }

    /// Objects at power-up.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Sensors.
    #[must_use]
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// Returns the scenario with the objects on the table moved at random by up to `most` mm in x
    /// and in y.
    ///
    /// `share` returns random numbers from 0 to 1. Objects that carry others stay, and so does an
    /// object without a free position in 20 tries.
    ///
    /// ```
    /// use magician_sim::Scenario;
    ///
    /// let cell = Scenario::from_toml(
    ///     "table = { height = -60 }\nobject = [{ name = \"cube\", size = [20, 20, 20], at = [220, 50] }]",
    /// )?;
    /// let moved = cell.scattered(10.0, || 1.0);
    /// assert_eq!((moved.objects()[0].place.x, moved.objects()[0].place.y), (230.0, 60.0));
    /// # Ok::<(), magician_sim::ScenarioError>(())
    /// ```
    #[must_use]
    pub fn scattered(&self, most: f64, mut share: impl FnMut() -> f64) -> Self {
        // A choice: a crowded table must not cost an endless search.
        const TRIES: u32 = 20;
        let mut scattered = self.clone();
        let Some(table) = self.table else {
            return scattered;
        };
        for nth in 0..self.objects.len() {
            let Some(object) = self.objects.get(nth) else {
                break;
            };
            let bears =
                |other: &Object| matches!(other.on, On::Object(below) if usize::from(below) == nth);
            if object.on != On::Table || self.objects.iter().any(bears) {
                continue;
            }
            for _ in 0..TRIES {
                let mut tried = object.clone();
                tried.place.x += (share() * 2.0 - 1.0) * most;
                tried.place.y += (share() * 2.0 - 1.0) * most;
                let others = scattered.objects.iter().enumerate();
                let taken = others
                    .filter(|(other, _)| *other != nth)
                    .any(|(_, other)| check::intersect(&tried, other));
                if !taken && table.footprint().contains(tried.place.xy()) {
                    if let Some(place) = scattered.objects.get_mut(nth) {
                        *place = tried;
                    }
                    break;
                }
            }
        }
        scattered
    }

    pub(crate) fn script(&self) -> &Script {
        &self.script
    }
}
