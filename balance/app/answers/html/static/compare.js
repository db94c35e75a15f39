/* Linkages side by side, each with its own sliders. */

const stages = data("scenes").map((scene, k) => {
  const stage = new Stage(byId(`plot${k}`), scene);
  buildShown(stage, byId(`view${k}`));
  return {stage, controls: new Controls(stage, byId(`sliders${k}`))};
});
