/* Draw the momentum of each body as a screw axis with a pitch, for the selected masses. */

const VIOLET = "#7a3b8f";
const tall = ([x, y, z], last) => [x, y, z, last];
const product = (A, B) => A.map((row) => B[0].map((_, j) => row.reduce((sum, a, k) => sum + a * B[k][j], 0)));
const transposed = (A) => A[0].map((_, j) => A.map((row) => row[j]));
const square = (H) => [H.slice(0, 4), H.slice(4, 8), H.slice(8, 12), [0, 0, 0, 1]];
const outer = (a, b) => a.map((x) => b.map((y) => x * y));
const sum = (A, B, s = 1) => A.map((row, i) => row.map((a, j) => a + s * B[i][j]));
const nothing = () => [0, 0, 0, 0].map(() => [0, 0, 0, 0]);

/** Pseudo-inertia [[∫ x xᵀ dm, mc], [mcᵀ, m]] of a primitive, at the reference pose. */
function pseudo(p) {
  const at = p.point && tall(p.point, 1), along = p.direction && tall(p.direction, 0);
  if (p.kind === "mass") return outer(at, at);
  return p.kind === "rod" ? outer(along, along) : sum(outer(along, at), outer(at, along));
}

/** Pseudo-inertia of each body: the sum of its primitives. */
const gathered = (primitives) => scene.bodies.map(({name}) =>
  primitives.filter((p) => p.body === name).reduce((P, p) => sum(P, pseudo(p), p.value), nothing()));

/** Momentum of a body about the middle of the drawing, and its size before cancellation. */
function momentum(P, H, twist) {
  const Q = H === null ? P : product(product(square(H), P), transposed(square(H)));
  const w = twist.slice(0, 3), v = twist.slice(3), m = Q[3][3], mc = Q.slice(0, 3).map((row) => row[3]);
  const S = Q.slice(0, 3).map((row) => row.slice(0, 3)), trace = S[0][0] + S[1][1] + S[2][2];
  let force = add(scaled(v, m), cross(w, mc));
  let moment = add(add(scaled(w, trace), S.map((row) => dot(row, w)), -1), cross(mc, v));
  moment = add(moment, cross(centre, force), -1);
  if (scene.planar) {
    force = add(force, normal, -dot(force, normal));
    moment = scaled(normal, dot(moment, normal));
  }
  const whole = Math.abs(m) * norm(v) + norm(w) * norm(mc) + (Math.abs(trace) * norm(w) + norm(mc) * norm(v)) / size;
  return {force, moment, whole};
}

/** Momentum lines of all bodies: a line, a couple, or none for a body at rest. */
function screws(masses, H, rates) {
  const found = scene.bodies.map((body, b) =>
    ({body, ...momentum(masses[b], H[body.part], rates[b])}));
  const least = 1e-6 * Math.max(...found.map((h) => h.whole));
  return found.map(({body, force, moment}) => {
    const p = norm(force), d = unit(force), couple = norm(moment) / size;
    if (p <= least) return {body, kind: couple > least ? "couple" : "rest", value: norm(moment)};
    const point = add(centre, scaled(cross(force, moment), 1 / (p * p)));
    const pitch = dot(moment, d) / p;
    return {body, kind: "line", value: p, d, point, pitch: Math.abs(pitch) > 1e-6 * size ? pitch : 0};
  });
}

/** Point nearest to lines, and its largest distance from one; null if they are parallel. */
function meeting(lines) {
  if (lines.every(({d}) => norm(cross(d, lines[0].d)) < 1e-6)) return null;
  let A = [[0, 0, 0], [0, 0, 0], [0, 0, 0]], right = [0, 0, 0];
  for (const {d, point} of lines) {
    const off = sum([[1, 0, 0], [0, 1, 0], [0, 0, 1]], outer(d, d), -1), at = add(point, centre, -1);
    A = sum(A, off);
    right = add(right, off.map((row) => dot(row, at)));
  }
  const [a, b, c] = A, det = dot(a, cross(b, c));
  const terms = [cross(b, c), cross(c, a), cross(a, b)].map((column, i) => scaled(column, right[i] / det));
  const point = add(terms.reduce((x, y) => add(x, y)), centre);
  return {point, miss: Math.max(...lines.map((line) => norm(cross(line.d, add(point, line.point, -1)))))};
}

/** Feet of the common normal of two lines. */
function perpendicular(one, other) {
  const n = cross(other.d, one.d), gap = add(one.point, other.point, -1), square = dot(n, n);
  const foot = (line, d) => add(line.point, line.d, dot(cross(gap, d), n) / square);
  return [foot(one, other.d), foot(other, one.d)];
}

/** Description of the lines, and its drawing data. */
function meant(lines, couples, balanced) {
  const count = lines.length;
  if (!balanced) return {words: "These masses are not balanced: the momenta do not cancel."};
  if (count === 0) {
    const which = couples ? "All momenta are couples, and add up to zero" : "No body has a linear momentum here";
    return {words: `${which}: there are no lines.`};
  }
  if (couples) return {words: "The momenta add up to zero. One of them at least is a couple, which has no line, so the lines of the others need not meet."};
  if (count === 2) return {words: "Two momenta, equal and opposite, on one line."};
  if (count > 3) {
    const place = scene.planar ? "in one point" : "one line at right angles";
    return {words: `The momenta add up to zero. The lines of three bodies would meet ${place}; those of ${count} need not.`};
  }
  const met = meeting(lines);
  if (!met) return {words: "The three lines are parallel: they meet at infinity."};
  if (met.miss < 1e-5 * size) {
    return {point: met.point, words: `The three lines meet in one point, ${vector(met.point)} m. It moves with the linkage.`};
  }
  const pair = [[0, 1], [0, 2], [1, 2]].map(([i, j]) => [lines[i], lines[j]])
    .reduce((a, b) => norm(cross(a[0].d, a[1].d)) < norm(cross(b[0].d, b[1].d)) ? b : a);
  return {
    feet: perpendicular(...pair),
    words: "The three lines meet one line, dashed, each at a right angle: their common normal. It moves with the linkage.",
  };
}

/** The slider that was moved last (the first one at rest), and the twists of the bodies as it runs. */
function rate() {
  const column = scene.columns[controls.moving], {mechanism} = stage;
  const twists = mechanism.twists(stage.q, mechanism.rates(stage.q, column.column));
  return {column, twists: scene.bodies.map((body) => twists[body.link])};
}

const MASSES = {
  none: {label: "do not show them"},
  given: {label: "of the masses in the file", of: () => scene.bodies.map((body) => body.pseudo)},
  chosen: {label: "of the chosen freedom", of: () => gathered(primitives)},
  all: {
    label: "of all freedoms together",
    of: () => gathered(groups.flatMap((group) => group.freedoms.flatMap((f) => f.primitives))),
  },
  pure: {label: "of the pure inertias", of: () => scene.pure},
};

/** Whether masses are there to choose. */
const offered = (name) => name === "pure" ? scene.pure : groups.length || !["chosen", "all"].includes(name);

/** Whether the masses of a name are balanced. */
const cancels = (name) => name === "pure" ? report.pure_inertia.balanced
  : name !== "given" || report.as_given.balanced;

/** Traces of the lines at a pose; updates the text beside the figure. */
function momentumLines(H) {
  const name = byId("masses").value, {column, twists} = rate();
  const found = name === "none" ? [] : screws(MASSES[name].of(), H, twists);
  const lines_ = found.filter((line) => line.kind === "line");
  const couples = found.some((line) => line.kind === "couple");
  const told = name === "none" ? {words: ""}
    : meant(lines_, couples, cancels(name));
  const far = lines_.some(({d, point}) => norm(cross(d, add(point, centre, -1))) > size);
  byId("meeting").textContent = told.words + (far ? " Not all lines are near enough to be in the drawing." : "");
  showMomenta(found, column);
  return drawMomenta(lines_, H, told);
}

function drawMomenta(found, H, {point, feet}) {
  const whole = new Lines(), shafts = new Lines(), heads = new Mesh(), labels = new Labels(), star = new Labels();
  const largest = Math.max(...found.map((line) => line.value)), common = new Lines();
  for (const {body, d, point, value, pitch} of found) {
    const text = `momentum of ${plain(body.name)}, pitch ${number(pitch)} m`;
    const over = (p) => add(point, d, dot(add(p, point, -1), d));
    const middle = over(centre), start = over(moved(H[body.part], body.centre));
    const long = 0.1 * size + 0.2 * size * value / largest, tip = add(start, d, long);
    const neck = add(start, d, long - 0.045 * size);
    whole.path(0, [add(middle, d, -3 * size), add(middle, d, 3 * size)], text);
    shafts.path(0, [start, neck], text);
    heads.turned(0, [neck, neck, tip], [0, 0.013 * size, 0], d, text);
    labels.put(0, add(start, d, 0.5 * long), plain(body.name));
  }
  if (point) star.put(0, point, `all lines meet at ${vector(point)} m`);
  if (feet) {
    const along = unit(add(feet[1], feet[0], -1)), middle = add(feet[0], along, dot(add(centre, feet[0], -1), along));
    common.path(0, [add(middle, along, -3 * size), add(middle, along, 3 * size)], "common normal");
  }
  return [
    lines("momenta", whole, stage.rest, {color: VIOLET, width: 1.3}, true),
    lines("common normal", common, stage.rest, {color: VIOLET, width: 2, dash: "dash"}, true),
    lines("momentum shafts", shafts, stage.rest, {color: VIOLET, width: 4}, true),
    mesh("momentum heads", heads, stage.rest, VIOLET),
    texts("momentum names", labels, stage.rest, VIOLET, 13),
    marks("meeting", star, stage.rest, "diamond", 4, VIOLET),
  ];
}

function showMomenta(found, column) {
  const unit_ = column.angle ? "rad/s" : "m/s", rows = found.map(({body, kind, value, pitch}) => element("tr", {},
    element("td", {}, body.name),
    element("td", {class: "number"}, kind === "rest" ? "0" : `${number(value)} ${kind === "line" ? "N s" : "N m s"}`),
    element("td", {class: "number"}, kind === "line" ? `${number(pitch)} m` : kind === "couple" ? "a couple" : "at rest")));
  const head = element("tr", {}, ...[["Body", ""], [`Momentum at 1 ${unit_}`, "number"], ["Pitch", "number"]]
    .map(([text, kind]) => element("th", {scope: "col", class: kind}, text)));
  const table = element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows));
  byId("momenta").replaceChildren(...(rows.length ? [table] : []));
}

function buildMomenta() {
  const field = byId("momentum"), choice = byId("masses");
  /* Force balance does not constrain moments; a linkage at rest has no momentum. */
  field.hidden = report.balance !== "dynamic" || !scene.columns.length;
  if (field.hidden) return;
  for (const [name, {label}] of Object.entries(MASSES)) {
    if (offered(name)) choice.append(element("option", {value: name}, label));
  }
  choice.value = report.as_given.balanced ? "given" : "none";
  choice.addEventListener("change", () => stage.draw());
  byId("legend").insertAdjacentHTML("beforeend",
    `<li><svg width="34" height="16" viewBox="0 0 34 16" aria-hidden="true"><path class="violet" d="M1 8H33"/><path class="violet" stroke-width="3" d="M6 8H18"/><path class="violet full" d="M18 3L26 8L18 13Z"/></svg>momentum of a body</li>`);
  stage.layers.push(momentumLines);
}
