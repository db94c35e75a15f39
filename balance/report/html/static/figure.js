/* Figure 1: draw the linkage and its overlays at a pose with Plotly. */

const parts = linkage();
const rest = scene.parts.map(() => null);
let pose = rest;
/* Overlays: functions from a pose to traces. */
const layers = [];

function coordinates(vertices, H) {
  const x = [], y = [], z = [], text = [];
  for (const vertex of vertices) {
    const p = vertex === null ? [null, null, null] : moved(H[vertex[0]], vertex[1]);
    x.push(p[0]); y.push(p[1]); z.push(p[2]); text.push(vertex === null ? "" : vertex[2]);
  }
  return {x, y, z, text};
}

const FONT = 'Charter, "Bitstream Charter", "Liberation Serif", Georgia, serif';
const lines = (name, lines, H, line, hover) => ({
  type: "scatter3d", mode: "lines", name, ...coordinates(lines.vertices, H), line,
  hoverinfo: hover ? "text" : "skip", connectgaps: false, visible: lines.vertices.length > 0,
});
const mesh = (name, mesh, H, color, opacity = 1) => {
  const {x, y, z, text} = coordinates(mesh.vertices, H);
  const [i, j, k] = [0, 1, 2].map((n) => mesh.faces.map((face) => face[n]));
  return {
    type: "mesh3d", name, x, y, z, i, j, k, text, color, opacity, hoverinfo: "text",
    flatshading: false, visible: mesh.faces.length > 0,
    lighting: {ambient: color === STRIPE ? 0.95 : 0.72, diffuse: 0.5, specular: 0.12, roughness: 0.7},
  };
};
const texts = (name, labels, H, color, size, position = "middle center") => ({
  type: "scatter3d", mode: "text", name, ...coordinates(labels.vertices, H), hoverinfo: "skip",
  textposition: position, textfont: {family: FONT, size, color}, visible: labels.vertices.length > 0,
});
const marks = (name, labels, H, symbol, size, fill = "#fff") => ({
  type: "scatter3d", mode: "markers", name, ...coordinates(labels.vertices, H), hoverinfo: "text",
  marker: {symbol, size, color: fill, line: {color: INK, width: 2}}, visible: labels.vertices.length > 0,
});

/* Plotly sets a wrong size for texts that first appear in an update: draw all texts first. */
const everyText = (() => {
  const found = new Labels();
  const names = [...parts.names.vertices, ...parts.joints.vertices].map((vertex) => vertex[2]);
  for (const text of new Set([...overlay.texts, ...names])) found.put(0, centre, text);
  return found;
})();

/** Names to show: all if there are few, otherwise those of the overlay. */
function named() {
  const few = scene.bodies.length + parts.joints.vertices.length <= 10;
  const bodies = new Labels(), joints = new Labels();
  bodies.vertices = parts.names.vertices.filter((v) => few || overlay.bodies.includes(v[2]));
  joints.vertices = parts.joints.vertices.filter((v) =>
    few || v[3].some((name) => overlay.joints.includes(name)));
  return {bodies, joints};
}

function traces() {
  const names = named(), triad = compass();
  return [
    lines("reference", pose === rest ? new Lines() : parts.links, rest, {color: GHOST, width: 3, dash: "dash"}),
    mesh("base", parts.base, pose, LINK, 0.1),
    lines("rails", parts.rails, pose, {color: LINK, width: 4}, true),
    lines("axes", parts.axes, pose, {color: SOFT, width: 2, dash: "dashdot"}),
    lines("ground", parts.ground, pose, {color: INK, width: 3}),
    mesh("plates", parts.plates, pose, LINK, 0.28),
    lines("links", parts.links, pose, {color: LINK, width: 7}, true),
    marks("joints", parts.marks.turning, pose, "circle", 5.5),
    marks("balls", parts.marks.balls, pose, "circle", 6.5, SOFT),
    marks("slides", parts.marks.sliding, pose, "square", 6),
    texts("bodies", names.bodies, pose, SOFT, 13, names.bodies.vertices.map((v) => v[3])),
    texts("joint names", names.joints, pose, SOFT, 12),
    ...overlay.traces(pose),
    ...layers.flatMap((layer) => layer(pose)),
    texts("all", everyText, rest, "rgba(0,0,0,0)", 12),
    lines("compass", triad.arms, rest, {color: SOFT, width: 3}),
    texts("scale", triad.labels, rest, SOFT, 12),
  ];
}

/** Corners, joints and outer points of the overlay in all poses. */
const cloud = [rest, ...scene.columns.flatMap((column) => column.poses)].flatMap((H) => [
  ...scene.parts.flatMap((part, p) => part.corners.map((corner) => moved(H[p], corner))),
  ...scene.joints.flatMap((joint) => joint.parts.map((p) => moved(H[p], joint.point))),
  ...overlay.points.map(([p, point]) => moved(H[p], point)),
]);
const ends = (axis, points) => points.reduce(
  ([low, high], p) => [Math.min(low, dot(p, axis)), Math.max(high, dot(p, axis))], [Infinity, -Infinity]);

/** Inertial axes of a round length, below and to the left of all poses. */
function compass() {
  const power = 10 ** Math.floor(Math.log10(0.16 * size));
  const long = [5, 2, 1].map((f) => f * power).find((l) => l <= 0.16 * size * 1.0001);
  const arms = new Lines(), labels = new Labels();
  const corner = [vertical, horizontal, depth].map((axis) => scaled(axis, ends(axis, cloud)[0]))
    .reduce((a, b) => add(a, b));
  const origin = add(add(corner, vertical, -0.12 * size), horizontal, -0.05 * size);
  let first = true;
  ["x", "y", "z"].forEach((name, i) => {
    const axis = [0, 1, 2].map((k) => k === i ? 1 : 0);
    if (scene.planar && Math.abs(dot(axis, normal)) > 0.999) return;
    const tip = add(origin, axis, long);
    arms.path(0, [origin, tip]);
    labels.put(0, add(tip, axis, (first ? 0.09 : 0.035) * size), first ? `${name}, ${number(long)} m` : name);
    first = false;
  });
  return {arms, labels};
}

/** Width of the drawing over its height. */
function frame() {
  const plot = byId("plot");
  return (plot.clientWidth || 8) / (plot.clientHeight || 5);
}

const layout = (() => {
  const seen = [...cloud, ...compass().labels.vertices.map((vertex) => vertex[1])];
  const limits = [0, 1, 2].map((i) => ends([0, 1, 2].map((k) => k === i ? 1 : 0), seen));
  /* Momentum lines extend beyond the linkage; the box clips them. */
  const low = limits.map((l) => l[0] - 1.5 * size), high = limits.map((l) => l[1] + 1.5 * size);
  const span = high.map((x, i) => x - low[i]), widest = Math.max(...span);
  const middle = scaled(add(low, high), 0.5), margin = 0.07 * size / widest;
  /* Projected coordinates in units of the drawing: right and up. */
  const right = unit(cross(vertical, sight)), top = cross(sight, right);
  const views = seen.map((p) => {
    const at = scaled(add(p, middle, -1), 1 / widest);
    return [dot(at, right), dot(at, top), 0];
  });
  const [[x0, x1], [y0, y1]] = [[1, 0, 0], [0, 1, 0]].map((axis) => ends(axis, views));
  const aim = [(x0 + x1) / 2, (y0 + y1) / 2], aspect = frame();
  const reach = ([x, y]) => margin + Math.max(Math.abs(y - aim[1]), Math.abs(x - aim[0]) / aspect);
  /* In orthographic projection Plotly shows one unit up and one unit down. */
  const zoom = 1 / views.reduce((most, view) => Math.max(most, reach(view)), 0);
  const centre = add(scaled(right, zoom * aim[0]), top, zoom * aim[1]);
  const xyz = ([x, y, z]) => ({x, y, z});
  const hidden = (i) => ({visible: false, range: [low[i], high[i]], autorange: false});
  return {
    margin: {l: 0, r: 0, t: 0, b: 0}, showlegend: false, uirevision: "kept",
    paper_bgcolor: "#fff", hoverlabel: {font: {family: FONT}, bgcolor: "#fff"},
    scene: {
      xaxis: hidden(0), yaxis: hidden(1), zaxis: hidden(2), bgcolor: "#fff",
      aspectmode: "manual", aspectratio: xyz(scaled(span, zoom / widest)),
      dragmode: scene.planar ? "pan" : "orbit",
      camera: {
        eye: xyz(add(centre, sight, 3)), up: xyz(vertical), center: xyz(centre),
        projection: {type: "orthographic"},
      },
    },
  };
})();
const config = {
  displaylogo: false, responsive: true, scrollZoom: false,
  modeBarButtons: [["toImage", "resetCameraDefault3d"]],
};

let drawing = null, again = false, later = 0;
function draw() {
  if (drawing) { again = true; return; }
  byId("plot").setAttribute("aria-busy", "true");
  drawing = Plotly.react("plot", traces(), layout, config).then(() => {
    drawing = null;
    if (again) { again = false; draw(); return; }
    byId("plot").setAttribute("aria-busy", "false");
    clearTimeout(later);
    later = setTimeout(picture, 1000);
  });
}

/** Print an image in place of the canvas, which printers cannot show. */
function picture() {
  if (!byId("plot").clientWidth) return;
  Plotly.toImage("plot", {format: "png", width: 640, height: Math.round(640 / frame()), scale: 3}).then((url) => {
    byId("paper").src = url;
  });
}
