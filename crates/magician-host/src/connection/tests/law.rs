//! Arms that break the index law, and arms that only seem to.

use std::collections::VecDeque;

use magician_protocol::commands::{
    QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, WaitCmd,
};
use magician_protocol::{FrameBuf, NoArgs, Readable, Writable};

use super::shared;
use crate::connection::{
    Connection, Event, Failure, IndexLaw, LawViolation, Micros, Request, Settings, Ticket,
};

/// Ways of breaking the law.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Habit {
    Lawful,
    StepsOfTwo,
    /// The reply carries the index of the command executed last.
    NumberedWhenExecuted,
    /// The current index is always 2^64 - 1.
    CurrentIsNothing,
    /// The current index is 0 while nothing is queued.
    CurrentStartsOver,
    CurrentStandsStill,
    LeftSpaceStandsStill,
    /// The running command occupies no place.
    RunningHoldsNoPlace,
}

/// An arm that answers at once, and executes a command on request.
struct Fake {
    habit: Habit,
    host: Connection,
    now: Micros,
    next: u64,
    done: u64,
    queue: VecDeque<u64>,
    accepted: u32,
    lose_replies: bool,
    sent: Vec<u8>,
    events: Vec<Event>,
}

impl Fake {
    fn new(habit: Habit, window: usize) -> Self {
        let settings = Settings {
            window,
            ..Settings::ORDERED
        };
        let mut fake = Self {
            habit,
            host: Connection::new(settings),
            now: 0,
            next: 1,
            done: 0,
            queue: VecDeque::new(),
            accepted: 0,
            lose_replies: false,
            sent: Vec::new(),
            events: Vec::new(),
        };
        fake.look();
        fake
    }

    fn look(&mut self) {
        for read in [
            Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap(),
            Request::get::<QueuedCmdLeftSpace>(&NoArgs).unwrap(),
            Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap(),
        ] {
            self.host.submit(read.deadline(self.now + 1_000_000));
            self.run(0);
        }
    }

    fn execute(&mut self) {
        if let Some(index) = self.queue.pop_front() {
            self.done = index;
        }
    }

    fn answer(&mut self, request: &FrameBuf) -> FrameBuf {
        let view = request.frame();
        let index = match view.id() {
            id if id == WaitCmd::ROW.id => {
                let index = self.next;
                self.next += if self.habit == Habit::StepsOfTwo {
                    2
                } else {
                    1
                };
                self.accepted += 1;
                self.queue.push_back(index);
                match self.habit {
                    Habit::NumberedWhenExecuted => self.done + 1,
                    _ => index,
                }
            }
            id if id == QueuedCmdCurrentIndex::ROW.id => match self.habit {
                Habit::CurrentIsNothing => u64::MAX,
                Habit::CurrentStandsStill => 0,
                Habit::CurrentStartsOver if self.queue.is_empty() => 0,
                _ => self.done,
            },
            id if id == QueuedCmdLeftSpace::ROW.id => {
                let waits = match self.habit {
                    Habit::LeftSpaceStandsStill => 0,
                    Habit::RunningHoldsNoPlace => self.queue.len().saturating_sub(1),
                    _ => self.queue.len(),
                };
                let left = 32 - waits as u32;
                return FrameBuf::new(view.id(), view.ctrl(), &left.to_le_bytes()).unwrap();
            }
            id if id == QueuedCmdClear::ROW.id => {
                self.queue.clear();
                0
            }
            id => panic!("request {id}"),
        };
        FrameBuf::new(view.id(), view.ctrl(), &index.to_le_bytes()).unwrap()
    }

    /// Advances time and exchanges all pending frames.
    fn run(&mut self, time: Micros) {
        let end = self.now + time;
        loop {
            let mut frames = Vec::new();
            while let Some(frame) = self.host.poll_transmit(self.now) {
                frames.push(frame);
            }
            for frame in &frames {
                self.sent.push(frame.frame().id());
                let reply = self.answer(frame);
                if !self.lose_replies {
                    self.host.receive(self.now, reply.bytes());
                }
            }
            while let Some(event) = self.host.poll_event() {
                self.events.push(event);
            }
            if !frames.is_empty() {
                continue;
            }
            match self.host.poll_timeout().filter(|at| *at <= end) {
                Some(at) => {
                    self.now = self.now.max(at);
                    self.host.handle_timeout(self.now);
                }
                None => break,
            }
        }
        self.now = end;
    }

    fn submit(&mut self) -> Ticket {
        let deadline = self.now + 10_000_000;
        self.host.submit(shared(1).deadline(deadline))
    }

    fn command(&mut self) -> Result<FrameBuf, Failure> {
        let ticket = self.submit();
        self.run(0);
        self.fate(ticket).expect("an answer")
    }

    fn fate(&self, wanted: Ticket) -> Option<Result<FrameBuf, Failure>> {
        self.events.iter().find_map(|event| match event {
            Event::Done { ticket, result } if *ticket == wanted => Some(*result),
            _ => None,
        })
    }

    /// Sends commands and readings like a program that keeps a few commands queued. Returns the
    /// number of commands until the law was broken.
    fn learn(&mut self) -> Option<u32> {
        for round in 0..40 {
            let _ = self.command();
            if matches!(self.host.law(), IndexLaw::Broken(_)) {
                return Some(round + 1);
            }
            if round % 4 >= 2 {
                self.execute();
            }
            if round % 4 == 3 {
                while !self.queue.is_empty() {
                    self.execute();
                }
            }
            self.look();
        }
        None
    }
}

const LAWLESS: [Habit; 7] = [
    Habit::StepsOfTwo,
    Habit::NumberedWhenExecuted,
    Habit::CurrentIsNothing,
    Habit::CurrentStartsOver,
    Habit::CurrentStandsStill,
    Habit::LeftSpaceStandsStill,
    Habit::RunningHoldsNoPlace,
];

#[test]
fn an_arm_with_a_habit_of_its_own_is_recognised_and_nothing_is_concluded() {
    for habit in LAWLESS {
        for window in [1, 4] {
            let mut fake = Fake::new(habit, window);
            let after = fake.learn();
            assert!(
                after.is_some_and(|after| after <= 12),
                "{habit:?}: {after:?}"
            );
            assert!(fake.sent.iter().all(|id| [84, 110, 246, 247].contains(id)));
            let IndexLaw::Broken(breach) = fake.host.law() else {
                panic!("{habit:?}");
            };
            assert!(breach.to_string().starts_with("the arm"), "{breach}");
            // Answered commands were taken. Unanswered ones are uncertain at once, without
            // readings.
            fake.execute();
            fake.command().unwrap();
            assert_eq!(fake.host.confirmed_index(), None);
            let before = (fake.accepted, fake.sent.len());
            fake.lose_replies = true;
            let tickets = [fake.submit(), fake.submit()];
            fake.run(fake.host.answer_timeout() + 1);
            let nowhere = Failure::Uncertain {
                from: None,
                to: None,
            };
            assert_eq!(fake.fate(tickets[0]), Some(Err(nowhere)), "{habit:?}");
            assert_eq!(fake.accepted, before.0 + 1, "{habit:?}: one at a time");
            assert_eq!(fake.sent[before.1], WaitCmd::ROW.id);
        }
    }
}

#[test]
fn each_habit_has_its_reason() {
    let breach = |habit| {
        let mut fake = Fake::new(habit, 1);
        fake.learn();
        match fake.host.law() {
            IndexLaw::Broken(breach) => breach,
            other => panic!("{habit:?}: {other:?}"),
        }
    };
    use LawViolation::{Back, Current, LeftSpace, Step};
    assert!(matches!(
        breach(Habit::StepsOfTwo),
        Step {
            before: 5,
            after: 7
        }
    ));
    let late = breach(Habit::NumberedWhenExecuted);
    assert!(matches!(late, Step { .. } | LeftSpace { .. }), "{late:?}");
    let nothing = breach(Habit::CurrentIsNothing);
    assert!(matches!(
        nothing,
        Current {
            current: u64::MAX,
            index: 2
        }
    ));
    let over = breach(Habit::CurrentStartsOver);
    assert!(matches!(over, Back { .. }), "{over:?}");
    assert!(matches!(
        breach(Habit::CurrentStandsStill),
        LeftSpace { .. }
    ));
    assert!(matches!(
        breach(Habit::LeftSpaceStandsStill),
        LeftSpace { .. }
    ));
    assert!(matches!(
        breach(Habit::RunningHoldsNoPlace),
        LeftSpace { .. }
    ));
}

#[test]
fn a_lawful_arm_is_believed_after_a_few_commands() {
    let mut fake = Fake::new(Habit::Lawful, 1);
    for index in 1..=4 {
        assert_eq!(fake.host.law(), IndexLaw::Unknown, "{index}");
        fake.command().unwrap();
    }
    assert_eq!(fake.host.law(), IndexLaw::Followed);
    assert_eq!(fake.learn(), None);
}

#[test]
fn another_host_does_not_break_the_law() {
    let mut fake = Fake::new(Habit::Lawful, 1);
    for round in 0..60 {
        let _ = fake.command();
        match round % 12 {
            // Another host queues some commands, runs them, and clears.
            3 => {
                for _ in 0..3 {
                    fake.queue.push_back(fake.next);
                    fake.next += 1;
                }
                fake.look();
            }
            6 => {
                fake.queue.clear();
                fake.look();
            }
            at if at > 7 => fake.execute(),
            _ => {}
        }
        fake.look();
        assert!(
            !matches!(fake.host.law(), IndexLaw::Broken(_)),
            "{round}: {:?}",
            fake.host.law()
        );
    }
    let resets = fake.events.iter().filter(|event| **event == Event::Reset);
    assert_eq!(resets.count(), 0);
}

#[test]
fn a_reset_does_not_break_the_law() {
    let mut fake = Fake::new(Habit::Lawful, 1);
    for round in 0..60 {
        let _ = fake.command();
        fake.execute();
        if round % 7 > 2 {
            fake.look();
        }
        if round % 7 == 6 {
            (fake.next, fake.done) = (1, 0);
            fake.queue.clear();
        }
        assert!(
            !matches!(fake.host.law(), IndexLaw::Broken(_)),
            "{round}: {:?}",
            fake.host.law()
        );
    }
    let resets = fake.events.iter().filter(|event| **event == Event::Reset);
    assert!(resets.count() > 5);
}
