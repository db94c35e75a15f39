/* Run the linkage along a path: drawing, plane of the inputs, and loads over time. */

const run = data("run");
const chosen = byId("chosen"), time = byId("time");
const still = {responsive: true, displayModeBar: false};
const FONT_STYLE = {family: "Charter, Liberation Serif, Georgia, serif", color: "#1b1e22"};
const paper = {paper_bgcolor: "#fff", plot_bgcolor: "#fff", font: FONT_STYLE};

/** Points of all parts at a frame, parts apart by gaps. */
function outline(path, k) {
  const x = [], y = [];
  for (const part of path.frames[k]) {
    for (const [a, b] of part) { x.push(a); y.push(b); }
    x.push(null); y.push(null);
  }
  return {x, y};
}

function drawLinkage(path, k) {
  const trace = path.trace;
  const box = {zeroline: false, gridcolor: "#e6e9ec"};
  Plotly.react("drawing", [
    {type: "scatter", mode: "lines", ...trace, line: {color: "#c05a10", width: 1.5}, hoverinfo: "skip"},
    {type: "scatter", mode: "lines+markers", ...outline(path, k), line: {color: "#1f5a94", width: 4},
      marker: {color: "#1b1e22", size: 7}, hoverinfo: "skip", connectgaps: false},
  ], {
    ...paper, margin: {l: 48, r: 8, t: 8, b: 40}, showlegend: false,
    xaxis: {...box, title: {text: run.axes[0]}, range: run.box[0], scaleanchor: "y"},
    yaxis: {...box, title: {text: run.axes[1]}, range: run.box[1]},
  }, still);
}

/** The shade of quiet poses, and strokes along their directions. */
function background() {
  const field = run.field;
  if (!field) return [];
  return [
    {type: "heatmap", x: field.x, y: field.y, z: field.size, zmin: 0, hoverinfo: "skip",
      colorscale: [[0, "#6fa3cf"], [1, "#ffffff"]], colorbar: {thickness: 10, len: 0.8}},
    {type: "scatter", mode: "lines", x: field.strokes[0], y: field.strokes[1],
      line: {color: "#5d6a76", width: 1}, hoverinfo: "skip", connectgaps: false},
  ];
}

function drawPlane(path, k) {
  const lines = run.paths.map((other) => ({
    type: "scatter", mode: "lines", x: other.u[0], y: other.u[1], hoverinfo: "skip",
    line: {color: other === path ? "#c05a10" : "#1b1e22", width: other === path ? 3 : 1.5},
  }));
  const here = path ? [{type: "scatter", mode: "markers", x: [path.u[0][k]], y: [path.u[1][k]],
    marker: {color: "#1b1e22", size: 9}, hoverinfo: "skip"}] : [];
  const box = {zeroline: false, gridcolor: "#e6e9ec"};
  Plotly.react("plane", [...background(), ...lines, ...here], {
    ...paper, margin: {l: 56, r: 8, t: 8, b: 40}, showlegend: false,
    xaxis: {...box, title: {text: run.inputs[0]}}, yaxis: {...box, title: {text: run.inputs[1]}},
  }, still);
}

function drawLoads(path, k) {
  for (const [name, unit] of [["force", "N"], ["moment", "N m"]]) {
    const curves = [["on the path", path.loads[name], "#1f5a94"],
      ["straight", path.straight ? path.straight[name] : [], "#c05a10"]];
    Plotly.react(name, curves.map(([label, y, color]) => ({
      type: "scatter", mode: "lines", name: label, x: path.time, y, line: {color, width: 2},
    })), {
      ...paper, margin: {l: 64, r: 8, t: 36, b: 40}, legend: {orientation: "h", x: 1, xanchor: "right", y: 1.15},
      title: {text: `shaking ${name} (${unit})`, x: 0, font: {size: 14}},
      xaxis: {title: {text: "time (s)"}, gridcolor: "#e6e9ec"},
      yaxis: {gridcolor: "#e6e9ec", exponentformat: "power",
        range: [0, 1.1 * Math.max(1e-6, ...curves.flatMap((curve) => curve[1] || []))]},
      shapes: [{type: "line", x0: path.time[k], x1: path.time[k], yref: "paper", y0: 0, y1: 1,
        line: {color: "#1b1e22", width: 1}}],
    }, still);
  }
}

function show() {
  const path = run.paths[Number(chosen.value)], k = Number(time.value);
  byId("now").textContent = `${path.time[k].toFixed(2)} s`;
  drawLinkage(path, k); drawPlane(path, k); drawLoads(path, k);
}

if (run.paths.length) {
  run.paths.forEach((path, k) => chosen.add(new Option(path.label, String(k))));
  time.max = String(run.paths[0].time.length - 1);
  chosen.addEventListener("input", show);
  time.addEventListener("input", show);
  let timer = 0;
  byId("play").addEventListener("click", (event) => {
    clearInterval(timer);
    const playing = event.target.textContent === "Play";
    event.target.textContent = playing ? "Stop" : "Play";
    if (playing) timer = setInterval(() => {
      time.value = String((Number(time.value) + 1) % (Number(time.max) + 1));
      show();
    }, 60);
  });
  show();
} else {
  byId("controls").hidden = true;
  byId("drawing").hidden = true;
  byId("loads").hidden = true;
  if (run.field) drawPlane(null, 0);
  else byId("plane").hidden = true;
}
