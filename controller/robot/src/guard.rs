//! The second of the three independent stops: a thread of its own that stops a robot whose loop hangs or has panicked.
//!
//! The loop beats its [`Heart`] at every turn. When a heart has not beaten for longer than its limit, the guard sends
//! that robot's stop bytes over a duplicate of its socket, and again every [`PERIOD`] until the heart beats again. The
//! bytes are encoded beforehand and the socket is never waited for, so the guard needs nothing of the hung loop.
//!
//! A process that was frozen as a whole (SIGSTOP) has a hung heart when it wakes, and no hung loop: a guard that itself
//! comes late by more than the limit lets the loop have one period to beat again.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often the guard looks, and how often it repeats a stop.
const PERIOD: Duration = Duration::from_millis(20);

/// Sends one robot's stop, from any thread.
pub type StopAction = Box<dyn FnMut() + Send>;

struct Ward {
    robot: u32,
    heart: Arc<HeartState>,
    limit: Duration,
    stop: StopAction,
    /// The beat after which the guard itself came late: forgiven once.
    forgiven_us: Option<u64>,
}

#[derive(Default)]
struct HeartState {
    beaten_us: AtomicU64,
    panicked: AtomicBool,
    at_rest: AtomicBool,
    stops_sent: AtomicU64,
}

struct Shared {
    wards: Mutex<Vec<Ward>>,
    epoch: Instant,
    ended: AtomicBool,
}

/// The thread that watches all robots of a process.
pub struct Guard {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// A robot's sign of life.
pub struct Heart {
    state: Arc<HeartState>,
    epoch: Instant,
}

impl Guard {
    /// Start watching.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn start() -> std::io::Result<Self> {
        let shared = Arc::new(Shared { wards: Mutex::default(), epoch: Instant::now(), ended: AtomicBool::new(false) });
        let watched = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("guard".into()).spawn(move || watch(&watched))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Watch one more robot: `stop` is sent when its heart stands still for longer than `limit`.
    #[must_use]
    pub fn add(&self, robot: u32, limit: Duration, stop: StopAction) -> Heart {
        let state = Arc::new(HeartState::default());
        let heart = Heart { state: Arc::clone(&state), epoch: self.shared.epoch };
        heart.beat();
        lock(&self.shared.wards).push(Ward { robot, heart: state, limit, stop, forgiven_us: None });
        heart
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The guard's thread does not panic; if it did, there is nobody left to tell.
            let _ = thread.join();
        }
    }
}

impl Heart {
    /// The loop is alive.
    pub fn beat(&self) {
        self.state.beaten_us.store(micros(self.epoch), Ordering::Relaxed);
    }

    /// The loop has panicked: stop the robot now and for as long as the guard lives.
    pub fn panicked(&self) {
        self.state.panicked.store(true, Ordering::Relaxed);
    }

    /// The loop has ended in good order: nothing to watch any more.
    pub fn rest(&self) {
        self.state.at_rest.store(true, Ordering::Relaxed);
    }

    /// How often the guard had to send this robot's stop.
    #[must_use]
    pub fn stops_sent(&self) -> u64 {
        self.state.stops_sent.load(Ordering::Relaxed)
    }
}

impl Drop for Heart {
    /// A loop that is gone without a word (a task that was cancelled) is treated as one that panicked.
    fn drop(&mut self) {
        if !self.state.at_rest.load(Ordering::Relaxed) {
            self.panicked();
        }
    }
}

fn micros(epoch: Instant) -> u64 {
    u64::try_from(epoch.elapsed().as_micros()).unwrap_or(u64::MAX)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn watch(shared: &Shared) {
    let mut looked_us = micros(shared.epoch);
    while !shared.ended.load(Ordering::Relaxed) {
        let now_us = micros(shared.epoch);
        let late_us = now_us.saturating_sub(std::mem::replace(&mut looked_us, now_us));
        let mut wards = lock(&shared.wards);
        wards.retain(|ward| !ward.heart.at_rest.load(Ordering::Relaxed));
        wards.iter_mut().for_each(|ward| look_at(ward, now_us, late_us));
        drop(wards);
        std::thread::sleep(PERIOD);
    }
}

/// `late_us`: since the guard looked last.
fn look_at(ward: &mut Ward, now_us: u64, late_us: u64) {
    let beaten_us = ward.heart.beaten_us.load(Ordering::Relaxed);
    let silent_us = now_us.saturating_sub(beaten_us);
    let longer = |span_us: u64| u128::from(span_us) > ward.limit.as_micros();
    let frozen = longer(late_us) && ward.forgiven_us.replace(beaten_us) != Some(beaten_us);
    let hung = longer(silent_us) && !frozen;
    let panicked = ward.heart.panicked.load(Ordering::Relaxed);
    if !hung && !panicked {
        return;
    }
    if ward.heart.stops_sent.fetch_add(1, Ordering::Relaxed) == 0 {
        let why = if panicked { "panicked" } else { "hangs" };
        tracing::error!(robot = ward.robot, silent_ms = silent_us / 1_000, "the loop {why}: the guard stops the robot");
    }
    (ward.stop)();
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    fn counted(guard: &Guard, limit_ms: u64) -> (Heart, Arc<AtomicUsize>) {
        let count = Arc::new(AtomicUsize::new(0));
        let seen = Arc::clone(&count);
        let stop = Box::new(move || {
            seen.fetch_add(1, Ordering::Relaxed);
        });
        (guard.add(1, Duration::from_millis(limit_ms), stop), count)
    }

    #[test]
    fn a_beating_heart_is_left_alone_and_a_silent_one_is_stopped_again_and_again() {
        let guard = Guard::start().expect("a thread");
        let (heart, stops) = counted(&guard, 200);
        for _ in 0..20 {
            heart.beat();
            std::thread::sleep(Duration::from_millis(10));
        }
        assert_eq!(stops.load(Ordering::Relaxed), 0);
        std::thread::sleep(Duration::from_millis(600));
        assert!(stops.load(Ordering::Relaxed) >= 3);
        assert_eq!(heart.stops_sent() as usize, stops.load(Ordering::Relaxed));
    }

    #[test]
    fn a_guard_that_comes_late_itself_forgives_a_silent_heart_once() {
        let guard = Guard::start().expect("a thread");
        let (heart, stops) = counted(&guard, 60_000);
        // Looked at by hand, as after a second in which the whole process was frozen.
        let mut ward = lock(&guard.shared.wards).pop().expect("it was added");
        ward.limit = Duration::from_millis(250);
        let beaten_us = heart.state.beaten_us.load(Ordering::Relaxed);
        look_at(&mut ward, beaten_us + 1_000_000, 1_000_000);
        assert_eq!(stops.load(Ordering::Relaxed), 0);
        look_at(&mut ward, beaten_us + 1_020_000, 20_000);
        assert_eq!(stops.load(Ordering::Relaxed), 1, "it had its time to beat");
        look_at(&mut ward, beaten_us + 2_000_000, 980_000);
        assert_eq!(stops.load(Ordering::Relaxed), 2, "only once");
    }

    #[test]
    fn a_panicked_loop_is_stopped_at_once_and_one_at_rest_never() {
        let guard = Guard::start().expect("a thread");
        let (dropped, stops) = counted(&guard, 60_000);
        let (resting, none) = counted(&guard, 50);
        resting.rest();
        drop(dropped);
        std::thread::sleep(Duration::from_millis(300));
        assert!(stops.load(Ordering::Relaxed) >= 2);
        assert_eq!(none.load(Ordering::Relaxed), 0);
    }
}
