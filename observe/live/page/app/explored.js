// What the lidars have swept since the page was opened: a coarse grid, in square pieces made where they are needed.

import { colours } from "./theme.js";

const CELL_M = 0.25;
const SIDE = 64;
const PIECE_M = SIDE * CELL_M;
const PIECES_MAX = 1024;
const BEAMS_MAX = 120;
/** A beam that met nothing is not believed farther than this. */
const CLEAR_M_MAX = 12;
/** Several hits outweigh a few beams that passed: a wall stays, a robot that drove on does not. */
const HITS_MAX = 5;

const parse = (colour) => {
  const numbers = colour.match(/[\d.]+/g).map(Number);
  return [numbers[0], numbers[1], numbers[2], Math.round((numbers[3] ?? 1) * 255)];
};

export class Explored {
  constructor() {
    this.pieces = new Map();
    this.last = null;
  }

  clear() {
    this.pieces.clear();
    this.last = null;
  }

  pieceAt(column, row) {
    const key = column * 100_003 + row;
    if (this.last?.key === key) return this.last;
    let piece = this.pieces.get(key);
    if (!piece) {
      if (this.pieces.size >= PIECES_MAX) return null;
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [SIDE, SIDE];
      // 0: not seen; 1: free; more: hit, so many times more than passed.
      piece = { key, column, row, cells: new Uint8Array(SIDE * SIDE), canvas, changed: true };
      this.pieces.set(key, piece);
    }
    this.last = piece;
    return piece;
  }

  mark(x, y, hit) {
    const [cx, cy] = [Math.floor(x / CELL_M), Math.floor(y / CELL_M)];
    const piece = this.pieceAt(Math.floor(cx / SIDE), Math.floor(cy / SIDE));
    if (!piece) return;
    const index = (cy - piece.row * SIDE) * SIDE + (cx - piece.column * SIDE);
    const before = piece.cells[index];
    const after = hit ? Math.min(Math.max(before, 1) + 2, HITS_MAX) : Math.max(before - 1, 1);
    if (after === before) return;
    piece.cells[index] = after;
    if (before === 0 || before > 1 !== after > 1) piece.changed = true;
  }

  /** A scan taken with the sensor at x, y, pointing to yaw. */
  sweep(scan, x, y, yaw) {
    const { ranges_m: ranges } = scan;
    const stride = Math.max(1, Math.floor(ranges.length / BEAMS_MAX));
    const clear = Math.min(scan.range_m_max, CLEAR_M_MAX);
    for (let beam = 0; beam < ranges.length; beam += stride) {
      const range = ranges[beam];
      if (range === null) continue;
      const angle = yaw + scan.angle_first_rad + beam * scan.angle_step_rad;
      const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
      const reach = range < 0 ? clear : range;
      for (let r = 0; r < reach - CELL_M; r += CELL_M * 0.8) this.mark(x + dx * r, y + dy * r, false);
      if (range >= 0) this.mark(x + dx * range, y + dy * range, true);
    }
  }

  draw(context) {
    if (this.version !== colours.version) {
      this.version = colours.version;
      [this.free, this.hit] = [parse(colours.free), parse(colours.hit)];
      for (const piece of this.pieces.values()) piece.changed = true;
    }
    context.imageSmoothingEnabled = false;
    for (const piece of this.pieces.values()) {
      if (piece.changed) this.paint(piece);
      context.save();
      context.translate(piece.column * PIECE_M, (piece.row + 1) * PIECE_M);
      context.scale(CELL_M, -CELL_M);
      context.drawImage(piece.canvas, 0, 0);
      context.restore();
    }
  }

  paint(piece) {
    piece.changed = false;
    const context = piece.canvas.getContext("2d");
    const image = context.createImageData(SIDE, SIDE);
    for (let y = 0; y < SIDE; y += 1) {
      for (let x = 0; x < SIDE; x += 1) {
        const value = piece.cells[y * SIDE + x];
        if (value) image.data.set(value > 1 ? this.hit : this.free, ((SIDE - 1 - y) * SIDE + x) * 4);
      }
    }
    context.putImageData(image, 0, 0);
  }
}
