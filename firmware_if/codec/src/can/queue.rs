//! A queue that never grows: when it is full, the oldest entry goes.

use std::collections::VecDeque;

/// At most `capacity` entries, oldest first.
#[derive(Clone, Debug)]
pub(crate) struct Queue<T> {
    entries: VecDeque<T>,
    capacity: usize,
    dropped: u64,
}

impl<T> Queue<T> {
    /// An empty queue for `capacity` entries.
    pub(crate) fn new(capacity: usize) -> Self {
        Self { entries: VecDeque::with_capacity(capacity), capacity, dropped: 0 }
    }

    /// Add `entry`; if there is no room, drop the oldest one and count it.
    pub(crate) fn push(&mut self, entry: T) {
        if self.entries.len() >= self.capacity && self.entries.pop_front().is_some() {
            self.dropped += 1;
        }
        self.entries.push_back(entry);
    }

    /// Take the oldest entry.
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.entries.pop_front()
    }

    /// Keep only the entries that `keep` says yes to.
    pub(crate) fn retain(&mut self, keep: impl FnMut(&T) -> bool) {
        self.entries.retain(keep);
    }

    /// How many entries were dropped for want of room.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::Queue;

    #[test]
    fn a_full_queue_drops_its_oldest_entry_and_counts_it() {
        let mut queue = Queue::new(2);
        for entry in 0..4 {
            queue.push(entry);
        }
        assert_eq!(queue.dropped(), 2);
        assert_eq!([queue.pop(), queue.pop(), queue.pop()], [Some(2), Some(3), None]);
    }
}
