/* Select a freedom, and show its text beside the figure. */

function caption() {
  const where = stage.atRest ? "at its reference pose" : "away from its reference pose, which is dashed";
  const axes = scene.planar ? "seen along the axes of its joints" : "with the axes of its joints";
  byId("caption").textContent =
    `The linkage ${where}, ${axes}. Masses, displacements and rods of the chosen freedom are ` +
    "drawn on their bodies; filled and blue adds, open and orange takes away.";
}

/* The primitives of the chosen freedom, and their traces at a pose. */
let primitives = [], overlay = () => [];

function buildChoice() {
  stage.layers.push((H) => overlay(H));
  const choice = byId("choice"), all = [];
  groups.forEach((group) => {
    const options = group.freedoms.map((freedom, f) => {
      all.push({freedom, group, joints: group.joints});
      return element("option", {value: all.length - 1}, `${f + 1}. ${freedom.words}`);
    });
    choice.append(element("optgroup", {label: group.label}, ...options));
  });
  if (!all.length) choice.append(element("option", {value: -1}, "none"));
  const show = () => {
    const chosen = all[Number(choice.value)] || {freedom: {words: "", primitives: []}, joints: [], group: null};
    stage.named = {bodies: chosen.freedom.primitives.map((p) => plain(p.body)), joints: chosen.joints};
    primitives = chosen.freedom.primitives;
    overlay = glyphs(drawn(chosen.freedom));
    byId("words").textContent = chosen.freedom.words;
    byId("note").textContent = chosen.group ? chosen.group.label : "The linkage has no freedom of the masses.";
    showPrimitives(chosen.freedom.primitives);
  };
  choice.addEventListener("change", () => { show(); stage.draw(); });
  show();
}

function showPrimitives(chosen) {
  const rows = chosen.map((p) => element("tr", {},
    element("td", {class: `number ${p.value < 0 ? "minus" : "plus"}`}, `${signed(p.value)} ${KINDS[p.kind][1]}`),
    element("td", {}, `${KINDS[p.kind][0]} on ${p.body}`),
    element("td", {}, [
      p.point ? `at ${vector(p.point)} m` : "", p.direction ? `along ${vector(p.direction)}` : "",
    ].filter(Boolean).join(" ")),
  ));
  const head = element("tr", {}, ...["Value", "What", "Where"].map((text, i) =>
    element("th", {scope: "col", class: i ? "" : "number"}, text)));
  const table = element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows));
  byId("primitives").replaceChildren(...(rows.length ? [table] : []));
}

function buildLegend() {
  const svg_ = (inner) => `<svg width="34" height="16" viewBox="0 0 34 16" aria-hidden="true">${inner}</svg>`;
  const items = [
    [`<path class="link" d="M1 8H33"/>`, "link"],
    [`<path class="ghost" d="M1 8H33"/>`, "reference pose"],
    [`<circle class="plus full" cx="10" cy="8" r="6"/><circle class="minus" cx="25" cy="8" r="6"/><ellipse class="minus" cx="25" cy="8" rx="2.5" ry="6"/><path class="minus" d="M19 8H31"/>`, "mass + and −"],
    [`<path class="plus" stroke-width="2.5" d="M1 4H24"/><path class="plus full" d="M24 0L33 4L24 8Z"/><path class="minus" stroke-dasharray="4 3" d="M1 12H24"/><path class="minus" d="M24 9L33 12L24 15Z"/>`, "displacement + and −"],
    [`<path class="plus" stroke-width="5" stroke-dasharray="5 4" d="M1 4H33"/><path class="minus" d="M1 10H7V14H1ZM7 12H12M12 10H18V14H12ZM18 12H23M23 10H29V14H23Z"/>`, "rod (inertia, no mass) + and −"],
  ];
  byId("legend").innerHTML = items.map(([inner, text]) => `<li>${svg_(inner)}${text}</li>`).join("");
}
