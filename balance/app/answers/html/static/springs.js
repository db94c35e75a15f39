/* Draw springs between their points, and what the inputs hold over the workspace. */

const COIL = "#8a5a00", TURNS = 8;
const springs = data("springs"), torques = data("torques");

stage.points.push(...springs.flatMap(({ends}) => ends.map(({part, point}) => [part, point])));

/** Points of a zigzag from a to b, in the plane of a planar linkage. */
function coil(a, b) {
  const way = add(b, a, -1), long = norm(way);
  if (!(long > 1e-6 * size)) return [a, b];
  const d = unit(way), aside = Math.abs(dot(d, normal)) < 0.9 ? unit(cross(normal, d)) : across(d)[0];
  const inner = Array.from({length: 2 * TURNS}, (_, k) =>
    add(add(a, way, 0.15 + 0.7 * (k + 0.5) / (2 * TURNS)), aside, (k % 2 ? -1 : 1) * 0.02 * size));
  return [a, add(a, way, 0.15), ...inner, add(a, way, 0.85), b];
}

/** Length of a spring at a pose, and the force that pulls its ends together. */
function stateOf({stiffness, free, ends: [p, q]}, H) {
  const a = moved(H[p.part], p.point), b = moved(H[q.part], q.point), length = norm(add(b, a, -1));
  return {a, b, length, force: stiffness * (length - free)};
}

stage.layers.push((H) => {
  const coils = new Lines(), ends = new Labels();
  for (const spring of springs) {
    const {a, b, length, force} = stateOf(spring, H);
    coils.path(0, coil(a, b), `${spring.name}: ${number(spring.stiffness)} N/m, ${number(length)} m, ${number(force)} N`);
    for (const {part, point} of spring.ends) ends.put(part, point, spring.name);
  }
  return [lines("springs", coils, stage.rest, {color: COIL, width: 2}, true), marks("spring ends", ends, H, "circle", 3, COIL)];
});

torques.forEach(({data: traces, layout}, k) => chartOn(`torque${k}`, traces, layout));

/** Say where the linkage is, how long the springs are there, and mark the inputs in the charts. */
function atPose() {
  const where = stage.atRest ? "at its reference pose" : "away from its reference pose, which is dashed";
  byId("caption").textContent = `The linkage ${where}. Springs are drawn as zigzags between their points.`;
  const rows = springs.map((spring) => {
    const {length, force} = stateOf(spring, stage.pose);
    return element("tr", {}, element("th", {scope: "row"}, spring.name),
      element("td", {class: "number"}, `${number(length)} m`), element("td", {class: "number"}, `${number(force)} N`));
  });
  byId("lengths").replaceChildren(element("table", {}, element("caption", {}, "Springs at this pose"), element("tbody", {}, ...rows)));
  byId("lengths").hidden = !rows.length;
  torques.forEach(({input}, k) => byId(`torque${k}`).chart.cursor(stage.q[stage.mechanism.inputs[input]]));
}

const picture = (inner) => `<svg width="34" height="16" viewBox="0 0 34 16" aria-hidden="true">${inner}</svg>`;
byId("legend").innerHTML = [
  [`<path class="link" d="M1 8H33"/>`, "link"],
  [`<path class="ghost" d="M1 8H33"/>`, "reference pose"],
  ...(springs.length ? [[`<path class="lump" fill="none" d="M1 8H6L9 2L14 14L19 2L24 14L27 8H33"/>`, "spring"]] : []),
].map(([inner, text]) => `<li>${picture(inner)}${text}</li>`).join("");
const controls = new Controls(stage, byId("sliders"), atPose);
buildShown(stage, byId("view"));
