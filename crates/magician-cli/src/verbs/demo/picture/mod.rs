//! The picture of a run: where the tool really went, from above and from the side.

mod above;
mod legend;
mod marks;
mod panel;
mod side;
mod workspace;

use magician_picture::svg::Svg;
use magician_picture::svg::palette::{FAINT, INK};

/// The tool at an instant, as the arm reported it; mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
    /// Whether it carries a cube.
    pub(super) carrying: bool,
}

impl Sample {
    fn radius(&self) -> f64 {
        self.x.hypot(self.y)
    }
}

const WIDTH: f64 = 1302.0;
const HEIGHT: f64 = 880.0;
const TITLE: &str = "Six cubes, picked from a row and placed on a grid";

/// Draws a run.
pub(super) fn draw(samples: &[Sample], subtitle: &str) -> String {
    let mut svg = Svg::page([WIDTH, HEIGHT], "", TITLE);
    let title = [("font-size", "24"), ("font-weight", "bold"), ("fill", INK)];
    svg.label([60.0, 44.0], TITLE, &title);
    let look = [("font-size", "15"), ("fill", FAINT)];
    svg.label([60.0, 70.0], subtitle, &look);
    above::draw(&mut svg, samples);
    side::draw(&mut svg, samples);
    legend::draw(&mut svg);
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::super::scene::{CUBES, LIFT, TOP};
    use super::*;
    use magician_picture::svg::palette;

    /// The corners of a run, without what lies between.
    fn corners() -> Vec<Sample> {
        let mut samples = Vec::new();
        for errand in CUBES {
            for ((x, y), carrying) in [(errand.from, false), (errand.to, true)] {
                for z in [TOP + LIFT, TOP] {
                    samples.push(Sample { x, y, z, carrying });
                }
            }
            let (x, y) = errand.to;
            samples.push(Sample {
                x,
                y,
                z: TOP + LIFT,
                carrying: false,
            });
        }
        samples
    }

    #[test]
    fn a_run_is_drawn_with_both_tracks_and_all_labels() {
        let picture = draw(&corners(), "a subtitle");
        for part in [
            palette::EMPTY,
            palette::CARRIED,
            "From above",
            "From the side",
            "a subtitle",
            "home",
            "base",
        ] {
            assert!(picture.contains(part), "{part}");
        }
        assert_eq!(
            picture.matches("<g ").count(),
            picture.matches("</g>").count()
        );
        assert!(!picture.contains("NaN"));
    }
}
