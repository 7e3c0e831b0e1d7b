//! Drawings that do not fit: the reason, and the sizes, places and rotations that would.

use magician_host::message;
use magician_host::{Act, Setting, SettingValue};
use serde::Serialize;

use super::{Layout, Placer, rounded};
use crate::reach::Fit;
use crate::{Diagnostic, Origin};

/// Reason why a drawing does not fit.
#[derive(Clone, Debug)]
pub struct FitFailure {
    /// Message with remedies.
    pub diagnostic: Diagnostic,
    /// Scale and rotation that would fit, if any.
    pub would_fit: Option<WouldFit>,
}

/// Largest scale that would fit at the wanted place, and the rotation for it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WouldFit {
    /// Scale, 1 being the true size.
    pub scale: f64,
    /// Rotation counter-clockwise, degrees.
    pub rotate: f64,
}

impl FitFailure {
    /// Multiplies all scales in the message and the remedies.
    #[must_use]
    pub fn scaled(mut self, by: f64) -> Self {
        let times = |scale: f64| WouldFit::new(scale * by, 0.0).scale;
        for remedy in &mut self.diagnostic.remedies {
            if let Act::Give(Setting::Scale, SettingValue::Number(scale)) = &mut remedy.act {
                *scale = times(*scale);
            }
        }
        if let Some(would_fit) = &mut self.would_fit {
            would_fit.scale = times(would_fit.scale);
        }
        self
    }
}

impl WouldFit {
    /// Creates the value with the scale rounded down to a thousandth, so that it can be typed and
    /// still fits.
    #[must_use]
    pub fn new(scale: f64, rotate: f64) -> Self {
        let scale = (scale * 1000.0).floor() / 1000.0;
        Self { scale, rotate }
    }

    /// True if a size exists that would fit.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.scale > 0.0
    }
}

impl Placer<'_> {
    /// Returns the reason why the drawing does not fit, and what would.
    pub(super) fn misfit(&self, most: Option<f64>, [near, far]: [f64; 2]) -> FitFailure {
        let turned = self.turned_by_90();
        let elsewhere = self.fitting_position();
        let at = |[x, y]: [f64; 2]| (Setting::At, SettingValue::Point(x, y));
        let size = |scale: f64| {
            let [width, height] = self.size.map(|side| scale * side);
            message!("{width:.0} by {height:.0} mm", width, height)
        };
        let own = size(self.layout.scale);
        let Some(most) = most else {
            let message = match (self.layout.at, self.layout.sheet) {
                (Some([x, y]), _) => {
                    message!(
                        "nothing can be drawn around x = {x:.1}, y = {y:.1}; straight ahead x = {near:.0} to {far:.0} mm is reachable",
                        x,
                        y,
                        near,
                        far
                    )
                }
                (None, Some(_)) => message!(
                    "the corner of the sheet cannot be reached; straight ahead x = {near:.0} to {far:.0} mm is reachable",
                    near,
                    far
                ),
                (None, None) => message!(
                    "the drawing is {own}; straight ahead x = {near:.0} to {far:.0} mm is reachable",
                    own,
                    near,
                    far
                ),
            };
            let would_fit = turned.map(|scale| WouldFit::new(scale, self.layout.rotate + 90.0));
            let diagnostic = Diagnostic::of_file(message);
            return FitFailure {
                diagnostic: match elsewhere {
                    Some(place) => diagnostic.remedy(at(place), "fits there"),
                    None => diagnostic.remedy(
                        (Setting::At, SettingValue::Any("X,Y")),
                        "places it elsewhere",
                    ),
                },
                would_fit: would_fit.filter(WouldFit::is_any),
            };
        };
        let other = turned.filter(|other| *other > most * 1.001);
        let free = (self.layout.at, self.layout.sheet) == (None, None);
        // A drawing that may be rotated has its largest size in that orientation.
        let turns = free && self.layout.turn;
        let most = other.filter(|_| turns).unwrap_or(most);
        let limit = size(most);
        let message = match (self.layout.at, self.layout.sheet) {
            _ if self.layout.room.is_some() => message!(
                "the drawing is {own}, at most {limit} of that shape fits the page inside its margin and is reachable there",
                own,
                limit
            ),
            (Some(_), _) => message!(
                "the drawing is {own}, at most {limit} of that shape is reachable there",
                own,
                limit
            ),
            (None, Some(_)) => message!(
                "the drawing is {own}, at most {limit} of that shape fits the sheet and is reachable",
                own,
                limit
            ),
            (None, None) => message!(
                "the drawing is {own}, at most {limit} of that shape is reachable",
                own,
                limit
            ),
        };
        let mut would_fit = WouldFit::new(most, self.layout.rotate);
        let scale = (Setting::Scale, SettingValue::Number(would_fit.scale));
        let mut diagnostic = Diagnostic::new(self.origin_of_worst_point(), message)
            .remedy((Setting::Fit, SettingValue::On), "shrinks it")
            .remedy(scale, "fits there");
        if let Some(place) = elsewhere {
            diagnostic = diagnostic.remedy(at(place), "fits at this size");
        }
        if let Some(other) = other {
            let rotate = self.layout.rotate + 90.0;
            would_fit = WouldFit::new(other, rotate);
            if !turns {
                let turn = (Setting::Rotate, SettingValue::Number(rotate));
                diagnostic = diagnostic.remedy(turn, "leaves it more room");
            }
        }
        FitFailure {
            diagnostic,
            would_fit: Some(would_fit).filter(WouldFit::is_any),
        }
    }

    /// Returns a place where the drawing would fit in this size and rotation. `None` if the layout
    /// leaves the place open, because then all places were tried already.
    fn fitting_position(&self) -> Option<[f64; 2]> {
        if (self.layout.at, self.layout.sheet) == (None, None) {
            return None;
        }
        let wanted = self.layout.scale;
        let corners = self.hull.iter();
        let corners: Vec<_> = corners.map(|corner| corner.map(|at| wanted * at)).collect();
        let place = self.reach.best_place(&corners, Fit::TrueSize).ok()?;
        let at = place.offset.map(rounded);
        self.is_within(at, wanted).then_some(at)
    }

    /// Returns the largest scale that would fit after a rotation by 90 degrees.
    fn turned_by_90(&self) -> Option<f64> {
        let rotate = self.layout.rotate + 90.0;
        let layout = Layout {
            rotate,
            ..self.layout.clone()
        };
        let placer = Placer::new(self.artwork, self.artwork.bounds()?, &layout, self.reach);
        placer
            .largest()
            .map(|(scale, _)| placer.scale_in_room(scale))
    }

    /// Returns the origin of the first stroke that is out of reach.
    fn origin_of_worst_point(&self) -> Origin {
        let Some(at) = self.middle(self.layout.scale) else {
            return Origin::NONE;
        };
        let put = |point: &[f64; 2]| [0, 1].map(|axis| at[axis] + self.layout.scale * point[axis]);
        let mut lines = self.turned.iter().zip(&self.artwork.strokes);
        let beyond = |points: &Vec<[f64; 2]>| points.iter().any(|at| !self.reach.has(put(at)));
        let first = lines.find(|(points, _)| beyond(points));
        first.map_or(Origin::NONE, |(_, stroke)| stroke.origin)
    }
}
