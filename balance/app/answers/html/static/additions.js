/* Draw regions to which matter may be added, and the lumps in them. */

const LUMP = "#8a5a00";

const additions = data("additions").map((one) =>
  ({...one, part: scene.bodies.find((body) => body.name === one.name).part}));

stage.points.push(...additions.flatMap(({part, paths}) =>
  paths.flatMap((path) => path.map((point) => [part, point]))));

/** Traces of the regions, and of the lumps where the design is shown. */
const added = (H, designed) => {
  const borders = new Lines(), lumps = new Labels(), balls = new Mesh(), grains = new Labels();
  for (const {name, part, paths, lumps: own, filled} of additions) {
    for (const path of paths) borders.path(part, path, `region of ${plain(name)}`);
    for (const {mass, at, radius} of designed ? own : []) {
      const text = `${plain(name)}, ${Number(mass.toPrecision(3))} kg added`;
      lumps.put(part, at, text);
      if (radius) balls.sphere(part, at, radius, text);
    }
    for (const at of designed ? filled : []) grains.put(part, at, plain(name));
  }
  return [
    lines("regions", borders, H, {color: GHOST, width: 2}),
    marks("filled", grains, H, "circle", 2, LUMP),
    mesh("steel", balls, H, LUMP, 0.55),
    marks("lumps", lumps, H, "circle", 3, LUMP),
  ];
};

const addedLegend = (svg) => [
  [svg(`<ellipse cx="17" cy="8" rx="15" ry="7" class="ghost solid"/>`),
    "region for added matter"],
  [svg(`<circle cx="17" cy="8" r="5" class="lump full"/>`), "added matter; point masses as balls of steel"],
];
