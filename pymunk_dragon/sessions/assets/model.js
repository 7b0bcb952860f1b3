// The scene as the view and the painter need it: benches and their sizes, or any other bodies.

const SMALLEST_SIZE = 1e-3; // m: least size of a shape, for the largest zoom

class Model {
  constructor(scene) {
    const { dragon, bodies, field } = scene;
    this.scene = scene;
    this.field = field;
    this.benches = dragon ? dragon.lengths.length : 0;
    this.lengths = dragon?.lengths ?? [];
    this.spacings = dragon?.spacings ?? [];
    const shapes = bodies.flatMap((body) => body.shapes);
    this.widths = dragon?.widths ?? [Math.min(...field.size) / 20];
    this.narrowest = Math.max(SMALLEST_SIZE, Math.min(...this.widths, ...shapes.map(thicknessOf)));
    this.joints = scene.joints.map((joint, number) => ({ ...joint, number }));
  }

  can(ability) {
    return this.scene.abilities.includes(ability);
  }

  // Ends of a joint in the world: its anchors on both bodies.
  ends({ a, b, anchor_a, anchor_b }, poses) {
    return [placed(poses, a, anchor_a), placed(poses, b, anchor_b)];
  }

  // A bench as one shape in its own coordinates.
  benchShape(i) {
    const along = this.lengths[i] / 2, across = this.widths[i] / 2;
    return { polygon: [-along, -across, along, -across, along, across, -along, across], radius: 0 };
  }

  shapesOf(i) {
    return i < this.benches ? [this.benchShape(i)] : this.scene.bodies[i].shapes;
  }

  // The dynamic body within `slip` m of a point, and its point closest to that point; null if there is none.
  bodyAt(point, slip, poses) {
    let found = null;
    this.scene.bodies.forEach(({ type }, body) => {
      if (type !== "dynamic" || found?.distance === 0) return;
      for (const shape of this.shapesOf(body)) {
        const near = nearestOnShape(shape, localPoint(poses, body, point));
        if (near.distance > slip || near.distance >= (found?.distance ?? Infinity)) continue;
        found = { body, distance: near.distance, point: placed(poses, body, near.point) };
      }
    });
    return found;
  }

  // The joint with an end within `slip` m of a point, or whose line passes so close; null if there is none.
  jointAt(point, slip, poses, cuts) {
    let found = null, nearest = slip;
    for (const joint of this.joints) {
      if (cuts.has(joint.number)) continue;
      const [one, two] = this.ends(joint, poses);
      const { distance } = nearestOnSegment(one, two, point);
      if (distance <= nearest) [found, nearest] = [joint, distance];
    }
    return found;
  }
}
