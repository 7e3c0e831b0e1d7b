//! The work surface from an arm whose tool touches it: what every front end calls that takes a
//! height or a corner of the paper from where the tool is, and where the result is kept.

use magician::commands::{EndEffectorParams, Pose};
use magician::message;
use magician::{Arm, Error, ErrorCode, Geometry, JointAngles, Message, Result, ToolBias};
use magician_program::artwork::Sheet;
use magician_program::{Surface, Tool, rounded_height, rounded_surface};

/// Heights of tips that differ by less are the same, mm: biases pass through `f32`.
const SAME_HEIGHT: f64 = 0.01;

/// Place where a tool touched a level work surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Touch {
    /// x and y of the tip, as the arm has them, mm.
    pub at: [f64; 2],
    /// x and y of the tip of the tool that draws, mm: the arm may count its poses from another one.
    pub tip: [f64; 2],
    /// Height of the surface, z of the tip, mm.
    pub height: f64,
}

impl Touch {
    /// The touch of a tip at x, y and z (mm), as exactly as an arm touches; `None` if one of them is
    /// not finite.
    ///
    /// ```
    /// let touch = magician_job::Touch::of([220.0, 10.0, -61.43216]).expect("finite");
    /// assert_eq!((touch.at, touch.height), ([220.0, 10.0], -61.432));
    /// assert!(magician_job::Touch::of([220.0, 10.0, f64::NAN]).is_none());
    /// ```
    #[must_use]
    pub fn of([x, y, z]: [f64; 3]) -> Option<Self> {
        let is_finite = [x, y, z].iter().all(|number| number.is_finite());
        let at = [rounded_height(x), rounded_height(y)];
        is_finite.then(|| Self {
            at,
            tip: at,
            height: rounded_height(z),
        })
    }
}

/// The measured work surface under an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum WorkSurface {
    /// A plane that drawings are laid on wherever there is room.
    Plane(Surface),
    /// A sheet of paper, which has a place as well.
    Sheet(Sheet),
}

impl WorkSurface {
    /// The plane of either.
    #[must_use]
    pub const fn plane(&self) -> Surface {
        match self {
            Self::Plane(surface) => *surface,
            Self::Sheet(sheet) => sheet.surface,
        }
    }

    /// The same as exactly as an arm touches: a level height to 0.001 mm.
    #[must_use]
    pub fn rounded(self) -> Self {
        match self {
            Self::Plane(surface) if surface.slope == [0.0, 0.0] => {
                Self::Plane(Surface::level(rounded_height(surface.height)))
            }
            Self::Plane(surface) => Self::Plane(rounded_surface(surface)),
            Self::Sheet(sheet) => Self::Sheet(sheet.rounded()),
        }
    }
}

/// Takes a place of the work surface from where the tool of an arm touches it. `draws` is the tool
/// that draws later. Moves nothing.
///
/// # Errors
/// [`NotHomed`](ErrorCode::NotHomed) as [`Homing::check`](magician::Homing::check), [`LaserOn`](ErrorCode::LaserOn) as
/// [`Laser::check_off`](magician::Laser::check_off), [`Busy`](ErrorCode::Busy) if the arm moves,
/// [`InvalidValue`](ErrorCode::InvalidValue) if the arm counts from the tip of a tool that ends at
/// another height than the one that draws; else as [`Arm::get`].
pub async fn touch_off(arm: &Arm, draws: Tool) -> Result<Touch> {
    arm.homing().check().await?;
    arm.laser().check_off().await?;
    // A hand or another program moves it, too: then two poses differ.
    if !arm.stands().await? {
        let why = message!("the arm moves: its tool touches nothing yet");
        return Err(Error::new(ErrorCode::Busy, why));
    }
    let bias = arm.get::<EndEffectorParams>().await?;
    let pose = arm.get::<Pose>().await?;
    let mounted = Tool::from(&bias);
    if !same_height(mounted.bias(), draws.bias()) {
        let why = message!(
            "the arm's poses are for the tool {mounted}, but drawings use the tool {draws}: the \
                measured height would be wrong",
            mounted,
            draws
        );
        return Err(Error::new(ErrorCode::InvalidValue, why));
    }
    let touch = Touch::of([pose.x, pose.y, pose.z].map(f64::from)).ok_or_else(|| {
        Error::new(
            ErrorCode::BadAnswer,
            message!("the arm's pose is not finite"),
        )
    })?;
    let joints = JointAngles::from(pose.joint_angle.map(f64::from));
    let [from, to] = [mounted, draws].map(|tool| Geometry::magician(tool.bias()).forward(&joints));
    let [x, y] = touch.at;
    Ok(Touch {
        tip: [x + to.x - from.x, y + to.y - from.y].map(rounded_height),
        ..touch
    })
}

/// True if both tips end equally low.
fn same_height(mounted: ToolBias, draws: ToolBias) -> bool {
    (mounted.z - draws.z).abs() < SAME_HEIGHT
}

/// The work surface that the file of settings keeps; `None` if it keeps none. A sheet goes before a
/// plane.
///
/// # Errors
/// [`InvalidSettings`](ErrorCode::InvalidSettings) for a file that cannot be read.
#[cfg(feature = "settings")]
pub fn kept_surface() -> Result<Option<WorkSurface>> {
    let file = crate::settings::SettingsFile::load().map_err(unkept)?;
    if let Some(sheet) = file.value("sheet").map_err(unkept)? {
        return Ok(Some(WorkSurface::Sheet(sheet)));
    }
    Ok(surface_of(&file).map_err(unkept)?.map(WorkSurface::Plane))
}

/// The plane that a file of settings keeps beside a sheet: `surface` is a height in mm, or a table
/// with height and slope.
///
/// # Errors
/// [`SettingsError::Broken`](crate::settings::SettingsError::Broken).
#[cfg(feature = "settings")]
pub fn surface_of(
    file: &crate::settings::SettingsFile,
) -> std::result::Result<Option<Surface>, crate::settings::SettingsError> {
    #[derive(serde::Deserialize)]
    #[serde(untagged)]
    enum Kept {
        Level(f64),
        Plane(Surface),
    }
    Ok(file.value("surface")?.map(|kept| match kept {
        Kept::Level(height) => Surface::level(height),
        Kept::Plane(surface) => surface,
    }))
}

/// Keeps a work surface in the file of settings, where the command, a station and Python find it.
/// `None` forgets plane and sheet.
///
/// # Errors
/// [`InvalidSettings`](ErrorCode::InvalidSettings) for a file that cannot be read or changed, and
/// for a plane while the file keeps a sheet, whose height takes precedence: nothing was changed.
#[cfg(feature = "settings")]
pub fn keep_surface(surface: Option<WorkSurface>) -> Result<()> {
    let mut file = crate::settings::SettingsFile::load().map_err(unkept)?;
    let has = |name: &str| {
        let value = file.value::<toml::Value>(name).map_err(unkept)?;
        Ok::<_, Error>(value.is_some())
    };
    let edited = match surface.map(WorkSurface::rounded) {
        Some(WorkSurface::Plane(_)) if has("sheet")? => {
            return Err(Error::new(ErrorCode::InvalidSettings, sheet_counts()));
        }
        Some(WorkSurface::Plane(surface)) if surface.slope == [0.0, 0.0] => {
            file.with("surface", &surface.height.to_string())
        }
        Some(WorkSurface::Plane(Surface {
            height,
            slope: [x, y],
        })) => file.with(
            "surface",
            &format!("{{ height = {height}, slope = [{x:?}, {y:?}] }}"),
        ),
        Some(WorkSurface::Sheet(sheet)) => file.with_table("sheet", &sheet),
        None => {
            let mut left = Some(file.clone());
            for name in ["sheet", "surface"] {
                if has(name)? {
                    left = left.and_then(|file| file.without(name));
                }
            }
            if left.as_ref() == Some(&file) {
                return Ok(());
            }
            left
        }
    };
    file.change(edited).map_err(unkept)
}

/// Reason for refusing a touch while there is a sheet.
#[must_use]
pub fn sheet_counts() -> Message {
    message!(
        "the settings keep a calibrated sheet, whose height takes precedence over a \
            touched surface"
    )
}

#[cfg(feature = "settings")]
fn unkept(error: crate::settings::SettingsError) -> Error {
    Error::new(ErrorCode::InvalidSettings, error.to_string())
}

#[cfg(all(test, feature = "settings"))]
mod tests {
    use super::*;
    use crate::settings::SettingsFile;

    #[test]
    fn surface_of_the_settings_is_a_height_or_a_tilted_plane() {
        let said = |value: &str| {
            let file = SettingsFile::default()
                .with("surface", value)
                .expect("it can");
            surface_of(&file).ok().flatten()
        };
        assert_eq!(said("-52.5"), Some(Surface::level(-52.5)));
        let slope = [0.01, -0.002];
        let tilted = Surface {
            height: -55.0,
            slope,
        };
        assert_eq!(
            said("{ height = -55.0, slope = [0.01, -0.002] }"),
            Some(tilted)
        );
        assert_eq!(said("\"low\""), None);
        let empty = surface_of(&SettingsFile::default());
        assert_eq!(empty.expect("nothing is wrong"), None);
    }
}
