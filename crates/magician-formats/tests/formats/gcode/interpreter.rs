//! Parameters, expressions, O-words and subprograms: computed values are drawn, and every program
//! ends.

use magician_formats::Action;
use proptest::prelude::*;

use super::{actions, actions_with, diagnostic, motions, notes, path, travel, try_read};

/// Returns the X coordinate to which a line with the expression `value` moves.
fn value(before: &str, value: &str) -> f32 {
    let text = format!("{before}\nG0 X{value} Y0 Z0\n");
    match motions(&text)[..] {
        [Action::Move { to: [x, ..], .. }] => x,
        ref other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn values_follow_rs_274() {
    for (text, expected) in [
        ("[1+2*3]", 7.0),
        ("[[1+2]*3]", 9.0),
        ("[2**3**2]", 64.0),
        ("[10-4-3]", 3.0),
        ("[7 MOD 3]", 1.0),
        ("[-7 mod 3]", 2.0),
        ("[2 * 3 MOD 4]", 2.0),
        ("[1 + acos[0] - [2 ** [4.0/2]]]", 87.0),
        ("-[4]", -4.0),
        ("+[4]", 4.0),
        ("[-[2+1]*-2]", 6.0),
        ("[5 GT 4]", 1.0),
        ("[5 gt 5]", 0.0),
        ("[5 GE 5.0000001]", 1.0),
        ("[1 EQ 1.0000001]", 1.0),
        ("[1 NE 1.0000001]", 0.0),
        ("[1 LT 2 AND 3 LE 2]", 0.0),
        ("[1 LT 2 OR 3 LE 2]", 1.0),
        ("[1 XOR 2]", 0.0),
        ("[1+1 EQ 2]", 1.0),
        ("ABS[-3.5]", 3.5),
        ("sin[30]", 0.5),
        ("COS[60]", 0.5),
        ("TAN[45]", 1.0),
        ("ASIN[0.5]", 30.0),
        ("ATAN[1]/[-1]", 135.0),
        ("ATAN [ 1 ] / [ 1 ]", 45.0),
        ("SQRT[[9]]", 3.0),
        ("EXP[0]", 1.0),
        ("LN[EXP[2]]", 2.0),
        ("FIX[2.8]", 2.0),
        ("FIX[-2.8]", -3.0),
        ("FUP[2.2]", 3.0),
        ("FUP[-2.8]", -2.0),
        ("ROUND[2.5]", 3.0),
        ("ROUND[-2.5]", -3.0),
        ("#1", 3.0),
        ("-#1", -3.0),
        ("[#1+2]", 5.0),
        ("#[1+1]", 12.0),
        ("##1", 7.0),
        ("#<width>", 20.0),
        ("#< W idth >", 20.0),
        ("[#<_deep>*2]", 3.0),
        ("EXISTS[#<width>]", 1.0),
        ("EXISTS[#<height>]", 0.0),
        ("[EXISTS[#<_deep>] + 1]", 2.0),
        ("EXISTS[#99]", 1.0),
        ("EXISTS[#99999]", 0.0),
    ] {
        let before = "#1=3 #2=12 #3=7\n#<width>=20 #<_DEEP>=1.5";
        let found = value(before, text);
        assert!((found - expected).abs() < 1e-5, "{text}: {found}");
    }
}

#[test]
fn line_is_evaluated_before_its_assignments() {
    assert_eq!(value("#3=15\n#3=6 #4=#3", "#4"), 15.0);
    let swapped = "#1=10 #2=20\n#1=#2 #2=#1\n";
    assert_eq!(value(swapped, "[#1*100+#2]"), 2010.0);
    assert_eq!(value("#3=15 #3=6", "#3"), 6.0);
    assert_eq!(
        motions("#3=200\n#3=6 G0 X#3 Y0 Z0\nG1 X#3\n")[..],
        [travel(200.0, 0.0, 0.0), path(6.0, 0.0, 0.0)]
    );
}

#[test]
fn program_state_is_readable() {
    assert_eq!(value("G10 L2 P2 Y7", "#5242"), 7.0);
    assert_eq!(value("G55", "#5220"), 2.0);
    assert_eq!(value("G59.1", "#<_coord_system>"), 591.0);
    assert_eq!(value("G56", "#<_coord_system>"), 560.0);
    assert_eq!(value("F120", "#<_feed>"), 120.0);
    assert_eq!(value("G18", "#<_plane>"), 180.0);
    assert_eq!(value("G91\nG90", "[#<_absolute>+#<_incremental>*10]"), 1.0);
    let after = |before: &str, asked: &str| match motions(&format!("{before}\nG1 X{asked}\n")).pop()
    {
        Some(Action::Path { to: [x, ..] }) => x,
        other => panic!("{other:?}"),
    };
    assert_eq!(after("G0 X230 Y10 Z5", "[#5420+1]"), 231.0);
    assert_eq!(after("G0 X230 Y10 Z5", "[#<_y>+#5422]"), 15.0);
    assert_eq!(after("G0 X230 Y10 Z5\nG92 X0", "[#<_x>+#<_abs_x>]"), 460.0);
    assert_eq!(after("G0 X254 Y10 Z5\nG20", "[#<_x>-1]"), 228.6);
    assert_eq!(
        notes("G0 X#100 Y0 Z0\n")[..1],
        ["line 1, column 1: #100 is read before it is set: 0 is used"]
    );
}

#[test]
fn loops_and_branches_follow_their_labels() {
    let expected = [
        travel(200.0, 0.0, 0.0),
        path(201.0, 0.0, 0.0),
        path(202.0, 0.0, 0.0),
        path(203.0, 0.0, 0.0),
    ];
    let start = "G0 X200 Y0 Z0\n#1=1\n";
    for text in [
        "o1 while [#1 LE 3]\nG1 X[200+#1]\n#1=[#1+1]\no1 endwhile\n",
        "O1WHILE[#1 LE 3]\nG1 X[200+#1]\n#1=[#1+1]\nN5 o1 ENDWHILE (done)\n",
        "o<l oop> do\nG1 X[200+#1]\n#1=[#1+1]\no<loop> while [#1 LE 3]\n",
        "o1 repeat [3]\nG1 X[200+#1]\n#1=[#1+1]\no1 endrepeat\n",
        "o1 repeat [1]\no2 repeat [3]\nG1 X[200+#1]\n#1=[#1+1]\no2 endrepeat\no1 endrepeat\no1 repeat [0]\nG1 X0\no1 endrepeat\n",
        "o1 while [1]\no2 if [#1 GT 3]\no1 break\no2 endif\nG1 X[200+#1]\n#1=[#1+1]\no1 endwhile\n",
        "o1 repeat [9]\no2 if [#1 GT 3]\no1 continue\no2 endif\nG1 X[200+#1]\n#1=[#1+1]\no1 endrepeat\n",
        "o1 do\no2 if [#1 EQ 2]\nG1 X202\n#1=3\no1 continue\no2 endif\nG1 X[200+#1]\n#1=[#1+1]\no1 while [#1 LT 4]\n",
        "o1 repeat [3]\no2 if [#1 EQ 1]\nG1 X201\no2 elseif [#1 EQ 2]\nG1 X202\no2 else\nG1 X203\no2 endif\n#1=[#1+1]\no1 endrepeat\n",
        "o9 sub\nG1 X[200+#1]\no9 endsub\no9 call [1]\no9 call [2]\no9 call [3] (a comment)\n",
        "o9 sub\nG1 X[200+#1]\no9 endsub\no[4+5] call [1]\n#7=9\no#7 call [2]\no9 call [3]\n",
        "o9 call [3]\nM2\no9 sub\no1 if [#1 GT 1]\no9 call [#1-1]\no1 endif\nG1 X[200+#1]\no9 endsub\n",
        "o9 sub\n#<here>=#1\no8 call [#<here>] [1]\nG1 X[200+#<_value>]\no9 endsub\no8 sub\n#<here>=99\no1 if [#2]\no8 return [#1]\no1 endif\nG1 X0\no8 endsub\no9 call [1]\no9 call [2]\no9 call [3]\n",
        "M98 P100 L3\nM30\nO100\nG1 X[200+#1]\n#1=[#1+1]\nM99\n",
        "M98 P0100\nG1 X203\nM99\nO0100 (the first)\nG1 X201\nM98 P7\nM99\nO7\nG1 X202\nM99\n",
        "G1 X201\nG1 X202\nG1 X203\n%\nG1 X0\n",
        "N10 /G1 X0\nG1 X201 ((nested (twice)) Y7)\n(MSG,(a) b)X202(X5\nX203\n",
    ] {
        assert_eq!(motions(&format!("{start}{text}")), expected, "{text}");
    }
    // Parameters and names that are local to the call disappear after it.
    let text =
        "#1=5\no1 sub\n#1=[#1*2]\n#31=#1\n#<a>=1\no1 endsub\no1 call [20]\n#<_e>=EXISTS[#<a>]\n";
    assert_eq!(value(text, "[#1+#31*10+#<_e>*1000]"), 405.0);
    // A parameter that the call does not give keeps the caller's value.
    let text = "#1=5 #2=6\no1 sub\n#31=[#1*10+#2]\no1 endsub\no1 call [2]\n";
    assert_eq!(value(text, "#31"), 26.0);
}

#[test]
fn step_has_the_origin_of_its_line() {
    let text = "G0 X200 Y0 Z0\no1 repeat [2]\n  G91 G1 X1\no1 endrepeat\nG1 Y1\n";
    let (plan, _) = try_read(text).expect("it is right");
    let paths = plan
        .steps
        .iter()
        .filter(|step| matches!(step.action, Action::Path { .. }));
    let lines: Vec<_> = paths
        .map(|step| (step.origin.line, step.origin.column))
        .collect();
    assert_eq!(lines, [(3, 3), (3, 3), (5, 1)]);
}

#[test]
fn impossible_statement_is_refused_with_origin_and_reason() {
    for (text, message) in [
        ("G0 X[1+", "line 1, column 8: a value is missing here"),
        ("G0 X[1+2", "line 1, column 5: this bracket is not closed"),
        ("G0 X[1 2]", "line 1, column 5: this bracket is not closed"),
        ("G0 X[1/0]", "line 1, column 6: this divides by 0"),
        (
            "G0 XSQRT[-1]",
            "line 1, column 5: SQRT of -1 is not a number",
        ),
        (
            "G0 X[-8**0.5]",
            "line 1, column 6: this of -8 and 0.5 is not a number (*..)",
        ),
        (
            "G0 XATAN[1]",
            "line 1, column 5: ATAN takes two values: ATAN[1]/[2]",
        ),
        (
            "#1",
            "line 1, column 1: #1 needs a letter before it or = after it",
        ),
        ("#1=", "line 1, column 1: #1 is set without a value"),
        (
            "#0=1",
            "line 1, column 1: unknown parameter #0; they are #1 to #5602",
        ),
        (
            "#[1.5]=1",
            "line 1, column 1: unknown parameter #1.5; they are #1 to #5602",
        ),
        ("#<a=1", "line 1, column 2: a name ends with > on its line"),
        ("G0 X#<a>", "line 1, column 5: #<a> is read, but never set"),
        (
            "\nG0 X#5061",
            "line 2, column 5: #5061 is the result of a probe, which is unknown here",
        ),
        (
            "G0 X#5410",
            "line 1, column 5: #5410 is a property of a machine's tool, which is unknown here",
        ),
        (
            "#1=#5161",
            "line 1, column 4: #5161 is a position stored in the controller (G28, G30), which is unknown here",
        ),
        (
            "#1=#5399",
            "line 1, column 4: #5399 is an input of a machine (M66), which is unknown here",
        ),
        (
            "#1=#5420",
            "line 1, column 4: #5420 is the tool's position, which is unknown here",
        ),
        (
            "#1=#<_current_tool>",
            "line 1, column 4: #<_current_tool> is a property of a machine, which is unknown here",
        ),
        (
            "#1=#<_ini[setup]xpos>",
            "line 1, column 4: #<_ini[setup]xpos> is a property of a machine, which is unknown here",
        ),
        (
            "#5221=1",
            "line 1, column 1: #5221 is a property of a machine and cannot be set",
        ),
        ("#<_feed>=1", "line 1, column 1: #<_feed> is read-only"),
        (
            "o1 endif",
            "line 1, column 1: o1 endif does not match: nothing is open here",
        ),
        (
            "o1 if [1]\no2 while [1]\no1 endif",
            "line 3, column 1: o1 endif does not match: o2 while of line 2 is open here",
        ),
        (
            "G0 X1 Y1\no1 if [1]\n",
            "line 2, column 1: o1 if is not ended",
        ),
        ("o1 break", "line 1, column 1: break is not in a loop o1"),
        (
            "o1 sub\no2 sub\no2 endsub\no1 endsub",
            "line 2, column 1: a subroutine begins within another one",
        ),
        (
            "o1 sub\no1 endsub\no1 sub\no1 endsub",
            "line 3, column 1: there are two subroutines o1",
        ),
        (
            "o<away> call",
            "line 1, column 1: o<away> is called, but this file has no such subroutine",
        ),
        (
            "o[1+1] call",
            "line 1, column 1: o2 is called, but this file has no such subroutine",
        ),
        ("o#1 if [1]", "line 1, column 5: I has no number"),
        (
            "o1 return",
            "line 1, column 1: o1 returns, but it was not called",
        ),
        (
            "o1 if\no1 endif",
            "line 1, column 1: o1 has no value in brackets",
        ),
        (
            "o1 if [1] G0 X1\no1 endif",
            "line 1, column 11: unexpected text after the value of an O-word",
        ),
        (
            "o1 sub\no1 endsub\no1 call 5",
            "line 3, column 9: call takes up to 30 values in brackets, as in o100 call [1] [#2]",
        ),
        (
            "M98 P7",
            "line 1, column 1: M98 calls program O7, which is not in this file",
        ),
        (
            "o1 sub\no1 call\no1 endsub\no1 call",
            "line 2, column 1: subroutines call each other more than 100 deep",
        ),
        (
            "O5\nM98 P5\nM99",
            "line 2, column 1: subroutines call each other more than 100 deep",
        ),
        (
            "M3 S[500*3]\nG0 X200 Y0 Z0\nG1 X201",
            "line 1, column 4: S1500 is above 1000, but the S of full power is unknown",
        ),
    ] {
        assert_eq!(diagnostic(text), message, "{text}");
    }
    let deep = format!("G0 X{}1{}", "[".repeat(2000), "]".repeat(2000));
    assert!(diagnostic(&deep).contains("values are nested more than 60 deep"));
    let deep = format!("G0 X{}1", "#".repeat(5000));
    assert!(diagnostic(&deep).contains("values are nested more than 60 deep"));
}

#[test]
fn endless_program_is_refused() {
    let text = "M98 P1 L999999999\nM2\nO1\nG4 P0\nM99\n";
    let found = diagnostic(text);
    let endless = "the program repeats more than 300000 lines: it seems endless";
    assert!(
        found.starts_with("line ") && found.contains(endless),
        "{found}"
    );
    // A loop is limited also by its moves: each line here is many of them.
    let text = "M3 S1\nG0 X200 Y0 Z0\no1 repeat [100000]\nG2 I-50 P10\no1 endrepeat\n";
    assert!(diagnostic(text).contains("the program makes more than 1000000 moves"));
}

#[test]
fn computed_power_stays_within_full_power() {
    let burns = |text: &str| -> Vec<f32> {
        let all = actions(text).into_iter();
        let powers = all.filter_map(|action| match action {
            Action::Burn { power, .. } if power > 0.0 => Some(power),
            _ => None,
        });
        powers.collect()
    };
    let start = "G0 X200 Y0 Z0\n";
    // The greatest S counts even within a loop or in a branch never taken.
    let text = format!(
        "{start}M3\n#1=100\no1 repeat [3]\nG1 S#1 X[200+#1/100] F600\n#1=[#1+100]\no1 endrepeat\n"
    );
    assert_eq!(burns(&text), [10.0, 20.0, 30.0]);
    let text =
        format!("{start}M3 S[5*10]\no1 if [0]\n; $30=50\nM3 S5000\no1 endif\nG1 X201 F600\n");
    assert_eq!(burns(&text), [5.0]);
    // The S of a mill is a spindle speed, even if it is computed.
    let text = format!(
        "{start}M3 S[12*1000]\n#1=-1\no1 repeat [2]\nG1 Z#1 F60\nX[201-#1]\n#1=[#1-1]\no1 endrepeat\n"
    );
    assert_eq!(burns(&text), [0.0; 0]);
    let servo = actions_with(
        &format!("{start}#<down>=30\nM300 S#<down>\nG1 X201\nM300 S[#<down>+20]\nG0 X202\n"),
        |options| options.surface = Some(magician_formats::Surface::level(-40.0)),
    );
    let low = servo
        .iter()
        .filter(|action| action.target().is_some_and(|to| to[2] == -40.0));
    assert_eq!(low.count(), 2);
}

/// Returns a strategy for lines of loops, calls and parameters, which match each other or not.
fn line() -> impl Strategy<Value = String> {
    let value = prop::sample::select(vec![
        "[#1 LT 5]",
        "[#1+1]",
        "[#2]",
        "[1]",
        "[0]",
        "[3]",
        "#1",
        "[#<a> EQ 2]",
        "[RANDOM]",
        "[#1/#2]",
    ]);
    let word = prop::sample::select(vec![
        "sub",
        "endsub",
        "call",
        "return",
        "if",
        "elseif",
        "else",
        "endif",
        "do",
        "while",
        "endwhile",
        "repeat",
        "endrepeat",
        "break",
        "continue",
    ]);
    prop_oneof![
        6 => (1..4_u32, word, prop::option::of(value.clone()))
            .prop_map(|(label, word, value)| format!("o{label} {word} {}", value.unwrap_or_default())),
        2 => (1..4_u32, value.clone()).prop_map(|(number, value)| format!("#{number}={value}")),
        1 => value.clone().prop_map(|value| format!("#<a>={value}")),
        2 => value.prop_map(|value| format!("G1 X{value} Y#1 S#2")),
        1 => (1..4_u32).prop_map(|number| format!("M98 P{number} L2")),
        1 => (1..4_u32).prop_map(|number| format!("O{number}")),
        1 => prop::sample::select(vec!["M99", "M2", "%", "G10 L20 P1 X#1", "G92 X#2"]).prop_map(str::to_owned),
    ]
}

proptest! {
    #[test]
    fn every_program_terminates(lines in prop::collection::vec(line(), 0..20)) {
        let _ = try_read(&lines.join("\n"));
    }

    #[test]
    fn parser_survives_malformed_expressions(
        text in "((G1|o1|o<a>|#|#<a>|=|\\[|\\]|\\*\\*|ATAN|EXISTS|MOD|if|while|sub|endsub|call|M98|[XPL]|[0-9.+-]|[ \n/]){1,3}){0,60}"
    ) {
        let _ = try_read(&text);
    }
}
