// What may be asked of the run: stop, and where it makes sense pace, restart and another moment.

import { clock, write } from "./words.js";

const byId = (id) => document.getElementById(id);

/** A stop that was sent and that nothing is heard of for so long is said to be unanswered. */
const ANSWER_MS = 1000;
const SEEK_MS = 100;
const RATES = [0.25, 0.5, 1, 2, 4];
const RATES_OF_RECORDING = [...RATES, 8, 16];

export class Controls {
  /** `send(control)`: whether it went out; `notice(text)`. */
  constructor(send, notice) {
    this.send = send;
    this.notice = notice;
    this.connected = false;
    this.allowed = {};
    this.stopSentAt = null;
    this.seeking = false;
    this.seekSentAt = 0;
    byId("stop").addEventListener("click", () => this.stop());
    byId("pause").addEventListener("click", () => this.ask({ do: this.paused ? "resume" : "pause" }));
    byId("restart").addEventListener("click", () => this.ask({ do: "restart" }));
    byId("speed").addEventListener("change", (event) => this.ask({ do: "speed", rate: Number(event.target.value) }));
    const seek = byId("seek");
    seek.addEventListener("input", () => this.seek(false));
    seek.addEventListener("change", () => this.seek(true));
  }

  begin(setting, allowed) {
    this.allowed = allowed;
    this.count = setting.robots.length;
    this.stopSentAt = null;
    this.result("", "");
    byId("stop-bar").hidden = !allowed.stop;
    byId("pause").hidden = byId("speed-label").hidden = !allowed.pace;
    byId("restart").hidden = !allowed.restart;
    this.duration = setting.duration_s;
    byId("seek-label").hidden = !allowed.seek || this.duration === null;
    byId("pace").hidden = !allowed.pace && !allowed.restart && !allowed.seek;
    byId("seek").max = this.duration ?? 1;
    this.fillRates(allowed.seek ? RATES_OF_RECORDING : RATES);
    this.setConnected(this.connected);
  }

  fillRates(rates) {
    const options = rates.map((rate) => {
      const option = document.createElement("option");
      option.value = rate;
      option.textContent = `${rate}\u00D7`;
      return option;
    });
    byId("speed").replaceChildren(...options);
    byId("speed").value = "1";
  }

  setConnected(connected) {
    this.connected = connected;
    const stop = byId("stop");
    stop.toggleAttribute("data-off", !connected);
    const many = this.count === 1 ? "the robot" : `all ${this.count ?? ""} robots`;
    write(byId("stop-hint"), connected ? many : "not connected: use drover stop");
    for (const id of ["pause", "speed", "restart", "seek"]) byId(id).disabled = !connected;
  }

  ask(control) {
    if (!this.send(control)) this.notice("Not connected: nothing was sent.");
  }

  stop() {
    // The button is never disabled: whoever presses it must learn at once whether anything was sent.
    if (this.send({ do: "stop" })) {
      this.stopSentAt ??= performance.now();
      if (!this.answered) this.result("STOP sent", "going");
    } else {
      this.result("Not connected, nothing was sent. Use drover stop, or the robots' own stop buttons.", "going");
    }
  }

  refused(why) {
    if (this.stopSentAt !== null && !this.answered) {
      this.stopSentAt = null;
      this.result(`Refused: ${why}`, "going");
    }
    this.notice(`Refused: ${why}`);
  }

  seek(last) {
    const now = performance.now();
    this.seeking = !last;
    write(byId("seek-time"), this.seekWords(Number(byId("seek").value)));
    if (!last && now - this.seekSentAt < SEEK_MS) return;
    this.seekSentAt = now;
    this.ask({ do: "seek", time_s: Number(byId("seek").value) });
  }

  seekWords(time) {
    return `${clock(time)} of ${clock(this.duration)}`;
  }

  update(moment) {
    this.paused = moment.run.phase === "paused";
    write(byId("pause"), this.paused ? "Resume" : "Pause");
    const speed = byId("speed");
    const rate = `${moment.run.rate}`;
    const offered = [...speed.options].some((option) => option.value === rate);
    if (offered && speed.value !== rate && document.activeElement !== speed) speed.value = rate;
    if (this.allowed.seek && !this.seeking) {
      byId("seek").value = moment.time_s;
      write(byId("seek-time"), this.seekWords(moment.time_s));
    }
    this.updateStop(moment);
  }

  updateStop({ run, robots }) {
    const { stop } = run;
    this.answered = Boolean(stop);
    const all = robots.length;
    if (stop && stop.all_standing_s !== null) {
      const after = Math.max(0, stop.all_standing_s - stop.asked_s).toFixed(2);
      const who = all === 1 ? "the robot stands" : `all ${all} robots stand`;
      const latched = stop.latched < all ? `; ${stop.latched} of ${all} latched` : "";
      this.result(`Stopped: ${who}, ${after} s after${latched}`, "done");
    } else if (stop) {
      this.result(`Stopping: ${stop.standing} of ${all} stand`, "going");
    } else if (this.stopSentAt !== null && performance.now() - this.stopSentAt > ANSWER_MS) {
      this.result("STOP sent, no answer yet. If they still move: drover stop.", "going");
    }
  }

  result(text, state) {
    const element = byId("stop-result");
    write(element, text);
    element.dataset.state = state;
  }
}
