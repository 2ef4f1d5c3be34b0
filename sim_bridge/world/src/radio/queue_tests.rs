use super::*;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// What the calendar must be equal to: a sorted map by (moment, order of handing in).
#[derive(Default)]
struct Model {
    waiting: BTreeMap<(u64, u64), u32>,
    pushed: u64,
}

impl Model {
    fn push(&mut self, due_us: u64, to: u32) {
        self.waiting.insert((due_us, self.pushed), to);
        self.pushed += 1;
    }

    fn pop(&mut self, now_us: u64) -> Option<u32> {
        let first = self.waiting.first_entry().filter(|first| first.key().0 <= now_us)?;
        Some(first.remove())
    }
}

fn pop(calendar: &mut Calendar, now_us: u64) -> Option<Due> {
    calendar.take(now_us, 1).first().copied()
}

/// Time goes on by so many us, then so many deliveries with these delays are handed in, then at most so many taken.
type Round = (u64, Vec<u64>, usize);

fn rounds() -> impl Strategy<Value = Vec<Round>> {
    let delay = prop_oneof![4 => 0..3_000_u64, 2 => 0..300_000_u64, 1 => 0..20_000_000_u64];
    let span = prop_oneof![4 => 0..2_000_u64, 1 => 0..500_000_u64, 1 => 0..40_000_000_u64];
    prop::collection::vec((span, prop::collection::vec(delay, 0..300), 0..400_usize), 1..30)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn it_hands_out_like_a_sorted_map(rounds in rounds()) {
        let (mut calendar, mut model) = (Calendar::new(1_000_000), Model::default());
        let (mut now_us, mut name) = (0, 0);
        for (span_us, delays_us, take_max) in rounds {
            now_us += span_us;
            calendar.begin(now_us);
            for delay_us in delays_us {
                // Nobody may fall so far behind that there is no room ahead; that is a test of its own.
                if calendar.push(now_us + delay_us, name, 7) {
                    model.push(now_us + delay_us, name);
                }
                name += 1;
            }
            prop_assert_eq!(calendar.len(), model.waiting.len());
            let next_us = model.waiting.first_key_value().map(|((due_us, _), _)| *due_us);
            prop_assert_eq!(calendar.next_due_us(), next_us);
            for _ in 0..take_max {
                let taken = pop(&mut calendar, now_us);
                prop_assert_eq!(taken.map(|due| due.to), model.pop(now_us));
                if taken.is_none() {
                    break;
                }
            }
        }
        while let Some(due) = pop(&mut calendar, u64::MAX) {
            prop_assert_eq!(Some(due.to), model.pop(u64::MAX));
        }
        prop_assert!(model.waiting.is_empty() && calendar.len() == 0);
    }
}

#[test]
fn it_holds_no_more_than_asked_and_nothing_due_too_far_ahead() {
    let mut calendar = Calendar::new(3);
    assert!((0..3).all(|to| calendar.push(5_000, to, 0)));
    assert!(!calendar.push(1, 3, 0));
    assert_eq!(pop(&mut calendar, 5_000).map(|due| due.to), Some(0));
    assert!(!calendar.push(AHEAD_MAX << (TICK_BITS + 1), 3, 0));
    assert!(calendar.push(20_000_000, 3, 0), "20 s are not too far ahead");
    assert!(calendar.lists.len() as u64 <= AHEAD_MAX);
}

#[test]
fn an_idle_calendar_stays_short_and_a_busy_one_uses_its_memory_again() {
    let mut calendar = Calendar::new(1_000_000);
    let mut bytes = 0;
    for second in 0..100_u64 {
        let now_us = second * 1_000_000;
        calendar.begin(now_us);
        (0..1000).for_each(|to| assert!(calendar.push(now_us + 2_000 + u64::from(to) * 3, to, 0)));
        let taken = std::iter::from_fn(|| pop(&mut calendar, now_us + 10_000)).count();
        assert_eq!(taken, 1000);
        if second == 2 {
            bytes = calendar.bytes();
        }
    }
    assert_eq!(calendar.lists.len(), 16);
    assert_eq!(calendar.bytes(), bytes);
}

#[test]
fn a_message_is_freed_with_its_last_delivery() {
    let message = std::rc::Rc::new(());
    let holders = || std::rc::Rc::strong_count(&message) - 1;
    let mut messages = Messages::new();
    let slot = messages.put(4, message.clone());
    messages.expect(slot, 2);
    messages.show(slot, |from, _| assert_eq!(from, 4));
    assert_eq!(holders(), 1);
    messages.show(slot, |from, _| assert_eq!(from, 4));
    assert_eq!(holders(), 0);
    let unheard = messages.put(4, message.clone());
    assert_eq!(unheard, slot, "the place is used again");
    messages.expect(unheard, 0);
    assert_eq!(holders(), 0);
}
