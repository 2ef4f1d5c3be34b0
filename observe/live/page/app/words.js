// Numbers and states as people read them.

/** Every state a robot can be in, with the sign that stands for it where colour is not enough. */
export const STATES = {
  active: { word: "driving", sign: "\u25B8" },
  waiting: { word: "waiting", sign: "\u2026" },
  held: { word: "held", sign: "\u2016" },
  done: { word: "done", sign: "\u2713" },
  stopped: { word: "stopped", sign: "\u25A0" },
  dead: { word: "dead", sign: "\u2715" },
};

/** The state's entry; one that this page does not know is shown as it is. */
export const stateOf = (state) => STATES[state] ?? { word: state, sign: "?" };

/** A number with so many decimals, or a dash for what is not known. Nothing is not negative. */
export const fixed = (value, decimals) =>
  Number.isFinite(value) ? value.toFixed(decimals).replace(/^-(?=[0.]*$)/, "") : "-";

/** The same with a unit. */
export const withUnit = (value, decimals, unit) =>
  Number.isFinite(value) ? `${value.toFixed(decimals)} ${unit}` : "-";

/** An age in ms, or in s when that is long. */
export const age = (ms) => (!Number.isFinite(ms) ? "-" : ms < 10_000 ? `${ms}` : `${(ms / 1000).toFixed(0)}s`);

export const percent = (share) => (Number.isFinite(share) ? `${Math.round(share * 100)} %` : "-");

/** Seconds as minutes and seconds from a minute on. */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return "-";
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const minutes = Math.floor(seconds / 60);
  return `${minutes} min ${(seconds - minutes * 60).toFixed(1).padStart(4, "0")} s`;
}

/** Radians as degrees in (-180, 180]. */
export function degrees(radians) {
  const turned = Math.atan2(Math.sin(radians), Math.cos(radians));
  return `${Math.round((turned * 180) / Math.PI)}\u00B0`;
}

export const place = (at) =>
  at ? `${at.x_m.toFixed(2)}, ${at.y_m.toFixed(2)} m, ${degrees(at.yaw_rad)}` : "-";

export const twist = (pair) => (pair ? `${pair[0].toFixed(2)} m/s, ${pair[1].toFixed(2)} rad/s` : "-");

/** Write text where it differs: touching the document costs more than comparing. */
export function write(element, text) {
  if (element.shown === text) return;
  element.shown = text;
  element.textContent = text;
}

/** An element with a class and text. */
export function make(tag, className, text) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text !== undefined) element.textContent = text;
  return element;
}
