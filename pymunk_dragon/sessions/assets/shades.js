// Colours of bodies, forces and charts.

// Pymunk's debug colours: of static shapes, of outlines and of collision points.
const STATIC_COLOUR = "#95a5a6";
const OUTLINE_COLOUR = "#2c3e50";
const COLLISION_COLOUR = "#e74c3c";
// Forces from small to large.
const RAMP = ["#ffffcc", "#fed976", "#fd8d3c", "#e31a1c", "#800026"];
const SHADES = 32; // colours of discs: those of one shade share a path

// A mixture of two colours: the second has the weight `share`.
const mixed = (one, two, share) => `color-mix(in srgb, ${one}, ${two} ${100 * share}%)`;

const SHADE_COLOURS = Array.from({ length: SHADES }, (_, shade) => {
  const place = shade / (SHADES - 1) * (RAMP.length - 1), k = Math.min(Math.floor(place), RAMP.length - 2);
  return mixed(RAMP[k], RAMP[k + 1], place - k);
});
