//! A simulated day: twenty sessions that connect, act and leave in every way. Nothing of them may
//! remain.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};
use tokio::time::sleep;

use crate::bench::{LocalStation, Tester};

const CLIENTS: usize = 20;
/// Silence between two rounds.
const ROUND: Duration = Duration::from_secs(600);
const ROUNDS: u32 = 24 * 6;

/// Random numbers with a fixed seed.
struct Random(u64);

impl Random {
    fn below(&mut self, sides: u64) -> u64 {
        // xorshift64.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % sides
    }
}

/// Seat of the class, occupied or empty.
#[derive(Default)]
struct Seat {
    tester: Option<Tester>,
    resume: Value,
    jog: u64,
}

impl Seat {
    /// A client connects, resuming or anew.
    fn come(&mut self, bench: &LocalStation, dice: &mut Random) {
        let role = [Role::Viewer, Role::Student, Role::Teacher][dice.below(3) as usize];
        let mut tester = bench.socket(Some(role));
        let mut hello = json!({"client": {"name": "Anna"}});
        if self.resume.is_string() {
            hello["resume"] = self.resume.clone();
        }
        tester.send("session.hello", hello);
        self.tester = Some(tester);
    }

    /// The client does something without waiting for the answer.
    fn act(&mut self, dice: &mut Random) {
        let Some(tester) = &mut self.tester else {
            return;
        };
        let arm = json!(["arm1", "arm2"][dice.below(2) as usize]);
        let to = [180 + dice.below(60), 0, 20 + dice.below(60), 0];
        let (method, params) = match dice.below(16) {
            0 | 1 => ("lease.acquire", json!({"arm": arm})),
            2 => (
                "lease.acquire",
                json!({"arm": arm, "wait_s": dice.below(300)}),
            ),
            3 => ("lease.ask", json!({"arm": arm})),
            4 => ("lease.take", json!({"arm": arm})),
            5 | 6 => ("arm.move", json!({"arm": arm, "to": to})),
            7 => ("arm.move", json!({"arm": arm, "to": to, "wait": false})),
            8 | 9 => ("jog.start", json!({"arm": arm, "axis": "y+"})),
            10 => ("jog.keep", json!({"jog": format!("g0-{}", self.jog)})),
            11 => ("arm.stop", json!({})),
            12 => ("arm.state", json!({"arm": arm})),
            13 => ("arm.get", json!({"arm": arm, "command": "Pose"})),
            14 => ("arm.subscribe", json!({"arm": arm, "rate": 1})),
            _ => ("arm.unsubscribe", json!({"subscription": 1})),
        };
        tester.send(method, params);
    }

    /// Reads messages, and notes the secret and the last jog.
    fn read(&mut self) {
        let Some(tester) = &mut self.tester else {
            return;
        };
        while let Some(outgoing) = tester.client.try_receive() {
            let magician_station::Outgoing::Text(text) = outgoing else {
                self.tester = None;
                return;
            };
            let message: Value = serde_json::from_str(&text).unwrap();
            let result = &message["result"];
            if result["resume"].is_string() {
                self.resume = result["resume"].clone();
            }
            if let Some(jog) = result["jog"].as_str() {
                self.jog = jog.trim_start_matches("g0-").parse().unwrap();
            }
        }
    }
}

async fn live(rounds: u32) {
    let bench = LocalStation::new(2).await;
    let mut dice = Random(0x9E37_79B9_7F4A_7C15);
    let mut seats: Vec<_> = (0..CLIENTS).map(|_| Seat::default()).collect();
    for round in 0..rounds {
        for step in 0..12 {
            for seat in &mut seats {
                match dice.below(8) {
                    0 if seat.tester.is_none() => seat.come(&bench, &mut dice),
                    1 if step > 8 => seat.tester = None,
                    _ => seat.act(&mut dice),
                }
                // A client that never reads is closed at some point.
                if dice.below(50) != 0 {
                    seat.read();
                }
            }
            sleep(Duration::from_millis(50 + dice.below(400))).await;
        }
        // Most leave; some stay and are silent.
        for seat in &mut seats {
            if dice.below(8) != 0 {
                seat.tester = None;
            }
        }
        sleep(ROUND).await;
        for seat in &mut seats {
            seat.read();
        }
        let (size, orders) = bench.station.size();
        let there = seats.iter().filter(|seat| seat.tester.is_some()).count();
        assert!(
            size.sockets == there && size.sessions <= there,
            "{round}: {size:?}"
        );
        assert!(size.subscriptions <= 16 * there, "{round}: {size:?}");
        assert!(size.jogs <= 256 && size.events <= 2000, "{round}: {size:?}");
        assert!(
            size.pending <= there,
            "only who waits is not answered: {size:?}"
        );
        assert!(size.unsent <= there * 256 * 1024, "{round}: {size:?}");
        // At most a reading.
        assert!(orders <= 4, "{round}: {orders} orders under way");
        bench.lines.lock().unwrap().clear();
    }
    seats.clear();
    sleep(Duration::from_secs(30)).await;
    let (size, orders) = bench.station.size();
    let left = (
        size.sockets,
        size.sessions,
        size.pending,
        size.subscriptions,
    );
    assert_eq!(
        (left, size.unsent, orders),
        ((0, 0, 0, 0), 0, 0),
        "{size:?}"
    );
    for arm in &bench.arms {
        assert_eq!((arm.state().queue.waiting, arm.state().moving), (0, false));
    }
}

#[tokio::test(start_paused = true)]
async fn state_is_empty_after_a_day_of_sessions() {
    live(ROUNDS).await;
}
