/* Draw a freedom of the masses as masses, arrows and rods on the bodies. */

const KINDS = {mass: ["point mass", "kg"], displacement: ["displacement", "kg m"], rod: ["rod", "kg m²"]};
const signed = (x) => (x < 0 ? "−" : "+") + String(Number(Math.abs(x).toPrecision(4)));
const vector = (v) => {
  const largest = Math.max(...v.map(Math.abs));
  return `(${v.map((x) => number(Math.abs(x) > 1e-9 * largest ? x : 0)).join(", ")})`;
};

const groups = [
  {label: "Parallel: opened by the loops", joints: [], freedoms: report.freedoms},
  ...report.transfers.map((transfer, t) => ({
    label: `Across ${scene.titles[t]}`, joints: transfer.joints, freedoms: transfer.freedoms,
  })),
].filter((group) => group.freedoms.length > 0);

/** Traces of a freedom at a pose. */
const glyphs = ({solid, stripes, strokes, open, labels}) => (H) => [
  mesh("plus", solid, H, PLUS),
  mesh("stripes", stripes, H, STRIPE),
  lines("arrows", strokes, H, {color: PLUS, width: 4}, true),
  lines("minus", open, H, {color: MINUS, width: 1.5}, true),
  texts("values", labels, H, INK, 15),
];

/** Drawing data of the primitives of a freedom. */
function drawn(freedom) {
  const solid = new Mesh(), stripes = new Mesh(), strokes = new Lines(), open = new Lines(), labels = new Labels();
  const largest = {};
  for (const p of freedom.primitives) {
    largest[p.kind] = Math.max(largest[p.kind] || 0, Math.abs(p.value));
  }
  for (const p of freedom.primitives) {
    const body = scene.bodies.find((b) => b.name === p.body), part = body.part;
    const corners = scene.parts[part].corners;
    const middle = corners.length > 1 ? mean(corners) : body.centre;
    const share = Math.max(Math.abs(p.value) / largest[p.kind], 0.05);
    const text = `${signed(p.value)} ${KINDS[p.kind][1]}, ${KINDS[p.kind][0]} on ${plain(p.body)}`;
    const alone = freedom.primitives.filter((q) => q.body === p.body).length === 1;
    const target = {part, middle, share, text, alone, plus: p.value > 0, solid, stripes, strokes, open};
    const tip = p.kind === "mass" ? drawMass(p, target)
      : p.kind === "rod" ? drawRod(p, target, corners) : drawArrow(p, target);
    labels.put(part, tip, signed(p.value));
  }
  return {solid, stripes, strokes, open, labels};
}

function drawMass(p, {part, share, text, plus, solid, open}) {
  const radius = 0.027 * size * Math.cbrt(share);
  if (plus) solid.sphere(part, p.point, radius, text);
  else {
    const r = 1.3 * radius;
    for (const t of [-0.8, 0, 0.8]) {
      open.circle(part, add(p.point, normal, r * Math.sin(t)), side, up, r * Math.cos(t));
    }
    for (let k = 0; k < 4; k++) {
      const a = Math.PI * k / 4;
      const u = add(scaled(side, Math.cos(a)), up, Math.sin(a));
      open.circle(part, p.point, u, normal, r);
    }
  }
  return p.point;
}

function drawArrow(p, {part, middle, share, text, plus, solid, strokes, open}) {
  const d = unit(p.direction), long = 0.2 * size * (0.35 + 0.65 * share);
  const toward = add(middle, p.point || middle, -1);
  const start = add(p.point || middle, unit(toward), 0.035 * size);
  const neck = add(start, d, long - 0.055 * size), tip = add(start, d, long);
  const radius = 0.019 * size;
  if (plus) {
    strokes.path(part, [start, neck], text);
    solid.turned(part, [neck, neck, tip], [0, radius, 0], d, text);
  } else {
    const [u, v] = across(d);
    for (let k = 0; k < 7; k += 2) {
      const at = (f) => add(start, add(neck, start, -1), Math.min(f / 7, 1));
      open.path(part, [at(k), at(k + 1)], text);
    }
    open.circle(part, neck, u, v, radius);
    for (let k = 0; k < 8; k++) {
      const t = 2 * Math.PI * k / 8;
      open.path(part, [add(add(neck, u, radius * Math.cos(t)), v, radius * Math.sin(t)), tip]);
    }
  }
  return tip;
}

function drawRod(p, {part, middle, share, text, alone, plus, solid, stripes, open}, corners) {
  const line = corners.length > 1 ? add(corners[1], corners[0], -1) : side;
  const d = unit(p.direction || line), here = p.point || middle;
  const long = corners.length > 1 ? Math.max(...corners.map((c) => norm(add(c, corners[0], -1)))) : size;
  const half = Math.min(0.13 * size, 0.4 * long) * (0.4 + 0.6 * share), count = 9;
  const radius = Math.min(0.0125 * size, 0.14 * half);
  const [u, v] = scene.planar ? [unit(cross(d, normal)), normal] : across(d);
  const at = (k) => add(here, d, half * (2 * k / count - 1));
  for (let k = 0; k < count; k++) {
    const from = at(k), to = at(k + 1);
    if (plus) {
      const target = k % 2 ? stripes : solid;
      target.turned(part, [from, from, to, to], [0, radius, radius, 0], d, text);
    } else if (k % 2 === 0) {
      open.circle(part, from, u, v, radius, 12);
      open.circle(part, to, u, v, radius, 12);
      for (const [i, j] of [[1, 0], [0, 1], [-1, 0], [0, -1]]) {
        const off = add(scaled(u, i * radius), v, j * radius);
        open.path(part, [add(from, off), add(to, off)], text);
      }
      open.path(part, [add(from, u, radius), add(to, u, -radius)]);
    } else {
      open.path(part, [from, to]);
    }
  }
  return alone ? here : add(here, d, half);
}
