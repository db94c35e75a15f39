/* Move the linkages of a verification through the chosen motion, beside its curves. */

const models = data("models");
const motion = byId("motion"), time = byId("time"), now = byId("now");

/** Draw the shaking force of a stage as an arrow from the middle of the linkage. */
function forceArrow(stage, H, force, largest) {
  const shaft = new Lines(), head = new Mesh(), {centre, size} = stage.frame, strength = norm(force);
  if (strength > stage.least) {
    const d = unit(force), long = 0.45 * size * strength / largest, neck = Math.max(long - 0.05 * size, 0.5 * long);
    shaft.path(0, [centre, add(centre, d, neck)], `shaking force ${number(strength)} N`);
    head.turned(0, [add(centre, d, neck), add(centre, d, neck), add(centre, d, long)], [0, 0.017 * size, 0], d, "");
  }
  return [lines("force", shaft, stage.rest, {color: MINUS, width: 4}, true), mesh("force head", head, stage.rest, MINUS)];
}

const stages = models.map((model, k) => {
  const stage = new Stage(byId(`plot${k}`), model.scene);
  stage.shown.centres = true;
  stage.layers.push((H) => forceArrow(stage, H, stage.force, stage.largest));
  return stage;
});

/** The motion of a linkage that is drawn, and its sample at the time of the slider. */
const runOf = (k) => models[k].runs[Number(motion.value)];
const duration = () => Math.max(...models.map((_, k) => runOf(k).time.at(-1) - runOf(k).time[0]));

function showMotion() {
  stages.forEach((stage, k) => {
    const run = runOf(k);
    stage.least = models[k].least;
    stage.largest = Math.max(...models.flatMap((model) => model.runs[Number(motion.value)].force.map(norm))) || 1;
    stage.force = [0, 0, 0];
    stage.view.reset();
    stage.follow(null);
    const at = stage.common(), trail = [];
    for (const q of run.q) {
      stage.put(q);
      stage.view.hold(stage.cloud());
      if (at) trail.push(at(stage.pose));
    }
    stage.trail = {points: trail, at: null};
    chartOn(`traces${k}`, run.chart.data, run.chart.layout);
    chartOn(`polar${k}`, run.polar.data, run.polar.layout);
    const rows = run.rows.map(([label, value]) => element("tr", {}, element("th", {scope: "row"}, label), element("td", {class: "number"}, value)));
    byId(`numbers${k}`).replaceChildren(element("table", {}, element("caption", {}, motion.selectedOptions[0].text), element("tbody", {}, ...rows)));
  });
  showTime();
}

function showTime() {
  const share = Number(time.value) / 1000, t = share * duration();
  now.textContent = `${t.toFixed(3)} s`;
  time.setAttribute("aria-valuetext", now.textContent);
  stages.forEach((stage, k) => {
    const run = runOf(k), at = Math.min(run.time[0] + t, run.time.at(-1)), sample = nearestIndex(run.time, at);
    stage.force = run.force[sample];
    stage.put(run.q[sample]);
    stage.draw();
    byId(`traces${k}`).chart.cursor(at);
    byId(`polar${k}`).chart.cursor(at);
  });
}

motion.addEventListener("change", showMotion);
time.addEventListener("input", showTime);
let share = 0;
player(byId("play"), (seconds) => {
  /* Ten seconds or less for a motion, at its own pace if that is slower. */
  share = (Math.abs(share - Number(time.value)) <= 1 ? share : Number(time.value)) + 1000 * seconds / Math.min(Math.max(duration(), 4), 10);
  time.value = share %= 1000;
  showTime();
});
showMotion();
