//! A swarm against a simulator, as it is seen from outside: what robots tell, beside where their bodies are.

use drover_contract::Stamp;
use drover_record::{Moment, RobotMoment, RunState, Truth};
use drover_robot::View;
use drover_world::Arena;

/// The swarm at `now`: every robot's id and what it told last, in the arena's order.
pub(crate) fn moment_of(
    now: Stamp,
    arena: &Arena,
    robots: impl Iterator<Item = (u32, Option<View>)>,
    run: RunState,
) -> Moment {
    let robots = robots.enumerate().map(|(robot, (id, view))| {
        let state = arena.state(robot);
        let truth = Some(Truth::new(state.pose_wb, state.twist_b, state.in_contact));
        view.map_or_else(|| RobotMoment::unheard(id, truth), |view| RobotMoment::of_view(&view, truth))
    });
    Moment {
        time_s: now.as_secs_f64(),
        run,
        robots: robots.collect(),
        movers_m: arena.movers().map(|(at_w, _)| [at_w.x, at_w.y]).collect(),
        min_gap_robot_m: arena.min_gap_robot_m(),
        min_gap_wall_m: arena.min_gap_wall_m(),
    }
}
