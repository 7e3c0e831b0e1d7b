//! Tests of blocks: insertion, nesting, and protection against exponential expansion.

use std::fmt::Write;

use super::*;

#[test]
fn blocks_are_inserted_turned_scaled_in_rows_and_within_one_another() {
    let words = |entities: &str| {
        file(&format!(
            "0 SECTION 2 HEADER 9 $INSUNITS 70 5 0 ENDSEC \
             0 SECTION 2 TABLES 0 TABLE 2 LAYER 0 LAYER 2 cold 70 1 0 LAYER 2 dark 62 -7 0 LAYER 2 blank 290 0 0 ENDSEC \
             0 SECTION 2 BLOCKS \
             0 BLOCK 2 Tick 10 1 20 1 0 LINE 8 0 10 1 20 1 11 2 21 1 0 ENDBLK \
             0 BLOCK 2 Pair 10 0 20 0 0 INSERT 2 tick 10 0 20 0 0 INSERT 2 TICK 10 0 20 5 50 90 0 ENDBLK \
             0 BLOCK 2 Snake 0 INSERT 2 SNAKE 10 0 20 0 0 POINT 10 0 20 0 0 ENDBLK \
             0 ENDSEC 0 SECTION 2 ENTITIES {entities} 0 ENDSEC"
        ))
    };
    let drawn = |entities: &str| {
        let (artwork, notes) = drawn(words(entities).as_bytes());
        let lines = artwork.strokes.iter().map(|stroke| {
            let rounded = |value: f64| (value * 1e6).round() as i64 / 1_000_000;
            let points = stroke.points.iter();
            points.map(|point| point.map(rounded)).collect::<Vec<_>>()
        });
        let notes: Vec<_> = notes.into_iter().map(|note| note.message).collect();
        (lines.collect::<Vec<_>>(), notes)
    };
    // Coordinates are in cm.
    let (lines, notes) = drawn("0 INSERT 2 Tick 10 3 20 4 41 2 50 180");
    assert_eq!((lines, notes.len()), (vec![vec![[30, 40], [10, 40]]], 0));
    let (lines, _) = drawn("0 INSERT 2 Tick 10 0 20 0 70 2 71 2 44 3 45 4 50 90");
    let starts: Vec<_> = lines.iter().map(|line| line[0]).collect();
    assert_eq!(starts, [[0, 0], [0, 30], [-40, 0], [-40, 30]]);
    let (lines, _) = drawn("0 INSERT 2 Pair 10 1 20 1 42 -1");
    assert_eq!(lines, [[[10, 10], [20, 10]], [[10, -40], [10, -50]]]);

    let (lines, notes) = drawn("0 INSERT 2 Snake 10 0 20 0 0 INSERT 2 Nobody 10 0 20 0");
    assert_eq!(lines.len(), 1);
    assert!(notes[0].contains("contains itself") && notes[1].contains("not in the file"));

    // Layer 0 of a block stands for the layer of the insertion.
    for (layer, count) in [
        ("cold", 0),
        ("COLD", 0),
        ("dark", 0),
        ("blank", 0),
        ("other", 1),
    ] {
        let (lines, notes) = drawn(&format!("0 INSERT 8 {layer} 2 Tick 10 0 20 0"));
        assert_eq!((lines.len(), notes.len()), (count, 1 - count), "{layer}");
    }
}

#[test]
fn blocks_that_expand_too_far_are_refused() {
    let mut words = "0 SECTION 2 BLOCKS 0 BLOCK 2 b0 0 POINT 10 0 20 0 0 ENDBLK".to_owned();
    for nth in 1..30 {
        let inner = format!("0 INSERT 2 b{} 10 0 20 0", nth - 1);
        write!(words, " 0 BLOCK 2 b{nth} {inner} {inner} 0 ENDBLK").unwrap();
    }
    words += " 0 ENDSEC 0 SECTION 2 ENTITIES 0 INSERT 2 b29 10 0 20 0 0 ENDSEC";
    let diagnostic = read(Format::Dxf, file(&words).as_bytes(), &options()).unwrap_err();
    assert!(diagnostic.message.contains("more than"), "{diagnostic}");
    let rows = "0 SECTION 2 BLOCKS 0 BLOCK 2 b 0 ENDBLK 0 ENDSEC \
        0 SECTION 2 ENTITIES 0 INSERT 2 b 10 0 20 0 70 9000000 71 9000000 0 ENDSEC";
    read(Format::Dxf, file(rows).as_bytes(), &options()).unwrap_err();
}
