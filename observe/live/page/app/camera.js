// What part of the world is seen. World: metres, y up. Screen: CSS pixels, y down.

const SCALE_MIN = 0.5;
const SCALE_MAX = 600;
const CLICK_PX = 5;

export class Camera {
  constructor(canvas, onTap) {
    this.canvas = canvas;
    this.onTap = onTap;
    this.x = 0;
    this.y = 0;
    this.scale = 40;
    this.width = 1;
    this.height = 1;
    this.bounds = null;
    /** Fitted to the bounds until somebody moves it. */
    this.fitted = true;
    this.pointers = new Map();
    this.listen();
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  /** Make `context` draw in metres. */
  apply(context, ratio) {
    const s = this.scale * ratio;
    context.setTransform(s, 0, 0, -s, (this.width / 2) * ratio - this.x * s, (this.height / 2) * ratio + this.y * s);
  }

  /** What the camera shows, as a key: two moments with the same key look at the same. */
  get key() {
    return `${this.x},${this.y},${this.scale},${this.width},${this.height}`;
  }

  resize(width, height) {
    if (width === this.width && height === this.height) return;
    this.width = width;
    this.height = height;
    if (this.fitted) this.fit();
  }

  /** Everything is within these bounds: [west, south, east, north]. */
  setBounds(bounds) {
    this.bounds = bounds;
    if (this.fitted) this.fit();
  }

  fit() {
    this.fitted = true;
    if (!this.bounds) return;
    const [west, south, east, north] = this.bounds;
    // Room for what lies over the picture: layers above, scale and buttons below.
    const [top, bottom] = [this.width > 500 ? 84 : 48, 56];
    const [wide, high] = [this.width - 36, this.height - top - bottom];
    const scale = Math.min(wide / Math.max(east - west, 1), high / Math.max(north - south, 1));
    this.scale = Math.min(SCALE_MAX, Math.max(SCALE_MIN, scale));
    this.x = (west + east) / 2;
    this.y = (south + north) / 2 + (top - bottom) / 2 / this.scale;
  }

  lookAt(x, y) {
    this.x = x;
    this.y = y;
  }

  pan(dx, dy) {
    this.fitted = false;
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.onPan?.();
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    this.fitted = false;
    const [x, y] = this.toWorld(px, py);
    this.scale = Math.min(SCALE_MAX, Math.max(SCALE_MIN, this.scale * factor));
    const [nx, ny] = this.toWorld(px, py);
    this.x += x - nx;
    this.y += y - ny;
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const pixels = event.deltaMode === 1 ? event.deltaY * 30 : event.deltaY;
      this.zoom(Math.exp(-Math.max(-240, Math.min(240, pixels)) * 0.0016), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      this.travel = this.pointers.size > 1 ? Infinity : 0;
      canvas.classList.add("dragging");
    });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => {
        const known = this.pointers.delete(event.pointerId);
        if (known && end === "pointerup" && this.travel <= CLICK_PX) this.onTap(event.offsetX, event.offsetY);
        if (this.pointers.size === 0) canvas.classList.remove("dragging");
      });
    }
    canvas.addEventListener("keydown", (event) => this.key_down(event));
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.offsetX, event.offsetY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (this.pointers.size === 1) {
      this.travel += Math.hypot(dx, dy);
      // A finger trembles: until it has gone some way it is a tap.
      if (this.travel > CLICK_PX) this.pan(dx, dy);
    } else {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = Math.hypot(before[0] - other[0], before[1] - other[1]);
      const factor = Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(apart, 1);
      this.zoom(factor, (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      this.pan(dx / 2, dy / 2);
    }
    this.pointers.set(event.pointerId, now);
  }

  key_down(event) {
    const step = 60;
    const actions = {
      ArrowLeft: () => this.pan(step, 0),
      ArrowRight: () => this.pan(-step, 0),
      ArrowUp: () => this.pan(0, step),
      ArrowDown: () => this.pan(0, -step),
      "+": () => this.zoom(1.25),
      "-": () => this.zoom(0.8),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }
}
