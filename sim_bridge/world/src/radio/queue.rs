//! What is on its way: each message once, and one small delivery for each receiver, in order of arrival.
//!
//! A calendar queue (Brown 1988): deliveries wait in a ring of lists, one list a tick of 1024 us, and a list is put in
//! order when its tick comes. Lists are chains of blocks out of one pool, so memory is what is on its way and little
//! more, a delivery costs no allocation, and handing in and out is O(1) and goes along memory.
//!
//! The order of arrival is (moment, order of handing in). A list keeps the order of handing in, so a stable sort by the
//! moment within the tick is all that its opening needs.

/// A tick is 2^TICK_BITS us long.
const TICK_BITS: u32 = 10;
const TICK_US: usize = 1 << TICK_BITS;
/// The farthest that a delivery can lie ahead of the open tick, in ticks: 67 s.
const AHEAD_MAX: u64 = 1 << 16;
/// Deliveries of one block, 384 bytes.
const BLOCK: usize = 32;
/// No block: the end of a chain.
const END: u32 = u32::MAX;
/// Longer lists are sorted by counting, shorter ones by comparing.
const COUNTING_FROM: usize = 128;

/// A message for one receiver, in the list of its tick: 12 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Due {
    /// Since the beginning of its tick, us.
    offset_us: u16,
    /// Index of the receiver.
    pub(super) to: u32,
    /// Which message, in [`Messages`].
    pub(super) slot: u32,
}

/// The deliveries of a tick that has not come yet: a chain of blocks, all but the last one full.
#[derive(Clone, Copy, Debug)]
struct List {
    first: u32,
    last: u32,
    count: u32,
}

const EMPTY: List = List { first: END, last: END, count: 0 };

/// Blocks, those in lists and unused ones.
#[derive(Clone, Debug)]
struct Pool {
    /// Block b stands at b * BLOCK.
    dues: Vec<Due>,
    /// By block: the next one of its chain.
    next: Vec<u32>,
    /// The first of the chain of unused blocks.
    unused: u32,
}

impl Pool {
    fn append(&mut self, list: &mut List, due: Due) {
        let place = list.count as usize % BLOCK;
        if place == 0 {
            let block = self.take();
            match self.next.get_mut(list.last as usize) {
                Some(next) => *next = block,
                None => list.first = block,
            }
            list.last = block;
        }
        self.dues[list.last as usize * BLOCK + place] = due;
        list.count += 1;
    }

    /// The deliveries of a list, block by block.
    fn blocks(&self, list: List) -> impl Iterator<Item = &[Due]> {
        let mut block = list.first;
        (0..list.count as usize).step_by(BLOCK).map(move |gone| {
            let begin = block as usize * BLOCK;
            block = self.next[block as usize];
            &self.dues[begin..begin + BLOCK.min(list.count as usize - gone)]
        })
    }

    /// Take back the blocks of a list.
    fn free(&mut self, list: List) {
        if let Some(next) = self.next.get_mut(list.last as usize) {
            *next = self.unused;
            self.unused = list.first;
        }
    }

    fn take(&mut self) -> u32 {
        let block = self.unused;
        if let Some(next) = self.next.get_mut(block as usize) {
            self.unused = std::mem::replace(next, END);
            return block;
        }
        self.dues.resize(self.dues.len() + BLOCK, Due::default());
        self.next.push(END);
        (self.next.len() - 1) as u32
    }
}

/// Deliveries in order of arrival.
#[derive(Clone, Debug)]
pub(super) struct Calendar {
    capacity: usize,
    pool: Pool,
    /// Tick t's list stands at t modulo the length, a power of two.
    lists: Vec<List>,
    /// Deliveries in lists.
    listed: usize,
    /// The tick that is being handed out. No list is of it or of an earlier one.
    open_tick: u64,
    /// Its deliveries; those before `taken` are gone.
    open: Vec<Due>,
    taken: usize,
    in_order: bool,
    /// Room to count in: by moment within a tick.
    counts: Vec<u32>,
}

impl Calendar {
    /// An empty calendar that will hold at most `capacity` deliveries.
    pub(super) fn new(capacity: usize) -> Self {
        Self {
            capacity,
            pool: Pool { dues: Vec::new(), next: Vec::new(), unused: END },
            lists: vec![EMPTY; 16],
            listed: 0,
            open_tick: 0,
            open: Vec::new(),
            taken: 0,
            in_order: true,
            counts: Vec::new(),
        }
    }

    /// It is `now_us`: nothing that is handed in from now on is due earlier. Keeps an idle calendar short.
    pub(super) fn begin(&mut self, now_us: u64) {
        if self.len() == 0 {
            self.open_tick = self.open_tick.max(now_us >> TICK_BITS);
        }
    }

    /// Hand in a delivery; whether there was room for it. One that is due before the open tick is due at its beginning.
    pub(super) fn push(&mut self, due_us: u64, to: u32, slot: u32) -> bool {
        let (tick, offset_us) = (due_us >> TICK_BITS, (due_us % TICK_US as u64) as u16);
        let ahead = tick.saturating_sub(self.open_tick);
        if self.len() >= self.capacity || ahead >= AHEAD_MAX {
            return false;
        }
        if ahead == 0 {
            if self.taken == self.open.len() {
                self.open.clear();
                self.taken = 0;
            }
            let offset_us = if tick < self.open_tick { 0 } else { offset_us };
            self.in_order &= self.open[self.taken..].last().is_none_or(|last| last.offset_us <= offset_us);
            self.open.push(Due { offset_us, to, slot });
            return true;
        }
        if ahead >= self.lists.len() as u64 {
            self.lengthen(ahead);
        }
        let place = self.place(tick);
        self.pool.append(&mut self.lists[place], Due { offset_us, to, slot });
        self.listed += 1;
        true
    }

    /// Take the next deliveries that are due by `now_us`, at most `max` of them; none if and only if none is due.
    pub(super) fn take(&mut self, now_us: u64, max: usize) -> &[Due] {
        while self.taken == self.open.len() && self.open_tick < now_us >> TICK_BITS {
            self.open_next(now_us >> TICK_BITS);
        }
        if !self.in_order {
            self.put_in_order();
        }
        let left = &self.open[self.taken..];
        let ripe = match now_us.checked_sub(self.open_tick << TICK_BITS) {
            Some(gone_us) if gone_us >= TICK_US as u64 => left.len(),
            Some(gone_us) => left.partition_point(|due| u64::from(due.offset_us) <= gone_us),
            None => 0,
        };
        let begin = self.taken;
        self.taken += ripe.min(max);
        &self.open[begin..self.taken]
    }

    /// When the next delivery is due, us.
    pub(super) fn next_due_us(&self) -> Option<u64> {
        let at = |tick: u64, offset_us: u16| (tick << TICK_BITS) + u64::from(offset_us);
        if let Some(first) = self.open[self.taken..].iter().map(|due| due.offset_us).min() {
            return Some(at(self.open_tick, first));
        }
        let mut ticks = self.open_tick..self.open_tick + self.lists.len() as u64;
        let tick = ticks.find(|tick| self.listed > 0 && self.lists[self.place(*tick)].count > 0)?;
        let dues = self.pool.blocks(self.lists[self.place(tick)]).flatten();
        dues.map(|due| due.offset_us).min().map(|first| at(tick, first))
    }

    /// Deliveries on their way.
    pub(super) fn len(&self) -> usize {
        self.listed + self.open.len() - self.taken
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        (self.pool.dues.capacity() + self.open.capacity()) * size_of::<Due>()
            + (self.pool.next.capacity() + self.counts.capacity()) * size_of::<u32>()
            + self.lists.capacity() * size_of::<List>()
    }

    fn place(&self, tick: u64) -> usize {
        tick as usize & (self.lists.len() - 1)
    }

    /// Room for a tick that is `ahead` of the open one.
    fn lengthen(&mut self, ahead: u64) {
        let length = (ahead as usize + 1).next_power_of_two();
        let mut longer = vec![EMPTY; length];
        for tick in self.open_tick + 1..self.open_tick + self.lists.len() as u64 {
            longer[tick as usize & (length - 1)] = self.lists[self.place(tick)];
        }
        self.lists = longer;
    }

    /// Open the first tick up to `last` that has deliveries, or `last`.
    fn open_next(&mut self, last: u64) {
        self.open.clear();
        self.taken = 0;
        if self.listed == 0 {
            self.open_tick = last;
            return;
        }
        while self.open_tick < last && self.open.is_empty() {
            self.open_tick += 1;
            let place = self.place(self.open_tick);
            let list = std::mem::replace(&mut self.lists[place], EMPTY);
            self.listed -= list.count as usize;
            self.open_list(list);
            self.pool.free(list);
        }
    }

    /// Copy a list to the open deliveries, in order.
    fn open_list(&mut self, list: List) {
        if (list.count as usize) < COUNTING_FROM {
            self.open.extend(self.pool.blocks(list).flatten());
            self.put_in_order();
            return;
        }
        // How many there are of each moment says where each moment begins.
        self.counts.clear();
        self.counts.resize(TICK_US, 0);
        for due in self.pool.blocks(list).flatten() {
            self.counts[usize::from(due.offset_us)] += 1;
        }
        let mut before = 0;
        for count in &mut self.counts {
            before += std::mem::replace(count, before);
        }
        self.open.resize(list.count as usize, Due::default());
        for due in self.pool.blocks(list).flatten() {
            let place = &mut self.counts[usize::from(due.offset_us)];
            self.open[*place as usize] = *due;
            *place += 1;
        }
    }

    /// Put what is left of the open tick in order of arrival: a stable sort by the moment.
    fn put_in_order(&mut self) {
        self.open.drain(..self.taken);
        self.taken = 0;
        self.in_order = true;
        self.open.sort_by_key(|due| due.offset_us);
    }
}

/// Messages with deliveries on their way. Each is held once, and freed with its last delivery.
#[derive(Clone, Debug)]
pub(super) struct Messages<M> {
    messages: Vec<Option<M>>,
    /// What is known of each; beside the messages and not in them, so that it stays near.
    labels: Vec<Label>,
    unused: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Label {
    from: u32,
    /// Deliveries on their way.
    left: u32,
}

impl<M> Messages<M> {
    /// None yet.
    pub(super) fn new() -> Self {
        Self { messages: Vec::new(), labels: Vec::new(), unused: Vec::new() }
    }

    /// Hold a message; where it is held.
    pub(super) fn put(&mut self, from: u32, message: M) -> u32 {
        let label = Label { from, left: 0 };
        if let Some(slot) = self.unused.pop() {
            self.messages[slot as usize] = Some(message);
            self.labels[slot as usize] = label;
            return slot;
        }
        self.messages.push(Some(message));
        self.labels.push(label);
        (self.labels.len() - 1) as u32
    }

    /// So many deliveries of it are on their way; without any it is freed at once.
    pub(super) fn expect(&mut self, slot: u32, left: u32) {
        self.labels[slot as usize].left = left;
        if left == 0 {
            self.free(slot);
        }
    }

    /// Show the message of a delivery that has arrived, with the index of its sender.
    pub(super) fn show(&mut self, slot: u32, see: impl FnOnce(usize, &M)) {
        let label = &mut self.labels[slot as usize];
        label.left = label.left.saturating_sub(1);
        let Label { from, left } = *label;
        if let Some(message) = &self.messages[slot as usize] {
            see(from as usize, message);
        }
        if left == 0 {
            self.free(slot);
        }
    }

    /// Heap bytes held, without what the messages themselves point to.
    pub(super) fn bytes(&self) -> usize {
        self.messages.capacity() * size_of::<Option<M>>()
            + self.labels.capacity() * size_of::<Label>()
            + self.unused.capacity() * size_of::<u32>()
    }

    fn free(&mut self, slot: u32) {
        self.messages[slot as usize] = None;
        self.unused.push(slot);
    }
}

#[cfg(test)]
#[path = "queue_tests.rs"]
mod tests;
