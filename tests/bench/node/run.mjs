/**
 * Plays a scene of `tests/bench/adapters` in an engine: `node run.mjs ENGINE [SCENE POSES]`.
 * It writes the poses to a file, and the rest as a line of JSON to the standard output; without the
 * two files, only the length of the engine's steps.
 */
import { readFileSync, writeFileSync } from "node:fs";

const [module, given, found] = process.argv.slice(2);
const { Engine, about } = await import(`./${module}.mjs`);

/** The scene in a file: a line of JSON, and the numbers of its arrays. */
function readScene(path) {
  const file = readFileSync(path);
  const end = file.indexOf("\n");
  const scene = JSON.parse(file.toString("utf8", 0, end));
  const bytes = file.buffer.slice(file.byteOffset + end + 1, file.byteOffset + file.length);
  const numbers = new Float64Array(bytes);
  let at = 0;
  const take = (rows, columns) =>
    Array.from({ length: rows }, () => numbers.subarray(at, (at += columns)));
  const benches = scene.lengths.length;
  scene.poses = take(benches, 3);
  scene.velocities = take(benches, 3);
  scene.head = take(scene.steps + 1, 3);
  const anchors = take(scene.steps + 1, 2 * scene.anchors);
  scene.anchors = anchors.map((row) =>
    Array.from({ length: row.length / 2 }, (_, index) => [row[2 * index], row[2 * index + 1]]),
  );
  return scene;
}

/** Processor time of this process, s. */
function processorTime() {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e6;
}

/** Play the scene and write what was found. */
function play() {
  const scene = readScene(given);
  const engine = new Engine(scene);
  const poses = new Float64Array(3 * scene.poses.length * (scene.steps + 1));
  scene.poses.forEach((pose, index) => poses.set(pose, 3 * index));
  const reported = [];
  let at = 3 * scene.poses.length;
  let bare = 0;
  const begin = processorTime();
  for (let number = 1; number <= scene.steps; number++) {
    engine.move(number);
    const before = processorTime();
    engine.touched = [];
    engine.step();
    bare += processorTime() - before;
    for (const pose of engine.poses()) {
      poses.set(pose, at);
      at += 3;
    }
    for (const pair of engine.touched)
      reported.push([number, Math.min(...pair), Math.max(...pair)]);
  }
  const whole = processorTime() - begin;
  writeFileSync(found, poses);
  const { name, settings } = about;
  console.log(JSON.stringify({ name, settings, reported, bare, whole }));
}

if (given) play();
else console.log(JSON.stringify({ drives: ["head", "rails", "pinned"], ...about }));
