//! Tests of reading HPGL as artwork.

use magician_formats::{
    Artwork, Content, Diagnostic, Fills, Format, Lines, Parsed, ReadOptions, read,
};
use proptest::prelude::*;

const STAR: &str = include_str!("../../../magician-program/samples/star.plt");

fn try_read(text: &str) -> Result<(Artwork, Vec<String>), Diagnostic> {
    let options = ReadOptions::default();
    let Parsed { content, notes, .. } = read(Format::Hpgl, text.as_bytes(), &options)?;
    match content {
        Content::Artwork(artwork) => Ok((artwork, notes.iter().map(ToString::to_string).collect())),
        other => panic!("{other:?}"),
    }
}

fn strokes(text: &str) -> Vec<Vec<[f64; 2]>> {
    let (artwork, _) = try_read(text).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    let strokes = artwork.strokes.into_iter();
    strokes.map(|stroke| stroke.points).collect()
}

fn diagnostic(text: &str) -> String {
    try_read(text).expect_err(text).to_string()
}

#[test]
fn sample_is_a_star_in_millimetres() {
    let (artwork, notes) = try_read(STAR).expect("it is all right");
    let [stroke] = &artwork.strokes[..] else {
        panic!("{artwork:?}")
    };
    let star = [
        [40.0, 65.0],
        [54.675, 19.775],
        [16.225, 47.725],
        [63.775, 47.725],
        [25.325, 19.775],
        [40.0, 65.0],
    ];
    assert_eq!(stroke.points, star);
    assert!(stroke.is_closed());
    assert_eq!(notes, [""; 0]);
    let range = Lines::new(STAR).range(&stroke.origin).expect("a place");
    let text = &STAR[range];
    assert!(
        text.starts_with("PD2187 791") && text.ends_with("PD1600 2600"),
        "{text}"
    );
    assert_eq!((stroke.origin.line, stroke.origin.column), (8, 1));
}

#[test]
fn pens_go_up_and_down_absolutely_and_relatively() {
    let expected = vec![
        vec![[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]],
        vec![[3.0, 3.0], [3.5, 3.0]],
    ];
    for text in [
        "IN;SP1;PU40,40;PD80,40,80,80;PU120 120;PD;PA140 120;PU;",
        "sp1pu40 40pd80 40 80 80pupa120 120pdpr20 0pupa0,0",
        "IN;SP1;PR;PU40,40;PD40,0,0,40;PU40,40;PD20,0;SP0;PA;PD0,0;",
    ] {
        assert_eq!(strokes(text), expected, "{text}");
    }
    assert_eq!(strokes("SP1;PU40,40;PD;PU;"), [[[1.0, 1.0]]]);
    assert_eq!(
        strokes("SP0;PU40,40;PD80,80;PU;"),
        Vec::<Vec<[f64; 2]>>::new()
    );
}

#[test]
fn rectangles_and_wedges_leave_the_pen_where_it_was() {
    assert_eq!(
        strokes("PU40,40;EA80,120;PD40,80;"),
        [
            vec![[1.0, 1.0], [2.0, 1.0], [2.0, 3.0], [1.0, 3.0], [1.0, 1.0]],
            vec![[1.0, 1.0], [1.0, 2.0]],
        ]
    );
    assert_eq!(strokes("PU40,40;ER40,80;"), strokes("PU40,40;EA80,120;"));
    let wedge = strokes("PU400,400;EW400,0,90;");
    let [wedge] = &wedge[..] else {
        panic!("{wedge:?}")
    };
    assert_eq!((wedge[0], wedge[1]), ([10.0, 10.0], [20.0, 10.0]));
    let [_, .., before, last] = wedge[..] else {
        panic!("{wedge:?}")
    };
    assert_eq!(last, [10.0, 10.0]);
    assert!((before[0] - 10.0).abs() < 1e-9 && (before[1] - 20.0).abs() < 1e-9);
}

/// Asserts that all corners and the middles of all sides are within 0.05 mm of a circle.
fn is_round(points: &[[f64; 2]], centre: [f64; 2], radius: f64) {
    let off = |[x, y]: [f64; 2]| ((x - centre[0]).hypot(y - centre[1]) - radius).abs();
    for side in points.windows(2) {
        let middle = [0, 1].map(|axis| f64::midpoint(side[0][axis], side[1][axis]));
        assert!(off(side[0]) < 0.05 && off(middle) < 0.05, "{side:?}");
    }
}

#[test]
fn circles_and_arcs_are_within_the_tolerance() {
    let circle = strokes("PU4000,4000;CI1000;");
    is_round(&circle[0], [100.0, 100.0], 25.0);
    assert_eq!(
        (circle[0].first(), circle[0].len() > 20),
        (circle[0].last(), true)
    );
    assert_eq!(circle[0][0], [125.0, 100.0]);
    for text in [
        "PU4000,4000;PD;AA4000,3000,-90;PU;",
        "PU4000,4000;PD;AR0,-1000,-90;PU;",
    ] {
        let arc = strokes(text);
        is_round(&arc[0], [100.0, 75.0], 25.0);
        // The arc runs clockwise from the top to the right.
        let end = arc[0].last().expect("an end");
        assert!(
            (end[0] - 125.0).abs() < 1e-9 && (end[1] - 75.0).abs() < 1e-9,
            "{end:?}"
        );
    }
    // The pen moves along an arc even when it is up.
    let after = strokes("PU4000,4000;AA4000,3000,-90;PD4000,4000;");
    assert!((after[0][0][0] - 125.0).abs() < 1e-9);
}

#[test]
fn user_units_apply_if_the_file_defines_them() {
    let scaled = "IN;IP400,800,4400,4800;SC0,100,0,200;PU0,0;PD100,200;";
    assert_eq!(strokes(scaled), [[[10.0, 20.0], [110.0, 120.0]]]);
    // A change of units does not move the pen.
    let first = "IP400,800,4400,4800;PU2400,2800;SC0,100,0,200;PD100,200;SC;PD440,840;";
    let line = [[60.0, 70.0], [110.0, 120.0], [11.0, 21.0]];
    assert_eq!(strokes(first).concat(), [&line[..2], &line[1..]].concat());
    let reset = "IP0,0,40,40;SC0,1,0,1;PU2,2;DF;PD160,160;";
    assert_eq!(strokes(reset), [[[2.0, 2.0], [4.0, 4.0]]]);
    let factors = "IP400,800,0,0;SC0,40,0,80,2;PU0,0;PD1,1;";
    assert_eq!(strokes(factors), [[[10.0, 20.0], [11.0, 22.0]]]);
    assert!(diagnostic("IP0,0,40,40;SC0,0,0,1;").ends_with(
        "the scale of SC is not a finite \
        number"
    ));
}

#[test]
fn user_units_without_a_frame_assume_a4_with_a_note() {
    let (artwork, notes) = try_read("IN;SC0,100,0,200;PU0,0;PD100,200;").expect("it is all right");
    assert_eq!(
        artwork.strokes[0].points,
        [[15.075, 13.025], [265.075, 193.025]]
    );
    assert_eq!(
        notes,
        [
            "line 1, column 4: SC without IP scales to the plotter's own frame: A4 is assumed, \
                250 by 180 mm"
        ]
    );
    // IP without parameters restores the default frame, which is the page if PS gives one.
    assert_eq!(
        strokes("IP0,0,40,40;IP;SC0,100,0,200;PD100,200;"),
        [[[0.0, 0.0], [265.075, 193.025]]]
    );
    let (artwork, notes) = try_read("PS8000,4000;SC0,2,0,1;PD2,1;").expect("it is all right");
    assert_eq!(artwork.strokes[0].points, [[0.0, 0.0], [200.0, 100.0]]);
    assert_eq!((artwork.page, notes.len()), (Some([200.0, 100.0]), 0));
}

#[test]
fn p2_follows_p1_and_user_units_follow_both() {
    // A square of 100 mm begins at 0, then at (20, 40).
    let follows = "IP0,0,4000,4000;IP800,1600;SC0,1,0,1;PU0,0;PD1,1;";
    assert_eq!(strokes(follows), [[[20.0, 40.0], [120.0, 140.0]]]);
    let later = "SC0,1,0,1;IP0,0,4000,4000;IP800,1600;PU0,0;PD1,1;";
    assert_eq!(strokes(later), strokes(follows));
    let shares = "PS4000,2000;IR0,0,100,100;IR50,50;SC0,1,0,1;PU0,0;PD1,1;";
    assert_eq!(strokes(shares), [[[50.0, 25.0], [150.0, 75.0]]]);
}

#[test]
fn isotropic_units_follow_their_alignment() {
    // The frame is 200 by 100 mm and the plot is square, which leaves 100 mm of the width.
    for (shares, left) in [("", 50.0), (",0,0", 0.0), (",100,50", 100.0)] {
        let plot = format!("IP0,0,8000,4000;SC0,10,0,10,1{shares};PU0,0;PD10,10;");
        assert_eq!(
            strokes(&plot),
            [[[left, 0.0], [left + 100.0, 100.0]]],
            "{plot}"
        );
    }
    assert!(diagnostic("SC0,1,0,1,3;").contains("unknown type 3 of SC"));
}

#[test]
fn rotation_turns_the_coordinate_system_and_keeps_the_pen() {
    let shape = |turn: &str| strokes(&format!("PS4000,2000;{turn}PU400,0;PD800,0,800,400;"));
    for (turn, expected) in [
        ("RO0;", [[10.0, 0.0], [20.0, 0.0], [20.0, 10.0]]),
        ("RO90;", [[100.0, 10.0], [100.0, 20.0], [90.0, 20.0]]),
        ("RO180;", [[90.0, 50.0], [80.0, 50.0], [80.0, 40.0]]),
        ("RO270;", [[0.0, 40.0], [0.0, 30.0], [10.0, 30.0]]),
        ("RO90;RO;", [[10.0, 0.0], [20.0, 0.0], [20.0, 10.0]]),
        ("RO90;IN;", [[10.0, 0.0], [20.0, 0.0], [20.0, 10.0]]),
    ] {
        assert_eq!(shape(turn), [expected], "{turn}");
    }
    assert_eq!(
        strokes("PS4000,2000;PU400,0;RO90;PR;PD0,400;"),
        [[[10.0, 0.0], [0.0, 0.0]]]
    );
    // IP without parameters puts P1 and P2 back onto the sheet, which is now upright.
    assert_eq!(
        strokes("PS4000,2000;RO90;IP;SC0,1,0,1;PU0,0;PD1,1;"),
        [[[100.0, 0.0], [0.0, 50.0]]]
    );
}

#[test]
fn lines_outside_the_window_are_clipped() {
    assert_eq!(
        strokes("IW400,400,800,800;PU0,600;PD1200,600;IW;PD1200,0;"),
        [[[10.0, 15.0], [20.0, 15.0]], [[30.0, 15.0], [30.0, 0.0]]]
    );
    // A window is in user units once they are defined, and clips polygons and circles too.
    let user = "IP0,0,4000,4000;SC0,100,0,100;IW20,20,10,10;PU0,15;PD30,15;";
    assert_eq!(strokes(user), [[[10.0, 15.0], [20.0, 15.0]]]);
    let polygon = "IW0,0,400,400;PU200,200;PM0;PD600,200;PM2;EP;";
    assert_eq!(strokes(polygon)[0][..2], [[10.0, 5.0], [5.0, 5.0]]);
}

#[test]
fn encoded_polylines_are_decoded() {
    let plain = strokes("IN;SP1;PU40,80;PD50,80,50,70;PU60,70;PD61,70;");
    // PE in base 64 with bytes beyond UTF-8, in base 32, and with a fractional bit; then the same
    // bytes as saved by a program that takes them for characters.
    let saved: String = b"IN;SP1;PE<=O\xc0_\xc1\xd3\xbf\xbf\xd4<\xd3\xbf\xc1\xbf;"
        .iter()
        .map(|byte| char::from(*byte))
        .collect();
    for bytes in [
        saved.as_bytes(),
        &b"IN;SP1;PE<=O\xc0_\xc1\xd3\xbf\xbf\xd4<\xd3\xbf\xc1\xbf;"[..],
        b"IN;SP1;PE7<=Oa?ds__t<s_a_;",
        b"IN;SP1;PE7>a<=?d?iG`__H`;PU60,70;PE7a_;",
    ] {
        let reading = read(Format::Hpgl, bytes, &ReadOptions::default()).expect("it is all right");
        let Content::Artwork(artwork) = reading.content else {
            panic!("no drawing")
        };
        let found: Vec<_> = artwork
            .strokes
            .into_iter()
            .map(|stroke| stroke.points)
            .collect();
        assert_eq!(found, plain, "{}", bytes.escape_ascii());
    }
    assert_eq!(plain.len(), 2);
}

#[test]
fn an_arc_goes_through_its_three_points() {
    for text in [
        "PU4000,4000;PD;AT5000,5000,6000,4000;",
        "PU4000,4000;PD;RT1000,1000,2000,0;",
    ] {
        let arc = strokes(text);
        is_round(&arc[0], [125.0, 100.0], 25.0);
        assert_eq!(arc[0].last(), Some(&[150.0, 100.0]));
        assert!(arc[0].iter().all(|point| point[1] >= 99.9));
    }
    let circle = strokes("PU4000,4000;PD;AT6000,4000,4000,4000;");
    is_round(&circle[0], [125.0, 100.0], 25.0);
    assert_eq!(
        strokes("PU0,0;PD;AT40,0,80,0;"),
        [[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]]
    );
}

/// Returns the bounding box of a plot, rounded to hundredths of a millimetre.
fn extent(text: &str) -> [f64; 4] {
    let (artwork, _) = try_read(text).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    let [least, most] = artwork.bounds().expect(text);
    [least[0], least[1], most[0], most[1]].map(|side| (side * 100.0).round() / 100.0)
}

#[test]
fn tick_marks_cross_their_axis() {
    // A tick extends half a percent of 100 or 200 mm to each side, whether the pen is up or down.
    let ticks = strokes("IP0,0,4000,8000;PU400,400;XT;TL10,0;YT;TL5;XT;PD800,400;");
    assert_eq!(
        ticks,
        [
            [[10.0, 11.0], [10.0, 9.0]],
            [[20.0, 10.0], [10.0, 10.0]],
            [[10.0, 20.0], [10.0, 10.0]],
            [[10.0, 10.0], [20.0, 10.0]],
        ]
    );
}

#[test]
fn labels_stand_in_cells_of_one_width() {
    // Characters are 6 by 9 mm: an H fills the width, and the next one begins 9 mm further on.
    let style = "PU400,400;SI.6,.9;";
    assert_eq!(
        extent(&format!("{style}LBH\u{3}")),
        [10.0, 10.0, 16.0, 19.0]
    );
    assert_eq!(
        extent(&format!("{style}LBHIH\u{3}")),
        [10.0, 10.0, 34.0, 19.0]
    );
    // After a label the pen is up at its end, where the next line begins.
    assert_eq!(
        strokes(&format!("{style}LBH\u{3}PD1000,400;"))
            .last()
            .unwrap(),
        &[[19.0, 10.0], [25.0, 10.0]]
    );
    // The default size is 0.75 and 1.5 percent of the A4 frame, whose sides are 250 and 180 mm.
    assert_eq!(extent("PU400,400;LBH\u{3}"), [10.0, 10.0, 11.88, 12.7]);
    assert_eq!(
        extent("PU400,400;IP0,0,4000,4000;SR10,20;LBH\u{3}"),
        [10.0, 10.0, 20.0, 30.0]
    );
    for (words, expected) in [
        ("DI0,1;LBH\u{3}", [1.0, 10.0, 10.0, 16.0]),
        ("DR-1,0;LBH\u{3}", [4.0, 1.0, 10.0, 10.0]),
        ("SL1;LBH\u{3}", [10.0, 10.0, 25.0, 19.0]),
        ("LO5;LBHH\u{3}", [2.5, 5.5, 17.5, 14.5]),
        ("LO9;LBHH\u{3}", [-5.0, 1.0, 10.0, 10.0]),
        ("LO11;LBH\u{3}", [13.0, 14.5, 19.0, 23.5]),
        ("ES1;LBHH\u{3}", [10.0, 10.0, 34.0, 19.0]),
        ("LBH\r\nH\u{3}", [10.0, -8.0, 16.0, 19.0]),
        ("LBH\u{3}CP;LBH\u{3}", [10.0, -8.0, 16.0, 19.0]),
        ("CP2,1;LBH\u{3}", [28.0, 28.0, 34.0, 37.0]),
        ("DT#;LBH#DT;LBH\u{3}", [10.0, 10.0, 25.0, 19.0]),
        ("DV1;LBHH\u{3}", [10.0, -8.0, 16.0, 19.0]),
        ("BLH\u{3}PB;", [10.0, 10.0, 16.0, 19.0]),
        ("SMH;PU800,800;", [17.0, 15.5, 23.0, 24.5]),
        ("RO90;LBH\u{3}", [1.0, 10.0, 10.0, 16.0]),
    ] {
        assert_eq!(extent(&format!("{style}{words}")), expected, "{words:?}");
    }
    assert_eq!(strokes("SP0;LBH\u{3}"), Vec::<Vec<[f64; 2]>>::new());
    let (_, notes) = try_read("LB\u{4E2D}a\u{4E2D}\u{3}").expect("it is all right");
    assert!(notes[0].contains("U+4E2D") && notes.len() == 1, "{notes:?}");
}

#[test]
fn filled_shape_is_an_area_or_the_hatch_of_the_file() {
    let mut options = ReadOptions::default();
    options.fills = Fills::Areas;
    let filled = |text: &str| match read(Format::Hpgl, text.as_bytes(), &options) {
        Ok(Parsed {
            content: Content::Artwork(artwork),
            ..
        }) => (artwork.areas.len(), artwork.strokes.len()),
        other => panic!("{other:?}"),
    };
    let ring = "PU0,0;PM0;PD400,0,400,400,0,400;PM1;PU80,80;PD80,160,160,160,160,80;PM2;";
    assert_eq!(filled(&format!("{ring}FP;EP;")), (1, 2));
    assert_eq!(filled("PU0,0;RA400,400;"), (1, 0));
    assert_eq!(filled("PU0,0;EA400,400;"), (0, 1));
    assert_eq!(filled("SP0;PU0,0;RA400,400;"), (0, 0));
    // Moves with the pen up or down both define corners of a polygon.
    assert_eq!(filled("PU0,0;PM0;PU400,0,400,400;PM2;FP;EP;"), (1, 0));
    let hatch = "PU0,0;FT3,80,0;";
    assert_eq!(filled(&format!("{hatch}RA400,400;")), (0, 5));
    let lines = strokes(&format!("{hatch}{ring}FP;"));
    // Hatch lines lie at 0, 2, 4, 6 and 8 mm; the second is interrupted by the hole from 2 to 4 mm.
    assert_eq!(
        lines[1..3],
        [[[0.0, 2.0], [2.0, 2.0]], [[4.0, 2.0], [10.0, 2.0]]]
    );
    assert_eq!(filled("PU0,0;FT4,80,0;RA400,400;"), (0, 10));
}

#[test]
fn polygons_are_drawn_by_their_edge_instruction() {
    let triangle = "PU0,0;PM0;PD40,0,40,40;PU;PM2;";
    assert_eq!(strokes(triangle), Vec::<Vec<[f64; 2]>>::new());
    let (artwork, notes) = try_read(&format!("{triangle}FP;EP;")).expect("it is all right");
    assert_eq!(artwork.strokes.len(), 1);
    assert!(artwork.strokes[0].is_closed());
    assert_eq!(
        notes,
        ["line 1, column 31: filled shapes are drawn as outlines"]
    );
}

#[test]
fn omissions_are_noted_and_impossible_instructions_refused() {
    let (artwork, notes) = try_read("IN;SP1;LT2,1;PD40,40;SP2;LBhello PD1\u{3};PU;PD0,0;XX1;")
        .expect("it is all right");
    assert!(artwork.strokes.len() > 2);
    assert_eq!(
        notes,
        [
            "line 1, column 8: line types (LT) are left out: all lines are solid",
            "line 1, column 48: XX is left out",
        ]
    );
    assert!(
        diagnostic("IN;\nPE<=\u{100};")
            .starts_with("line 2, column 1: an encoded polyline (PE) is damaged")
    );
    let (_, notes) = try_read("PE7<=aaaaPU;").expect("it is all right");
    assert_eq!(
        notes,
        ["line 1, column 1: the end of an encoded polyline (PE) is cut off"]
    );
    assert!(diagnostic("RO45;").contains("must be 0, 90, 180 or 270"));
    assert!(diagnostic("IW1,2;").contains("IW needs two points"));
    assert!(diagnostic("PD1,2,3;").contains("PD has an x without a y"));
    assert!(diagnostic("CI;").contains("CI needs a radius"));
}

/// Returns a strategy for plots of instructions that are nearly valid.
fn malformed_plots() -> impl Strategy<Value = String> {
    let name = prop::sample::select(vec![
        "IN",
        "PA",
        "PR",
        "PU",
        "PD",
        "SP",
        "CI",
        "AA",
        "AR",
        "EA",
        "ER",
        "EW",
        "RA",
        "WG",
        "IP",
        "SC",
        "PM",
        "EP",
        "FP",
        "BZ",
        "BR",
        "LB",
        "DT",
        "\u{1b}.",
        "PE",
        "LT",
        "RO",
        "IR",
        "PS",
        "IW",
        "AT",
        "RT",
        "PE7<=",
        "PE7a_",
        "PE7>b",
        "\u{1b}%0A",
        "\u{1b}%0B",
        "\u{1b}E",
        "CO\"",
        "SI",
        "SR",
        "DI",
        "DR",
        "SL",
        "LO",
        "CP",
        "ES",
        "DV",
        "FT",
        "SM+",
        "LBa\u{3}",
    ]);
    let number = prop_oneof![
        (-9000_i32..9000).prop_map(f64::from),
        -400.0..400.0,
        Just(0.0),
        Just(8e6)
    ];
    let one = (name, prop::collection::vec(number, 0..8)).prop_map(|(name, numbers)| {
        let numbers: Vec<_> = numbers.iter().map(ToString::to_string).collect();
        format!("{name}{};", numbers.join(","))
    });
    prop::collection::vec(one, 0..20).prop_map(|all| all.concat())
}

proptest! {
    #[test]
    fn parser_survives_arbitrary_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(Format::Hpgl, &bytes, &ReadOptions::default());
    }

    #[test]
    fn accepted_strokes_are_finite_and_have_origins(text in malformed_plots()) {
        if let Ok((artwork, _)) = try_read(&text) {
            for stroke in &artwork.strokes {
                prop_assert!(!stroke.points.is_empty() && stroke.origin.is_known());
                prop_assert!(stroke.points.iter().flatten().all(|number| number.is_finite()));
            }
        }
    }
}

#[test]
fn curves_reach_their_end_within_their_control_polygon() {
    let absolute = strokes("PU400,400;PD;BZ400,800,800,800,800,400;PU;");
    assert_eq!(absolute, strokes("PU400,400;PD;BR0,400,400,400,400,0;PU;"));
    let [curve] = &absolute[..] else {
        panic!("{absolute:?}")
    };
    assert_eq!(
        (curve[0], curve[curve.len() - 1]),
        ([10.0, 10.0], [20.0, 10.0])
    );
    let highest = curve.iter().map(|point| point[1]).fold(0.0, f64::max);
    // A cubic Bezier curve with equal handles reaches three quarters of their height.
    assert!((highest - 17.5).abs() < 0.05, "{highest}");
    assert!(curve.len() > 8);
}
