// A picture that is kept and drawn anew only now and then: what changes slowly, or costs much.

/** The picture goes so far beyond the view, CSS pixels: a view that moves less finds all of it there. */
const MARGIN_PX = 64;

export class Layer {
  /** `periodMs`: how old the picture may get; `opaque`: it covers everything. */
  constructor(periodMs, opaque) {
    this.periodMs = periodMs;
    this.canvas = document.createElement("canvas");
    this.context = this.canvas.getContext("2d", { alpha: !opaque });
    this.paintedAt = -Infinity;
  }

  /** Put the picture onto `target`. `draw(context, camera, ratio)` draws it, in metres; `key` names what is on it. */
  show(target, camera, ratio, now, { key, draw }) {
    const whole = `${key},${camera.scale},${camera.width},${camera.height},${ratio}`;
    const margin = MARGIN_PX / camera.scale;
    const there = this.key === whole && Math.abs(this.x - camera.x) <= margin && Math.abs(this.y - camera.y) <= margin;
    if (!there || now - this.paintedAt > this.periodMs) {
      this.paint(camera, ratio, draw);
      Object.assign(this, { key: whole, x: camera.x, y: camera.y, paintedAt: now });
    }
    const scale = camera.scale * ratio;
    const [right, down] = [(this.x - camera.x) * scale, (camera.y - this.y) * scale];
    target.setTransform(1, 0, 0, 1, 0, 0);
    // Whole pixels: between them the picture would be blurred, and take long.
    target.drawImage(this.canvas, Math.round(right - MARGIN_PX * ratio), Math.round(down - MARGIN_PX * ratio));
  }

  paint(camera, ratio, draw) {
    const wider = Object.create(camera);
    wider.width = camera.width + 2 * MARGIN_PX;
    wider.height = camera.height + 2 * MARGIN_PX;
    const [width, height] = [Math.round(wider.width * ratio), Math.round(wider.height * ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.context.clearRect(0, 0, width, height);
    wider.apply(this.context, ratio);
    draw(this.context, wider, ratio);
  }
}
