// The robots as they are shown: a little behind the newest moment, so that there is always one to move towards.

const DELAY_MS = 60;
const DELAY_MS_MAX = 300;
const HISTORY_MAX = 40;
const TRAIL_S = 60;
const TRAIL_STEP_M = 0.1;
const TRAIL_POINTS_MAX = 600;
/** A jump in time over this many seconds (times the rate) is somebody seeking, not a moment that was lost. */
const JUMP_S = 3;
/** Each robot's scans go into the explored area at most so often, s. */
const SWEEP_S = 0.3;

const between = (a, b, share) => a + (b - a) * share;

/** The place between two, turning the short way round. */
function betweenPlaces(a, b, share) {
  if (!a || !b) return b ?? a;
  const turn = Math.atan2(Math.sin(b.yaw_rad - a.yaw_rad), Math.cos(b.yaw_rad - a.yaw_rad));
  return {
    x_m: between(a.x_m, b.x_m, share),
    y_m: between(a.y_m, b.y_m, share),
    yaw_rad: a.yaw_rad + turn * share,
  };
}

/** Where a robot is, as well as anybody knows. */
export const placeOf = (robot) => robot.truth ?? robot.believed;

export class Swarm {
  constructor(setting, explored) {
    this.setting = setting;
    this.explored = explored;
    this.bodies = setting.robots.map((robot) => ({
      id: robot.id, setting: robot, now: null, at: null, believed: null,
      trail: [], scan: null, points: null, sweptAt: -1,
    }));
    this.byId = new Map(this.bodies.map((body) => [body.id, body]));
    this.history = [];
    this.links = [];
    this.movers = [];
    this.moment = null;
    this.interval = 50;
  }

  take(moment, arrivedAt) {
    const last = this.history.at(-1);
    if (last) this.goOn(last, moment, arrivedAt);
    this.moment = moment;
    this.history.push({ arrivedAt, moment, robots: new Map(moment.robots.map((robot) => [robot.id, robot])) });
    if (this.history.length > HISTORY_MAX) this.history.shift();
    for (const robot of moment.robots) {
      const body = this.byId.get(robot.id);
      if (body) this.update(body, robot, moment.time_s);
    }
    this.findLinks(moment);
  }

  goOn(last, moment, arrivedAt) {
    const passed = moment.time_s - last.moment.time_s;
    if (passed < -1e-3 || passed > JUMP_S * Math.max(1, moment.run.rate)) {
      this.history = [];
      for (const body of this.bodies) Object.assign(body, { trail: [], scan: null, points: null, sweptAt: -1 });
      if (passed < 0) this.explored.clear();
      return;
    }
    const waited = Math.min(arrivedAt - last.arrivedAt, 500);
    this.interval = between(this.interval, waited, 0.1);
  }

  update(body, robot, time) {
    // A scan that has not changed is not told again.
    if (!robot.scan && robot.scan_age_ms !== null) robot.scan = body.scan;
    body.now = robot;
    const place = placeOf(robot);
    if (place) this.extendTrail(body.trail, place, time);
    if (!robot.scan) {
      body.scan = null;
      body.points = null;
    } else if (robot.scan.time_s !== body.scan?.time_s) {
      body.scan = robot.scan;
      this.takeScan(body, robot);
    }
  }

  extendTrail(trail, place, time) {
    const last = trail.at(-1);
    if (!last || Math.hypot(place.x_m - last[0], place.y_m - last[1]) >= TRAIL_STEP_M) {
      trail.push([place.x_m, place.y_m, time]);
    }
    let old = 0;
    while (old < trail.length - 1 && trail[old][2] < time - TRAIL_S) old += 1;
    old = Math.max(old, trail.length - TRAIL_POINTS_MAX);
    if (old > 0) trail.splice(0, old);
  }

  /** The scan's points in the world, about where the robot was when it was taken. */
  takeScan(body, robot) {
    const place = this.placeAt(robot.id, robot.scan.time_s) ?? placeOf(robot);
    body.points = null;
    if (!place) return;
    const { scan } = robot;
    const [mx, my, myaw] = body.setting.lidar_mount;
    const [c, s] = [Math.cos(place.yaw_rad), Math.sin(place.yaw_rad)];
    const [x, y] = [place.x_m + c * mx - s * my, place.y_m + s * mx + c * my];
    const yaw = place.yaw_rad + myaw;
    const points = [];
    scan.ranges_m.forEach((range, beam) => {
      if (range === null || range < 0) return;
      const angle = yaw + scan.angle_first_rad + beam * scan.angle_step_rad;
      points.push(x + range * Math.cos(angle), y + range * Math.sin(angle));
    });
    body.points = Float32Array.from(points);
    if (scan.time_s - body.sweptAt >= SWEEP_S) {
      body.sweptAt = scan.time_s;
      this.explored.sweep(scan, x, y, yaw);
    }
  }

  /** Where a robot was at a time of the swarm's clock, if that is not long ago. */
  placeAt(id, time) {
    for (let index = this.history.length - 1; index > 0; index -= 1) {
      const [a, b] = [this.history[index - 1], this.history[index]];
      const [from, to] = [a.moment.time_s, b.moment.time_s];
      if (time > to) return null;
      if (time < from || to <= from) continue;
      const [ra, rb] = [a.robots.get(id), b.robots.get(id)];
      return ra && rb ? betweenPlaces(placeOf(ra), placeOf(rb), (time - from) / (to - from)) : null;
    }
    return null;
  }

  /** A pair is linked when either hears the other; kept when either relies on it; late when that is old. */
  findLinks(moment) {
    const pairs = new Map();
    for (const robot of moment.robots) {
      const body = this.byId.get(robot.id);
      if (!body) continue;
      for (const { id, kept, age_ms: ageMs } of robot.heard) {
        const peer = this.byId.get(id);
        if (!peer) continue;
        const key = Math.min(id, robot.id) * 4_294_967 + Math.max(id, robot.id);
        let pair = pairs.get(key);
        if (!pair) pairs.set(key, (pair = { a: body, b: peer, kept: false, late: false }));
        pair.kept ||= kept;
        pair.late ||= kept && ageMs > body.setting.peer_ms;
      }
    }
    this.links = [...pairs.values()];
  }

  /** Put every body and every mover where it is shown at `now`. */
  pose(now) {
    const delay = Math.min(DELAY_MS_MAX, Math.max(DELAY_MS, this.interval * 1.2));
    const shown = now - delay;
    let index = this.history.length - 1;
    while (index > 0 && this.history[index].arrivedAt > shown) index -= 1;
    const [a, b] = [this.history[index], this.history[index + 1]];
    if (!a) return;
    const share = b ? Math.max(0, Math.min(1, (shown - a.arrivedAt) / Math.max(b.arrivedAt - a.arrivedAt, 1))) : 0;
    for (const body of this.bodies) {
      const ra = a.robots.get(body.id);
      const rb = b?.robots.get(body.id) ?? ra;
      if (!ra) continue;
      body.at = betweenPlaces(placeOf(ra), placeOf(rb), share);
      body.believed = betweenPlaces(ra.believed, rb.believed, share);
    }
    // Old recordings do not tell where movers are.
    const from = a.moment.movers_m ?? [];
    const to = b?.moment.movers_m ?? from;
    this.movers = (this.setting.place.movers ?? []).slice(0, Math.min(from.length, to.length)).map(
      ({ radius_m: r }, at) => [between(from[at][0], to[at][0], share), between(from[at][1], to[at][1], share), r],
    );
  }

  /** [west, south, east, north] of the bodies; null while none is known. */
  bounds() {
    const known = this.bodies.filter((body) => body.at);
    if (!known.length) return null;
    const [xs, ys] = [known.map((body) => body.at.x_m), known.map((body) => body.at.y_m)];
    return [Math.min(...xs) - 3, Math.min(...ys) - 3, Math.max(...xs) + 3, Math.max(...ys) + 3];
  }
}
