// Rectangles of the benches: corners, distances, and the grid cells that they cover.

// cells: margin around a bench, as in the package's grid; rounding never loses a cell.
const CELL_SLACK = 1e-8;

// Poses as columns, with cosines and sines; `poseOf` returns x, y and angle of a body.
/** @type {(count: number, poseOf: (i: number) => Iterable<number>) => Poses} */
function posesFrom(count, poseOf) {
  /** @type {Poses} */
  const poses = { x: [], y: [], angle: [], cos: [], sin: [] };
  for (let i = 0; i < count; i++) {
    [poses.x[i], poses.y[i], poses.angle[i]] = poseOf(i);
    poses.cos[i] = Math.cos(poses.angle[i]);
    poses.sin[i] = Math.sin(poses.angle[i]);
  }
  return poses;
}

// Poses of benches between their handles.
/** @type {(handles: Numbers[]) => Poses} */
function posesBetween(handles) {
  return posesFrom(handles.length - 1, (i) => {
    const [fx, fy] = handles[i];
    const [rx, ry] = handles[i + 1];
    return [(fx + rx) / 2, (fy + ry) / 2, Math.atan2(fy - ry, fx - rx)];
  });
}

// Benches at their poses; `model` has their number `benches` and their `lengths`,
// `widths` and `spacings`.
/** @template {BenchSizes} [M=any] @template {Poses} [P=Poses] */
class Benches {
  /** @param {M} model @param {P} poses */
  constructor(model, poses) {
    this.model = model;
    this.poses = poses;
    /** @type {Point[] | undefined} */
    this.cachedHandles = undefined;
  }

  // Positions of the handles: handle i is the front hole of bench i,
  // the last handle is the tail's rear hole.
  get handles() {
    const last = this.model.benches - 1;
    return (this.cachedHandles ??= range(0, last, last)
      .map((i) => this.hole(i, 1))
      .concat([this.hole(last, -1)]));
  }

  // The front hole of bench `i`, or with the side -1 the rear one.
  /** @type {(i: number, side: number) => Point} */
  hole(i, side) {
    const { x, y, cos, sin } = this.poses;
    const half = (side * this.model.spacings[i]) / 2;
    return [x[i] + half * cos[i], y[i] + half * sin[i]];
  }

  // Corners: rear right, front right, front left, rear left.
  /** @type {(i: number) => Point[]} */
  corners(i) {
    const { x, y, cos, sin } = this.poses;
    const along = this.model.lengths[i] / 2;
    const across = this.model.widths[i] / 2;
    return [
      [-along, -across],
      [along, -across],
      [along, across],
      [-along, across],
    ].map(([a, c]) => [x[i] + a * cos[i] - c * sin[i], y[i] + a * sin[i] + c * cos[i]]);
  }

  // Point of bench `i` that is closest to a point, and the distance; 0 within the bench.
  /** @type {(i: number, point: Numbers) => { distance: number, point: Point }} */
  nearestPoint(i, [px, py]) {
    const { x, y, cos, sin } = this.poses;
    const dx = px - x[i];
    const dy = py - y[i];
    const along = this.model.lengths[i] / 2;
    const across = this.model.widths[i] / 2;
    // In the coordinates of the bench.
    const ahead = dx * cos[i] + dy * sin[i];
    const left = dy * cos[i] - dx * sin[i];
    const a = Math.min(Math.max(ahead, -along), along);
    const c = Math.min(Math.max(left, -across), across);
    return {
      distance: Math.sqrt((ahead - a) ** 2 + (left - c) ** 2),
      point: [x[i] + a * cos[i] - c * sin[i], y[i] + a * sin[i] + c * cos[i]],
    };
  }

  // Gaps between the shadows of two benches along and across the first, and the second;
  // negative where they overlap.
  /** @type {(i: number, j: number) => number[]} */
  axisGaps(i, j) {
    const { x, y, cos, sin } = this.poses;
    const { lengths, widths } = this.model;
    const dx = x[j] - x[i];
    const dy = y[j] - y[i];
    const c = Math.abs(cos[i] * cos[j] + sin[i] * sin[j]);
    const s = Math.abs(cos[i] * sin[j] - sin[i] * cos[j]);
    /** @type {(own: number, other: number) => number} */
    const along = (own, other) =>
      Math.abs(dx * cos[own] + dy * sin[own]) -
      (lengths[own] + c * lengths[other] + s * widths[other]) / 2;
    /** @type {(own: number, other: number) => number} */
    const across = (own, other) =>
      Math.abs(dy * cos[own] - dx * sin[own]) -
      (widths[own] + s * lengths[other] + c * widths[other]) / 2;
    return [along(i, j), across(i, j), along(j, i), across(j, i)];
  }

  // The gap between two benches, and its two ends. Rectangles that do not overlap are closest at a
  // corner of one of them. The gap of two that overlap is negative: the shortest way that parts
  // them (separating axis theorem).
  /** @type {(i: number, j: number) => Gap} */
  gap(i, j) {
    /** @type {Gap} */
    let found = { gap: Infinity, ends: [] };
    for (const [own, other] of [
      [i, j],
      [j, i],
    ]) {
      for (const corner of this.corners(own)) {
        const { distance, point } = this.nearestPoint(other, corner);
        if (distance < found.gap) found = { gap: distance, ends: [corner, point] };
      }
    }
    const widest = Math.max(...this.axisGaps(i, j));
    found.gap = widest > 0 ? Math.max(widest, found.gap) : widest;
    return found;
  }

  // The bench closest to bench `i` among those that are not its neighbours, of the first `count`,
  // with the gap; `found` if that is a smaller one.
  /** @type {(i: number, found?: NearestBench | null, count?: number) => NearestBench | null} */
  nearest(i, found = null, count = this.model.benches) {
    const { x, y } = this.poses;
    const { lengths, widths } = this.model;
    /** @type {(k: number) => number} */
    const reach = (k) => Math.sqrt(lengths[k] ** 2 + widths[k] ** 2) / 2;
    for (let j = 0; j < count; j++) {
      if (Math.abs(i - j) <= 1) continue;
      // Lower bounds of the gap: distance of the centres less half a diagonal each,
      // and the gaps between shadows.
      const least = Math.sqrt((x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2) - reach(i) - reach(j);
      if (found && (least >= found.gap || Math.max(...this.axisGaps(i, j)) >= found.gap)) continue;
      const between = this.gap(i, j);
      if (!found || between.gap < found.gap) found = { bench: j, ...between };
    }
    return found;
  }

  // Grid cells [row, column] that bench `i` touches or covers: rows count downward,
  // columns to the right.
  /** @type {(i: number, grid: Grid) => Point[]} */
  cells(i, { cell, origin }) {
    const { x, y, cos, sin } = this.poses;
    const u = (x[i] - origin[0]) / cell;
    const v = (origin[1] - y[i]) / cell;
    const along = this.model.lengths[i] / 2 / cell;
    const across = this.model.widths[i] / 2 / cell;
    const c = Math.abs(cos[i]);
    const s = Math.abs(sin[i]);
    const reachU = along * c + across * s + CELL_SLACK;
    const reachV = along * s + across * c + CELL_SLACK;
    /** @type {Point[]} */
    const cells = [];
    for (let row = Math.floor(v - reachV); row <= Math.floor(v + reachV); row++) {
      for (let column = Math.floor(u - reachU); column <= Math.floor(u + reachU); column++) {
        // The ranges of rows and columns cover the cell's axes;
        // the bench's axes remain to be tested.
        const du = column + 0.5 - u;
        const dv = row + 0.5 - v;
        const half = (c + s) / 2 + CELL_SLACK;
        if (
          Math.abs(du * cos[i] - dv * sin[i]) <= along + half &&
          Math.abs(du * sin[i] + dv * cos[i]) <= across + half
        ) {
          cells.push([row, column]);
        }
      }
    }
    return cells;
  }
}
