/* A member of each family, with its sliders and the letters of its joints. */

const stages = data("scenes").map((scene, k) => {
  const stage = new Stage(byId(`plot${k}`), scene);
  stage.named.joints = scene.joints.map((joint) => joint.name);
  buildShown(stage, byId(`view${k}`));
  return {stage, controls: new Controls(stage, byId(`sliders${k}`))};
});
byId("members").hidden = !stages.length;
