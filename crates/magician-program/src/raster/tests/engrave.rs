//! Engraved images on a virtual arm.

use magician_host::JointAngles;
use magician_host::preflight::Preflight;
use magician_sim::ControllerState;

use super::bench::{
    EngravingArm, SURFACE, burnt, centred, difference, gradient, image, picture, wanted,
};
use crate::raster::{Engrave, Grid, Size, Tone};
use crate::{Action, Plan, Surface, Tool, check};

#[test]
fn gradient_is_burnt_true_to_tone() {
    let image = gradient();
    assert_eq!((image.width, image.height), (64, 48));
    for both_directions in [true, false] {
        let engrave = Engrave {
            both_directions,
            ..Engrave::default()
        };
        let grid = centred(&image, Size::Natural);
        let plan = engrave.plan(&image, &grid, SURFACE).unwrap();
        let strokes = burnt(&plan);
        let picture = picture(&strokes, &grid, [64, 48], 48);
        let [most, mean] = difference(&picture, wanted(&image));
        println!(
            "both directions {both_directions}: {} steps, power off by {most:.3} % at most, {mean:.3} % in the mean",
            plan.steps.len()
        );
        assert!(most < 0.55 && mean < 0.3);
    }
}

#[test]
fn tool_passes_the_image_at_one_speed() {
    let image = gradient();
    // A pixel of 0.2 mm in a period of 20 ms.
    let speed = Engrave::default().steady_speed();
    let engrave = Engrave {
        speed,
        ..Engrave::default()
    };
    let grid = centred(&image, Size::Natural);
    let columns = (0..image.width).map(|at| image.grey.iter().skip(at).step_by(image.width));
    let burnt = columns.map(|mut column| column.any(|grey| *grey < 250));
    let white = burnt.take_while(|burnt| !burnt).count();
    let [left, _] = grid.at([white as f64 / 64.0, 0.0]);
    let plan = engrave.plan(&image, &grid, SURFACE).unwrap();
    let (mut before, mut looks) = (None::<ControllerState>, 0);
    let mut farthest = left;
    let mut off = 0.0_f64;
    EngravingArm::new().perform(&plan, |now| {
        if now.pose.z < SURFACE.height + 1e-3 {
            farthest = farthest.min(now.pose.x);
        }
        // The pose changes once per period.
        let ended = |state: &ControllerState| state.now.as_micros() / 20_000;
        if before.is_some_and(|before| ended(&before) == ended(now)) {
            return;
        }
        let Some(before) = before.replace(*now) else {
            return;
        };
        let time = 0.02 * (ended(now) - ended(&before)) as f64;
        // At the edges the laser is off in one of the two looks.
        if before.laser && now.laser {
            let speed = (now.pose.x - before.pose.x).abs() / time;
            off = off.max((speed - engrave.speed).abs() / engrave.speed);
            looks += 1;
        }
    });
    println!("{looks} looks, speed off by {:.4} % at most", 100.0 * off);
    assert!(looks > 1000 && off < 0.005);
    // The overscan is as long as speed and acceleration require.
    assert_eq!(engrave.run_up(), speed * speed / (2.0 * 100.0));
    assert!((farthest - (left - engrave.run_up())).abs() < 1e-3);
}

#[test]
fn threshold_burns_darker_pixels_and_inverted_the_lighter_ones() {
    let image = gradient();
    let grid = centred(&image, Size::Natural);
    let share = |invert| {
        let engrave = Engrave {
            tone: Tone::Threshold(100),
            power: [20.0, 60.0],
            invert,
            ..Engrave::default()
        };
        let plan = engrave.plan(&image, &grid, SURFACE).unwrap();
        let strokes = burnt(&plan);
        assert!(strokes.iter().all(|stroke| stroke.power == 60.0));
        let powers = picture(&strokes, &grid, [64, 48], 48);
        powers.iter().filter(|power| **power > 30.0).count() as f64 / powers.len() as f64
    };
    let darker = |level| {
        let darker = image.grey.iter().filter(|grey| **grey < level).count();
        darker as f64 / image.grey.len() as f64
    };
    assert_eq!(share(false), darker(100));
    // Inverted, white counts as black: everything lighter than 155.
    assert_eq!(share(true), 1.0 - darker(156));
}

#[test]
fn dither_keeps_the_mean() {
    let image = gradient();
    let grid = centred(&image, Size::Natural);
    let engrave = Engrave {
        tone: Tone::Dither,
        ..Engrave::default()
    };
    let strokes = burnt(&engrave.plan(&image, &grid, SURFACE).unwrap());
    assert!(strokes.iter().all(|stroke| stroke.power == 100.0));
    let picture = picture(&strokes, &grid, [4, 3], 48);
    let wanted: Vec<f64> = wanted(&image).collect();
    let block = |nth: usize| {
        let pixels = (0..256).map(|at| (nth / 4 * 16 + at / 16) * 64 + nth % 4 * 16 + at % 16);
        pixels.map(|at| wanted[at]).sum::<f64>() / 256.0
    };
    let [most, mean] = difference(&picture, (0..12).map(block));
    println!("blocks of 16 by 16: power off by {most:.3} % at most, {mean:.3} % in the mean");
    assert!(most < 2.0 && mean < 1.0);
}

#[test]
fn rotated_mirrored_or_tilted_image_follows_its_grid() {
    let image = gradient();
    let surface = Surface {
        height: -60.0,
        slope: [0.02, -0.01],
    };
    for mirror in [false, true] {
        let size = image.size(Size::Width(20.0)).unwrap();
        let grid = Grid::centred(size, [240.0, -30.0], 35.0, mirror);
        let plan = Engrave::default().plan(&image, &grid, surface).unwrap();
        let strokes = burnt(&plan);
        let rows = (15.0_f64 / 0.2).round() as usize;
        let picture = picture(&strokes, &grid, [16, 3], rows);
        let wanted: Vec<f64> = wanted(&image).collect();
        let block = |nth: usize| {
            let pixels = (0..64).map(|at| (nth / 16 * 16 + at / 4) * 64 + nth % 16 * 4 + at % 4);
            pixels.map(|at| wanted[at]).sum::<f64>() / 64.0
        };
        let [most, _] = difference(&picture, (0..48).map(block));
        println!("mirror {mirror}: power off by {most:.3} % at most");
        assert!(most < 1.0);
        for step in &plan.steps {
            if let Action::Burn { to: [x, y, z], .. } = step.action {
                let height = surface.at([x, y].map(f64::from));
                assert!((f64::from(z) - height).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn a_wide_gap_is_travelled_dark() {
    let bars = format!("##{}##", " ".repeat(196));
    let image = image(200, &[&bars, &bars]);
    let grid = Grid::centred([100.0, 1.0], [240.0, 0.0], 90.0, false);
    let engrave = Engrave {
        spacing: 0.5,
        ..Engrave::default()
    };
    let moves = |plan: &Plan| {
        let steps = plan.steps.iter();
        let moves = steps.filter(|step| matches!(step.action, Action::Move { .. }));
        moves.count()
    };
    let start = Preflight::at(JointAngles::HOME, Tool::None.bias());
    let skips = engrave.plan(&image, &grid, SURFACE).unwrap();
    let stays = Engrave {
        white_skip: false,
        ..engrave
    };
    let stays = stays.plan(&image, &grid, SURFACE).unwrap();
    assert_eq!((moves(&skips), moves(&stays)), (3 + 2, 3));
    let time = |plan| check(plan, &start).time.unwrap();
    assert!(time(&skips) < time(&stays));
    assert_eq!(burnt(&skips).len(), 4);
}

#[test]
fn without_overscan_travel_is_dark() {
    let image = image(8, &["##   ###", "        ", "        ", "#      #"]);
    for (width, both_directions) in [(8.0, true), (60.0, true), (60.0, false)] {
        let engrave = Engrave {
            overscan: Some(0.0),
            both_directions,
            spacing: width / 8.0,
            ..Engrave::default()
        };
        let grid = centred(&image, Size::Width(width));
        let plan = engrave.plan(&image, &grid, SURFACE).unwrap();
        assert_eq!(burnt(&plan).len(), 4);
    }
}
