// The side: counts, gauges, the list of robots and the selected one.

import { STATES, age, fixed, make, percent, place, stateOf, twist, withUnit, write } from "./words.js";

const byId = (id) => document.getElementById(id);

/** From this share of a limit on, a value is near it. */
const NEAR = 0.6;

const speedOf = (robot) => (robot.truth ?? robot).twist_b[0];

const mark = (state) => {
  const element = make("span", "mark", stateOf(state).sign);
  element.dataset.state = state;
  element.setAttribute("aria-hidden", "true");
  return element;
};

class Gauge {
  constructor(parent, title, unit) {
    this.unit = unit;
    this.root = make("div", "gauge");
    this.value = make("span");
    this.note = make("div", "note");
    const bar = make("div", "bar");
    this.fill = bar.appendChild(make("i"));
    const line = make("div", "value");
    this.small = make("small", "", unit);
    line.append(this.value, " ", this.small);
    this.root.append(make("h2", "", title), line, bar, this.note);
    parent.append(this.root);
  }

  /** `share`: how far the value is on the way to its limit, `most`; null: it has none. */
  show(text, share, note, most = null) {
    write(this.value, text);
    write(this.small, most === null ? this.unit : `of ${most} ${this.unit}`);
    write(this.note, note);
    this.note.title = note;
    this.fill.parentElement.hidden = share === null;
    this.fill.style.width = `${Math.round(100 * Math.max(0, Math.min(1, share ?? 0)))}%`;
    this.root.dataset.level = share === null || share < NEAR ? "" : share < 1 ? "near" : "over";
  }
}

export class Panel {
  /** `onSelect(id)`: null for none; `onFollow(follow)`. */
  constructor(onSelect, onFollow) {
    this.onSelect = onSelect;
    this.onFollow = onFollow;
    this.table = byId("robots");
    this.detail = byId("detail");
    this.selected = null;
    this.buildGauges();
    this.buildDetail();
    this.table.addEventListener("click", (event) => {
      const body = event.target.closest("tbody");
      if (body) onSelect(Number(body.dataset.id) === this.selected ? null : Number(body.dataset.id));
    });
  }

  buildGauges() {
    const parent = byId("gauges");
    this.gauges = {
      link: new Gauge(parent, "Oldest link", "ms"),
      scan: new Gauge(parent, "Oldest scan", "ms"),
      speed: new Gauge(parent, "Fastest", "m/s"),
      robots: new Gauge(parent, "Robot to robot", "m"),
      walls: new Gauge(parent, "Robot to wall", "m"),
      nearest: new Gauge(parent, "Nearest seen", "m"),
    };
    this.counts = new Map();
  }

  countOf(state) {
    if (!this.counts.has(state)) {
      const element = make("span");
      const number = make("b", "", "0");
      element.append(mark(state), number, stateOf(state).word);
      byId("counts").append(element);
      this.counts.set(state, { element, number });
    }
    return this.counts.get(state);
  }

  buildDetail() {
    const top = make("div", "top");
    this.title = make("h2");
    this.follow = make("button", "", "Follow");
    this.follow.type = "button";
    this.follow.addEventListener("click", () => this.onFollow(this.follow.getAttribute("aria-pressed") !== "true"));
    const close = make("button", "", "Close");
    close.type = "button";
    close.addEventListener("click", () => this.onSelect(null));
    top.append(this.title, this.follow, close);
    this.facts = make("dl");
    this.detail.append(top, this.facts);
    this.factOf = new Map();
  }

  /** A new run: the list is made anew. */
  begin(setting) {
    this.setting = new Map(setting.robots.map((robot) => [robot.id, robot]));
    for (const body of [...this.table.tBodies]) body.remove();
    this.rows = new Map(setting.robots.map((robot) => [robot.id, this.buildRow(robot)]));
    byId("counts").replaceChildren();
    this.counts.clear();
    for (const state of Object.keys(STATES)) this.countOf(state);
  }

  buildRow(robot) {
    const body = make("tbody");
    body.dataset.id = robot.id;
    const [first, second] = [make("tr"), make("tr")];
    const cells = Object.fromEntries(["id", "state", "speed", "link", "scan", "near", "done"].map((name) => {
      return [name, first.appendChild(make("td"))];
    }));
    const button = cells.id.appendChild(make("button", "", `${robot.id}`));
    button.type = "button";
    button.setAttribute("aria-label", `Robot ${robot.id}: details`);
    const sign = cells.state.appendChild(make("span", "mark"));
    sign.setAttribute("aria-hidden", "true");
    const word = make("span");
    cells.state.append(" ", word);
    const why = second.appendChild(make("td"));
    why.colSpan = 7;
    const reason = why.appendChild(make("span"));
    const changed = why.appendChild(make("span", "changed"));
    body.append(first, second);
    this.table.append(body);
    return { body, cells, button, sign, word, why, reason, changed, kind: robot.kind };
  }

  select(id) {
    this.rows?.get(this.selected)?.body.classList.remove("selected");
    this.selected = id;
    this.rows?.get(id)?.body.classList.add("selected");
    this.detail.hidden = id === null;
  }

  setFollow(follow) {
    this.follow.setAttribute("aria-pressed", `${follow}`);
  }

  /** Bring the selected robot's row into view. */
  reveal() {
    this.rows?.get(this.selected)?.body.scrollIntoView({ block: "nearest" });
  }

  update(moment) {
    const counts = new Map(Object.keys(STATES).map((state) => [state, 0]));
    for (const robot of moment.robots) {
      counts.set(robot.state, (counts.get(robot.state) ?? 0) + 1);
      this.updateRow(robot);
      if (robot.id === this.selected) this.updateDetail(robot);
    }
    for (const [state, count] of counts) {
      const { element, number } = this.countOf(state);
      write(number, `${count}`);
      element.dataset.count = count;
    }
    this.updateGauges(moment);
  }

  updateRow(robot) {
    const row = this.rows.get(robot.id);
    if (!row) return;
    const { cells } = row;
    const limits = this.setting.get(robot.id);
    const { word, sign } = stateOf(robot.state);
    write(row.word, word);
    write(row.sign, sign);
    if (row.state !== robot.state) row.sign.dataset.state = row.state = robot.state;
    write(cells.speed, fixed(speedOf(robot), 2));
    write(cells.link, age(robot.link_age_ms));
    write(cells.scan, age(robot.scan_age_ms));
    cells.link.classList.toggle("late", robot.link_age_ms > limits.odometry_ms);
    cells.scan.classList.toggle("late", robot.scan_age_ms > limits.scan_ms);
    write(cells.near, fixed(robot.nearest_m, 2));
    write(cells.done, robot.reached ? "yes" : percent(robot.progress));
    write(row.reason, [row.kind, robot.reason].filter(Boolean).join(" \u00B7 "));
    write(row.changed, robot.changed ? ` \u00B7 changed: ${robot.changed}` : "");
    const title = row.reason.shown + row.changed.shown;
    if (row.why.title !== title) row.why.title = title;
  }

  updateGauges(moment) {
    const { link, scan, speed, robots, walls, nearest } = this.gauges;
    this.showGreatest(link, moment, (robot) => robot.link_age_ms, "odometry_ms", 0);
    this.showGreatest(scan, moment, (robot) => robot.scan_age_ms, "scan_ms", 0);
    this.showGreatest(speed, moment, (robot) => Math.abs(speedOf(robot)), "speed_mps_max", 2);
    const inField = moment.robots.every((robot) => !robot.truth);
    const soFar = inField ? "in simulation only" : "least gap so far";
    for (const [gauge, gap] of [[robots, moment.min_gap_robot_m], [walls, moment.min_gap_wall_m]]) {
      const touched = gap !== null && gap <= 0;
      gauge.show(fixed(gap, 2), null, touched ? "touched" : soFar);
      if (touched) gauge.root.dataset.level = "over";
    }
    const seen = moment.robots.filter((robot) => robot.nearest_m !== null);
    const closest = seen.reduce((a, b) => (a && a.nearest_m <= b.nearest_m ? a : b), null);
    nearest.show(fixed(closest?.nearest_m, 2), null, closest ? `by robot ${closest.id}` : "no scans");
  }

  /** The robot nearest to its limit, or over it. */
  showGreatest(gauge, moment, valueOf, limit, decimals) {
    let worst = null;
    let share = -1;
    for (const robot of moment.robots) {
      const value = valueOf(robot);
      const most = this.setting.get(robot.id)?.[limit];
      if (value === null || !(value / most > share)) continue;
      [worst, share] = [robot, value / most];
    }
    if (!worst) return gauge.show("-", null, "none known");
    const most = this.setting.get(worst.id)[limit];
    return gauge.show(fixed(valueOf(worst), decimals), share, `robot ${worst.id}`, most);
  }

  updateDetail(robot) {
    const setting = this.setting.get(robot.id);
    if (!setting) return;
    write(this.title, `Robot ${robot.id} \u00B7 ${setting.kind}`);
    const at = robot.truth ?? robot.believed;
    const error = robot.truth && robot.believed
      ? Math.hypot(robot.truth.x_m - robot.believed.x_m, robot.truth.y_m - robot.believed.y_m) : null;
    const heard = [...robot.heard].sort((a, b) => b.kept - a.kept || a.id - b.id);
    const peers = heard.slice(0, 12).map((peer) => `${peer.id}${peer.kept ? " kept" : ""} (${age(peer.age_ms)} ms)`);
    const facts = {
      State: `${stateOf(robot.state).word}${robot.reason ? `: ${robot.reason}` : ""}`,
      Changed: robot.changed ?? "no: the law's command went through",
      Asked: twist(robot.request_b),
      Commanded: twist(robot.command_b),
      Measured: twist(robot.twist_b),
      [robot.truth ? "True place" : "Place"]: place(at),
      Believed: robot.truth ? place(robot.believed) : "",
      "Off by": error === null ? "" : `${error.toFixed(2)} m, bound ${robot.pos_bound_m.toFixed(2)} m`,
      "Within": error === null ? `${robot.pos_bound_m.toFixed(2)} m` : "",
      Target: robot.target_w ? `${robot.target_w.map((value) => value.toFixed(2)).join(", ")} m` : "-",
      Nearest: withUnit(robot.nearest_m, 2, "m"),
      Drive: `${robot.link}, ${age(robot.link_age_ms)} ms old (limit ${setting.odometry_ms})`,
      Scan: `${age(robot.scan_age_ms)} ms old (limit ${setting.scan_ms})`,
      Progress: robot.reached ? `${percent(robot.progress)}, says it is done` : percent(robot.progress),
      Battery: percent(robot.charge),
      Contact: robot.truth ? (robot.truth.in_contact ? "touches something" : "none") : "",
      [`Hears ${heard.length}`]: peers.join(", ") + (heard.length > 12 ? ", ..." : "") || "nobody",
    };
    this.writeFacts(Object.entries(facts).filter(([, text]) => text !== ""));
  }

  writeFacts(facts) {
    const rows = this.facts.children;
    while (rows.length > facts.length * 2) rows[rows.length - 1].remove();
    while (rows.length < facts.length * 2) this.facts.append(make("dt"), make("dd"));
    facts.forEach(([name, text], index) => {
      write(rows[index * 2], name);
      write(rows[index * 2 + 1], text);
    });
  }
}
