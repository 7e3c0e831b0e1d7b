//! Canned cycles (G81 and similar): a pen travels to each hole, goes down and up again.

use super::{diagnostic, motions, path, travel};

#[test]
fn each_hole_is_drilled_by_one_move_down_and_up() {
    let down = |x: f32, y: f32, z: f32| [travel(x, y, 2.0), path(x, y, z)];
    let start = "G0 X200 Y0 Z5\n";
    let expected = |up: f32| {
        let mut all = vec![travel(200.0, 0.0, 5.0), travel(210.0, 0.0, 5.0)];
        all.extend(down(210.0, 0.0, -1.0));
        all.push(travel(210.0, 0.0, up));
        all.push(travel(220.0, 10.0, up));
        all.extend(down(220.0, 10.0, -1.0));
        all.push(travel(220.0, 10.0, up));
        all.dedup();
        all
    };
    for (text, up) in [
        ("G81 X210 Z-1 R2\nX220 Y10\nG80\n", 5.0),
        ("G99 G81 X210 Z-1 R2\nX220 Y10\n", 2.0),
        ("G98 G82 X210 Z-1 R2 P0.5\nX220 Y10\n", 5.0),
        ("G83 X210 Z-1 R2 Q0.5\nX220 Y10 Z-1\n", 5.0),
        ("G91 G81 X10 Z-3 R-3\nX10 Y10\n", 5.0),
        ("G91 G81 X10 Z-3 R-3\nG81 X10 Y10 R-3\n", 5.0),
        ("G91 G99 G81 X10 Z-3 R-3\nG81 X10 Y10 Z-3 R-3\n", 2.0),
        ("G92 Z0\nG73 X210 Z-6 R-3 Q1\nX220 Y10\n", 5.0),
    ] {
        let mut found = motions(&format!("{start}{text}"));
        found.dedup();
        assert_eq!(found, expected(up), "{text}");
    }
    let row = motions(&format!("{start}G91 G81 X10 Z-3 R-3 L3\n"));
    let holes = row
        .iter()
        .filter(|one| matches!(one, magician_formats::Action::Path { .. }));
    assert_eq!(holes.count(), 3);
    // A line that leaves the cycle is an ordinary motion.
    let text = format!("{start}G81 X210 Z-1 R2\nG1 X215 F60\n");
    assert_eq!(motions(&text).last(), Some(&path(215.0, 0.0, 5.0)));
}

#[test]
fn invalid_cycle_is_refused() {
    let start = "G0 X200 Y0 Z5\n";
    for (text, message) in [
        (
            "G81 X210 R2",
            "line 2, column 1: G81 needs Z: how deep it goes, below R",
        ),
        (
            "G81 X210 Z3 R2",
            "line 2, column 1: G81 needs Z: how deep it goes, below R",
        ),
        (
            "G18\nG81 X210 Z1 R2",
            "line 3, column 1: G81 drills, which needs a pen and the plane of G17",
        ),
        (
            "G91 G81 X1 Z-1 R0 L5000",
            "line 2, column 1: G81 makes 5000 holes, limit 1000",
        ),
        (
            "G88 X210 Z1 R2",
            "line 2, column 1: G88 may move the arm, which is not supported",
        ),
        (
            "G80\nX2",
            "line 3, column 1: the line has coordinates but no motion: G80 has ended the last one",
        ),
    ] {
        assert_eq!(diagnostic(&format!("{start}{text}\n")), message, "{text}");
    }
    assert!(diagnostic("G81 X210 Z1 R2\n").contains("X and Y are unknown"));
}
