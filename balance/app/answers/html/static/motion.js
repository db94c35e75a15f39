/* Move a linkage along a Taylor motion, beside the curves of its joints. */

const {scene, tool, runs} = data("motion");
const choice = byId("run"), place = byId("place");
byId("moving").hidden = !runs.length;
const stage = runs.length ? new Stage(byId("plot"), scene) : null;

/** The point whose path is drawn: that of the tool, or the end of the last body. */
const body = scene.bodies.at(-1);
const pointAt = tool ? (pose) => moved(pose[tool.part], tool.point) : (pose) => moved(pose[body.part], body.tip);

function showRun() {
  const run = runs[choice.value], trail = [];
  stage.view.reset();
  for (const q of run.q) {
    stage.put(q);
    stage.view.hold(stage.cloud());
    trail.push(pointAt(stage.pose));
  }
  stage.trail = {points: trail, at: null};
  stage.view.hold(trail);
  /* The names of what moves: the tool, and the joints of the curves. */
  stage.named = {bodies: [plain(tool ? tool.name : body.name)], joints: run.chart.data.map(({name}) => name)};
  place.max = run.q.length - 1;
  byId("way").textContent = run.label;
  chartOn("joints", run.chart.data, run.chart.layout);
  showPlace();
}

function showPlace() {
  const run = runs[choice.value], k = Number(place.value);
  stage.put(run.q[k]);
  stage.draw();
  byId("now").textContent = `${run.chart.layout.xaxis.title.text} ${shortNumber(run.x[k])}`;
  place.setAttribute("aria-valuetext", byId("now").textContent);
  byId("joints").chart.cursor(run.x[k]);
}

if (stage) {
  byId("tool").textContent = tool ? plain(tool.name) : `the end of ${plain(body.name)}`;
  runs.forEach((run, k) => choice.append(element("option", {value: k}, run.label)));
  choice.addEventListener("change", () => { place.value = 0; showRun(); });
  place.addEventListener("input", showPlace);
  let at = 0;
  player(byId("play"), (seconds) => {
    const last = Number(place.max);
    at = (Math.abs(at - Number(place.value)) <= 1 ? at : Number(place.value)) + seconds * last / 4;
    if (at > last) at = 0;
    place.value = Math.round(at);
    showPlace();
  });
  showRun();
}
