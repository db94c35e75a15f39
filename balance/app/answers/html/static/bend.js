/* Draw the linkage with beams that bend, exaggerated, beside the loads at the same time. */

const frames = data("frames");
const time = byId("time"), scale = byId("scale");
const factor = () => 10 ** Number(scale.value);

/** Lines one after the other as one trace, apart by gaps. */
function joined(lines) {
  const x = [], y = [];
  for (const line of lines) {
    for (const [a, b] of line) { x.push(a); y.push(b); }
    x.push(null); y.push(null);
  }
  return {x, y};
}

/** The line around a rigid link, through its joints. */
const around = (points) => points.length > 2 ? [...points, points[0]] : points;

/** The lines of frame k: rigid links, beams without deformation, and deformed ones. */
function linesAt(k) {
  const straight = frames.straight.map((poses) => poses[k]);
  const bent = straight.map((line, b) => line.map((p, i) =>
    p.map((x, axis) => x + factor() * (frames.bent[b][k][i][axis] - x))));
  return {links: frames.links.map((poses) => around(poses[k])), straight, bent};
}

function show() {
  const k = Number(time.value), {links, straight, bent} = linesAt(k);
  const line = (name, lines, color, width, dash = "solid") =>
    ({type: "scatter", mode: "lines", name, ...joined(lines), line: {color, width, dash}, hoverinfo: "skip"});
  chartOn("bend", [
    ...(links.length ? [line("rigid links", links, "#1b1e22", 4)] : []),
    line("beams without deformation", straight, "#9aa3ab", 1.5, "dash"),
    line(`beams, bending × ${shortNumber(factor())}`, bent, "#0a5ea8", 4),
    {type: "scatter", mode: "markers", name: "base", x: frames.grounds.map((p) => p[0]), y: frames.grounds.map((p) => p[1]),
      marker: {color: "#1b1e22", size: 11, symbol: "triangle-up"}},
  ], {
    showlegend: true,
    xaxis: {title: {text: "x (m)"}, range: frames.box[0], scaleanchor: "y"},
    yaxis: {title: {text: "y (m)"}, range: frames.box[1]},
  });
  byId("now").textContent = `${frames.times[k].toFixed(3)} s`;
  byId("times").textContent = `× ${shortNumber(factor())}`;
  time.setAttribute("aria-valuetext", byId("now").textContent);
  byId("traces0").chart.cursor(frames.times[k]);
}

time.max = frames.times.length - 1;
scale.max = Math.max(3, frames.exponent + 1);
scale.value = frames.exponent;
time.addEventListener("input", show);
scale.addEventListener("input", show);
let at = 0;
player(byId("play"), (seconds) => {
  const last = Number(time.max);
  at = (Math.abs(at - Number(time.value)) <= 1 ? at : Number(time.value)) + seconds * last / 5;
  if (at > last) at = 0;
  time.value = Math.round(at);
  show();
});
show();
