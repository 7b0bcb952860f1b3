// Decodes the server's binary frames: the length of a JSON header, the header, and arrays of 32-bit numbers.

const CONTACT_SIZE = 5; // numbers of a contact: point, normal, impulse; less than 0 without an arrow
const JOINT_SIZE = 5; // numbers of a joint: two ends and the force
const CALL_HEAD = 7; // numbers of a call before its points

function decodeFrame(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const frame = { ...header, poses: [], exact: [], errors: [], forces: [], contacts: [], joints: [], calls: [] };
  let offset = 4 + length;
  for (const [name, size] of Object.entries(header.sizes)) {
    frame[name] = new Float32Array(buffer, offset, size);
    offset += frame[name].byteLength;
  }
  frame.calls = callsOf(frame);
  return frame;
}

// What Pymunk draws, as objects: kind, points, radius, angle, colours, and whether the body is dynamic.
function callsOf({ calls, colours = [] }) {
  const texts = colours.map(([r, g, b, a]) => `rgba(${r}, ${g}, ${b}, ${a / 255})`);
  const found = [];
  for (let k = 0; k < calls.length;) {
    const count = calls[k + 1], points = [];
    for (let p = k + CALL_HEAD; p < k + CALL_HEAD + 2 * count; p += 2) points.push([calls[p], calls[p + 1]]);
    found.push({
      kind: KINDS[calls[k]], points, radius: calls[k + 2], angle: calls[k + 3],
      fill: texts[calls[k + 4]], outline: texts[calls[k + 5]], moves: calls[k + 6] === 1,
      opaque: colours[calls[k + 4]][3] >= 255,
    });
    k += CALL_HEAD + 2 * count;
  }
  return found;
}

const KINDS = ["circle", "segment", "polygon", "line", "dot"];

const posesOf = (packed) => posesFrom(packed.length / 3, (i) => packed.subarray(3 * i, 3 * i + 3));

// Rows of an array of numbers, as arrays.
function* rowsOf(numbers, size) {
  for (let k = 0; k < numbers.length; k += size) yield numbers.subarray(k, k + size);
}
