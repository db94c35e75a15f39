/* Select the masses to show, write the text below the figure, and initialise the page. */

/* Name bodies at their masses if there is space; hovering always names them. */
parts.names.vertices = [];
const roomy = 90 * scene.bodies.length <= byId("plot").clientWidth;

const nothing = {surface: new Mesh(), outlines: new Lines(), centres: new Labels(), values: new Labels()};
const drawn = Object.fromEntries(STATES.map((state) => [state, shapes(state)]));

function show() {
  const choice = document.querySelector("#shown input:checked").value;
  overlay.traces = (H) => [...(overlay.added?.(H, choice !== "given") ?? []), ...STATES.flatMap((state) => {
    const {surface, outlines, centres, values} = [state, "both"].includes(choice) ? drawn[state] : nothing;
    const colour = COLOURS[state], alone = choice === state || state === "designed";
    return [
      mesh(`${state} surfaces`, alone ? surface : nothing.surface, H, colour, 0.14),
      lines(`${state} outlines`, outlines, H, {color: colour, width: 2}),
      marks(`${state} centres`, centres, H, "diamond", 4, colour),
      texts(`${state} values`, roomy && alone ? values : nothing.values, H, INK, 13),
    ];
  })];
}

function caption() {
  const where = pose === rest ? "at its reference pose" : "away from its reference pose, which is dashed";
  byId("caption").textContent =
    `The linkage ${where}. Each body's mass is drawn as the homogeneous ellipsoid of the same ` +
    "mass, centre of mass and inertia.";
}

function buildLegend() {
  const svg = (inner) => `<svg width="34" height="16" viewBox="0 0 34 16" aria-hidden="true">${inner}</svg>`;
  const ellipse = (colour) => svg(
    `<ellipse cx="17" cy="8" rx="15" ry="7" fill="${colour}" fill-opacity=".18" stroke="${colour}"/>` +
    `<path d="M17 4L21 8L17 12L13 8Z" fill="${colour}"/>`);
  const items = [
    [svg(`<path d="M1 8H33" stroke="${LINK}" stroke-width="4"/>`), "link"],
    [svg(`<path d="M1 8H33" stroke="${GHOST}" stroke-width="2" stroke-dasharray="5 3"/>`), "reference pose"],
    [ellipse(PLUS), "mass as designed"],
    [ellipse(MINUS), "mass as in the file"],
    ...(overlay.legend?.(svg) ?? []),
  ];
  byId("legend").innerHTML = items.map(([image, text]) => `<li>${image}${text}</li>`).join("");
}

buildLegend();
show();
buildSliders();
for (const input of document.querySelectorAll("#shown input")) {
  input.addEventListener("change", () => { show(); draw(); });
}
draw();
