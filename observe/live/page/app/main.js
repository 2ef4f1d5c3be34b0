// Puts the page together: moments come in, the picture and the panel follow.

import { Camera } from "./camera.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { Explored } from "./explored.js";
import { Layer } from "./layer.js";
import { Panel } from "./panel.js";
import { Place } from "./place.js";
import {
  MANY, bodyAt, drawBeliefs, drawBodies, drawLabels, drawLinks, drawMovers, drawScaleBar, drawScans, drawTargets,
  drawTrails,
} from "./robots.js";
import { Swarm } from "./swarm.js";
import { colours, startTheme } from "./theme.js";
import { clock, make, write } from "./words.js";

const byId = (id) => document.getElementById(id);
const LAYERS = ["explored", "trails", "links", "targets", "scans", "belief", "labels"];
const PANEL_MS = 100;
const NOTICE_MS = 5000;
/** After this long without news there is nothing to draw anew. */
const REST_MS = 1000;

const hooks = document.body.dataset;
const canvas = byId("world");
const context = canvas.getContext("2d", { alpha: false });
const explored = new Explored();
const back = new Layer(250, true);
const slow = new Layer(150, false);
const shown = Object.fromEntries(LAYERS.map((name) => [name, true]));

let setting = null;
let moment = null;
let place = null;
let swarm = null;
let follow = false;
let selected = null;
let arrivedAt = 0;
let changes = 0;
let links = 0;

/** The newest of both, for tests: to be read, not written. */
window.drover = {
  get moment() {
    return moment;
  },
  get setting() {
    return setting;
  },
};

function notice(text) {
  const element = byId("notice");
  element.textContent = text;
  element.hidden = false;
  clearTimeout(notice.timer);
  notice.timer = setTimeout(() => (element.hidden = true), NOTICE_MS);
}

const camera = new Camera(canvas, (px, py) => {
  if (!swarm) return;
  select(bodyAt(camera, swarm, px, py)?.id ?? null);
  panel.reveal();
});
camera.onPan = () => setFollow(false);

const panel = new Panel(select, setFollow);
const controls = new Controls((control) => connection.send(control), notice);
startTheme(byId("theme"));

const connection = new Connection({
  message: (message) => {
    if (message.type === "setting") begin(message.setting, message.controls);
    else if (message.type === "moment") take(message.moment);
    else if (message.type === "refused") controls.refused(message.why);
  },
  state: (state, words) => {
    const element = byId("connection");
    element.dataset.state = state;
    write(element, words);
    hooks.connected = connection?.isOpen ? "yes" : "no";
    controls.setConnected(hooks.connected === "yes");
  },
});

function select(id) {
  selected = id;
  changes += 1;
  if (id === null) setFollow(false);
  panel.select(id);
  if (moment) panel.update(moment);
}

function setFollow(on) {
  follow = on && selected !== null;
  panel.setFollow(follow);
}

/** A setting: the same run again after the connection was lost, or another one. */
function begin(newSetting, allowed) {
  const sameRun = setting?.started_unix_us === newSetting.started_unix_us
    && setting.swarm === newSetting.swarm && setting.robots.length === newSetting.robots.length;
  setting = newSetting;
  controls.begin(setting, allowed);
  write(byId("swarm"), setting.swarm);
  const count = setting.robots.length;
  const where = setting.source === "field" ? "in the field" : `simulated in ${setting.place.name || "an open place"}`;
  write(byId("about"), `${setting.behaviour} \u00B7 ${count} ${count === 1 ? "robot" : "robots"} \u00B7 ${where}`);
  document.title = `${setting.swarm} \u00B7 Drover`;
  if (sameRun) return;
  moment = null;
  explored.clear();
  place = new Place(setting);
  swarm = new Swarm(setting, explored);
  panel.begin(setting);
  if (!swarm.byId.has(selected)) select(null);
  else select(selected);
  camera.setBounds(place.bounds);
  changes += 1;
}

function take(newMoment) {
  if (!swarm) return;
  arrivedAt = performance.now();
  swarm.take(newMoment, arrivedAt);
  moment = newMoment;
  connection.expect(["running", "stopping"].includes(moment.run.phase));
}

/** In the field nobody knows the place: the view follows the robots until somebody moves it. */
function fitToRobots() {
  if (place.bounds || !camera.fitted) return;
  const now = swarm.bounds();
  const old = camera.bounds;
  const within = old && now && now.every((value, side) => (side < 2 ? value >= old[side] - 2 : value <= old[side] + 2));
  if (now && !within) camera.setBounds(now.map((value, side) => value + (side < 2 ? -2 : 2)));
}

function resize() {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const { clientWidth: width, clientHeight: height } = canvas;
  const [deviceWidth, deviceHeight] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== deviceWidth || canvas.height !== deviceHeight) {
    [canvas.width, canvas.height] = [deviceWidth, deviceHeight];
    changes += 1;
  }
  camera.resize(width, height);
  return ratio;
}

function drawBack(to, wider) {
  place.drawFloor(to, wider, () => shown.explored && explored.draw(to));
  place.drawWalls(to, wider);
}

/** The links and scans of many robots change little from frame to frame, and take long. */
function drawSlow(to, wider, ratio) {
  const many = swarm.bodies.length > MANY;
  if (many && shown.links) links = drawLinks(to, wider, swarm);
  if (shown.trails) drawTrails(to, wider, swarm);
  to.setTransform(ratio, 0, 0, ratio, 0, 0);
  if (many && shown.scans) drawScans(to, wider, swarm);
}

function draw(now, ratio) {
  const many = swarm.bodies.length > MANY;
  const key = `${colours.version},${changes}`;
  back.show(context, camera, ratio, now, { key, draw: drawBack });
  slow.show(context, camera, ratio, now, { key, draw: drawSlow });
  if (!shown.links) links = 0;
  camera.apply(context, ratio);
  drawMovers(context, camera, swarm);
  if (!many && shown.links) links = drawLinks(context, camera, swarm);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  if (shown.targets) drawTargets(context, camera, swarm);
  if (!many && shown.scans) drawScans(context, camera, swarm);
  if (shown.belief) drawBeliefs(context, camera, swarm);
  const chosen = swarm.byId.get(selected);
  drawBodies(context, camera, swarm, chosen);
  if (shown.labels) drawLabels(context, camera, swarm, chosen);
  drawScaleBar(context, camera);
}

function drawNothing() {
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = colours.outside;
  context.fillRect(0, 0, canvas.width, canvas.height);
}

function updateHead() {
  const { phase, rate, words } = moment.run;
  const element = byId("phase");
  write(element, phase);
  element.dataset.phase = phase;
  element.title = words;
  write(byId("time"), clock(moment.time_s));
  write(byId("rate"), rate === 1 ? "" : `${rate}\u00D7`);
}

function updateHooks() {
  hooks.phase = moment.run.phase;
  hooks.time = moment.time_s.toFixed(2);
  hooks.robots = swarm.bodies.filter((body) => body.at).length;
  hooks.links = links;
  hooks.movers = swarm.movers.map((mover) => mover.map((value) => value.toFixed(3)).join()).join(" ");
  hooks.trails = shown.trails ? swarm.bodies.filter((body) => body.trail.length >= 2).length : 0;
}

const pace = { frames: 0, since: performance.now(), panelAt: 0, panelMoment: null, drawn: "" };

function frame(now) {
  requestAnimationFrame(frame);
  pace.frames += 1;
  if (now - pace.since >= 1000) {
    hooks.fps = Math.round((pace.frames * 1000) / (now - pace.since));
    [pace.frames, pace.since] = [0, now];
  }
  const ratio = resize();
  byId("empty").hidden = Boolean(moment);
  if (!swarm || !moment) {
    drawNothing();
    return;
  }
  swarm.pose(now);
  fitToRobots();
  const followed = follow ? swarm.byId.get(selected)?.at : null;
  if (followed) camera.lookAt(followed.x_m, followed.y_m);
  const key = `${camera.key},${colours.version},${changes}`;
  if (now - arrivedAt < REST_MS || key !== pace.drawn) draw(now, ratio);
  pace.drawn = key;
  if (now - pace.panelAt < PANEL_MS || moment === pace.panelMoment) return;
  [pace.panelAt, pace.panelMoment] = [now, moment];
  updateHead();
  updateHooks();
  panel.update(moment);
  controls.update(moment);
}

for (const name of LAYERS) {
  const label = make("label");
  const box = make("input");
  box.type = "checkbox";
  box.checked = true;
  box.dataset.layer = name;
  box.addEventListener("change", () => {
    shown[name] = box.checked;
    changes += 1;
  });
  label.append(box, name);
  byId("chips").append(label);
}
byId("zoom-in").addEventListener("click", () => camera.zoom(1.4));
byId("zoom-out").addEventListener("click", () => camera.zoom(1 / 1.4));
byId("fit").addEventListener("click", () => {
  setFollow(false);
  camera.fit();
});
if (matchMedia("(max-width: 760px)").matches) byId("layers").open = false;
requestAnimationFrame(frame);
