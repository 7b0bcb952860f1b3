#!/usr/bin/env bash
# matter.js: a rod that hangs from its end swings too slowly, and the more so the shorter it is in
# pixels.
#
# Expected: a thin rod of length L that swings a little about its end has the period 2 pi sqrt(2 L
# / (3 g)), which depends on no unit of length; small steps without air friction come close to it.
# Seen: 2147 ms in place of 1622 ms for a rod of 100 pixels. With a quarter of its moment of
# inertia it has the period of the formula. But a rod of length 1, with gravity in proportion,
# then takes 3245 ms. Smaller steps and more iterations change nothing.
# Versions: matter-js 0.20.0, node 20.20.2, Linux on x86-64.
# Source: measurement; and the code of matter.js. A body made of vertices gets four times its
# moment of inertia (`Body._inertiaScale`), and (4 / 12 + 1 / 4) / (1 / 3) is the square of 2147 /
# 1622. And `Constraint.solve` divides the turn of a body by the sum of its inverse mass and its
# inverse inertia, which are numbers of different units, in place of the inverse mass. That is
# hardly less for a rod of 100 pixels, and 13 times as much for a rod of length 1.
# Why it matters: chains, ragdolls and pendulums move otherwise than in any other engine, though
# their joints are closed. Give bodies their own inertia, work in pixels, not in metres, and lower
# the stiffness: a chain of rods with their own inertia flies apart at 1, and holds at 0.4.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
npm install --silent --no-audit --no-fund --prefix "$folder" matter-js@0.20.0

cd "$folder"
cat >swing.mjs <<'PROGRAM'
import Matter from "matter-js";

const { Bodies, Body, Composite, Constraint, Engine } = Matter;
// Length of the rod over the gravity, ms squared: 100 pixels over that of matter.js.
const RATIO = 100 / 0.001;

/** Period of a rod of a length that begins at rest, 0.05 rad from its lowest position, ms. */
function period(length, scale, step, iterations) {
  const gravity = { x: 0, y: 1, scale: length / RATIO };
  const engine = Engine.create({ constraintIterations: iterations, gravity });
  const tilt = Math.PI / 2 - 0.05;
  const [x, y] = [Math.cos(tilt), Math.sin(tilt)].map((share) => (share * length) / 2);
  const rod = Bodies.rectangle(x, y, length, length / 100, { angle: tilt, frictionAir: 0 });
  Body.setInertia(rod, rod.inertia * scale);
  const [pointA, pointB] = [{ x: 0, y: 0 }, { x: -x, y: -y }];
  const hinge = { pointA, bodyB: rod, pointB, length: 0, stiffness: 1 };
  Composite.add(engine.world, [rod, Constraint.create(hinge)]);
  const crossings = [];
  let [time, last] = [0, rod.position.x];
  while (crossings.length < 5) {
    Engine.update(engine, step);
    time += step;
    if (last > 0 !== rod.position.x > 0) crossings.push(time);
    last = rod.position.x;
  }
  return (crossings[4] - crossings[0]) / 2;
}

const right = 2 * Math.PI * Math.sqrt((2 / 3) * RATIO);
console.log(`formula: ${right.toFixed(0)} ms`);
const found = [[100, 1], [100, 1 / 4], [1, 1 / 4]].map(([length, scale]) => {
  const periods = [[4, 2], [1, 2], [1, 20]].map((settings) => period(length, scale, ...settings));
  const shown = periods.map(Math.round).join(", ");
  console.log(`length ${length}, ${scale} of its inertia: ${shown} ms`);
  return periods;
});
const near = (value, wanted) => Math.abs(value / wanted - 1) < 0.003;
const wanted = [Math.sqrt(1.75), 1, 2].map((factor) => factor * right);
const same = found.every((periods, row) => periods.every((each) => near(each, wanted[row])));
if (!same) throw new Error("this is no longer what was found");
PROGRAM
node swing.mjs
