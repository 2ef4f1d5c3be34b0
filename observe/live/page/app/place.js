// What does not move: the floor, the grid, walls, the map, the ways of movers, the route and the goal.

import { colours } from "./theme.js";

/** Bounds of the place, [west, south, east, north]; null if there is none. */
export function boundsOf(setting) {
  const { place } = setting;
  const points = [...place.enclosure_m, ...place.polygons_m.flat(), ...place.polylines_m.flat(), ...setting.route_m];
  for (const [x, y, r] of place.circles_m) points.push([x - r, y - r], [x + r, y + r]);
  points.push(...(place.movers ?? []).flatMap((mover) => mover.round_m));
  if (setting.goal) {
    const [[x, y], r] = [setting.goal.at_m, setting.goal.within_m];
    points.push([x - r, y - r], [x + r, y + r]);
  }
  if (place.map) points.push(...cornersOf(place.map));
  if (points.length === 0) return null;
  const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
  const low = (values) => values.reduce((a, b) => Math.min(a, b));
  const high = (values) => values.reduce((a, b) => Math.max(a, b));
  return [low(xs), low(ys), high(xs), high(ys)];
}

function cornersOf(map) {
  const [wide, high] = [map.width * map.resolution_m, map.height * map.resolution_m];
  const [c, s] = [Math.cos(map.origin_yaw_rad), Math.sin(map.origin_yaw_rad)];
  const at = ([x, y]) => [map.origin_m[0] + c * x - s * y, map.origin_m[1] + s * x + c * y];
  return [[0, 0], [wide, 0], [wide, high], [0, high]].map(at);
}

/** The map as a picture, a pixel a cell, south row last. */
function pictureOf(map, colour) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [map.width, map.height];
  const context = canvas.getContext("2d");
  context.fillStyle = colour;
  let cell = 0;
  map.runs.forEach((run, index) => {
    // A run may go over the end of a row: it is drawn row by row.
    for (let left = run; left > 0;) {
      const [x, y] = [cell % map.width, Math.floor(cell / map.width)];
      const length = Math.min(left, map.width - x);
      if (index % 2 === 1) context.fillRect(x, map.height - 1 - y, length, 1);
      cell += length;
      left -= length;
    }
  });
  return canvas;
}

const trace = (context, points, closed) => {
  points.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (closed) context.closePath();
};

/** Metres from one grid line to the next: 1, 2 or 5 times a power of ten, at least `pixels` apart. */
export function gridStep(scale, pixels) {
  const least = pixels / scale;
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= least);
}

export class Place {
  constructor(setting) {
    this.setting = setting;
    this.bounds = boundsOf(setting);
  }

  /** The floor with its grid, and what `drawOn` draws on it: nothing of it lies outside. */
  drawFloor(context, camera, drawOn) {
    const { place } = this.setting;
    const [west, north] = camera.toWorld(0, 0);
    const [east, south] = camera.toWorld(camera.width, camera.height);
    context.fillStyle = colours.outside;
    context.fillRect(west, south, east - west, north - south);
    context.save();
    context.beginPath();
    if (place.enclosure_m.length > 2) trace(context, place.enclosure_m, true);
    else if (place.map) trace(context, cornersOf(place.map), true);
    else context.rect(west, south, east - west, north - south);
    context.fillStyle = colours.floor;
    context.fill();
    context.clip();
    this.drawGrid(context, camera);
    drawOn();
    context.restore();
  }

  drawGrid(context, camera) {
    const step = gridStep(camera.scale, 46);
    const [west, north] = camera.toWorld(0, 0);
    const [east, south] = camera.toWorld(camera.width, camera.height);
    context.beginPath();
    for (let x = Math.ceil(west / step) * step; x < east; x += step) trace(context, [[x, south], [x, north]]);
    for (let y = Math.ceil(south / step) * step; y < north; y += step) trace(context, [[west, y], [east, y]]);
    context.strokeStyle = colours.grid;
    context.lineWidth = 1 / camera.scale;
    context.stroke();
  }

  drawWalls(context, camera) {
    const { place, route_m: route, goal } = this.setting;
    const px = 1 / camera.scale;
    if (place.map) this.drawMap(context, place.map);
    context.beginPath();
    for (const polygon of place.polygons_m) trace(context, polygon, true);
    for (const [x, y, r] of place.circles_m) {
      context.moveTo(x + r, y);
      context.arc(x, y, r, 0, 2 * Math.PI);
    }
    context.fillStyle = colours.solid;
    context.fill();
    context.strokeStyle = colours.wall;
    context.lineWidth = 1.5 * px;
    context.stroke();
    context.beginPath();
    trace(context, place.enclosure_m, true);
    for (const line of place.polylines_m) trace(context, line, false);
    context.lineWidth = 3 * px;
    context.lineJoin = "round";
    context.stroke();
    for (const { round_m: round } of place.movers ?? []) this.drawRound(context, round, px);
    if (route.length) this.drawRoute(context, route, px);
    if (goal) this.drawGoal(context, goal, px);
  }

  drawMap(context, map) {
    if (this.mapVersion !== colours.version) {
      this.map = pictureOf(map, colours.wall);
      this.mapVersion = colours.version;
    }
    context.save();
    context.translate(map.origin_m[0], map.origin_m[1]);
    context.rotate(map.origin_yaw_rad);
    // The picture's first row is the northern one, and y points up here.
    context.scale(map.resolution_m, -map.resolution_m);
    context.imageSmoothingEnabled = false;
    context.drawImage(this.map, 0, -map.height);
    context.restore();
  }

  drawRoute(context, route, px) {
    context.beginPath();
    trace(context, route, false);
    context.strokeStyle = colours.route;
    context.lineWidth = 2 * px;
    context.setLineDash([9 * px, 6 * px]);
    context.globalAlpha = 0.7;
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    for (const [x, y] of route) {
      context.moveTo(x + 3.5 * px, y);
      context.arc(x, y, 3.5 * px, 0, 2 * Math.PI);
    }
    context.fillStyle = colours.route;
    context.fill();
    context.globalAlpha = 1;
  }

  /** The way of what moves. */
  drawRound(context, round, px) {
    context.beginPath();
    trace(context, round, true);
    context.strokeStyle = colours.wall;
    context.lineWidth = 1.5 * px;
    context.setLineDash([6 * px, 6 * px]);
    context.stroke();
    context.setLineDash([]);
  }

  drawGoal(context, goal, px) {
    const [x, y] = goal.at_m;
    context.beginPath();
    context.arc(x, y, Math.max(goal.within_m, 4 * px), 0, 2 * Math.PI);
    context.strokeStyle = colours.goal;
    context.fillStyle = colours.goal;
    context.globalAlpha = 0.12;
    context.fill();
    context.globalAlpha = 1;
    context.lineWidth = 2 * px;
    context.stroke();
    context.beginPath();
    trace(context, [[x - 6 * px, y], [x + 6 * px, y]]);
    trace(context, [[x, y - 6 * px], [x, y + 6 * px]]);
    context.stroke();
  }
}
