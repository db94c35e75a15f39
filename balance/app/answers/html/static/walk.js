/* A walk: the linkage deforms from step to step while a singular value falls. */

const walk = data("walk");
const place = byId("place"), last = walk.points.length - 1;
const stage = new Stage(byId("plot"), walk.scene);
const three = (list, j) => list.slice(3 * j, 3 * j + 3);

/** The geometry between two steps: points and directions of the joints. */
function between(list, at) {
  const k = Math.min(Math.floor(at), last), next = Math.min(k + 1, last), share = at - k;
  return list[k].map((x, i) => x + share * (list[next][i] - x));
}

/** The scene with its joints moved to a place of the walk. */
function sceneAt(at) {
  const points = between(walk.points, at), axes = between(walk.axes, at), {scene} = walk;
  const joints = scene.joints.map((joint, j) => ({...joint, point: three(points, j), direction: three(axes, j)}));
  const parts = scene.parts.map((part, p) => ({...part, corners: walk.corners[p].map((j) => three(points, j))}));
  return {...scene, joints, parts};
}

/** The value of the curve between two steps. */
function valueAt(at) {
  const k = Math.min(Math.floor(at), last), next = Math.min(k + 1, last), share = at - k;
  const logs = [k, next].map((i) => Math.log(Math.max(walk.ratios[i], 1e-17)));
  return Math.exp(logs[0] + share * (logs[1] - logs[0]));
}

/** What is drawn: the geometry of the start, dashed, behind that of the step. */
const start = linkage(walk.scene, stage.frame).links, drawn = stage.traces.bind(stage);
stage.traces = () => [
  lines("start", Number(place.value) ? start : new Lines(), stage.rest, {color: GHOST, width: 2, dash: "dash"}),
  ...drawn(),
];
stage.named.joints = walk.scene.joints.map((joint) => joint.name);

function putStep(at) {
  stage.scene = sceneAt(at);
  stage.parts = linkage(stage.scene, stage.frame);
}

function showStep() {
  const at = Number(place.value), k = Math.round(at);
  putStep(at);
  stage.draw();
  byId("now").textContent = `step ${walk.names[k]}, s_min/s_max ${shortNumber(valueAt(at))}`;
  place.setAttribute("aria-valuetext", byId("now").textContent);
  byId("values").chart.cursor(at);
}

place.max = last;
for (let k = 0; k <= last; k++) {
  putStep(k);
  stage.view.hold(stage.cloud());
}
chartOn("values", walk.chart.data, walk.chart.layout);
player(byId("play"), (seconds) => {
  const now = Number(place.value);
  place.value = now >= last ? 0 : Math.min(now + seconds * Math.max(1, last / 10), last);
  showStep();
});
place.addEventListener("input", showStep);
showStep();
