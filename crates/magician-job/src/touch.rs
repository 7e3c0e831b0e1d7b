//! Touch-off: measures the work surface with an arm whose tool touches it, and stores the result.
//! Every front end that takes a height or a corner of the paper from the current pose uses it.

use magician::commands::{EndEffectorParams, Pose};
use magician::message;
use magician::{Arm, Error, ErrorCode, Geometry, JointAngles, Message, Result, ToolBias};
use magician_program::artwork::Sheet;
use magician_program::{Surface, Tool, rounded_height, rounded_surface};

/// Largest height difference of two tips that counts as equal, mm: biases pass through `f32`.
const SAME_HEIGHT: f64 = 0.01;

/// Point where a tool touched a level work surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Touch {
    /// x and y of the tip in arm coordinates, mm.
    pub at: [f64; 2],
    /// x and y of the tip of the drawing tool, mm: the arm's poses may refer to another tool.
    pub tip: [f64; 2],
    /// Height of the surface: z of the tip, mm.
    pub height: f64,
}

impl Touch {
    /// Touch of a tip at x, y and z (mm), rounded to the precision of a touch; `None` if one of
    /// them is not finite.
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

/// Measured work surface of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum WorkSurface {
    /// Plane on which drawings may lie wherever there is room.
    Plane(Surface),
    /// Sheet of paper, which also has a position.
    Sheet(Sheet),
}

impl WorkSurface {
    /// Plane of the surface.
    #[must_use]
    pub const fn plane(&self) -> Surface {
        match self {
            Self::Plane(surface) => *surface,
            Self::Sheet(sheet) => sheet.surface,
        }
    }

    /// Surface rounded to the precision of a touch: a level height to 0.001 mm.
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

/// Takes a point of the work surface from the current pose of an arm whose tool touches it.
/// `drawing_tool` is the tool used for drawing later. Moves nothing.
///
/// # Errors
/// [`NotHomed`](ErrorCode::NotHomed) as [`Homing::check`](magician::Homing::check),
/// [`LaserOn`](ErrorCode::LaserOn) as [`Laser::check_off`](magician::Laser::check_off),
/// [`Busy`](ErrorCode::Busy) if the arm moves, [`InvalidValue`](ErrorCode::InvalidValue) if the
/// arm's poses refer to a tool that ends at another height than `drawing_tool`; else as
/// [`Arm::get`].
pub async fn touch_off(arm: &Arm, drawing_tool: Tool) -> Result<Touch> {
    arm.homing().check().await?;
    arm.laser().check_off().await?;
    // A hand or another program may move the arm without the driver's knowledge, so two poses are
    // compared.
    if !arm.stands().await? {
        let why = message!("the arm moves: its tool touches nothing yet");
        return Err(Error::new(ErrorCode::Busy, why));
    }
    let bias = arm.get::<EndEffectorParams>().await?;
    let pose = arm.get::<Pose>().await?;
    let mounted = Tool::from(&bias);
    if !same_height(mounted.bias(), drawing_tool.bias()) {
        let why = message!(
            "the arm's poses are for the tool {mounted}, but drawings use the tool {draws}: the \
                measured height would be wrong",
            mounted,
            draws = drawing_tool
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
    let [from, to] =
        [mounted, drawing_tool].map(|tool| Geometry::magician(tool.bias()).forward(&joints));
    let [x, y] = touch.at;
    Ok(Touch {
        tip: [x + to.x - from.x, y + to.y - from.y].map(rounded_height),
        ..touch
    })
}

/// True if both tips end at the same height.
fn same_height(mounted: ToolBias, drawing_tool: ToolBias) -> bool {
    (mounted.z - drawing_tool.z).abs() < SAME_HEIGHT
}

/// Work surface stored in the settings file; `None` if absent. A sheet takes precedence over a
/// plane.
///
/// # Errors
/// [`InvalidSettings`](ErrorCode::InvalidSettings) if the file cannot be read.
#[cfg(feature = "settings")]
pub fn stored_surface() -> Result<Option<WorkSurface>> {
    let file = crate::settings::SettingsFile::load().map_err(settings_error)?;
    if let Some(sheet) = file.value("sheet").map_err(settings_error)? {
        return Ok(Some(WorkSurface::Sheet(sheet)));
    }
    Ok(surface_of(&file)
        .map_err(settings_error)?
        .map(WorkSurface::Plane))
}

/// Plane that a settings file stores under `surface`: a height in mm, or a table with height and
/// slope. `None` if absent.
///
/// # Errors
/// [`SettingsError::Broken`](crate::settings::SettingsError::Broken).
#[cfg(feature = "settings")]
pub fn surface_of(
    file: &crate::settings::SettingsFile,
) -> std::result::Result<Option<Surface>, crate::settings::SettingsError> {
    #[derive(serde::Deserialize)]
    #[serde(untagged)]
    enum StoredSurface {
        Level(f64),
        Plane(Surface),
    }
    Ok(file.value("surface")?.map(|kept| match kept {
        StoredSurface::Level(height) => Surface::level(height),
        StoredSurface::Plane(surface) => surface,
    }))
}

/// Stores a work surface in the settings file, where the command, a station and Python find it.
/// `None` removes plane and sheet.
///
/// # Errors
/// [`InvalidSettings`](ErrorCode::InvalidSettings) if the file cannot be read or edited, and for a
/// plane while the file has a sheet, whose height takes precedence. Nothing is changed then.
#[cfg(feature = "settings")]
pub fn store_surface(surface: Option<WorkSurface>) -> Result<()> {
    let mut file = crate::settings::SettingsFile::load().map_err(settings_error)?;
    let has = |name: &str| {
        let value = file.value::<toml::Value>(name).map_err(settings_error)?;
        Ok::<_, Error>(value.is_some())
    };
    let edited = match surface.map(WorkSurface::rounded) {
        Some(WorkSurface::Plane(_)) if has("sheet")? => {
            return Err(Error::new(
                ErrorCode::InvalidSettings,
                sheet_stored_message(),
            ));
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
            // Nothing to remove: do not touch the file.
            if left.as_ref() == Some(&file) {
                return Ok(());
            }
            left
        }
    };
    file.change(edited).map_err(settings_error)
}

/// Message that refuses a touched surface while a sheet is stored.
#[must_use]
pub fn sheet_stored_message() -> Message {
    message!(
        "the settings keep a calibrated sheet, whose height takes precedence over a \
            touched surface"
    )
}

#[cfg(feature = "settings")]
fn settings_error(error: crate::settings::SettingsError) -> Error {
    Error::new(ErrorCode::InvalidSettings, error.sentence())
}

#[cfg(all(test, feature = "settings"))]
mod tests {
    use super::*;
    use crate::settings::SettingsFile;

    #[test]
    fn surface_setting_is_a_height_or_a_tilted_plane() {
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
