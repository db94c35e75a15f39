/* Draw regions to which matter may be added, and the lumps in them. */

const LUMP = "#8a5a00";

const additions = data("additions").map((one) =>
  ({...one, part: scene.bodies.find((body) => body.name === one.name).part}));

stage.points.push(...additions.flatMap(({part, paths}) =>
  paths.flatMap((path) => path.map((point) => [part, point]))));

const drawnAdditions = {borders: new Lines(), lumps: new Labels(), matter: new Mesh()};
for (const {name, part, paths, lumps, surface} of additions) {
  for (const path of paths) drawnAdditions.borders.path(part, path, `region of ${plain(name)}`);
  for (const {mass, at, radius} of lumps) {
    const text = `${plain(name)}, ${Number(mass.toPrecision(4))} kg added`;
    drawnAdditions.lumps.put(part, at, text);
    if (radius) drawnAdditions.matter.sphere(part, at, radius, text);
    if (surface) drawnAdditions.matter.surface(part, surface, text);
  }
}

/** Traces of the regions, and of the matter in them where the design is shown. */
const added = (H, designed) => {
  const {borders, lumps, matter} = drawnAdditions;
  return [
    lines("regions", borders, H, {color: GHOST, width: 2}),
    mesh("matter", designed ? matter : new Mesh(), H, LUMP, 0.7),
    marks("lumps", designed ? lumps : new Labels(), H, "circle", 3, LUMP),
  ];
};

const addedLegend = (svg) => [
  [svg(`<ellipse cx="17" cy="8" rx="15" ry="7" class="ghost solid"/>`),
    "region for added matter"],
  [svg(`<circle cx="17" cy="8" r="5" class="lump full"/>`), "added matter; point masses as balls of steel"],
];
