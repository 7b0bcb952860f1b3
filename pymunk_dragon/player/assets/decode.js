// From the page's data blocks to numbers. The other side of packing.py.

const block = (id) => document.getElementById(id).textContent;

async function inflated(base64) {
  const text = atob(base64.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Places counted in steps from an origin: `counts` by frame, point and coordinate.
async function unpacked({ frames, points, origin, step }, base64) {
  const bytes = await inflated(base64);
  const tracks = 2 * points;
  const total = frames * tracks;
  const counts = new Int32Array(total);
  for (let track = 0; track < tracks; track++) {
    let third = 0, second = 0, first = 0;
    for (let frame = 0; frame < frames; frame++) {
      const i = track * frames + frame;
      const folded = bytes[i] | (bytes[total + i] << 8) | (bytes[2 * total + i] << 16) | (bytes[3 * total + i] << 24);
      third = (third + ((folded >>> 1) ^ -(folded & 1))) | 0;
      second = (second + third) | 0;
      first = (first + second) | 0;
      counts[frame * tracks + track] = first;
    }
  }
  return { frames, points, origin, step, counts };
}

// Where each of the points is in a frame: x and y in turn, in m.
function placesIn(packed, frame) {
  const { points, origin, step, counts } = packed;
  const places = new Float64Array(2 * points);
  const begin = frame * 2 * points;
  for (let i = 0; i < places.length; i++) places[i] = origin[i & 1] + step * counts[begin + i];
  return places;
}
