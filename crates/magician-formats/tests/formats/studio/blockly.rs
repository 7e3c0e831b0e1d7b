//! Blockly workspaces: order, loops, conditions, sums, and the sample on the virtual arm.

use magician_formats::{Format, Tool};

use super::machine::{plan, plan_text, run, sample};

/// Returns a workspace as text; tests write `<b>` for a block to stay readable.
pub(crate) fn workspace(blocks: &str) -> Vec<u8> {
    let xml = "http://www.w3.org/1999/xhtml";
    format!("<xml xmlns=\"{xml}\">{blocks}</xml>").into_bytes()
}

/// Joins blocks one below the other.
pub(crate) fn chain(blocks: &[String]) -> String {
    let mut chain = String::new();
    for block in blocks.iter().rev() {
        let body = block.strip_suffix("</block>").unwrap();
        chain = match chain.as_str() {
            "" => block.clone(),
            next => format!("{body}<next>{next}</next></block>"),
        };
    }
    chain
}

pub(crate) fn block(kind: &str, body: &str) -> String {
    format!("<block type=\"{kind}\" id=\"{kind}\">{body}</block>")
}

pub(crate) fn field(name: &str, text: &str) -> String {
    format!("<field name=\"{name}\">{text}</field>")
}

pub(crate) fn value(name: &str, block: &str) -> String {
    format!("<value name=\"{name}\">{block}</value>")
}

pub(crate) fn number(name: &str, number: f64) -> String {
    value(
        name,
        &block("math_number", &field("NUM", &number.to_string())),
    )
}

/// Returns a block that waits for a number of seconds, which shows a computed value.
pub(crate) fn wait(seconds: &str) -> String {
    block("dobot_delaytime", &value("time", seconds))
}

/// Returns the steps of a workspace, without the names of their blocks, and the notes.
pub(crate) fn steps(blocks: &str) -> (String, Vec<String>) {
    let (plan, notes) = plan(Format::Blockly, &workspace(blocks));
    let steps = plan_text(&plan);
    let steps = steps.lines().filter_map(|line| line.split_once(": "));
    (
        steps.map(|(_, step)| step).collect::<Vec<_>>().join(", "),
        notes,
    )
}

#[test]
fn sample_is_interpreted_and_runs() {
    let (plan, notes) = plan(Format::Blockly, &sample("example_loop.blockly"));
    let expected = "
        a1: Home
        a6: line 210 0 20 0
        b6: suction on
        b7: wait 200
        b9: shift 0 15 5 0 line
        a6: line 220 0 20 0
        b6: suction on
        b7: wait 200
        b9: shift 0 15 5 0 line
        a6: line 230 0 20 0
        b6: suction on
        b7: wait 200
        b9: shift 0 15 5 0 line
        c4: suction off
        c5: jump 210 -40 30 0";
    assert_eq!(plan_text(&plan), expected);
    assert_eq!(
        notes,
        ["line 1, column 469 (a6): it keeps r, which no earlier block has set: 0 is used"]
    );
    assert_eq!(run(&plan, Tool::Suction), [210.0, -40.0, 30.0, 0.0]);
}

#[test]
fn stacks_run_from_the_top_to_the_bottom() {
    let at = |x: i32, y: i32, n: f64| {
        let body = number("time", n);
        format!("<block type=\"dobot_delaytime\" id=\"{n}\" x=\"{x}\" y=\"{y}\">{body}</block>")
    };
    let stacks = [
        at(10, 300, 1.0),
        at(400, 20, 2.0),
        at(20, 20, 3.0),
        at(0, -50, 4.0),
    ]
    .concat();
    let (steps, notes) = steps(&stacks);
    assert_eq!(steps, "wait 4000, wait 3000, wait 2000, wait 1000");
    assert_eq!(notes.len(), 1);
    assert!(
        notes[0].ends_with(
            "(3): the workspace has 4 stacks; they run one after the other, the topmost first"
        ),
        "{notes:?}"
    );
}

#[test]
fn disabled_blocks_are_skipped() {
    let off = |kind: &str, body: &str| {
        format!("<block type=\"{kind}\" id=\"x\" disabled=\"true\">{body}</block>")
    };
    let blocks = chain(&[
        block("dobot_pump", &field("io", "1")),
        off("dobot_get_adc", ""),
        block("dobot_pump", &field("io", "0")),
    ]);
    assert_eq!(steps(&blocks).0, "suction on, suction off");
    let half = off("math_number", &field("NUM", "9"));
    let (said, notes) = steps(&wait(&half));
    assert_eq!(said, "wait 500", "the studio's own number");
    assert!(
        notes[0].ends_with("dobot_delaytime has no time: 0.5 is used"),
        "{notes:?}"
    );
}

/// Returns the steps of a loop, as the waits in it.
fn looped(kind: &str, body: &str, inner: &str) -> String {
    let inner = format!("<statement name=\"DO\">{inner}</statement>");
    steps(&block(kind, &format!("{body}{inner}"))).0
}

fn get(name: &str) -> String {
    block("variables_get", &field("VAR", name))
}

#[test]
fn loop_counts_match_the_studio() {
    let counted = |from, to, by| {
        let body = [
            field("VAR", "i"),
            number("FROM", from),
            number("TO", to),
            number("BY", by),
        ]
        .concat();
        looped("controls_for", &body, &wait(&get("i")))
    };
    assert_eq!(counted(1.0, 3.0, 1.0), "wait 1000, wait 2000, wait 3000");
    assert_eq!(counted(3.0, 1.0, 1.0), "wait 3000, wait 2000, wait 1000");
    assert_eq!(counted(1.0, 2.0, -0.5), "wait 1000, wait 1500, wait 2000");
    assert_eq!(counted(2.0, 2.0, 1.0), "wait 2000");
    let one = wait(&block("math_number", &field("NUM", "1")));
    assert_eq!(
        looped("controls_repeat_ext", &number("TIMES", 2.9), &one),
        "wait 1000, wait 1000"
    );
    assert_eq!(
        looped("controls_repeat", &field("TIMES", "2"), &one),
        "wait 1000, wait 1000"
    );
    assert_eq!(
        looped("controls_repeat_ext", &number("TIMES", -1.0), &one),
        ""
    );
}

#[test]
fn loops_end_by_their_condition_or_by_a_break() {
    let set = |to: f64| {
        block(
            "variables_set",
            &[field("VAR", "n"), number("VALUE", to)].concat(),
        )
    };
    let change = block(
        "math_change",
        &[field("VAR", "n"), number("DELTA", 1.0)].concat(),
    );
    let compare = |op: &str, to: f64| {
        let body = [field("OP", op), value("A", &get("n")), number("B", to)].concat();
        block("logic_compare", &body)
    };
    let body = format!(
        "<statement name=\"DO\">{}</statement>",
        chain(&[change.clone(), wait(&get("n"))])
    );
    let loops = |mode: &str, condition: &str| {
        let inner = [field("MODE", mode), value("BOOL", condition), body.clone()].concat();
        steps(&chain(&[set(0.0), block("controls_whileUntil", &inner)])).0
    };
    assert_eq!(loops("WHILE", &compare("LT", 2.0)), "wait 1000, wait 2000");
    assert_eq!(loops("UNTIL", &compare("GTE", 2.0)), "wait 1000, wait 2000");

    let flow = |how: &str| block("controls_flow_statements", &field("FLOW", how));
    let when = |n: f64, how: &str| {
        let then = format!("<statement name=\"DO0\">{}</statement>", flow(how));
        block(
            "controls_if",
            &[value("IF0", &compare("EQ", n)), then].concat(),
        )
    };
    let inner = chain(&[
        change,
        when(2.0, "CONTINUE"),
        when(4.0, "BREAK"),
        wait(&get("n")),
    ]);
    let forever = [
        field("MODE", "WHILE"),
        value("BOOL", &block("logic_boolean", &field("BOOL", "TRUE"))),
        format!("<statement name=\"DO\">{inner}</statement>"),
    ];
    let blocks = chain(&[
        set(0.0),
        block("controls_whileUntil", &forever.concat()),
        wait(&get("n")),
    ]);
    assert_eq!(steps(&blocks).0, "wait 1000, wait 3000, wait 4000");
}

#[test]
fn first_branch_with_a_true_condition_is_taken() {
    let truth = |truth: &str| block("logic_boolean", &field("BOOL", truth));
    let branch = |conditions: [&str; 2]| {
        let mut body = "<mutation elseif=\"1\" else=\"1\"></mutation>".to_owned();
        for (n, condition) in conditions.into_iter().enumerate() {
            let pump = field("io", "1");
            body += &value(&format!("IF{n}"), &truth(condition));
            let then = if n == 0 {
                wait(&block("math_number", &field("NUM", "1")))
            } else {
                block("dobot_pump", &pump)
            };
            body += &format!("<statement name=\"DO{n}\">{then}</statement>");
        }
        body += &format!(
            "<statement name=\"ELSE\">{}</statement>",
            block("dobot_home", "")
        );
        steps(&block("controls_if", &body)).0
    };
    assert_eq!(branch(["TRUE", "TRUE"]), "wait 1000");
    assert_eq!(branch(["FALSE", "TRUE"]), "suction on");
    assert_eq!(branch(["FALSE", "FALSE"]), "Home");
}

#[test]
fn arithmetic_matches_the_studio() {
    let sum = |kind: &str, op: &str, inputs: &[(&str, f64)]| {
        let inputs: String = inputs
            .iter()
            .map(|(name, value)| number(name, *value))
            .collect();
        let field = if op.is_empty() {
            String::new()
        } else {
            field("OP", op)
        };
        steps(&wait(&block(kind, &[field, inputs].concat()))).0
    };
    let two = |op, a, b| sum("math_arithmetic", op, &[("A", a), ("B", b)]);
    assert_eq!(two("ADD", 1.0, 2.5), "wait 3500");
    assert_eq!(two("MINUS", 3.0, 1.0), "wait 2000");
    assert_eq!(two("MULTIPLY", 3.0, 1.5), "wait 4500");
    assert_eq!(two("DIVIDE", 3.0, 2.0), "wait 1500");
    assert_eq!(two("POWER", 2.0, 3.0), "wait 8000");
    assert_eq!(
        sum("math_modulo", "", &[("DIVIDEND", -1.0), ("DIVISOR", 3.0)]),
        "wait 2000"
    );
    assert_eq!(sum("math_single", "ROOT", &[("NUM", 9.0)]), "wait 3000");
    assert_eq!(sum("math_round", "ROUND", &[("NUM", 2.5)]), "wait 2000");
    assert_eq!(sum("math_trig", "SIN", &[("NUM", 90.0)]), "wait 1000");
    assert_eq!(
        sum(
            "math_constrain",
            "",
            &[("VALUE", 9.0), ("LOW", 1.0), ("HIGH", 4.0)]
        ),
        "wait 4000"
    );
    assert_eq!(
        sum("math_arithmetic", "ADD", &[]),
        "",
        "what is missing is 0"
    );
}

#[test]
fn conditions_match_the_studio() {
    let truth = |truth: bool| {
        block(
            "logic_boolean",
            &field("BOOL", if truth { "TRUE" } else { "FALSE" }),
        )
    };
    let chosen = |condition: &str| {
        let body = [
            value("IF", condition),
            number("THEN", 1.0),
            number("ELSE", 2.0),
        ]
        .concat();
        steps(&wait(&block("logic_ternary", &body))).0 == "wait 1000"
    };
    let both = |op: &str, a, b| {
        let body = [
            field("OP", op),
            value("A", &truth(a)),
            value("B", &truth(b)),
        ]
        .concat();
        chosen(&block("logic_operation", &body))
    };
    for (a, b) in [(false, false), (false, true), (true, false), (true, true)] {
        assert_eq!(both("AND", a, b), a && b);
        assert_eq!(both("OR", a, b), a || b);
    }
    assert!(!chosen(&block(
        "logic_negate",
        &value("BOOL", &truth(true))
    )));
    // The second operand does not matter, and may even be an unsupported block.
    let body = [
        field("OP", "OR"),
        value("A", &truth(true)),
        value("B", &block("dobot_get_adc", "")),
    ];
    assert!(chosen(&block("logic_operation", &body.concat())));
    for (op, expected) in [
        ("EQ", [false, true, false]),
        ("NEQ", [true, false, true]),
        ("LT", [true, false, false]),
        ("LTE", [true, true, false]),
        ("GT", [false, false, true]),
        ("GTE", [false, true, true]),
    ] {
        let against = [1.0, 2.0, 3.0].map(|a| {
            let body = [field("OP", op), number("A", a), number("B", 2.0)].concat();
            chosen(&block("logic_compare", &body))
        });
        assert_eq!(against, expected, "{op}");
    }
}

/// A long program is deeply nested XML.
#[test]
fn long_program_is_accepted() {
    let blocks: Vec<_> = (0..20_000)
        .map(|_| block("dobot_pump", &field("io", "1")))
        .collect();
    let mut xml = String::new();
    for block in &blocks {
        xml += block.strip_suffix("</block>").unwrap();
        xml += "<next>";
    }
    xml += &block("dobot_home", "");
    xml += &"</next></block>".repeat(blocks.len());
    let (plan, _) = plan(Format::Blockly, &workspace(&xml));
    assert_eq!(plan.steps.len(), 20_001);
}
