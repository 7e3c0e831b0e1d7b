//! Rights of programs: connecting, leases, dangerous calls, invalid calls.

use magician_station::link::LinkOptions;
use magician_station::{Role, link::LinkService};
use serde_json::{Value, json};

use super::program::Program;
use crate::bench::LocalStation;

#[tokio::test(start_paused = true)]
async fn arm_names_are_link_ports() {
    let bench = LocalStation::new(2).await;
    let mut program = Program::new(&bench);
    let found = program.ok("SearchDobot", json!({"filter": "ARM2"})).await;
    assert_eq!(
        found,
        json!([{"portName": "arm1", "description": "virtual Magician arm1", "status": "unconnected"}])
    );
    assert_eq!(
        program
            .code("ConnectDobot", json!({"portName": "COM9"}))
            .await,
        100
    );
    let told = program
        .ok("ConnectDobot", json!({"portName": "arm1"}))
        .await;
    assert_eq!(told["productName"], json!("Magician"));
    assert_eq!(told["firmwareName"], json!("Dobot"));
    assert!(told["firmwareVersion"].as_str().unwrap().split('.').count() == 3);
    let found = program.ok("SearchDobot", json!({})).await;
    assert_eq!(
        (&found[0]["status"], &found[1]["status"]),
        (&json!("connected"), &json!("unconnected"))
    );
}

#[tokio::test(start_paused = true)]
async fn connect_may_return_empty_texts_like_dobotlink() {
    let bench = LocalStation::new(1).await;
    let mut options = LinkOptions::default();
    options.empty_connect = true;
    let mut program = Program::with(&bench, options);
    let told = program.ok("ConnectDobot", json!({})).await;
    assert_eq!(
        told,
        json!({"productName": "", "firmwareName": "", "firmwareVersion": ""})
    );
}

#[tokio::test(start_paused = true)]
async fn link_errors_have_their_codes() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::new(&bench);
    for (text, code) in [
        (r#"{"id": 1, "method": "other.Magician.GetPose"}"#, 2),
        (r#"{"id": 1, "method": "dobotlink"}"#, 2),
        (r#"{"id": 1, "method": 5}"#, 2),
        (r#"{"id": 1, "method": "dobotlink.Toaster.GetPose"}"#, 1),
        (
            r#"{"id": 1, "method": "dobotlink.RunCmd.Start", "params": {"cmd": "true"}}"#,
            1,
        ),
        (
            r#"{"id": 1, "method": "dobotlink.Magician.Fly", "params": {"portName": "arm"}}"#,
            -32600,
        ),
        (
            r#"{"id": 1, "method": "dobotlink.Magician.GetPose"}"#,
            -32603,
        ),
        (
            r#"{"id": 1, "method": "dobotlink.Magician.GetPose", "params": {"portName": 3}}"#,
            -32603,
        ),
        (
            r#"{"id": 1, "method": "dobotlink.MAGICIAN.GetPose", "params": {"portName": "arm"}}"#,
            103,
        ),
        (
            r#"{"id": 1, "method": "dobotlink.MagicianLite.GetSeeedTempSensor", "params": {"portName": "arm"}}"#,
            -32604,
        ),
        (
            r#"{"id": 1, "method": "dobotlink.Magician.GetPose", "params": [1]}"#,
            -32602,
        ),
        (r#"{"id": 1, "method": "dobotlink.api.Fly"}"#, -32600),
    ] {
        let answer = program.raw(text).await;
        assert_eq!(answer["error"]["code"], json!(code), "{text}");
        assert_eq!(answer["id"], json!(1), "{text}");
    }
    // Text other than JSON is not answered.
    program.link.send("{").await;
    let answer = program
        .raw(r#"{"id": 2, "method": "dobotlink.api.ShowMessage"}"#)
        .await;
    assert_eq!(
        (&answer["id"], &answer["result"]),
        (&json!(2), &json!(true))
    );
}

#[tokio::test(start_paused = true)]
async fn missing_or_mistyped_parameters_move_nothing() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let before = bench.arms[0].state().pose;
    for params in [
        json!({"ptpMode": 1, "x": 200, "y": 0, "z": 0}),
        json!({"ptpMode": 1, "x": "200", "y": 0, "z": 0, "r": 0}),
        json!({"ptpMode": 1.5, "x": 200, "y": 0, "z": 0, "r": 0}),
        json!({"ptpMode": 1, "x": 200, "y": 0, "z": 0, "r": 0, "isQueued": "yes"}),
        json!({"ptpMode": 1, "x": 200, "y": 0, "z": 0, "r": 0, "timeout": -1}),
        json!({"ptpMode": 1, "x": 1e300, "y": 0, "z": 0, "r": 0}),
        json!({"ptpMode": 99, "x": 200, "y": 0, "z": 0, "r": 0}),
    ] {
        assert_eq!(
            program.code("SetPTPCmd", params.clone()).await,
            -32602,
            "{params}"
        );
    }
    assert_eq!(bench.arms[0].state().pose, before);
}

#[tokio::test(start_paused = true)]
async fn unknown_parameters_are_reported_or_refused_when_strict() {
    let bench = LocalStation::new(1).await;
    let service = LinkService::new(bench.station.clone(), LinkOptions::default());
    let mut program = Program::of(&service);
    program.ok("ConnectDobot", json!({})).await;
    let cup = json!({"enableCtrl": true, "on": true, "colour": "red"});
    program.ok("SetEndEffectorSuctionCup", cup.clone()).await;
    let read = program.ok("GetEndEffectorSuctionCup", json!({})).await;
    assert_eq!(read, json!({"isEnabled": true, "isOn": true}));
    let report = service.report();
    let odd = &report["clients"][0]["unknown_params"];
    assert_eq!(
        odd["Magician.SetEndEffectorSuctionCup.enableCtrl"],
        json!(1)
    );
    assert_eq!(odd["Magician.SetEndEffectorSuctionCup.colour"], json!(1));
    drop(program);
    let mut options = LinkOptions::default();
    options.strict = true;
    let mut program = Program::with(&bench, options);
    program.ok("ConnectDobot", json!({})).await;
    assert_eq!(program.code("SetEndEffectorSuctionCup", cup).await, -32602);
}

#[tokio::test(start_paused = true)]
async fn program_without_lease_may_read_and_stop_only() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let mut program = Program::connected(&bench).await;
    program.ok("GetPose", json!({})).await;
    let at = json!({"ptpMode": 1, "x": 200, "y": 0, "z": 30, "r": 0});
    assert_eq!(program.code("SetPTPCmd", at.clone()).await, 101);
    let id = anna.send("arm.move", json!({"to": [200, 150, 30, 0]}));
    program
        .ok("QueuedCmdStop", json!({"forceStop": true}))
        .await;
    assert_eq!(anna.answer(id).await.unwrap_err()["code"], json!(-32007));
    let lease = anna.lease().await;
    anna.ok("lease.release", json!({"lease": lease})).await;
    // Now the lease is free.
    program.ok("SetPTPCmd", at).await;
}

#[tokio::test(start_paused = true)]
async fn taken_lease_ends_waits() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let mut teacher = bench.join_as("teacher", Role::Teacher).await;
    let at = json!({"ptpMode": 2, "x": 200, "y": 150, "z": 30, "r": 0, "timeout": 60_000});
    let id = program.send("SetPTPCmd", at.clone()).await;
    tokio::time::sleep(std::time::Duration::from_millis(300)).await;
    teacher.ok("lease.take", json!({})).await;
    assert_eq!(program.answer(id).await.unwrap_err().0, 161);
    assert_eq!(program.code("SetPTPCmd", at).await, 101);
}

#[tokio::test(start_paused = true)]
async fn program_keeps_its_lease_while_connected() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let mut anna = bench.join("Anna").await;
    tokio::time::sleep(std::time::Duration::from_secs(60)).await;
    assert_eq!(anna.code("lease.acquire", json!({})).await, -32002);
    program.ok("DisconnectDobot", json!({})).await;
    anna.lease().await;
    assert_eq!(program.code("GetPose", json!({})).await, 103);
}

async fn refused(program: &mut Program, api: &str, params: Value) -> String {
    let (code, why) = program.call(api, params).await.unwrap_err();
    assert_eq!(code, -32604, "{api}: {why}");
    why
}

#[tokio::test(start_paused = true)]
async fn dangerous_or_burning_call_needs_its_flag() {
    let bench = LocalStation::real(1).await;
    let mut program = Program::connected(&bench).await;
    let laser = json!({"enable": true, "on": true});
    let why = refused(&mut program, "SetEndEffectorLaser", laser.clone()).await;
    assert!(why.contains("--link-laser"), "{why}");
    assert!(!bench.arms[0].state().laser);
    let sn = json!({"deviceSN": "1"});
    let why = refused(&mut program, "SetDeviceSN", sn.clone()).await;
    assert!(why.contains("--link-dangerous"), "{why}");
    assert_eq!(program.code("SetDeviceRestart", json!({})).await, -32605);
    // Switching off is always permitted.
    program
        .ok("SetEndEffectorLaser", json!({"enable": true, "on": false}))
        .await;
    drop(program);
    // Each flag permits its own kind alone.
    let mut options = LinkOptions::default();
    options.laser = true;
    let mut program = Program::with(&bench, options);
    program.ok("ConnectDobot", json!({})).await;
    refused(&mut program, "SetDeviceSN", sn.clone()).await;
    program.ok("SetEndEffectorLaser", laser.clone()).await;
    program
        .ok("SetEndEffectorLaser", json!({"enable": true, "on": false}))
        .await;
    drop(program);
    let mut options = LinkOptions::default();
    options.dangerous = true;
    let mut program = Program::with(&bench, options);
    program.ok("ConnectDobot", json!({})).await;
    program.ok("SetDeviceSN", sn).await;
    refused(&mut program, "SetEndEffectorLaser", laser).await;
}
