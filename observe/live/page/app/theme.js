// Light or dark: as the computer says, until somebody chooses.

const KEY = "drover-theme";
const root = document.documentElement;
let button = null;
let chosen = null;
const dark = matchMedia("(prefers-color-scheme: dark)");

const NAMES = [
  "floor", "outside", "grid", "wall", "solid", "free", "hit", "route", "goal", "scan", "link", "label", "halo", "trail",
  "active", "waiting", "held", "done", "stopped", "dead", "contact", "ink", "accent", "text", "muted", "surface",
];

/** The colours of the style sheet, for the canvas. `version` grows when they change. */
export const colours = { version: 0 };

// A browser may forbid storage; then the choice lasts as long as the page.
function stored() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

function store(theme) {
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // The choice then lasts as long as the page.
  }
}

function apply() {
  root.dataset.theme = chosen ?? stored() ?? (dark.matches ? "dark" : "light");
  const other = root.dataset.theme === "dark" ? "light" : "dark";
  button.textContent = other === "dark" ? "Dark" : "Light";
  button.setAttribute("aria-label", `Use ${other} colours`);
  const style = getComputedStyle(root);
  for (const name of NAMES) colours[name] = style.getPropertyValue(`--${name}`).trim();
  colours.version += 1;
}

export function startTheme(switcher) {
  button = switcher;
  dark.addEventListener("change", apply);
  button.addEventListener("click", () => {
    chosen = root.dataset.theme === "dark" ? "light" : "dark";
    store(chosen);
    apply();
  });
  apply();
}
