//! Workspaces that cannot become a plan, and the positions of the refusals.

use magician_formats::{Format, ReadOptions, read};
use proptest::prelude::*;

use super::blockly::{block, chain, field, number, value, wait, workspace};
use super::machine::sample;

fn refusal(blocks: &str) -> String {
    whole(&workspace(blocks))
}

fn whole(file: &[u8]) -> String {
    let diagnostic = read(Format::Blockly, file, &ReadOptions::default()).unwrap_err();
    diagnostic.to_string()
}

#[test]
fn other_xml_is_not_a_workspace() {
    assert_eq!(
        whole(b"<root/>"),
        "line 1, column 1: this is not a Blockly workspace: its outermost element is 'root'"
    );
    assert_eq!(
        whole(b"<xml></xml>"),
        "line 1, column 1: the workspace has no blocks"
    );
    assert!(whole(b"IN;PU0 0;").contains("this is not XML"));
}

#[test]
fn endless_programs_are_refused() {
    let forever = [
        field("MODE", "WHILE"),
        value("BOOL", &block("logic_boolean", &field("BOOL", "TRUE"))),
    ];
    let said = refusal(&block("controls_whileUntil", &forever.concat()));
    assert!(
        said.ends_with("the program has not ended after 200000 blocks"),
        "{said}"
    );
    let many = block("controls_repeat_ext", &number("TIMES", 1e300));
    assert!(refusal(&many).ends_with("the program has not ended after 200000 blocks"));
    let counted = |from, to, by| {
        let body = [
            field("VAR", "i"),
            number("FROM", from),
            number("TO", to),
            number("BY", by),
        ];
        refusal(&block("controls_for", &body.concat()))
    };
    assert!(counted(0.0, 1.0, 0.0).ends_with("with steps of 0 from 0 it never ends"));
    assert!(
        counted(1e20, 2e20, 1.0)
            .ends_with("with steps of 1 from 100000000000000000000 it never ends")
    );
}

#[test]
fn blocks_that_are_too_deep_are_refused() {
    let mut sum = block("math_number", &field("NUM", "1"));
    let mut loops = block("dobot_home", "");
    for _ in 0..5000 {
        sum = block(
            "math_arithmetic",
            &[field("OP", "ADD"), value("A", &sum)].concat(),
        );
        loops = block(
            "controls_repeat_ext",
            &[
                number("TIMES", 1.0),
                format!("<statement name=\"DO\">{loops}</statement>"),
            ]
            .concat(),
        );
    }
    for blocks in [wait(&sum), loops] {
        let said = refusal(&blocks);
        assert!(
            said.ends_with("blocks are nested more than 100 deep here"),
            "{said}"
        );
    }
}

#[test]
fn invalid_numbers_are_refused() {
    let sum = |op: &str, a: f64, b: f64| {
        let body = [field("OP", op), number("A", a), number("B", b)].concat();
        refusal(&wait(&block("math_arithmetic", &body)))
    };
    assert!(sum("DIVIDE", 1.0, 0.0).ends_with("(math_arithmetic): its result is not a number"));
    assert!(sum("MULTIPLY", 1e300, 1e300).ends_with("its result is not a number"));
    assert!(sum("SHIFT", 1.0, 1.0).ends_with("math_arithmetic has an unknown operator: 'SHIFT'"));
    let number_of = |text: &str| refusal(&wait(&block("math_number", &field("NUM", text))));
    assert!(number_of("NaN").ends_with("NUM of math_number is 'NaN', which is not a number"));
    assert!(number_of("").ends_with("NUM of math_number is '', which is not a number"));
    let words = block("text", &field("TEXT", "soon"));
    assert!(
        refusal(&wait(&words))
            .ends_with("(dobot_delaytime): time of dobot_delaytime is 'soon', not a number")
    );
    let far = block("dobot_goto", &number("xBias", 1e200));
    assert!(
        refusal(&far).contains("xBias of dobot_goto is 1"),
        "{}",
        refusal(&far)
    );
    let back = block("math_number", &field("NUM", "-1"));
    assert!(refusal(&wait(&back)).ends_with("it waits for -1 s, it must be 0 to 4294967.295 s"));
}

#[test]
fn values_unknown_at_planning_time_are_refused() {
    let get = block("variables_get", &field("VAR", "height"));
    assert!(
        refusal(&wait(&get)).ends_with("(variables_get): the variable 'height' has no value yet")
    );
    let x = block("dobot_get_current_coordinate", &field("value", "1"));
    let home = block("dobot_home", "");
    let said = refusal(&chain(&[home.clone(), wait(&x)]));
    assert!(said.ends_with("it needs x, which is unknown when the plan is made: no earlier block gives the arm's position"), "{said}");
    for kind in ["dobot_setr", "dobot_setl"] {
        let said = refusal(&chain(&[home.clone(), block(kind, "")]));
        assert!(
            said.contains("which is unknown when the plan is made"),
            "{said}"
        );
    }
}

#[test]
fn unknown_choices_are_refused() {
    let is = |kind: &str, fields: &[(&str, &str)], expected: &str| {
        let body: String = fields
            .iter()
            .map(|(name, text)| field(name, text))
            .collect();
        let said = refusal(&block(kind, &body));
        assert!(said.ends_with(expected), "{said}");
    };
    is(
        "dobot_pump",
        &[("io", "2")],
        "io of dobot_pump is 2, it must be 0 to 1",
    );
    is(
        "dobot_gripper",
        &[("io", "0.5")],
        "io of dobot_gripper is 0.5, it must be 0 to 2",
    );
    is(
        "dobot_set_output",
        &[("io", "21"), ("value", "1")],
        "io of dobot_set_output is 21, it must be 1 to 20",
    );
    is(
        "dobot_setiomultiplexing",
        &[("value", "2"), ("io", "1")],
        "unknown pin function 2",
    );
    is(
        "dobot_selectendtype",
        &[("type", "60")],
        "unknown end effector type 60; known are 59.7, 59.701, 61 and 70",
    );
    is(
        "dobot_setemotor",
        &[("io", "0"), ("speed", "2e6")],
        "a motor would run at 2000000 pulses/s, limit 1000000 pulses/s",
    );
    is("", &[], "'' has no type");
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(Format::Blockly, &bytes, &ReadOptions::default());
    }

    #[test]
    fn damaged_workspaces_are_read_or_refused(
        at in any::<prop::sample::Index>(),
        length in 0..60usize,
        other in "[0-9a-zA-Z<>/&;_ .\"=-]{0,16}",
    ) {
        let mut bytes = sample("example_loop.blockly");
        let at = at.index(bytes.len());
        let end = (at + length).min(bytes.len());
        bytes.splice(at..end, other.bytes());
        let _ = read(Format::Blockly, &bytes, &ReadOptions::default());
    }
}
