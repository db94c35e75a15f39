/* A sweep: parallel coordinates to brush, a table of the rows that are kept, and their linkages. */

const sweep = data("sweep"), drawing = data("drawing");
const order = byId("order"), reverse = byId("reverse");
const MOST = 12, WIDTH = 88;
let kept = sweep.rows.map((_, k) => k), chosen = -1;

const label = (column) => (column.unit ? `${column.name} (${column.unit})` : column.name);
const shown = (column, value) =>
  value === null ? "" : column.whole ? String(value) : String(Number(Number(value).toPrecision(5))).replace("-", "−");

/** Split a long name at dots, underscores and its unit, so that names of neighbours do not overlap. */
function stacked(column) {
  const words = label(column).split(/(?<=[._])(?=[a-z])|(?= \()/i), lines = [""];
  for (const word of words) {
    if ((lines.at(-1) + word).length > 12 && lines.at(-1)) lines.push("");
    lines[lines.length - 1] += word;
  }
  return lines;
}

const frame = byId("coordinates");

/** Least and largest value of a column. */
function extent(column) {
  column.extent ??= column.values.filter((value) => value !== null).reduce(
    ([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  return column.extent;
}

/** Parallel coordinates that can be brushed. */
function drawCoordinates() {
  parallel.show(kept, sweep.columns.find((column) => column.name === order.value) || sweep.columns.at(-1));
}

/** Whether a row is in the ranges that were brushed. */
function inside(k) {
  return sweep.columns.every(({brush, values}) =>
    !brush || (values[k] !== null && brush[0] <= values[k] && values[k] <= brush[1]));
}

function keep() {
  kept = sweep.rows.map((_, k) => k).filter(inside);
  for (const column of sweep.columns) {
    column.fields.forEach((field, k) => {
      field.value = column.brush ? String(Number(column.brush[k].toPrecision(6))) : "";
    });
  }
  fill();
  drawCoordinates();
}

/** A field for the least and one for the largest value of each column, beside the axes. */
function addRanges() {
  for (const column of sweep.columns) {
    const row = document.createElement("div"), name = document.createElement("dt");
    const cell = document.createElement("dd");
    name.textContent = label(column);
    column.fields = ["at least", "at most"].map((word) => {
      const field = document.createElement("input");
      field.type = "number";
      field.step = "any";
      field.placeholder = word;
      field.setAttribute("aria-label", `${label(column)}, ${word}`);
      field.addEventListener("change", () => {
        const [least, most] = column.fields.map((one) => (one.value === "" ? NaN : Number(one.value)));
        const [low, high] = extent(column);
        const free = Number.isNaN(least) && Number.isNaN(most);
        column.brush = free ? undefined : [Number.isNaN(least) ? low : least, Number.isNaN(most) ? high : most];
        keep();
      });
      cell.append(field, " ");
      return field;
    });
    row.append(name, cell);
    byId("ranges").append(row);
  }
}

function fill() {
  const by = sweep.columns.find((column) => column.name === order.value);
  const sign = reverse.checked ? -1 : 1;
  if (by) {
    kept.sort((a, b) => (by.values[a] === null) - (by.values[b] === null)
      || sign * (by.values[a] - by.values[b]) || a - b);
  }
  byId("kept").textContent = `${kept.length} of ${sweep.rows.length} rows are kept`
    + (kept.length > MOST ? `; the first ${MOST}:` : ":");
  const head = byId("rows").tHead, body = byId("rows").tBodies[0];
  const why = kept.slice(0, MOST).some((k) => sweep.reasons[k]);
  head.replaceChildren(line("th", ["row", ...sweep.columns.map(label), ...(why ? ["no answer"] : [])]));
  body.replaceChildren(...kept.slice(0, MOST).map((k) => {
    const cells = sweep.columns.map((column) => shown(column, column.values[k]));
    const row = line("td", ["", ...cells, ...(why ? [sweep.reasons[k]] : [])]);
    if (why) row.lastChild.className = "";
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = String(sweep.rows[k]);
    button.setAttribute("aria-label", `Draw the linkage of row ${sweep.rows[k]}`);
    row.firstChild.append(button);
    row.dataset.number = String(k);
    row.addEventListener("click", () => draw(k));
    return row;
  }));
  if (kept.length) draw(kept.includes(chosen) ? chosen : kept[0]);
}

function line(kind, texts) {
  const row = document.createElement("tr");
  texts.forEach((text, k) => {
    const cell = document.createElement(kind);
    cell.textContent = text;
    if (k) cell.className = "number";
    row.append(cell);
  });
  return row;
}

function draw(k) {
  chosen = k;
  for (const row of byId("rows").tBodies[0].rows) {
    row.classList.toggle("chosen", row.dataset.number === String(k));
  }
  const point = (j) => [drawing.points[k][2 * j], drawing.points[k][2 * j + 1]];
  const links = drawing.parts.slice(1).filter((joints) => joints.length > 1).map((joints) => {
    const ring = joints.length > 2 ? [...joints, joints[0]] : joints;
    return {
      mode: "lines", x: ring.map((j) => point(j)[0]), y: ring.map((j) => point(j)[1]),
      line: {color: "#1f5a94", width: 4}, hoverinfo: "skip",
    };
  });
  const marks = [[true, "square", 11], [false, "circle", 8]].map(([ground, symbol, size]) => {
    const own = drawing.joints.map((_, j) => j).filter((j) => drawing.parts[0].includes(j) === ground);
    return {
      mode: "markers", x: own.map((j) => point(j)[0]), y: own.map((j) => point(j)[1]),
      text: own.map((j) => drawing.joints[j]), marker: {color: "#1b1e22", size, symbol},
    };
  });
  chartOn("linkage", [...links, ...marks], {
    showlegend: false, xaxis: {title: {text: drawing.axes[0]}},
    yaxis: {title: {text: drawing.axes[1]}, scaleanchor: "x"},
  });
  byId("which").textContent = `row ${sweep.rows[k]}` + (sweep.reasons[k] ? `: ${sweep.reasons[k]}` : "");
}

sweep.columns.forEach((column) => order.add(new Option(label(column), column.name)));
if (sweep.order) order.value = sweep.order;
order.addEventListener("input", () => { fill(); drawCoordinates(); });
reverse.addEventListener("input", fill);
addRanges();
for (const column of sweep.columns) {
  Object.assign(column, {range: extent(column), lines: stacked(column), text: (value) => shown(column, value)});
}
frame.style.minWidth = `${WIDTH * sweep.columns.length}px`;
const parallel = new Parallel(frame, sweep.columns, keep);
fill();
if (sweep.columns.length) drawCoordinates();
else byId("all").hidden = true;
