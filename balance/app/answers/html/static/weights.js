/* Select the masses to show, write the text below the figure, and initialise the page. */

/* Bodies are named at their masses; hovering always names them. */
stage.parts.names.vertices = [];
const extra = typeof added === "undefined" ? () => [] : added;

const none = {surface: new Mesh(), outlines: new Lines(), centres: new Labels(), values: new Labels()};
const pictures = Object.fromEntries(STATES.map((state) => [state, shapes(state)]));
const chosen = () => document.querySelector("#shown input:checked").value;

stage.layers.push((H) => {
  const choice = chosen();
  return [...extra(H, choice !== "given"), ...STATES.flatMap((state) => {
    const {surface, outlines, centres, values} = [state, "both"].includes(choice) ? pictures[state] : none;
    const colour = COLOURS[state], alone = choice === state || state === "designed";
    return [
      mesh(`${state} surfaces`, alone ? surface : none.surface, H, colour, 0.14),
      lines(`${state} outlines`, outlines, H, {color: colour, width: 1.5}),
      marks(`${state} centres`, centres, H, "diamond", 4, colour),
      texts(`${state} values`, alone && stage.shown.names ? values : none.values, H, INK, 13),
    ];
  })];
});

const SOLIDS = {block: "block", ellipsoid: "ellipsoid", plate: "elliptic plate"};

function caption() {
  const where = stage.atRest ? "at its reference pose" : "away from its reference pose, which is dashed";
  const drawn = [...new Set(STATES.flatMap((state) => bulks[state].map(({shape}) => shape)))].sort().map((shape) => SOLIDS[shape]);
  const bulk = `Each body's mass is drawn in scale, as the homogeneous ${drawn.join(" or ")} of the same mass, centre of mass and inertia.`;
  byId("caption").textContent = `The linkage ${where}. ${chosen() === "added" ? "" : bulk}`;
}

function buildLegend() {
  const image = (inner) => `<svg width="34" height="16" viewBox="0 0 34 16" aria-hidden="true">${inner}</svg>`;
  const ellipse = (kind) => image(`<ellipse class="${kind}" cx="17" cy="8" rx="15" ry="7"/><path class="${kind} full" d="M17 4L21 8L17 12L13 8Z"/>`);
  const items = [
    [image(`<path class="link" d="M1 8H33"/>`), "link"],
    [image(`<path class="ghost" d="M1 8H33"/>`), "reference pose"],
    [ellipse("plus"), "mass as designed"],
    [ellipse("minus"), "mass as in the file"],
    ...(typeof addedLegend === "undefined" ? [] : addedLegend(image)),
  ];
  byId("legend").innerHTML = items.map(([picture, text]) => `<li>${picture}${text}</li>`).join("");
}

buildLegend();
const controls = new Controls(stage, byId("sliders"), caption);
buildShown(stage, byId("view"));
for (const input of document.querySelectorAll("#shown input")) input.addEventListener("change", () => { caption(); stage.draw(); });
