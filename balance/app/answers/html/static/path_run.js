/* Run the linkage along a path: drawing, plane of the inputs, and loads over time. */

const run = data("run");
const chosen = byId("chosen"), time = byId("time");

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
  chartOn("drawing", [
    {type: "scatter", mode: "lines", ...trace, line: {color: "#c05a10", width: 1.5}, hoverinfo: "skip"},
    {type: "scatter", mode: "lines+markers", ...outline(path, k), line: {color: "#1f5a94", width: 4},
      marker: {color: "#1b1e22", size: 7}, hoverinfo: "skip"},
  ], {
    showlegend: false,
    xaxis: {title: {text: run.axes[0]}, range: run.box[0], scaleanchor: "y"},
    yaxis: {title: {text: run.axes[1]}, range: run.box[1]},
  });
}

/** The shade of quiet poses, and strokes along their directions. */
function background() {
  const field = run.field;
  if (!field) return [];
  return [
    {type: "heatmap", x: field.x, y: field.y, z: field.size, zmin: 0, hoverinfo: "skip",
      colorscale: [[0, "#6fa3cf"], [1, "#ffffff"]]},
    {type: "scatter", mode: "lines", x: field.strokes[0], y: field.strokes[1],
      line: {color: "#5d6a76", width: 1}, hoverinfo: "skip"},
  ];
}

/** The plane of a path; without one, that of the field. */
const planeOf = (path) => path ? path.plane
  : {axes: [0, 1], ranges: [run.field.x, run.field.y].map((values) => [values[0], values.at(-1)])};

function drawPlane(path, k) {
  const {axes: [first, second], ranges} = planeOf(path);
  const lines = run.paths.map((other) => ({
    type: "scatter", mode: "lines", x: other.u[first], y: other.u[second], hoverinfo: "skip",
    line: {color: other === path ? "#c05a10" : "#1b1e22", width: other === path ? 3 : 1.5},
  }));
  const here = path ? [{type: "scatter", mode: "markers", x: [path.u[first][k]], y: [path.u[second][k]],
    marker: {color: "#1b1e22", size: 9}, hoverinfo: "skip"}] : [];
  chartOn("plane", [...background(), ...lines, ...here], {
    showlegend: false,
    xaxis: {title: {text: run.inputs[first]}, range: ranges[0]},
    yaxis: {title: {text: run.inputs[second]}, range: ranges[1]},
  });
}

/** The ways of the tool in its complete workspace. */
function drawTool(path, k) {
  const {workspace, strokes, ways} = run.tool, chosenWay = path && ways[run.paths.indexOf(path)];
  const line = (way, color, width) => ({type: "scatter", mode: "lines", ...way, line: {color, width}, hoverinfo: "skip"});
  const here = path ? [{type: "scatter", mode: "markers", x: [path.trace.x[k]], y: [path.trace.y[k]],
    marker: {color: "#1b1e22", size: 9}, hoverinfo: "skip"}] : [];
  chartOn("tool", [
    {type: "scatter", mode: "markers", ...workspace, marker: {color: "#d3dae0", size: 3}, hoverinfo: "skip"},
    line(strokes, "#5d6a76", 1), ...ways.map((way) => line(way, "#1b1e22", 1.5)),
    ...(chosenWay ? [line(chosenWay, "#c05a10", 3)] : []), ...here,
  ], {
    showlegend: false,
    xaxis: {title: {text: run.axes[0]}, scaleanchor: "y"}, yaxis: {title: {text: run.axes[1]}},
  });
}

function drawLoads(path, k) {
  for (const [name, unit] of [["force", "N"], ["moment", "N m"]]) {
    const curves = [["on the path", path.loads[name], "#1f5a94", "solid"],
      ["straight", path.straight ? path.straight[name] : [], "#c05a10", "solid"],
      ["if nothing cancelled, on the path", path.loads[`own ${name}`], "#5d6a76", "dot"]];
    chartOn(name, curves.map(([label, y, color, dash]) => ({
      type: "scatter", mode: "lines", name: label, x: path.time, y, line: {color, width: 2, dash},
    })), {
      hovermode: "x", xaxis: {title: {text: "time (s)"}},
      yaxis: {title: {text: `shaking ${name} (${unit})`},
        range: [0, 1.1 * Math.max(0, ...curves.flatMap((curve) => curve[1] || [])) || 1]},
      shapes: [{type: "line", x0: path.time[k], x1: path.time[k], yref: "paper", y0: 0, y1: 1,
        line: {color: "#1b1e22", width: 1}}],
    });
  }
}

function show() {
  const path = run.paths[Number(chosen.value)], k = Number(time.value);
  byId("now").textContent = `${path.time[k].toFixed(2)} s`;
  drawLinkage(path, k); drawPlane(path, k); drawLoads(path, k);
  if (run.tool) drawTool(path, k);
}

if (run.paths.length) {
  run.paths.forEach((path, k) => chosen.add(new Option(path.label, String(k))));
  time.max = String(run.paths[0].time.length - 1);
  chosen.addEventListener("input", show);
  time.addEventListener("input", show);
  let at = 0;
  player(byId("play"), (seconds) => {
    const last = Number(time.max);
    at = (Math.abs(at - Number(time.value)) < 1 ? at : Number(time.value)) + seconds * last / 3;
    if (at >= last + 1) at = 0;
    time.value = String(Math.floor(at));
    show();
  });
  show();
} else {
  byId("controls").hidden = true;
  byId("drawing").hidden = true;
  byId("loads").hidden = true;
  if (run.tool) drawTool(null, 0);
  if (run.field) drawPlane(null, 0);
  else byId("plane").hidden = true;
}
