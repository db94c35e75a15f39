/* Draw masses as ellipsoids on the bodies: of the design, and of the file. */

const COLOURS = {designed: PLUS, given: MINUS};
const STATES = Object.keys(COLOURS);

/** Ellipsoids of one state: part, name and shape of each body. */
const bulks = Object.fromEntries(STATES.map((state) => [state, data("masses")
  .filter((body) => body[state])
  .map((body) => ({part: scene.bodies.find((b) => b.name === body.name).part, name: plain(body.name), ...body[state]}))]));
const weight = ({name, mass}) => `${name}, ${Number(mass.toPrecision(3))} kg`;

stage.points.push(...STATES.flatMap((state) => bulks[state].flatMap(({part, centre, axes}) =>
  axes.flatMap((axis) => [1, -1].map((s) => [part, add(centre, axis, s)])))));

/** Surfaces, outlines, centres of mass and values of the ellipsoids of one state. */
function shapes(state) {
  const surface = new Mesh(), outlines = new Lines(), centres = new Labels(), values = new Labels();
  for (const solid of bulks[state]) {
    const {part, centre, axes} = solid, text = weight(solid);
    const at = (x, y, z) => add(add(add(centre, axes[0], x), axes[1], y), axes[2], z);
    const turn = (count) => Array.from({length: count}, (_, k) => 2 * Math.PI * k / count);
    surface.grid(part, Array.from({length: 17}, (_, r) => {
      const a = Math.PI * r / 16;
      return turn(32).map((b) => at(Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)));
    }), text);
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) {
      outlines.path(part, [...turn(48), 0].map((t) => {
        const x = [0, 0, 0];
        x[i] = Math.cos(t); x[j] = Math.sin(t);
        return at(...x);
      }), text);
    }
    centres.put(part, centre, text);
    values.put(part, centre, text);
  }
  return {surface, outlines, centres, values};
}
