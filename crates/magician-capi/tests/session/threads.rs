//! Calls from many threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::scope;

use crate::bench::{connect_v1, connect_v2, home, pose, pose_of, registry};

#[test]
fn calls_of_many_threads_succeed_while_others_connect() {
    let registry = registry();
    assert_eq!(connect_v2(&registry, "sim").id, 0);
    let done = AtomicBool::new(false);
    scope(|scope| {
        let callers: Vec<_> = (0..8)
            .map(|_| {
                scope.spawn(|| {
                    let mut calls = 0;
                    while calls < 25 || !done.load(Ordering::Relaxed) {
                        let (code, bytes) = pose_of(&registry, 0);
                        assert_eq!(code, 0);
                        let first: [u8; 4] = bytes[..4].try_into().unwrap();
                        assert!(f32::from_le_bytes(first).is_finite());
                        calls += 1;
                    }
                })
            })
            .collect();
        for _ in 0..10 {
            let connection = connect_v2(&registry, "sim");
            assert_eq!((connection.code, connection.id), (0, 1));
            assert_eq!(pose_of(&registry, 1).0, 0);
            assert_eq!(registry.disconnect(1), 0);
        }
        done.store(true, Ordering::Relaxed);
        callers
            .into_iter()
            .for_each(|caller| caller.join().unwrap());
    });
}

#[test]
fn calls_of_many_threads_succeed_after_reconnecting() {
    let registry = registry();
    let done = AtomicBool::new(false);
    scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    // 2: no arm is connected. 0: the connection ended during the call.
                    assert!([0, 2].contains(&pose(&registry).0));
                }
            });
        }
        for _ in 0..10 {
            assert_eq!(connect_v1(&registry, "sim").code, 0);
            assert_eq!(registry.disconnect(0), 0);
        }
        done.store(true, Ordering::Relaxed);
    });
    assert_eq!(connect_v1(&registry, "sim").code, 0);
    assert_eq!(pose(&registry).0, 0);
}

#[test]
fn connecting_at_the_same_time_leaves_one_connection() {
    let registry = registry();
    scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| assert_eq!(connect_v1(&registry, "sim").code, 0));
        }
    });
    assert_eq!(home(&registry), (0, 2), "it was one arm all the time");
}

#[test]
fn indices_of_many_threads_are_unique() {
    let registry = registry();
    connect_v1(&registry, "sim");
    let mut indices: Vec<u64> = scope(|scope| {
        let callers: Vec<_> = (0..8)
            .map(|_| scope.spawn(|| [(); 4].map(|()| home(&registry))))
            .collect();
        let results = callers
            .into_iter()
            .flat_map(|caller| caller.join().unwrap());
        results
            .map(|(code, index)| {
                assert_eq!(code, 0);
                index
            })
            .collect()
    });
    indices.sort_unstable();
    assert_eq!(indices, (2..=33).collect::<Vec<_>>());
}
