/* Draw masses as solids on the bodies: of the design, and of the file. */

const COLOURS = {designed: PLUS, given: MINUS};
const STATES = Object.keys(COLOURS);

/** Solids of one state: part, name and shape of each body. */
const bulks = Object.fromEntries(STATES.map((state) => [state, data("masses")
  .filter((body) => body[state])
  .map((body) => ({part: scene.bodies.find((b) => b.name === body.name).part, name: plain(body.name), ...body[state]}))]));
const weight = ({name, mass}) => `${name}, ${Number(mass.toPrecision(3))} kg`;

/** Points of a ring around the last axis: a circle, or the corners of a square. */
const ring = (shape, count) => shape === "block" ? [[1, 1], [-1, 1], [-1, -1], [1, -1]]
  : Array.from({length: count}, (_, k) => [Math.cos(2 * Math.PI * k / count), Math.sin(2 * Math.PI * k / count)]);
/** Widths and heights of the rings of a surface. */
const profile = (shape) => shape === "ellipsoid"
  ? Array.from({length: 17}, (_, r) => [Math.sin(Math.PI * r / 16), Math.cos(Math.PI * r / 16)])
  : [[0, 1], [1, 1], [1, -1], [0, -1]];
const placer = ({centre, axes}) => (x, y, z) => add(add(add(centre, axes[0], x), axes[1], y), axes[2], z);

stage.points.push(...STATES.flatMap((state) => bulks[state].flatMap((solid) => {
  const at = placer(solid);
  return profile(solid.shape).flatMap(([wide, z]) => ring(solid.shape, 12).map(([x, y]) => [solid.part, at(wide * x, wide * y, z)]));
})));

/** Lines of a solid in units of its axes: three ellipses, or both ends and sides. */
function edges(shape) {
  const around = ring(shape, 48), closed = [...around, around[0]];
  if (shape === "ellipsoid") return [[0, 1], [0, 2], [1, 2]].map(([i, j]) => closed.map(([a, b]) => {
    const p = [0, 0, 0];
    p[i] = a; p[j] = b;
    return p;
  }));
  const sides = around.filter((_, k) => k % (around.length / 4) === 0);
  return [...[1, -1].map((z) => closed.map(([x, y]) => [x, y, z])), ...sides.map(([x, y]) => [[x, y, 1], [x, y, -1]])];
}

/** Surfaces, outlines, centres of mass and values of the solids of one state. */
function shapes(state) {
  const surface = new Mesh(), outlines = new Lines(), centres = new Labels(), values = new Labels();
  for (const solid of bulks[state]) {
    const {part, centre, shape} = solid, text = weight(solid), at = placer(solid);
    surface.grid(part, profile(shape).map(([wide, z]) => ring(shape, 32).map(([x, y]) => at(wide * x, wide * y, z))), text);
    for (const line of edges(shape)) outlines.path(part, line.map((p) => at(...p)), text);
    centres.put(part, centre, text);
    values.put(part, centre, text);
  }
  return {surface, outlines, centres, values};
}
