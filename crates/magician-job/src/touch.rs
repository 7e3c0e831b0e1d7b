//! Height of a level work surface, from an arm whose tool touches it: what every door calls that
//! takes the height from where the tool is.

use magician::commands::{EndEffectorParams, Pose};
use magician::message;
use magician::{Arm, Error, ErrorCode, Result, ToolBias};
use magician_program::{Tool, rounded_height};

/// Heights of tips that differ by less are the same, mm: biases pass through `f32`.
const SAME_HEIGHT: f64 = 0.01;

/// Place where a tool touched a level work surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Touch {
    /// x and y of the tip, mm.
    pub at: [f64; 2],
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
        is_finite.then(|| Self {
            at: [rounded_height(x), rounded_height(y)],
            height: rounded_height(z),
        })
    }
}

/// Takes the height of a level work surface from where the tool of an arm touches it. `draws` is the
/// tool that draws later. Moves nothing.
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
    check_tip(mounted.bias(), draws.bias()).map_err(|()| {
        let why = message!(
            "the arm's poses are for the tool {mounted}, but drawings use the tool {draws}: the \
                measured height would be wrong",
            mounted,
            draws
        );
        Error::new(ErrorCode::InvalidValue, why)
    })?;
    let [x, y, z] = [pose.x, pose.y, pose.z].map(f64::from);
    Touch::of([x, y, z]).ok_or_else(|| {
        Error::new(
            ErrorCode::BadAnswer,
            message!("the arm's pose is not finite"),
        )
    })
}

/// The height alone counts: a level surface is the same wherever it is touched.
fn check_tip(mounted: ToolBias, draws: ToolBias) -> std::result::Result<(), ()> {
    if (mounted.z - draws.z).abs() < SAME_HEIGHT {
        Ok(())
    } else {
        Err(())
    }
}

/// The height of the level work surface that the file of settings keeps, mm; `None` if it keeps
/// none.
///
/// # Errors
/// [`InvalidSettings`](ErrorCode::InvalidSettings) for a file that cannot be read.
#[cfg(feature = "settings")]
pub fn kept_surface() -> Result<Option<f64>> {
    let file = crate::settings::SettingsFile::load().map_err(unkept)?;
    file.value("surface").map_err(unkept)
}

/// Keeps a height of the level work surface (mm) in the file of settings, where the command, a
/// station and Python find it; `None` forgets it.
///
/// # Errors
/// [`InvalidSettings`](ErrorCode::InvalidSettings) for a file that cannot be read or changed, and
/// for one that keeps a sheet, whose height takes precedence: nothing was changed.
#[cfg(feature = "settings")]
pub fn keep_surface(height: Option<f64>) -> Result<()> {
    let mut file = crate::settings::SettingsFile::load().map_err(unkept)?;
    let has = |name: &str| {
        let value = file.value::<toml::Value>(name).map_err(unkept)?;
        Ok::<_, Error>(value.is_some())
    };
    let edited = match height {
        Some(_) if has("sheet")? => {
            let why = message!(
                "the settings keep a calibrated sheet, whose height takes precedence over a \
                touched surface"
            );
            return Err(Error::new(ErrorCode::InvalidSettings, why));
        }
        Some(height) => file.with("surface", &rounded_height(height).to_string()),
        None if !has("surface")? => return Ok(()),
        None => file.without("surface"),
    };
    file.change(edited).map_err(unkept)
}

#[cfg(feature = "settings")]
fn unkept(error: crate::settings::SettingsError) -> Error {
    Error::new(ErrorCode::InvalidSettings, error.to_string())
}
