//! Real time around a robot's loop: wakes it when something arrives or is due, stops the robot when it cannot go on.

use crate::guard::Heart;
use crate::report::{Report, View};
use crate::robot_loop::RobotLoop;
use drover_contract::Clock;
use drover_core::StopReason;
use std::future::poll_fn;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;
use tokio::sync::watch;

/// A loop without a deadline would still be looked at this often; its node always has one that is nearer.
const IDLE_MAX: Duration = Duration::from_millis(200);

/// The wish that a robot ends, and why.
#[derive(Clone, Debug)]
pub struct Shutdown(pub StopReason);

/// Is told how a robot is doing.
pub struct Teller<F> {
    /// How often, by the robot's clock.
    pub period: Duration,
    /// Told a view; must not block.
    pub tell: F,
}

/// Drive one robot until it is told to end and has ended, or until its loop panics.
///
/// A panic is caught: the guard then sends the robot's stop for
/// as long as the process lives, and the report says so.
pub async fn drive<C: Clock + Send + Sync + 'static>(
    mut robot: RobotLoop,
    clock: C,
    heart: Heart,
    mut end: watch::Receiver<Option<Shutdown>>,
    mut teller: Teller<impl FnMut(View) + Send>,
) -> Report {
    let mut next_view = clock.now();
    loop {
        let wanted = end.borrow_and_update().clone();
        let turned = catch_unwind(AssertUnwindSafe(|| {
            if let Some(Shutdown(reason)) = wanted {
                robot.begin_end(clock.now(), reason);
            }
            robot.turn(&clock);
        }));
        if let Err(panic) = turned {
            heart.panicked();
            return Report::of_panic(&robot, panic.as_ref());
        }
        heart.beat();
        let now = clock.now();
        if now >= next_view || robot.ended() {
            next_view = now + teller.period;
            (teller.tell)(View::of(&robot, now));
        }
        if robot.ended() {
            heart.rest();
            return Report::of(&robot, heart.stops_sent());
        }
        let sleep = clock.wall(robot.poll_timeout().0.since(now)).min(IDLE_MAX);
        tokio::select! {
            () = poll_fn(|cx| robot.poll_readable(cx)) => {}
            () = tokio::time::sleep(sleep) => {}
            changed = end.changed() => {
                if changed.is_err() {
                    // Whoever could tell us to end is gone: that ends us, too.
                    robot.begin_end(clock.now(), StopReason::Shutdown);
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
            }
        }
    }
}
