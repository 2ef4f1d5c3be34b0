//! One robot's law: its stage, what draws it, and the move that it wishes for.

use super::Params;
use super::detour::Detour;
use super::forces::Force;
use super::predict::total;
use crate::avoid::{Capsule, SafeSet, Steering};
use drover_contract::Vec2;
use drover_contract::math::{cos, sin};

/// What a robot sees when it decides; world frame, metres.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Where it is.
    pub at_w: Vec2,
    /// The robots that it hears or sees.
    pub peers_w: &'a [Vec2],
    /// Of these, the ones whose links attract in stage 1.
    pub linked_w: &'a [Vec2],
    /// Its parent in the tree of kept links.
    pub parent_w: Option<Vec2>,
    /// Where the way to the parent begins: the parent itself if it is in sight.
    pub parent_aim_w: Option<Vec2>,
    /// Walls nearby.
    pub walls: &'a [Capsule],
    /// Where to head for on the way to the layout's centre, and to its own target: the places themselves, or the first
    /// corners of the ways there.
    pub goal_aim_w: Vec2,
    /// See there.
    pub target_aim_w: Vec2,
    /// Its part of the network is led somewhere else first: whatever its stage, it follows its parent.
    pub towed: bool,
    /// Every second counts: it leads its part to where somebody was lost.
    pub hurry: bool,
    /// Since it last decided, seconds.
    pub dt_s: f64,
}

/// One robot's law and what it remembers.
#[derive(Clone, Debug)]
pub struct Pilot {
    target_w: Vec2,
    /// It has been within the surroundings of the layout: from then on it goes to its own target.
    close: bool,
    steering: Steering,
    detour: Detour,
}

impl Pilot {
    /// A robot that is to go to `target_w` and has not moved yet.
    #[must_use]
    pub fn new(target_w: Vec2) -> Self {
        Self { target_w, close: false, steering: Steering::default(), detour: Detour::default() }
    }

    /// Its target.
    #[must_use]
    pub fn target_w(&self) -> Vec2 {
        self.target_w
    }

    /// It takes over another target.
    pub fn retarget(&mut self, target_w: Vec2) {
        self.target_w = target_w;
    }

    /// Whether it is in stage 2.
    #[must_use]
    pub fn is_close(&self) -> bool {
        self.close
    }

    /// Whether a place counts as its target.
    #[must_use]
    pub fn has_arrived(&self, params: &Params, at_w: Vec2) -> bool {
        (at_w - self.target_w).norm() <= params.arrive_m
    }

    /// The displacement of the next period that the law wishes for, metres, world frame.
    pub fn wish(&mut self, params: &Params, sight: &Sight<'_>) -> Vec2 {
        self.close |= params.in_box(sight.at_w);
        let attraction =
            if self.close && !sight.towed { self.to_target(params, sight) } else { to_layout(params, sight) };
        let gains = &params.gains;
        let near = |at_w: &Vec2| (at_w - sight.at_w).norm() < gains.avoid_m;
        // Bodies are as near as their rims.
        let nearer = |at_w: Vec2, by_m: f64| {
            let to = at_w - sight.at_w;
            at_w - to * (by_m / to.norm().max(by_m + 1e-3))
        };
        // Within a solid nothing is defined: its faces repel from outside only.
        let walls_w = sight.walls.iter().filter(|wall| wall.faces(sight.at_w)).map(|wall| wall.border_w(sight.at_w));
        let walls_w = walls_w.map(|wall_w| nearer(wall_w, params.body_m));
        let robots_w = sight.peers_w.iter().map(|peer_w| nearer(*peer_w, 2.0 * params.body_m));
        let entities_w: Vec<Vec2> = robots_w.chain(walls_w).filter(near).collect();
        let heading = self.steering.last_rad().map(|rad| Vec2::new(cos(rad), sin(rad)));
        let force = total(params, sight.at_w, attraction, &entities_w, heading);
        let wish = force.step(params.period_s, params.safe.step_m_max);
        let led = params.follow && self.is_led(params, sight);
        if !params.detours || led || self.has_arrived(params, sight.at_w) {
            self.detour.rest();
            return wish;
        }
        self.detour.set_hurry(sight.hurry);
        self.detour.instead(sight.at_w, wish, sight.walls, (params.safe.step_m_max, sight.dt_s))
    }

    /// Whether it follows its parent now.
    fn is_led(&self, params: &Params, sight: &Sight<'_>) -> bool {
        let far = |parent_w: Vec2| (parent_w - sight.at_w).norm() > params.gains.calm_m;
        (!self.close || sight.towed) && sight.parent_w.is_some_and(far)
    }

    /// The end of the move for `wish`, within `set` or, without one, wherever the law leads.
    pub fn steer(&mut self, params: &Params, at_w: Vec2, wish: Vec2, set: Option<&SafeSet>) -> Vec2 {
        let free = SafeSet::new(params.safe, at_w);
        self.steering.choose(set.unwrap_or(&free), wish, params.steer)
    }

    /// Stage 2: to the own target, and to one peer, the one nearest to it; to all peers where links are not optimised.
    fn to_target(&self, params: &Params, sight: &Sight<'_>) -> Force {
        if params.all_links {
            let links = sight.peers_w.iter().map(|peer_w| params.gains.link(sight.at_w, *peer_w));
            return params.gains.goal(sight.at_w, sight.target_aim_w) + links.sum();
        }
        let gap_m2 = |peer_w: &&Vec2| (**peer_w - self.target_w).norm_squared();
        let nearest_w = sight.peers_w.iter().min_by(|a, b| gap_m2(a).total_cmp(&gap_m2(b)));
        let link = nearest_w.map_or(Force::NONE, |peer_w| params.gains.link(sight.at_w, *peer_w));
        params.gains.goal(sight.at_w, sight.target_aim_w) + link
    }
}

/// Stage 1: to the layout and to the linked peers; with `follow`, to the parent alone while it is far, else to the
/// layout alone.
fn to_layout(params: &Params, sight: &Sight<'_>) -> Force {
    let gains = &params.gains;
    let aim_w = sight.goal_aim_w + (sight.target_aim_w - sight.goal_aim_w) * params.spread;
    let goal = gains.goal(sight.at_w, aim_w);
    if !params.follow {
        return goal + sight.linked_w.iter().map(|peer_w| gains.link(sight.at_w, *peer_w)).sum();
    }
    match sight.parent_w {
        Some(parent_w) if (parent_w - sight.at_w).norm() > gains.calm_m => {
            gains.link_via(sight.at_w, parent_w, sight.parent_aim_w.unwrap_or(parent_w))
        }
        Some(_) | None => goal,
    }
}
