//! Scenarios: a text that puts a world around the arm and says what happens in it.
//!
//! A scenario is a TOML file. Lengths are mm, angles deg, times seconds of the arm's clock from
//! power-up. Positions are in the frame of the arm's base, and every height is the z that the arm
//! reports when its tool touches there (model section 1), which is about -60 to -75 for a table.
//! `scenario.schema.json` beside the examples in `scenarios/` describes every field, for editors.
//!
//! | section | what it says |
//! |---|---|
//! | `title` | what the scenario is called |
//! | `[arm]` | where the base really stands at power-up, whether the arm has been homed |
//! | `[tool]` | the tool that is really on the arm, and that the controller knows at power-up; how far it gives way |
//! | `[table]` | a level table; the pen writes on it |
//! | `[conveyor]` | a belt that a stepper output drives |
//! | `[[object]]` | a box to pick: size, place, colour, what it stands on |
//! | `[[sensor]]` | a colour or infrared sensor, its connector and where it looks |
//! | `[[input]]` | what an input reads from an instant on |
//! | `[[hand]]` | a hand unlocks the arm, guides it, releases it |
//! | `[[key]]` | the key at the base is pressed |
//! | `[[fault]]` | a slip, a pulled cable, a reset, slow answers, an alarm: at a time or at a command's index |
//!
//! What is not simulated: objects do not push, tilt or stop one another, a knock from the side
//! moves nothing, the belt drives nothing against a tool at rest, an object falls straight and at
//! once, and the laser is in focus at every height.
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

/// A checked scenario: what stands around the arm, and what happens.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scenario {
    title: Option<String>,
    arm: Arm,
    /// What it says of the tool, if anything.
    tool: Option<Tool>,
    table: Option<Table>,
    conveyor: Option<Conveyor>,
    objects: Vec<Object>,
    sensors: Vec<Sensor>,
    script: Script,
}

impl Scenario {
    /// The JSON Schema of scenario files, for editors.
    pub const SCHEMA: &str = include_str!("../../scenarios/scenario.schema.json");

    /// A cell to try programs in: a belt brings cubes, sensors tell when one is there and which
    /// colour it has.
    ///
    /// ```
    /// use magician_sim::Scenario;
    ///
    /// let cell = Scenario::from_toml(Scenario::PICK_AND_SORT)?;
    /// assert!(cell.conveyor().is_some());
    /// # Ok::<(), magician_sim::ScenarioError>(())
    /// ```
    pub const PICK_AND_SORT: &str = include_str!("../../scenarios/pick_and_sort.toml");

    /// Scenarios to begin with, by short names.
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

    /// Reads a scenario.
    ///
    /// # Errors
    /// [`ScenarioError`] with line and column for a text that is no scenario, or that makes no
    /// sense.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        let syntax = |error: toml::de::Error| ScenarioError::syntax(text, &error);
        let shape = toml::de::DeTable::parse(text).map_err(syntax)?;
        if let Some(error) = ScenarioError::shape(text, &shape) {
            return Err(error);
        }
        let file = toml::from_str(text).map_err(syntax)?;
        check::scenario(file).map_err(|diagnostic| ScenarioError::locate(text, diagnostic))
    }

    /// What it is called.
    #[must_use]
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// How the arm stands at power-up.
    #[must_use]
    pub fn arm(&self) -> &Arm {
        &self.arm
    }

    /// The tool that is really on the arm; the suction cup if the scenario says nothing of it.
    #[must_use]
    pub fn tool(&self) -> Tool {
        self.tool.unwrap_or_default()
    }

    /// The tool that the scenario puts on the arm, if it says so: its bias is then in force at
    /// power-up.
    #[must_use]
    pub fn chosen_tool(&self) -> Option<Tool> {
        self.tool
    }

    /// The table.
    #[must_use]
    pub fn table(&self) -> Option<&Table> {
        self.table.as_ref()
    }

    /// The conveyor.
    #[must_use]
    pub fn conveyor(&self) -> Option<&Conveyor> {
        self.conveyor.as_ref()
    }

    /// The objects as they stand at power-up.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The sensors.
    #[must_use]
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// The same scenario, with each object that stands on the table, and bears nothing, moved by up
    /// to so many mm in x and in y. `share` gives numbers from 0 to 1. An object for which no free
    /// place is found in 20 tries stays where it is.
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
