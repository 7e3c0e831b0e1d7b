//! Property tests with programs and stations that send anything: nothing panics, each call is
//! answered once, and no loop is endless.

mod host;

use magician_link::{LinkOptions, ParamType, methods};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::RngSeed;
use serde_json::{Map, Value, json};

use self::host::Harness;

/// Arbitrary values, valid ones more often.
fn value() -> BoxedStrategy<Value> {
    prop_oneof![
        10 => (-300..300_i32).prop_map(Value::from),
        4 => any::<bool>().prop_map(Value::from),
        1 => Just(Value::Null),
        1 => any::<i64>().prop_map(Value::from),
        1 => any::<u64>().prop_map(Value::from),
        1 => select(vec![1e308, -1e308, 1e-308, 4e9, -0.0, 65536.5]).prop_map(Value::from),
        1 => ".{0,8}".prop_map(Value::from),
        1 => vec(-300.0..300.0_f64, 0..70).prop_map(Value::from),
        1 => (1..120_usize).prop_map(|depth| (0..depth).fold(json!(0), |inner, _| json!([inner]))),
    ]
    .boxed()
}

/// Value that a parameter of this type accepts.
fn valid_value(kind: ParamType) -> BoxedStrategy<Value> {
    match kind {
        ParamType::Number => (-300.0..300.0_f64).prop_map(Value::from).boxed(),
        ParamType::Integer => (0..20_u32).prop_map(Value::from).boxed(),
        ParamType::Bool => any::<bool>().prop_map(Value::from).boxed(),
        ParamType::Text => "[a-z]{0,4}".prop_map(Value::from).boxed(),
        ParamType::Numbers => vec(0..200_u32, 0..70).prop_map(Value::from).boxed(),
        ParamType::Point => Just(json!({"x": 200, "y": 0, "z": 50, "r": 0})).boxed(),
        ParamType::Outputs => Just(json!([{"ratio": 50, "port": 4, "level": 1}])).boxed(),
    }
}

/// Call of a program, mostly valid.
fn call() -> BoxedStrategy<String> {
    let known = any::<Index>().prop_flat_map(|at| {
        let method = at.get(methods());
        let params = (method.params.iter())
            .map(|param| {
                let name = param.name.clone();
                prop_oneof![20 => valid_value(param.kind).prop_map(Some), 1 => value().prop_map(Some), 1 => Just(None)]
                    .prop_map(move |value| value.map(|value| (name.clone(), value)))
            })
            .collect::<Vec<_>>();
        (Just(method.name.clone()), params)
    });
    let common_calls = select(vec![
        "ConnectDobot",
        "ConnectDobot",
        "SetPTPCmd",
        "SetCPCmd",
        "DisconnectDobot",
    ]);
    let common_calls = common_calls.prop_map(|name| {
        let pose_params = ["ptpMode", "cpMode", "x", "y", "z", "r", "velocity"];
        let params = pose_params.map(|name| Some((name.to_owned(), json!(1))));
        (name.to_owned(), params.to_vec())
    });
    let port = select(vec!["sim", "arm", "ttyUSB0", "nowhere"]);
    let wait_params = (any::<bool>(), select(vec![0, 1, 5000, u64::MAX]));
    (
        prop_oneof![3 => known, 1 => common_calls],
        port,
        wait_params,
        0..2000_i64,
    )
        .prop_map(|((name, params), port, (waits, timeout), id)| {
            let mut all: Map<String, Value> = params.into_iter().flatten().collect();
            all.insert("portName".to_owned(), json!(port));
            if waits {
                all.insert("isWaitForFinish".to_owned(), json!(true));
                all.insert("timeout".to_owned(), json!(timeout));
            }
            let method = format!("dobotlink.Magician.{name}");
            json!({"id": id, "method": method, "params": all}).to_string()
        })
        .boxed()
}

/// Line of a script: a call, or a letter with its argument, as read by [`Harness::run_script`].
fn script_line() -> BoxedStrategy<String> {
    let with_number = |marks: &'static [&'static str], most: u32| {
        (select(marks), 0..most).prop_map(|(mark, number)| format!("{mark}{number}"))
    };
    prop_oneof![
        30 => call(),
        2 => ".{0,30}".prop_map(|text| format!("m{text}")),
        2 => value().prop_map(|value| format!("v{value}")),
        1 => value().prop_map(|value| format!("s{}", json!({"method": "arm.state", "params": {"subscription": 1, "state": value}}))),
        10 => Just("A".to_owned()),
        6 => with_number(&["a", "e"], 100),
        6 => with_number(&["f", "t"], 5000),
        2 => with_number(&["!", "x", "l", "p"], 256),
    ]
    .boxed()
}

fn all(strict: bool) -> LinkOptions {
    let mut options = LinkOptions::default();
    (options.strict, options.dangerous, options.laser) = (strict, true, true);
    options
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn each_call_is_answered_exactly_once(script in vec(script_line(), 1..150), strict in any::<bool>()) {
        let mut harness = Harness::new(all(strict));
        harness.run_script(&script.join("\n"));
        harness.end();
    }
}

#[test]
fn flood_of_calls_is_answered() {
    let mut harness = Harness::new(all(false));
    let connect = json!({"id": "c", "method": "dobotlink.Magician.ConnectDobot", "params": {"portName": "sim"}});
    harness.run_script(&format!("A\n{connect}\nA"));
    for id in 0..3000 {
        let params = json!({"portName": "sim", "ptpMode": 1, "x": 200, "y": 0, "z": 50, "r": 0});
        let call = json!({"id": id, "method": "dobotlink.Magician.SetPTPCmd", "params": params});
        harness.run_script(&call.to_string());
    }
    harness.end();
}
