// The exact model's handles: offsets from those of the run,
// in the frames in which the model has a state.

const MAGNIFIED_BELOW = 1; // pixels: the ghost of a smaller error is magnified ...
const MAGNIFIED_TO = 3; // pixels: ... to at least this, and to
const MAGNIFIED_SHARE = 0.3; // of the width of a bench

class Exact {
  /** @param {Recording} recording @param {Packed} offsets */
  constructor(recording, offsets) {
    this.recording = recording;
    this.offsets = offsets;
    this.resolution = offsets.step / Math.SQRT2; // m: the error of a position error
  }

  // Offsets in m of all handles at a time, x0, y0, x1, y1, ..., linear between frames;
  // null if unknown.
  /** @type {(time: number) => Float64Array | null} */
  offsetsAt(time) {
    const { before, after, share } = this.recording.between(time);
    const last = share > 0 ? after : before;
    if (last >= this.offsets.frames) return null;
    const one = vectorsIn(this.offsets, before);
    if (share === 0) return one;
    const two = vectorsIn(this.offsets, after);
    return one.map((value, k) => value + share * (two[k] - value));
  }

  // Position errors in m of all benches: of the worse of two holes. Null if unknown.
  /** @type {(time: number) => number[] | null} */
  errorsAt(time) {
    const offsets = this.offsetsAt(time);
    if (!offsets) return null;
    const lengths = Array.from(rowsOf(offsets, 2), ([x, y]) => Math.hypot(x, y));
    return lengths.slice(1).map((length, i) => Math.max(lengths[i], length));
  }

  // Poses of the exact benches beside `benches` at `time`,
  // with their distances from these magnified; null if unknown.
  /**
   * @type {(
   *   benches: Benches<DrawnModel>,
   *   time: number,
   *   magnification?: number,
   * ) => Poses | null}
   */
  posesBeside(benches, time, magnification = 1) {
    const offsets = this.offsetsAt(time);
    if (!offsets) return null;
    return posesBetween(
      benches.handles.map(([x, y], i) => [
        x + magnification * offsets[2 * i],
        y + magnification * offsets[2 * i + 1],
      ]),
    );
  }
}

// The factor 1, 2 or 5 times a power of ten by which an error is magnified,
// in a view with benches of a width; pixels.
/** @type {(error: number, width: number) => number} */
function magnificationOf(error, width) {
  if (error >= MAGNIFIED_BELOW || error === 0) return 1;
  return roundUp(Math.max(MAGNIFIED_TO, MAGNIFIED_SHARE * width) / error);
}
