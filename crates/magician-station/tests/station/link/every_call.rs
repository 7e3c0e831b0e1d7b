//! Every call of the table on a virtual arm: each is answered. On a real arm, frames beyond the
//! table are sent.

use magician_link::{Access, AnswerTime, Method, ParamType, methods};
use magician_station::link::LinkOptions;
use serde_json::{Map, Value, json};

use super::program::Program;
use crate::bench::LocalStation;

/// Parameters of the right types, within the table's ranges.
fn sample(method: &Method) -> Value {
    let mut params = Map::new();
    for param in &method.params {
        let value = match (param.kind, param.name.as_str()) {
            (ParamType::Number, "x" | "ptpCmd.x") => json!(200),
            (ParamType::Number, "z" | "ptpCmd.z") => json!(30),
            (ParamType::Number, name) if name.to_lowercase().contains("velocity") => json!(50),
            (ParamType::Number, name) if name.to_lowercase().contains("acc") => json!(50),
            (ParamType::Number, "junctionVel" | "frequency" | "value") => json!(50),
            (ParamType::Number, _) => json!(0),
            (ParamType::Integer, "ptpMode" | "ptpCmd.ptpMode" | "cpMode" | "count" | "port") => {
                json!(1)
            }
            (ParamType::Integer, "totalLoop" | "linePerLoop") => json!(1),
            (ParamType::Integer, "delay") => json!(10),
            (ParamType::Integer, "speed" | "distance") => json!(100),
            (ParamType::Integer, _) => json!(0),
            (ParamType::Bool, name) => json!(name == "enable" && method.name.contains("Sensor")),
            (ParamType::Text, _) => json!("text"),
            (ParamType::Numbers, "address") => json!([192, 168, 1, 2]),
            (ParamType::Numbers, _) => json!([50, 50, 50, 50]),
            (ParamType::Point, "cirPoint") => json!({"x": 220, "y": 20, "z": 30, "r": 0}),
            (ParamType::Point, _) => json!({"x": 200, "y": 40, "z": 30, "r": 0}),
            (ParamType::Outputs, _) => json!([{"ratio": 50, "port": 4, "level": 1}]),
        };
        match param.name.split_once('.') {
            None => drop(params.insert(param.name.clone(), value)),
            Some((object, member)) => {
                let object = params.entry(object).or_insert_with(|| json!({}));
                object[member] = value;
            }
        }
    }
    if method.class == AnswerTime::Action {
        params.insert("isWaitForFinish".to_owned(), json!(false));
    }
    Value::Object(params)
}

/// Returns the answer of each method: `ok`, or the error number.
async fn answers(ids: std::ops::RangeInclusive<u8>) -> Vec<(String, String, String)> {
    let mut options = LinkOptions::default();
    (options.dangerous, options.laser) = (true, true);
    let bench = LocalStation::new(1).await;
    let mut program = Program::with(&bench, options);
    program.ok("ConnectDobot", json!({})).await;
    let mut all = Vec::new();
    for method in methods().iter().filter(|method| ids.contains(&method.id)) {
        let outcome = program.call(&method.name, sample(method)).await;
        if let (Ok(result), Access::Read) = (&outcome, method.access) {
            let keys: Vec<_> = method.results.iter().map(|result| &result.name).collect();
            let told = |key: &&String| result.get(key.as_str()).is_some();
            // `period` and `acc` exclude each other.
            let missing = keys.iter().filter(|key| !told(key)).count();
            assert!(
                missing <= usize::from(method.name == "GetCPParams"),
                "{}: {result}",
                method.name
            );
        }
        let (told, why) = match outcome {
            Ok(_) => ("ok".to_owned(), String::new()),
            Err((code, why)) => {
                assert!(code != -32606, "{}: {why}", method.name);
                (code.to_string(), why)
            }
        };
        all.push((method.name.clone(), told, why));
    }
    all
}

#[tokio::test(start_paused = true)]
async fn every_link_call_is_answered_on_a_virtual_arm() {
    // A laser that may burn prevents the start of the queue, so calls of the queue use another arm.
    let mut all = answers(0..=239).await;
    all.extend(answers(240..=255).await);
    assert_eq!(all.len(), 149);
    let not_ok: Vec<_> = all.iter().filter(|(_, told, _)| told != "ok").collect();
    for (name, told, why) in &not_ok {
        let method = Method::named(name).unwrap();
        let expected = if method.refused.is_some() {
            "-32605"
        } else {
            "-32604"
        };
        assert_eq!(told, expected, "{name}: {why}");
        assert!(
            method.command.is_none() && method.virtual_answer.is_none(),
            "{name}: {told} {why}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn unknown_frames_are_sent_to_a_real_arm() {
    let bench = LocalStation::real(1).await;
    let mut options = LinkOptions::default();
    options.dangerous = true;
    let mut program = Program::with(&bench, options);
    program.ok("ConnectDobot", json!({})).await;
    let beyond =
        { methods().iter() }.filter(|method| method.command.is_none() && method.refused.is_none());
    for method in beyond {
        // This arm does not know the frames and does not answer.
        let code = program.code(&method.name, sample(method)).await;
        assert_eq!(code, 150, "{}", method.name);
    }
    let beyond = { bench.arms[0].state().alarms }.contains(0x01);
    assert!(beyond, "the alarm of an unknown command tells that it came");
}
