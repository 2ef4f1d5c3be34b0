//! What the radio asks about the world.

use drover_contract::Vec2;

/// Where the robots are and what stands between them. Robots are named by their index in the swarm's list.
pub trait Scene {
    /// A robot's true position in the world, metres; `None` if it has none: it neither speaks nor hears.
    fn position_w(&self, robot: usize) -> Option<Vec2>;

    /// Visit every robot within `range_m` metres of `centre_w` at least once. More may be visited, and in any order:
    /// the radio checks the distance itself, and no result depends on the order.
    fn for_each_near(&self, centre_w: Vec2, range_m: f64, visit: &mut dyn FnMut(usize));

    /// How many walls the straight line from `a_w` to `b_w` crosses. Asked only where walls weaken the radio.
    fn walls_between(&self, a_w: Vec2, b_w: Vec2) -> u32;
}

/// Robots in an open field, by their positions; for small swarms, as every robot is visited every time.
impl Scene for [Vec2] {
    fn position_w(&self, robot: usize) -> Option<Vec2> {
        self.get(robot).copied()
    }

    fn for_each_near(&self, _centre_w: Vec2, _range_m: f64, visit: &mut dyn FnMut(usize)) {
        (0..self.len()).for_each(visit);
    }

    fn walls_between(&self, _a_w: Vec2, _b_w: Vec2) -> u32 {
        0
    }
}
