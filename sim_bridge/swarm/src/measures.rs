//! What a run is measured by while it goes on, in virtual and in real time alike.

use crate::deployment::Deployment;
use crate::flock::Flocking;
use crate::trial::{deploys, flocks};
use drover_config::Swarm;
use drover_core::Status;
use drover_robot::View;
use drover_world::Arena;

/// What a robot says of itself, as far as measuring depends on it: all else is seen from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Said {
    /// Whether its task is done.
    pub(crate) reached: bool,
    /// Whether it stands aside for others.
    pub(crate) gives_way: bool,
    /// How often it has begun to follow a wall.
    pub(crate) wall_entries: u64,
}

impl From<&Status> for Said {
    fn from(status: &Status) -> Self {
        let (gives_way, wall_entries) = (status.gives_way_to.is_some(), status.counters.wall_entries);
        Self { reached: status.reached, gives_way, wall_entries }
    }
}

impl From<&View> for Said {
    fn from(view: &View) -> Self {
        Self { reached: view.reached, gives_way: view.gives_way_to.is_some(), wall_entries: view.wall_entries }
    }
}

/// What its behaviour makes worth measuring; nothing of one that is measured otherwise.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measures {
    pub(crate) deployment: Option<Deployment>,
    pub(crate) flocking: Option<Flocking>,
}

impl Measures {
    /// Before the first step of `swarm`.
    pub(crate) fn new(swarm: &Swarm, arena: &Arena) -> Self {
        Self {
            deployment: deploys(swarm).map(|deploy| Deployment::new(swarm, deploy, arena)),
            flocking: flocks(swarm).map(|flock| Flocking::new(swarm, flock)),
        }
    }

    /// The bodies at `now_s`, `dt_s` after they were looked at before; `said` is what robots say, `None` for the dead.
    pub(crate) fn see(&mut self, arena: &Arena, said: impl Fn(usize) -> Option<Said>, (now_s, dt_s): (f64, f64)) {
        if let Some(deployment) = &mut self.deployment {
            deployment.see(arena, |robot| said(robot).is_some(), (now_s, dt_s));
        }
        if let Some(flocking) = &mut self.flocking {
            flocking.see(arena, said, now_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::Tally;
    use drover_contract::{Pose, RobotId, Stamp};
    use drover_robot::Report;
    use serde_json::{Value, from_value, to_value};

    /// A follower's words, as a node knows them.
    fn status() -> Status {
        let mut status = Status { reached: true, ..Status::first(Stamp::ZERO, Pose::default()) };
        status.gives_way_to = Some(RobotId(3));
        status.counters.wall_entries = 7;
        status
    }

    fn view() -> Value {
        to_value(View::of_status(2, &status(), Stamp::ZERO)).expect("text")
    }

    #[test]
    fn a_robots_words_are_the_same_from_its_node_and_through_its_processs_output() {
        let said = Said { reached: true, gives_way: true, wall_entries: 7 };
        assert_eq!(Said::from(&status()), said);
        assert_eq!(Said::from(&from_value::<View>(view()).expect("a view")), said);
        let mut old = view();
        let fields = old.as_object_mut().expect("an object");
        assert!(fields.remove("gives_way_to").is_some() && fields.remove("wall_entries").is_some());
        let old = Said::from(&from_value::<View>(old).expect("a view of an older process"));
        assert_eq!(old, Said { reached: true, ..Said::default() });
    }

    #[test]
    fn who_ends_without_a_report_or_with_a_panic_died() {
        let report = |panic: Option<&str>| Report {
            id: 2,
            reached: true,
            reason: "operator".into(),
            seen_stopped: true,
            guard_stops: 0,
            panic: panic.map(Into::into),
            map: None,
        };
        let view: View = from_value(view()).expect("a view");
        let of = |report| Tally { view: Some(view.clone()), report, ..Tally::default() }.last_said();
        assert_eq!(of(Some(report(None))).map(|said| said.wall_entries), Some(7));
        assert_eq!((of(Some(report(Some("a word")))), of(None)), (None, None));
        assert_eq!(Tally::default().said(), Said::default());
    }
}
