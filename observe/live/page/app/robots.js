// Draws what moves. Bodies and signs are drawn in CSS pixels: they must not get too small to be seen.

import { colours } from "./theme.js";
import { gridStep } from "./place.js";
import { STATES } from "./words.js";

const BODY_PX_MIN = 5;
/** A crowd of bodies smaller than this has no room for its numbers. */
const LABEL_PX_MIN = 4;
const SIGN_PX_MIN = 3.2;
/** A belief nearer to the truth than this is not drawn apart. */
const ASTRAY_M = 0.05;
/** With more robots than this, many lines are drawn plain and at once. */
export const MANY = 30;
const TRAIL_BANDS = 4;

const FULL = 2 * Math.PI;

export function drawTrails(context, camera, swarm) {
  const time = swarm.moment.time_s;
  context.strokeStyle = colours.trail;
  context.lineJoin = "round";
  context.lineWidth = (swarm.bodies.length > MANY ? 1.2 : 2) / camera.scale;
  for (let band = 0; band < TRAIL_BANDS; band += 1) {
    context.globalAlpha = 0.12 + (0.6 * (TRAIL_BANDS - 1 - band)) / TRAIL_BANDS;
    const [youngest, oldest] = [time - (band * 60) / TRAIL_BANDS, time - ((band + 1) * 60) / TRAIL_BANDS];
    context.beginPath();
    for (const { trail } of swarm.bodies) traceSpan(context, trail, oldest, youngest);
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** The part of a trail between two times, with the point before it so that parts join. */
function traceSpan(context, trail, from, to) {
  let started = false;
  for (let index = 1; index < trail.length; index += 1) {
    const [x, y, time] = trail[index];
    if (time < from || time >= to + 1e-6) continue;
    if (!started) context.moveTo(trail[index - 1][0], trail[index - 1][1]);
    started = true;
    context.lineTo(x, y);
  }
}

/** Number of links drawn. */
export function drawLinks(context, camera, swarm) {
  const many = swarm.bodies.length > MANY;
  const px = 1 / camera.scale;
  const known = swarm.links.filter(({ a, b }) => a.at && b.at);
  const stroke = (links, width, alpha, dash) => {
    if (!links.length) return;
    context.beginPath();
    for (const { a, b } of links) {
      context.moveTo(a.at.x_m, a.at.y_m);
      context.lineTo(b.at.x_m, b.at.y_m);
    }
    context.setLineDash(dash.map((length) => length * px));
    context.lineWidth = width * px;
    context.globalAlpha = alpha;
    context.stroke();
  };
  context.strokeStyle = colours.link;
  stroke(known.filter((link) => !link.kept), 1, many ? 0.13 : 0.4, many ? [] : [3, 5]);
  const thick = many ? 1.8 : 3;
  stroke(known.filter((link) => link.kept && !link.late), thick, many ? 0.6 : 0.8, []);
  stroke(known.filter((link) => link.late), thick, 0.9, [8, 6]);
  context.setLineDash([]);
  context.globalAlpha = 1;
  return known.length;
}

export function drawScans(context, camera, swarm) {
  context.fillStyle = colours.scan;
  const size = swarm.bodies.length > MANY ? 1.5 : 2.5;
  const { x, y, scale, width, height } = camera;
  for (const { points } of swarm.bodies) {
    for (let index = 0; points && index < points.length; index += 2) {
      const px = width / 2 + (points[index] - x) * scale;
      const py = height / 2 - (points[index + 1] - y) * scale;
      if (px > 0 && py > 0 && px < width && py < height) context.fillRect(px - size / 2, py - size / 2, size, size);
    }
  }
}

export function drawTargets(context, camera, swarm) {
  context.beginPath();
  for (const body of swarm.bodies) {
    const target = body.now?.target_w;
    if (!body.at || !target) continue;
    const [x, y] = camera.toScreen(target[0], target[1]);
    context.moveTo(...camera.toScreen(body.at.x_m, body.at.y_m));
    context.lineTo(x, y);
    context.moveTo(x - 4, y - 4);
    context.lineTo(x + 4, y + 4);
    context.moveTo(x - 4, y + 4);
    context.lineTo(x + 4, y - 4);
  }
  context.strokeStyle = colours.muted;
  context.lineWidth = swarm.bodies.length > MANY ? 0.7 : 1.2;
  context.stroke();
}

/** The body's outline about a place, as screen points; a disc has none. */
function outline(body, place, camera, grow) {
  const [c, s] = [Math.cos(place.yaw_rad) * grow, Math.sin(place.yaw_rad) * grow];
  const { x_m: east, y_m: north } = place;
  return body.setting.footprint_m.map(([x, y]) => camera.toScreen(east + c * x - s * y, north + s * x + c * y));
}

function traceBody(context, body, place, camera) {
  const radius = body.setting.radius_m * camera.scale;
  const grow = Math.max(1, BODY_PX_MIN / radius);
  const corners = outline(body, place, camera, grow);
  if (corners.length > 2) {
    corners.forEach((corner, index) => (index ? context.lineTo(...corner) : context.moveTo(...corner)));
    context.closePath();
    return;
  }
  const [x, y] = camera.toScreen(place.x_m, place.y_m);
  context.moveTo(x + radius * grow, y);
  context.arc(x, y, radius * grow, 0, FULL);
}

const radiusOf = (body, camera) => Math.max(body.setting.radius_m * camera.scale, BODY_PX_MIN);

/** Where robots believe to be when that is not where they are, and how sure they are of it. */
export function drawBeliefs(context, camera, swarm) {
  context.strokeStyle = colours.muted;
  context.lineWidth = 1.2;
  context.beginPath();
  const bounds = [];
  for (const body of swarm.bodies) {
    const { at, believed, now } = body;
    if (!at || !believed) continue;
    const apart = Math.hypot(at.x_m - believed.x_m, at.y_m - believed.y_m);
    if (now.truth && apart <= ASTRAY_M) continue;
    if (now.truth) {
      traceBody(context, body, believed, camera);
      context.moveTo(...camera.toScreen(at.x_m, at.y_m));
      context.lineTo(...camera.toScreen(believed.x_m, believed.y_m));
    }
    bounds.push([...camera.toScreen(believed.x_m, believed.y_m), now.pos_bound_m * camera.scale]);
  }
  context.setLineDash([4, 3]);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  for (const [x, y, r] of bounds) {
    context.moveTo(x + r, y);
    context.arc(x, y, r, 0, FULL);
  }
  context.globalAlpha = 0.6;
  context.stroke();
  context.globalAlpha = 1;
}

/** What stands in a body for its state: signs that differ in shape, `u` pixels from the middle to their edge. */
const SIGNS = {
  waiting: (context, x, y, u) => {
    for (const dx of [-u, 0, u]) context.rect(x + dx - u * 0.27, y - u * 0.27, u * 0.54, u * 0.54);
  },
  held: (context, x, y, u) => {
    context.rect(x - u * 0.8, y - u, u * 0.55, u * 2);
    context.rect(x + u * 0.25, y - u, u * 0.55, u * 2);
  },
  stopped: (context, x, y, u) => context.rect(x - u * 0.85, y - u * 0.85, u * 1.7, u * 1.7),
  done: (context, x, y, u) => polygon(context, x, y, u,
    [[-1, 0], [-0.3, 0.85], [1.05, -0.6], [0.65, -0.95], [-0.33, 0.2], [-0.62, -0.35]]),
  dead: (context, x, y, u) => {
    polygon(context, x, y, u, [[-1, -0.7], [-0.7, -1], [1, 0.7], [0.7, 1]]);
    polygon(context, x, y, u, [[0.7, -1], [1, -0.7], [-0.7, 1], [-1, 0.7]]);
  },
};

function polygon(context, x, y, u, corners) {
  corners.forEach(([dx, dy], index) => {
    if (index) context.lineTo(x + dx * u, y + dy * u);
    else context.moveTo(x + dx * u, y + dy * u);
  });
  context.closePath();
}

/** A body that drives is an arrowhead inside; one that does not has a sign inside and its heading at its edge. */
function traceSign(context, body, camera) {
  const [x, y] = camera.toScreen(body.at.x_m, body.at.y_m);
  const radius = radiusOf(body, camera);
  const u = Math.max(SIGN_PX_MIN, radius * 0.42);
  const [c, s] = [Math.cos(body.at.yaw_rad), -Math.sin(body.at.yaw_rad)];
  const turned = (fx, fy) => [x + c * fx - s * fy, y + s * fx + c * fy];
  const sign = SIGNS[body.now.state];
  const tip = sign ? [[1.5, 0], [0.95, 0.4], [0.95, -0.4]] : [[0.85, 0], [-0.5, 0.55], [-0.25, 0], [-0.5, -0.55]];
  tip.forEach(([fx, fy], index) => {
    const corner = turned(fx * radius, fy * radius);
    if (index) context.lineTo(...corner);
    else context.moveTo(...corner);
  });
  context.closePath();
  sign?.(context, x, y, u);
}

/** What moves and is no robot; in metres. */
export function drawMovers(context, camera, swarm) {
  context.beginPath();
  for (const [x, y, r] of swarm.movers) {
    context.moveTo(x + r, y);
    context.arc(x, y, r, 0, FULL);
  }
  context.fillStyle = colours.solid;
  context.fill();
  context.strokeStyle = colours.wall;
  context.lineWidth = 1.5 / camera.scale;
  context.stroke();
}

export function drawBodies(context, camera, swarm, selected) {
  const byState = new Map();
  for (const body of swarm.bodies) {
    if (!body.at || !body.now) continue;
    const { state } = body.now;
    if (!byState.has(state)) byState.set(state, []);
    byState.get(state).push(body);
  }
  for (const [state, bodies] of byState) {
    context.beginPath();
    for (const body of bodies) traceBody(context, body, body.at, camera);
    context.fillStyle = colours[STATES[state] ? state : "dead"];
    context.fill();
    context.strokeStyle = state === "dead" ? colours.text : colours.ink;
    context.lineWidth = 1.3;
    context.setLineDash(state === "dead" ? [3, 2] : []);
    context.stroke();
    context.setLineDash([]);
    drawSigns(context, camera, bodies);
  }
  drawContacts(context, camera, swarm);
  if (selected?.at) {
    const [x, y] = camera.toScreen(selected.at.x_m, selected.at.y_m);
    context.beginPath();
    context.arc(x, y, radiusOf(selected, camera) + 6, 0, FULL);
    context.strokeStyle = colours.text;
    context.lineWidth = 2.5;
    context.stroke();
  }
}

function drawSigns(context, camera, bodies) {
  context.beginPath();
  for (const body of bodies) traceSign(context, body, camera);
  context.fillStyle = colours.ink;
  context.fill();
  // An arrowhead outside of its body lies on the floor, which may be dark.
  context.strokeStyle = colours.halo;
  context.lineWidth = 0.6;
  context.stroke();
}

function drawContacts(context, camera, swarm) {
  const touching = swarm.bodies.filter((body) => body.at && body.now?.truth?.in_contact);
  if (!touching.length) return;
  context.beginPath();
  for (const body of touching) {
    const [x, y] = camera.toScreen(body.at.x_m, body.at.y_m);
    for (const more of [4, 9]) {
      const r = radiusOf(body, camera) + more;
      context.moveTo(x + r, y);
      context.arc(x, y, r, 0, FULL);
    }
  }
  context.strokeStyle = colours.contact;
  context.lineWidth = 2.5;
  context.stroke();
}

export function drawLabels(context, camera, swarm, selected) {
  const many = swarm.bodies.length > MANY;
  context.font = `600 ${many ? 10 : 12}px system-ui, sans-serif`;
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeStyle = colours.halo;
  context.fillStyle = colours.label;
  for (const body of swarm.bodies) {
    if (!body.at || (many && body !== selected && body.setting.radius_m * camera.scale < LABEL_PX_MIN)) continue;
    const [x, y] = camera.toScreen(body.at.x_m, body.at.y_m);
    const off = radiusOf(body, camera) * 0.8 + 3;
    if (x < -20 || y < -20 || x > camera.width + 20 || y > camera.height + 20) continue;
    const text = body.now?.truth?.in_contact ? `${body.id} contact` : `${body.id}`;
    if (!many) context.strokeText(text, x + off, y - off);
    context.fillText(text, x + off, y - off);
  }
}

export function drawScaleBar(context, camera) {
  const metres = gridStep(camera.scale, 60);
  const length = metres * camera.scale;
  const [x, y] = [14, camera.height - 14];
  context.fillStyle = colours.halo;
  context.fillRect(x - 6, y - 23, length + 12, 30);
  context.strokeStyle = colours.text;
  context.lineWidth = 2;
  context.beginPath();
  for (const [fromX, fromY, toX, toY] of [[0, 0, length, 0], [0, -5, 0, 1], [length, -5, length, 1]]) {
    context.moveTo(x + fromX, y + fromY);
    context.lineTo(x + toX, y + toY);
  }
  context.stroke();
  context.font = "600 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  context.fillStyle = colours.text;
  context.fillText(metres >= 1000 ? `${metres / 1000} km` : `${+metres.toPrecision(2)} m`, x + length / 2, y - 8);
}

/** The body under a point of the screen, or the nearest within a finger's width. */
export function bodyAt(camera, swarm, px, py) {
  let best = null;
  let least = Infinity;
  for (const body of swarm.bodies) {
    if (!body.at) continue;
    const [x, y] = camera.toScreen(body.at.x_m, body.at.y_m);
    const apart = Math.hypot(x - px, y - py);
    if (apart < least && apart < radiusOf(body, camera) + 10) [best, least] = [body, apart];
  }
  return best;
}
