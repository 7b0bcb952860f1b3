// Decodes the server's binary frames: little endian, a header, and arrays of 32-bit numbers.

const COUNTS = 6; // numbers of 32 bits at the beginning
const CLOCKS = 5; // numbers of 64 bits after them
const HELD = 1; // flag: a body is held
const CONTACT_SIZE = 7; // numbers of a contact

function decodeFrame(buffer) {
  const header = new DataView(buffer);
  const counts = Array.from({ length: COUNTS }, (_, i) => header.getUint32(4 * i, true));
  const clocks = Array.from({ length: CLOCKS }, (_, i) => header.getFloat64(4 * COUNTS + 8 * i, true));
  const [generation, bodies, joints, contacts, exact, flags] = counts;
  const [step, time, marchTime, rate, stepTime] = clocks;
  let offset = 4 * COUNTS + 8 * CLOCKS;
  const take = (count) => {
    const numbers = new Float32Array(buffer, offset, count);
    offset += numbers.byteLength;
    return numbers;
  };
  const [body, u, v, x, y] = take(5);
  return {
    generation, step, time, marchTime, rate, stepTime,
    held: flags & HELD ? { body, anchor: [u, v], target: [x, y] } : null,
    poses: take(3 * bodies),
    forces: take(joints),
    exact: take(3 * exact),
    errors: take(exact),
    contacts: take(CONTACT_SIZE * contacts),
  };
}

// Poses as columns, with cosines and sines.
function posesOf(packed) {
  const count = packed.length / 3;
  const poses = Object.fromEntries(["x", "y", "angle", "cos", "sin"].map((name) => [name, new Float64Array(count)]));
  for (let i = 0; i < count; i++) {
    poses.x[i] = packed[3 * i];
    poses.y[i] = packed[3 * i + 1];
    poses.angle[i] = packed[3 * i + 2];
    poses.cos[i] = Math.cos(poses.angle[i]);
    poses.sin[i] = Math.sin(poses.angle[i]);
  }
  return poses;
}

// A point of body `i` in the world, m; body -1 is the world itself.
function placed(poses, i, [u, v]) {
  if (i < 0) return [u, v];
  const { x, y, cos, sin } = poses;
  return [x[i] + u * cos[i] - v * sin[i], y[i] + u * sin[i] + v * cos[i]];
}

// The contacts of a frame as objects, one at a time.
function* contactsOf({ contacts }) {
  for (let k = 0; k < contacts.length; k += CONTACT_SIZE) {
    const [a, b, x, y, nx, ny, impulse] = contacts.subarray(k, k + CONTACT_SIZE);
    yield { bodies: [a, b], point: [x, y], normal: [nx, ny], impulse };
  }
}
