// Tiles: asked for from the coarse to the fine and from the middle outwards, kept while there is room, given up when the view has moved on.

import { gone, post } from "./ask.js";
import { CELLS } from "./plane.js";

const COUNT = CELLS * CELLS;
const MOST_KEPT = 700; // some 60 MB
const AT_ONCE = 5; // of the six connections that a browser opens; one is left for what is asked of a point
const PINNED = 1; // levels that are never forgotten: something is there to show wherever one goes

export class Tiles {
  constructor(changed, failed) {
    this.changed = changed;
    this.failed = failed;
    this.kept = new Map();
    this.pending = new Map();
    this.queue = [];
    this.scene = null;
  }

  // Another scene: nothing of what is here is of it.
  reset(scene) {
    this.scene = scene;
    this.queue = [];
    for (const controller of this.pending.values()) controller.abort();
    this.pending.clear();
    this.kept.clear();
  }

  get(z, x, y) {
    const key = `${z}/${x}/${y}`;
    const tile = this.kept.get(key);
    if (tile) { // the last one used is the last one forgotten
      this.kept.delete(key);
      this.kept.set(key, tile);
    }
    return tile;
  }

  // The tile itself, or a coarser one that has the place; with how much coarser it is.
  best(z, x, y) {
    for (let up = 0; up <= z; up += 1) {
      const tile = this.get(z - up, Math.floor(x / 2 ** up), Math.floor(y / 2 ** up));
      if (tile) return { tile, up };
    }
    return null;
  }

  // What is wanted now, the most urgent first. Whatever else is under way is given up.
  want(list) {
    const keys = new Set(list.map(([z, x, y]) => `${z}/${x}/${y}`));
    for (const [key, controller] of this.pending) {
      if (!keys.has(key)) {
        controller.abort();
        this.pending.delete(key);
      }
    }
    this.queue = list.filter(([z, x, y]) => !this.kept.has(`${z}/${x}/${y}`) && !this.pending.has(`${z}/${x}/${y}`));
    this.next();
  }

  get busy() {
    return this.queue.length + this.pending.size;
  }

  next() {
    while (this.pending.size < AT_ONCE && this.queue.length > 0) this.ask(...this.queue.shift());
  }

  async ask(z, x, y) {
    const key = `${z}/${x}/${y}`;
    const controller = new AbortController();
    const scene = this.scene;
    this.pending.set(key, controller);
    try {
      const bytes = await post("tile", { scene, z, x, y }, controller.signal);
      if (this.scene !== scene) return;
      this.keep(key, new Tile(bytes));
    } catch (error) {
      if (!gone(error) && this.scene === scene) this.failed(error);
    } finally {
      if (this.pending.get(key) === controller) this.pending.delete(key);
      this.next();
      this.changed();
    }
  }

  keep(key, tile) {
    this.kept.set(key, tile);
    if (this.kept.size <= MOST_KEPT) return;
    for (const old of this.kept.keys()) {
      if (Number(old.split("/")[0]) <= PINNED) continue;
      this.kept.delete(old);
      break;
    }
  }
}

// Cells by rows, the lowest y first.
class Tile {
  constructor(bytes) {
    this.radius = new Float64Array(bytes, 0, COUNT);
    this.margin = new Float64Array(bytes, 8 * COUNT, COUNT);
    const words = (i) => new Uint8Array(bytes, (16 + i) * COUNT, COUNT);
    [this.class, this.mechanism, this.status, this.solutions] = [0, 1, 2, 3].map(words);
  }
}

export const NONE = 255;
