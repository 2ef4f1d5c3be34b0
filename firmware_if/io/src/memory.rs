//! Links without an operating system: for simulation in one process, and in virtual time.
//!
//! A queue that is full drops its oldest message and counts it: the newest state is worth more than a complete history.

use drover_contract::{BusHealth, CanBus, CanFrame, Link, LinkError};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

/// A bounded queue that wakes its reader.
struct Inbox<T> {
    waiting: VecDeque<T>,
    capacity: usize,
    dropped: u64,
    waker: Option<Waker>,
}

impl<T> Inbox<T> {
    fn new(capacity: usize) -> Self {
        Self { waiting: VecDeque::new(), capacity: capacity.max(1), dropped: 0, waker: None }
    }

    fn put(&mut self, message: T) {
        if self.waiting.len() >= self.capacity {
            self.waiting.pop_front();
            self.dropped += 1;
        }
        self.waiting.push_back(message);
        if let Some(waker) = self.waker.take() {
            waker.wake();
        }
    }

    fn poll(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        if self.waiting.is_empty() {
            self.waker = Some(cx.waker().clone());
            Poll::Pending
        } else {
            Poll::Ready(())
        }
    }
}

/// A lock whose holder panicked still holds good data: no method here leaves it half changed.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A CAN bus in memory. Clones are the same bus.
#[derive(Clone)]
pub struct MemoryBus {
    wire: Arc<Mutex<Wire>>,
}

struct Wire {
    capacity: usize,
    next_node: u64,
    nodes: Vec<(u64, Inbox<CanFrame>)>,
}

impl MemoryBus {
    /// A bus without nodes; each will keep at most `capacity` frames (at least one) that it has not read.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { wire: Arc::new(Mutex::new(Wire { capacity, next_node: 0, nodes: Vec::new() })) }
    }

    /// One more node. It hears what others send from now on, until it is dropped.
    #[must_use]
    pub fn node(&self) -> MemoryNode {
        add_node(&self.wire)
    }
}

fn add_node(shared: &Arc<Mutex<Wire>>) -> MemoryNode {
    let mut wire = lock(shared);
    let key = wire.next_node;
    wire.next_node += 1;
    let inbox = Inbox::new(wire.capacity);
    wire.nodes.push((key, inbox));
    MemoryNode { wire: Arc::clone(shared), key }
}

/// One node of a [`MemoryBus`]. It does not hear itself.
pub struct MemoryNode {
    wire: Arc<Mutex<Wire>>,
    key: u64,
}

impl MemoryNode {
    /// One more node of the same bus.
    #[must_use]
    pub fn sibling(&self) -> Self {
        add_node(&self.wire)
    }

    fn with_inbox<R>(&self, act: impl FnOnce(&mut Inbox<CanFrame>) -> R) -> Option<R> {
        let mut wire = lock(&self.wire);
        wire.nodes.iter_mut().find(|(key, _)| *key == self.key).map(|(_, inbox)| act(inbox))
    }
}

impl CanBus for MemoryNode {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        Ok(self.with_inbox(|inbox| inbox.waiting.pop_front()).flatten())
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        let mut wire = lock(&self.wire);
        for (_, inbox) in wire.nodes.iter_mut().filter(|(key, _)| *key != self.key) {
            inbox.put(*frame);
        }
        Ok(())
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.with_inbox(|inbox| inbox.poll(cx)).unwrap_or(Poll::Pending)
    }

    /// `dropped_full` counts the frames that this node was too slow to read.
    fn health(&self) -> BusHealth {
        let dropped_full = self.with_inbox(|inbox| inbox.dropped).unwrap_or_default();
        BusHealth { dropped_full, ..BusHealth::default() }
    }
}

impl Drop for MemoryNode {
    fn drop(&mut self) {
        lock(&self.wire).nodes.retain(|(key, _)| *key != self.key);
    }
}

/// Two ends of a datagram link in memory; each keeps at most `capacity` datagrams (at least one) that it has not read.
#[must_use]
pub fn memory_link(capacity: usize) -> (MemoryLink, MemoryLink) {
    let near = Arc::new(Mutex::new(Inbox::new(capacity)));
    let far = Arc::new(Mutex::new(Inbox::new(capacity)));
    (MemoryLink { inbox: Arc::clone(&near), other: Arc::clone(&far) }, MemoryLink { inbox: far, other: near })
}

/// One end of a datagram link in memory.
pub struct MemoryLink {
    inbox: Arc<Mutex<Inbox<Vec<u8>>>>,
    other: Arc<Mutex<Inbox<Vec<u8>>>>,
}

impl MemoryLink {
    /// Datagrams that this end was too slow to read.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        lock(&self.inbox).dropped
    }
}

impl Link for MemoryLink {
    /// As a socket does, a datagram longer than `buf` is cut.
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        let Some(datagram) = lock(&self.inbox).waiting.pop_front() else { return Ok(None) };
        let len = datagram.len().min(buf.len());
        buf[..len].copy_from_slice(&datagram[..len]);
        Ok(Some(len))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        // The two ends are the only holders of an inbox: one holder left means that the other end was dropped.
        if Arc::strong_count(&self.other) == 1 {
            return Err(LinkError::Down("nobody listens at the other end".into()));
        }
        lock(&self.other).put(bytes.to_vec());
        Ok(())
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        lock(&self.inbox).poll(cx)
    }
}

#[cfg(test)]
mod tests;
