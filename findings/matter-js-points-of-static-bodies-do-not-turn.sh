#!/usr/bin/env bash
# matter.js: the point of a constraint on a static body does not turn with the body.
#
# Expected: `pointA` is a point of `bodyA`, so what hangs from it follows when the body is turned,
# as it does when the body is moved.
# Seen: a ball that hangs from the end of a wheel's spoke stays below the old place of that end
# after the wheel, a static body, was turned by a right angle; it is 141 pixels away from the new
# one. If the wheel is moved as well, the ball goes along. A body that is not static turns its
# point.
# Versions: matter-js 0.20.0, node 20.20.2, Linux on x86-64.
# Source: measurement; and the code of matter.js: `Constraint.solve` turns the point by the change
# of the body's angle, but only "if (bodyA && !bodyA.isStatic)".
# Why it matters: cranks, doors and gears that a program turns by `Body.setAngle` or `Body.rotate`
# do not pull what is fixed to them, without an error. Give the constraint a point of the world
# instead of the body, and move that.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
npm install --silent --no-audit --no-fund --prefix "$folder" matter-js@0.20.0

cd "$folder"
cat >wheel.mjs <<'PROGRAM'
import Matter from "matter-js";

const { Bodies, Body, Composite, Constraint, Engine } = Matter;
const SPOKE = 100;

/** Distance of the ball from the end of the spoke after the wheel was changed, pixels. */
function distance(isStatic, change) {
  const engine = Engine.create({ constraintIterations: 20, gravity: { x: 0, y: 0 } });
  const options = { collisionFilter: { mask: 0 } };
  const wheel = Bodies.circle(0, 0, 150, { isStatic, density: 10, ...options });
  const ball = Bodies.circle(SPOKE, 0, 5, options);
  const pointA = { x: SPOKE, y: 0 };
  const joint = { bodyA: wheel, pointA, bodyB: ball, length: 0, stiffness: 1 };
  Composite.add(engine.world, [wheel, ball, Constraint.create(joint)]);
  change(wheel);
  for (let step = 0; step < 600; step++) Engine.update(engine, 16);
  const { x, y } = wheel.position;
  const end = [x + SPOKE * Math.cos(wheel.angle), y + SPOKE * Math.sin(wheel.angle)];
  return Math.hypot(ball.position.x - end[0], ball.position.y - end[1]);
}

const turn = (wheel) => Body.setAngle(wheel, Math.PI / 2);
const move = (wheel) => Body.setPosition(wheel, { x: 30, y: 40 });
const found = [distance(true, turn), distance(true, move), distance(false, turn)];
console.log(`static wheel, turned: the ball is ${found[0].toFixed(1)} pixels from the spoke`);
console.log(`static wheel, moved: ${found[1].toFixed(1)}`);
console.log(`wheel that is not static, turned: ${found[2].toFixed(1)}`);
const near = found[1] < 1 && found[2] < 1;
if (!(near && Math.abs(found[0] - SPOKE * Math.SQRT2) < 1)) {
  throw new Error("this is no longer what was found");
}
PROGRAM
node wheel.mjs
