//! Steps of an engraved image.

use super::bench::{SURFACE, centred, gradient, image};
use crate::raster::resample::resample;
use crate::raster::{Engrave, Grid, Raster, Size};
use crate::{Action, Artwork, Plan, Tool, Travel};

/// Powers and end points in x of the segments, row by row, for a plan on an unturned grid.
fn segments(plan: &Plan) -> Vec<(u32, f32, f32)> {
    let steps = plan.steps.iter();
    let segments = steps.filter_map(|step| match step.action {
        Action::Burn { to, power } => Some((step.origin.line, to[0], power)),
        _ => None,
    });
    segments.collect()
}

#[test]
fn scan_line_has_run_up_burnt_runs_and_run_out() {
    let image = image(6, &["##++ #", "      ", " #  ##"]);
    let grid = Grid::centred([6.0, 3.0], [203.0, 1.5], 0.0, false);
    let engrave = Engrave {
        spacing: 1.0,
        overscan: Some(2.0),
        ..Engrave::default()
    };
    let plan = engrave.plan(&image, &grid, SURFACE).unwrap();
    let there = [
        (1, 200.0, 0.0),
        (1, 202.0, 100.0),
        (1, 204.0, 50.0),
        (1, 205.0, 0.0),
        (1, 206.0, 100.0),
        (1, 208.0, 0.0),
    ];
    let back = [
        (3, 208.0, 0.0),
        (3, 206.0, 0.0),
        (3, 204.0, 100.0),
        (3, 202.0, 0.0),
        (3, 201.0, 100.0),
        (3, 199.0, 0.0),
    ];
    assert_eq!(segments(&plan), [there, back].concat());

    let [.., dark, up] = plan.steps.as_slice() else {
        panic!("{plan:?}")
    };
    assert_eq!(dark.action, Action::Laser(false));
    let r = libm::atan2f(0.5_f32, 199.0).to_degrees();
    let to = [199.0, 0.5, -50.0, r];
    let by = Travel::Line;
    assert_eq!(up.action, Action::Move { to, by });
    assert_eq!(
        (plan.tool, plan.surface),
        (Some(Tool::Laser), Some(SURFACE))
    );

    let one_way = Engrave {
        both_directions: false,
        white_skip: false,
        ..engrave
    };
    let plan = one_way.plan(&image, &grid, SURFACE).unwrap();
    let blank = [(2, 208.0, 0.0)];
    let lit = segments(&plan)
        .into_iter()
        .filter(|(.., power)| *power > 0.0);
    let rising = lit.collect::<Vec<_>>();
    assert!(rising.is_sorted_by(|one, other| one.0 < other.0 || one.1 < other.1));
    assert!(segments(&plan).iter().any(|segment| *segment == blank[0]));
}

#[test]
fn cells_are_means_of_the_area_they_cover() {
    let ramp = Raster {
        width: 3,
        height: 2,
        grey: vec![0, 90, 180, 30, 120, 210],
        ..Raster::default()
    };
    assert_eq!(resample(&ramp, 1, 1), [105]);
    assert_eq!(resample(&ramp, 2, 1), [45, 165]);
    assert_eq!(resample(&ramp, 3, 2), ramp.grey);
    assert_eq!(
        resample(&ramp, 6, 2),
        [0, 0, 90, 90, 180, 180, 30, 30, 120, 120, 210, 210]
    );
    let photo = gradient();
    let mean = |grey: &[u8]| grey.iter().map(|at| f64::from(*at)).sum::<f64>() / grey.len() as f64;
    let small = resample(&photo, 37, 31);
    assert!((mean(&small) - mean(&photo.grey)).abs() < 0.2);
}

#[test]
fn invalid_values_are_refused() {
    let dot = image(1, &["#"]);
    let grid = centred(&dot, Size::Natural);
    let refused = |raster: &Raster, grid: &Grid, engrave: Engrave| {
        engrave.plan(raster, grid, SURFACE).unwrap_err().to_string()
    };
    let usual = Engrave::default;
    let refusals = [
        refused(&Raster::default(), &grid, usual()),
        refused(
            &Raster {
                width: 2,
                ..dot.clone()
            },
            &grid,
            usual(),
        ),
        refused(&image(1, &[" "]), &grid, usual()),
        refused(
            &dot,
            &Grid {
                across: [0.0; 2],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &Grid {
                down: [f64::NAN; 2],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &Grid {
                origin: [f64::INFINITY; 2],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &Grid {
                across: [1e9, 0.0],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                spacing: 0.0,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                speed: f64::NAN,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                acceleration: -1.0,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                gamma: 0.0,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                overscan: Some(-1.0),
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                lift: f64::INFINITY,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                power: [50.0, 40.0],
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                power: [0.0, 101.0],
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                power: [0.0, 0.0],
                ..usual()
            },
        ),
    ];
    assert!(refusals[2].contains("white"), "{}", refusals[2]);
    assert!(refusals[6].contains("cells"), "{}", refusals[6]);
    for size in [Size::Width(0.0), Size::Height(f64::NAN), Size::Pixel(-1.0)] {
        dot.size(size).unwrap_err();
    }
}

#[test]
fn placed_frame_gives_the_image_position() {
    let size = [20.0, 10.0];
    let engrave = Engrave::default();
    let frame = engrave.frame(size);
    assert_eq!(frame.page, Some(size));
    let run_up = engrave.run_up();
    let all = [[-run_up, 0.0], [20.0 + run_up, 10.0]];
    assert_eq!(frame.bounds(), Some(all));
    let upright = Grid::of_frame(&frame).unwrap();
    assert_eq!(upright, Grid::centred(size, [10.0, 5.0], 0.0, false));
    assert_eq!(Grid::of_frame(&Artwork::default()), None);
}
