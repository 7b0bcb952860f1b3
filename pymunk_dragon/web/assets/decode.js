// Unpacks the numbers in the page's data blocks, which data.py packs.

/** @type {(id: string) => string} */
const block = (id) => element(id).textContent ?? "";

/** @type {(base64: string) => Promise<Uint8Array>} */
async function inflate(base64) {
  const text = atob(base64.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Vectors as counts of steps from an origin, by frame, point and component.
/** @type {(packing: Packing, base64: string) => Promise<Packed>} */
async function unpack({ frames, points, origin, step, order }, base64) {
  const bytes = await inflate(base64);
  const tracks = 2 * points;
  const total = frames * tracks;
  const counts = new Int32Array(total);
  for (let track = 0; track < tracks; track++) {
    // Differences of every order, the highest first; the last entry is the count.
    const sums = new Int32Array(order + 1);
    for (let frame = 0; frame < frames; frame++) {
      const i = track * frames + frame;
      const folded =
        bytes[i] |
        (bytes[total + i] << 8) |
        (bytes[2 * total + i] << 16) |
        (bytes[3 * total + i] << 24);
      sums[0] = (folded >>> 1) ^ -(folded & 1);
      for (let k = 1; k <= order; k++) sums[k] += sums[k - 1];
      counts[frame * tracks + track] = sums[order];
    }
  }
  return { frames, points, origin, step, counts };
}

// Vectors of all points, x0, y0, x1, y1, ..., in m or m/s: of all frames, and in a frame.
/** @type {(packed: { origin: Numbers, step: number }, counts: Int32Array) => Float64Array} */
const vectorsOf = ({ origin, step }, counts) =>
  Float64Array.from(counts, (count, i) => origin[i & 1] + step * count);

/** @type {(packed: Packed, frame: number) => Float64Array} */
function vectorsIn(packed, frame) {
  const size = 2 * packed.points;
  return vectorsOf(packed, packed.counts.subarray(frame * size, (frame + 1) * size));
}
