//! Invalid scenarios: line, column and remedy.

use magician_sim::scenario::Scenario;
use proptest::prelude::*;

use super::EXAMPLES;

/// A valid file before the lines of a case.
const GROUND: &str = "[table]\nheight = -70\nx = [0, 300]\ny = [-200, 200]\n\
    [conveyor]\nstart = [200, 0]\ndirection = 0\nlength = 100\nwidth = 50\nheight = -50\nstepper = 0\n\
    [[object]]\nname = \"cube\"\nsize = [20, 20, 20]\nat = [150, 0]\n";
/// Number of lines in [`GROUND`].
const ABOVE: usize = 15;

/// Cases: lines after the valid part; line (from there) and column of the error; a word of the
/// message.
const CASES: &[(&str, usize, usize, &str)] = &[
    // Shape.
    ("[[input]\n", 1, 9, "unclosed"),
    (
        "[tool]\nkind = \"hammer\"",
        2,
        8,
        "unknown variant `hammer`",
    ),
    ("[tool]\n", 1, 1, "missing field `kind`"),
    (
        "[tool]\nkind = \"pen\"\ncolour = 1",
        3,
        1,
        "unknown field `colour`",
    ),
    ("[[robot]]\n", 1, 3, "unknown field `robot`"),
    ("[arm]\nhomed = 1", 2, 9, "expected true or false"),
    (
        "[[object]]\nname = \"b\"\nsize = [1, 2]\nat = [0, 0]",
        3,
        8,
        "list of length 3",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\ncolor = \"mauve\"",
        5,
        9,
        "orange",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\ncolor = [256, 0, 0]",
        5,
        10,
        "256",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\ncolor = \"#12345\"",
        5,
        9,
        "#rrggbb",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP3\"\nat = [1, 2, 3]",
        3,
        8,
        "GP4",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nat = [1, 2, 3]\nfacing = \"left\"",
        5,
        10,
        "degrees",
    ),
    ("[[fault]]\nkind = \"earthquake\"", 2, 8, "slip"),
    // One or several.
    (
        "[key]\npress = \"long\"\nat = 1",
        1,
        1,
        "write [[key]], not [key]",
    ),
    ("[[arm]]\nhomed = true", 1, 1, "write [arm] and"),
    ("[[tool]]\nkind = \"pen\"", 1, 1, "write [tool] and"),
    // In the terms of the file's author.
    (
        "[tool]\nkind = \"pen\"\ngive = \"much\"",
        3,
        8,
        "expected a number",
    ),
    (
        "[[input]]\naddress = 5\nlevel = true",
        3,
        9,
        "expected a whole number",
    ),
    (
        "[arm]\nhomed = { now = true }",
        2,
        9,
        "type: table, expected true or false",
    ),
    // Objects.
    (
        "[[object]]\nname = \"cube\"\nsize = [9, 9, 9]\nat = [10, 0]",
        2,
        8,
        "another object is called 'cube'",
    ),
    (
        "[[object]]\nname = \"belt\"\nsize = [9, 9, 9]\nat = [10, 0]",
        2,
        8,
        "own name",
    ),
    (
        "[[object]]\nname = \" \"\nsize = [9, 9, 9]\nat = [10, 0]",
        2,
        8,
        "needs a name",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, -9, 9]\nat = [10, 0]",
        3,
        8,
        "is -9",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 0, 9]\nat = [10, 0]",
        3,
        8,
        "above 0",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, nan, 9]\nat = [10, 0]",
        3,
        8,
        "NaN",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, inf, 9]\nat = [10, 0]",
        3,
        8,
        "inf",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [nan, 0]",
        4,
        6,
        "at is NaN",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [301, 0]",
        4,
        6,
        "lies outside the table",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\non = \"belt\"",
        4,
        6,
        "lies outside the belt",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\non = \"cube\"",
        4,
        6,
        "lies outside cube",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\non = \"c\"",
        5,
        6,
        "there is no earlier object 'c'",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\non = \"table\"\nz = 5",
        5,
        6,
        "no meaning",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [155, 0]",
        4,
        6,
        "overlaps 'cube'",
    ),
    (
        "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [155, 0]\nz = -51",
        4,
        6,
        "overlaps 'cube'",
    ),
    // Sensors.
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"",
        1,
        1,
        "the sensor has no position",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nat = [1, 2, 3]\nbelt_at = 4",
        5,
        11,
        "one position",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nbelt_at = 400",
        4,
        11,
        "0 to 100 mm",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nat = [1, 2, 3]\nabove = 4",
        5,
        9,
        "belt_at",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nbelt_at = 4\nfacing = \"up\"",
        5,
        10,
        "no meaning",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nat = [1, 2, 3]\nrange = 0",
        5,
        9,
        "above 0",
    ),
    (
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nat = [1, 2, 3]\n[[sensor]]\nkind = \"infrared\"\nport = \"GP1\"\nat = [1, 2, 3]",
        7,
        8,
        "another sensor",
    ),
    // Inputs.
    ("[[input]]\naddress = 0\nlevel = 1", 2, 11, "1 to 20"),
    ("[[input]]\naddress = 21\nlevel = 1", 2, 11, "1 to 20"),
    ("[[input]]\naddress = 5\nlevel = 2", 3, 9, "0 or 1"),
    ("[[input]]\naddress = 5\nvalue = 4096", 3, 9, "0 to 4095"),
    ("[[input]]\naddress = 5\nvalue = -1", 3, 9, "0 to 4095"),
    ("[[input]]\naddress = 5", 1, 1, "give level"),
    (
        "[[input]]\naddress = 5\nlevel = 1\nvalue = 1",
        4,
        9,
        "one of them",
    ),
    (
        "[[input]]\naddress = 5\nlevel = 1\nat = -0.5",
        4,
        6,
        "0 to 10000000 s",
    ),
    ("[[input]]\naddress = 5\nlevel = 1\nat = nan", 4, 6, "NaN"),
    // Hands and keys.
    ("[[hand]]\nkind = \"release\"\nat = 1", 2, 8, "unlock first"),
    (
        "[[hand]]\nkind = \"guide\"\nat = 1\njoints = [0, 0, 0, 0]",
        2,
        8,
        "unlock first",
    ),
    (
        "[[hand]]\nkind = \"unlock\"\nat = 1\njoints = [0, 0, 0, 0]",
        4,
        10,
        "guide",
    ),
    (
        "[[hand]]\nkind = \"unlock\"\nat = 1\n[[hand]]\nkind = \"guide\"\nat = 2",
        4,
        1,
        "joints is missing",
    ),
    (
        "[[hand]]\nkind = \"unlock\"\nat = 1\n[[hand]]\nkind = \"release\"\nat = 0.5",
        6,
        6,
        "order of time",
    ),
    (
        "[[hand]]\nkind = \"unlock\"\nat = 1\n[[hand]]\nkind = \"guide\"\nat = 2\njoints = [0, 0, 0, 0]\nover = 1",
        8,
        8,
        "has no start",
    ),
    ("[[key]]\npress = \"long\"", 1, 1, "missing field `at`"),
    // Faults.
    ("[[fault]]\nkind = \"reset\"", 1, 1, "at = seconds"),
    (
        "[[fault]]\nkind = \"reset\"\nat = 1\nindex = 2",
        4,
        9,
        "at or index",
    ),
    (
        "[[fault]]\nkind = \"reset\"\nindex = 0",
        3,
        9,
        "counts from 1",
    ),
    (
        "[[fault]]\nkind = \"reset\"\nat = 1\njoint = 2",
        4,
        9,
        "slip",
    ),
    (
        "[[fault]]\nkind = \"slip\"\nat = 1\njoint = 5\ndegrees = 8",
        4,
        9,
        "1 to 4",
    ),
    (
        "[[fault]]\nkind = \"slip\"\nat = 1\njoint = 2",
        1,
        1,
        "degrees is missing",
    ),
    (
        "[[fault]]\nkind = \"slip\"\nat = 1\njoint = 2\ndegrees = nan",
        5,
        11,
        "NaN",
    ),
    (
        "[[fault]]\nkind = \"cable\"\nat = 1",
        1,
        1,
        "for is missing",
    ),
    (
        "[[fault]]\nkind = \"cable\"\nat = 1\nfor = 0",
        4,
        7,
        "above 0",
    ),
    (
        "[[fault]]\nkind = \"slow\"\nat = 1\nfor = 1\ndelay = -1",
        5,
        9,
        "delay is -1",
    ),
    (
        "[[fault]]\nkind = \"alarm\"\nat = 1\nalarm = 0x0F",
        4,
        9,
        "0x0f",
    ),
    (
        "[[fault]]\nkind = \"alarm\"\nat = 1\nalarm = \"Tired\"",
        4,
        9,
        "'Tired'",
    ),
    // Arm and tool.
    (
        "[arm]\nbase_angle = 5\nhomed = true",
        2,
        14,
        "homed = false",
    ),
    ("[arm]\nbase_angle = 181", 2, 14, "-180 to 180 deg"),
    ("[tool]\nkind = \"pen\"\nopening = 5", 3, 11, "gripper"),
    ("[tool]\nkind = \"pen\"\ngive = -1", 3, 8, "0 to 100 mm"),
];

#[test]
fn what_makes_no_sense_is_refused_where_it_stands() {
    assert!(Scenario::from_toml(GROUND).is_ok());
    assert_eq!(GROUND.lines().count(), ABOVE);
    let mut wrong = String::new();
    for (text, line, column, word) in CASES {
        let told = match Scenario::from_toml(&format!("{GROUND}{text}")) {
            Ok(_) => "accepted".to_owned(),
            Err(error) if error.message.contains('\n') => format!("two lines: {error}"),
            Err(error) if (error.line, error.column) != (ABOVE + line, *column) => {
                error.to_string()
            }
            Err(error) if !error.message.contains(word) => error.to_string(),
            Err(_) => continue,
        };
        wrong.push_str(&format!("{text}\n=> {told}\n\n"));
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn ground_that_makes_no_sense_is_refused() {
    for (text, line, column, word) in [
        ("[table]\nheight = inf", 2, 10, "inf"),
        (
            "[table]\nheight = -70\nx = [5, 5]",
            3,
            5,
            "smaller to the larger",
        ),
        (
            "[conveyor]\nstart = [0, 0]\ndirection = 0\nlength = 0\nwidth = 5\nheight = 0\nstepper = 0",
            4,
            10,
            "above 0",
        ),
        (
            "[conveyor]\nstart = [0, 0]\ndirection = 0\nlength = 9\nwidth = 5\nheight = 0\nstepper = 2",
            7,
            11,
            "0 and 1",
        ),
        (
            "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]",
            1,
            1,
            "there is no table",
        ),
        (
            "[[object]]\nname = \"b\"\nsize = [9, 9, 9]\nat = [10, 0]\non = \"belt\"",
            5,
            6,
            "there is no belt",
        ),
        (
            "[[sensor]]\nkind = \"color\"\nport = \"GP1\"\nbelt_at = 4",
            4,
            11,
            "there is no belt",
        ),
        ("title = 5", 1, 9, "string"),
        ("# ä\n[tool]\nkind = \"Stift, ä\"", 3, 8, "unknown variant"),
    ] {
        let error = Scenario::from_toml(text).unwrap_err();
        assert_eq!(
            (error.line, error.column),
            (line, column),
            "{text}\n{error}"
        );
        assert!(error.message.contains(word), "{text}\n{error}");
    }
}

#[test]
fn an_error_says_where_it_is() {
    let error = Scenario::from_toml("[table]\nheight = 900").unwrap_err();
    let told = "line 2, column 10: height is 900, it must be -500 to 500 mm";
    assert_eq!(error.to_string(), told);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// A damaged file does not panic, and the error names a position inside it.
    #[test]
    fn a_damaged_file_is_refused_inside_it(
        example in 0..EXAMPLES.len(),
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0..6_usize, "[-0-9\\[\\]=\"a-z. \n]{0,6}"), 1..4),
    ) {
        let mut text: Vec<char> = EXAMPLES[example].1.chars().collect();
        for (at, cut, put) in cuts {
            let at = at.index(text.len());
            let end = (at + cut).min(text.len());
            text.splice(at..end, put.chars());
        }
        let text: String = text.into_iter().collect();
        if let Err(error) = Scenario::from_toml(&text) {
            prop_assert!(error.line >= 1 && error.line <= text.lines().count() + 1, "{error}");
            let line = text.split('\n').nth(error.line - 1).unwrap_or_default();
            prop_assert!(error.column >= 1 && error.column <= line.chars().count() + 1, "{error}");
        }
    }
}
