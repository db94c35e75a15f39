/* Charts of lines, marks and shades in SVG, from traces and a layout. */

const SVG = "http://www.w3.org/2000/svg";
const DASH = {solid: "", dash: "7 4", dot: "1.5 3.5", dashdot: "7 3 1.5 3", longdash: "12 5", longdashdot: "12 4 2 4"};
const MARKS = {
  circle: (r) => `M${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`,
  square: (r) => `M${-r} ${-r}H${r}V${r}H${-r}Z`,
  diamond: (r) => `M0 ${-1.3 * r}L${1.3 * r} 0L0 ${1.3 * r}L${-1.3 * r} 0Z`,
  "triangle-up": (r) => `M0 ${-1.2 * r}L${1.1 * r} ${0.9 * r}H${-1.1 * r}Z`,
  cross: (r) => `M${-0.4 * r} ${-r}h${0.8 * r}v${0.6 * r}h${0.6 * r}v${0.8 * r}h${-0.6 * r}v${0.6 * r}h${-0.8 * r}v${-0.6 * r}h${-0.6 * r}v${-0.8 * r}h${0.6 * r}Z`,
  x: (r) => `M${-r} ${-r}L${r} ${r}M${-r} ${r}L${r} ${-r}`,
  star: (r) => `M0 ${-1.3 * r}L${0.4 * r} ${-0.4 * r}L${1.3 * r} 0L${0.4 * r} ${0.4 * r}L0 ${1.3 * r}L${-0.4 * r} ${0.4 * r}L${-1.3 * r} 0L${-0.4 * r} ${-0.4 * r}Z`,
};
const CURVE_INK = "#1b1e22", CURVE_SOFT = "#5a626b", CURVE_GRID = "#e6e9ec";

/** An SVG element. */
function svg(tag, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** A chart of panels one above the other over one axis. */
class Chart {
  constructor(target, figure) {
    this.target = target;
    target.chart = this;
    this.set(figure);
    redrawn.add(() => this.draw());
  }
  set({data, layout = {}}) {
    this.traces = data;
    this.layout = layout;
    if (layout.height) this.target.style.height = `${layout.height}px`;
    this.draw();
  }
  draw() {
    const W = this.target.clientWidth, H = this.target.clientHeight;
    if (!W || !H) return;
    this.root = svg("svg", {width: W, height: H, viewBox: `0 0 ${W} ${H}`, "aria-hidden": true});
    this.panels = this.arrange(W, H);
    for (const panel of this.panels) this.drawPanel(panel);
    this.target.replaceChildren(this.root, this.readout());
    if (this.now !== undefined) this.cursor(this.now);
  }
  /** A vertical line through all panels at a value of their axis, as of time. */
  cursor(x) {
    this.now = x;
    for (const panel of this.panels || []) {
      panel.line ||= this.root.appendChild(svg("path", {class: "cursor", stroke: tone(CURVE_INK), "stroke-width": 1}));
      const at = Math.min(Math.max(panel.x.at(x), panel.x.from), panel.x.to);
      panel.line.setAttribute("d", `M${at} ${panel.top}V${panel.bottom}`);
      panel.dots?.forEach((dot) => dot.remove());
      panel.dots = panel.traces.filter((trace) => trace.follows).map((trace) => {
        const k = nearestIndex(trace.follows, x);
        return this.root.appendChild(svg("circle", {r: 4.5, fill: tone(trace.line.color), cx: panel.x.at(trace.x[k]), cy: panel.y.at(trace.y[k])}));
      });
      if (panel.dots.length) panel.line.setAttribute("d", "");
    }
  }

  /** Places and axes of the panels, which share the horizontal axis. */
  arrange(W, H) {
    const names = [...new Set(this.traces.map((trace) => trace.yaxis || "y"))];
    const option = (name) => this.layout[`yaxis${name.slice(1)}`] || {};
    names.sort((a, b) => (option(b).domain?.[1] ?? 1) - (option(a).domain?.[1] ?? 1));
    const bar = this.traces.find((trace) => trace.type === "heatmap");
    const title = (this.layout.title?.text || "").split("\n").filter(Boolean);
    const head = title.length ? 8 + 19 * title.length : 0;
    title.forEach((line, k) => this.write(0, 17 + 19 * k, line, {size: k ? 14 : 16, fill: k ? CURVE_SOFT : CURVE_INK, "font-weight": k ? 400 : 600}));
    const across = new Axis({tight: true, ...this.layout.xaxis}, this.traces.flatMap((trace) => trace.x));
    const panels = names.map((name) => {
      const traces = this.traces.filter((trace) => (trace.yaxis || "y") === name);
      const y = new Axis(option(name), traces.flatMap((trace) => trace.y));
      return {traces, y, x: across, title: option(name).title?.text || ""};
    });
    const foot = 26 + (this.layout.xaxis?.title ? 18 : 0);
    const left = 10 + Math.max(...panels.map(({y}) =>
      Math.max(0, ...y.over(Math.max((H - head - foot) / panels.length - 26, 40), 0).ticks(34).map((tick) => wide(tick.text)))));
    const right = W - (bar ? 64 : 14);
    for (const panel of panels) panel.legend = this.legendRows(panel, right);
    const rows = panels.reduce((sum, panel) => sum + panel.legend.height, 0);
    const high = Math.max((H - head - foot - rows - 14 * (panels.length - 1)) / panels.length, 40);
    let top = head;
    for (const panel of panels) {
      panel.top = top + panel.legend.height;
      panel.bottom = panel.top + high;
      [panel.left, panel.right] = [left, right];
      panel.x.over(left, right);
      panel.y.over(panel.bottom, panel.top);
      if (this.layout.yaxis?.scaleanchor || this.layout.xaxis?.scaleanchor) {
        const largest = Math.max(panel.x.perPixel, panel.y.perPixel);
        panel.x.widen(largest); panel.y.widen(largest);
      }
      top = panel.bottom + 14;
    }
    return panels;
  }
  /** Title and legend above a panel: items with their places, in as many rows as needed. */
  legendRows(panel, right) {
    const all = this.traces.length > 1;
    const named = panel.traces.filter((trace) => trace.name && trace.type !== "heatmap"
      && (trace.showlegend ?? this.layout.showlegend ?? all));
    const items = [];
    let x = panel.title ? wide(panel.title, 13, 600) + 18 : 0, row = 0;
    for (const trace of named) {
      const long = 30 + wide(trace.name) + 14;
      if (x + long > right && x > 0) { x = 0; row += 1; }
      items.push({trace, x, row});
      x += long;
    }
    return {items, height: panel.title || items.length ? 20 * (row + 1) + 6 : 4};
  }

  write(x, y, text, {size = 13, fill = CURVE_INK, ...more} = {}) {
    const made = svg("text", {x, y, "font-size": size, fill: tone(fill), ...more});
    made.textContent = text;
    this.root.append(made);
    return made;
  }
  stroke(path, color, width, dash = "", more = {}) {
    this.root.append(svg("path", {d: path, fill: "none", stroke: tone(color), "stroke-width": width, "stroke-dasharray": dash, "stroke-linejoin": "round", ...more}));
  }
  drawPanel(panel) {
    const clip = `clip${Math.random().toString(36).slice(2)}`, {left, right, top, bottom} = panel;
    this.root.append(svg("clipPath", {id: clip},
      svg("rect", {x: left, y: top - 1, width: Math.max(right - left, 1), height: Math.max(bottom - top + 2, 1)})));
    panel.clip = `url(#${clip})`;
    this.drawShapes(panel, "below");
    if (this.layout.polar) this.drawRings(panel);
    else this.drawGrid(panel);
    for (const trace of panel.traces) {
      if (trace.type === "heatmap") this.drawShade(panel, trace);
      else this.drawTrace(panel, trace);
    }
    this.drawShapes(panel, "above");
    this.drawLegend(panel);
    if (panel === this.panels.at(-1)) this.write((left + right) / 2, bottom + 38, this.layout.xaxis?.title?.text || "", {"text-anchor": "middle"});
  }
  drawGrid(panel) {
    const {left, right, top, bottom, x, y} = panel, last = panel === this.panels.at(-1);
    for (const tick of x.ticks(80)) {
      const at = x.at(tick.value);
      this.stroke(`M${at} ${top}V${bottom}`, CURVE_GRID, 1);
      if (last) this.write(at, bottom + 18, tick.text, {"text-anchor": "middle"});
    }
    for (const tick of y.ticks(34)) {
      const at = y.at(tick.value);
      this.stroke(`M${left} ${at}H${right}`, tick.value === 0 ? "#b9c0c8" : CURVE_GRID, 1);
      this.write(left - 6, at + 4, tick.text, {"text-anchor": "end"});
    }
  }
  /** Rings around zero instead of a grid. */
  drawRings(panel) {
    const {x, y} = panel, reach = Math.max(...x.range.map(Math.abs), ...y.range.map(Math.abs));
    for (const {value, text} of linearTicks([0, reach], 4)) {
      const r = value / x.perPixel;
      if (!value) continue;
      this.root.append(svg("circle", {cx: x.at(0), cy: y.at(0), r, fill: "none", stroke: tone(CURVE_GRID), "clip-path": panel.clip}));
      if (y.at(0) - r > panel.top) this.write(x.at(0) + 4, y.at(0) - r - 3, text, {fill: CURVE_SOFT, size: 12});
    }
    this.stroke(`M${panel.left} ${y.at(0)}H${panel.right}M${x.at(0)} ${panel.top}V${panel.bottom}`, "#b9c0c8", 1);
  }
  drawTrace(panel, trace) {
    const mode = trace.mode || "lines", line = trace.line || {}, marker = trace.marker || {};
    const points = trace.x.map((x, k) => x === null || trace.y[k] === null ? null : [panel.x.at(x), panel.y.at(trace.y[k])])
      .map((p) => p && p.every(Number.isFinite) ? p : null);
    if (mode.includes("lines")) {
      const path = points.map((p, k) => p ? `${points[k - 1] ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}` : "").join("");
      this.stroke(path, line.color || CURVE_INK, line.width || 1.5, DASH[line.dash || "solid"], {class: "line", "clip-path": panel.clip});
    }
    if (mode.includes("markers")) {
      const shape = MARKS[marker.symbol || "circle"]((marker.size || 6) / 2), color = tone(marker.color || line.color || CURVE_INK);
      for (const p of points.filter(Boolean)) {
        this.root.append(svg("path", {d: shape, transform: `translate(${p[0]} ${p[1]})`, fill: color, stroke: color, class: "mark"}));
      }
    }
    if (mode.includes("text")) {
      points.forEach((p, k) => {
        if (!p) return;
        /* To the left of its point where the panel ends on the right. */
        const text = trace.text[k] || "", left = p[0] + 6 + wide(text) > panel.right;
        this.write(p[0] + (left ? -6 : 6), p[1] - 6, text, {fill: CURVE_SOFT, class: "halo", "text-anchor": left ? "end" : "start"});
      });
    }
  }
  drawShapes(panel, where) {
    for (const shape of this.layout.shapes || []) {
      if ((shape.layer || "above") !== where) continue;
      const [a, b] = [panel.x.at(shape.x0), panel.x.at(shape.x1)].map((v) => Math.min(Math.max(v, panel.left), panel.right));
      if (shape.type === "rect") {
        this.root.append(svg("rect", {x: a, y: panel.top, width: b - a, height: panel.bottom - panel.top, fill: tone(shape.fillcolor)}));
      } else this.stroke(`M${a} ${panel.top}V${panel.bottom}`, shape.line.color, shape.line.width || 1, DASH[shape.line.dash || "solid"]);
    }
  }
  drawLegend({title, legend, top}) {
    const start = top - legend.height + 14;
    if (title) this.write(0, start, title, {"font-weight": 600});
    for (const {trace, x, row} of legend.items) {
      const y = start + 20 * row, line = trace.line || {}, marker = trace.marker || {};
      if ((trace.mode || "lines").includes("lines")) {
        this.stroke(`M${x} ${y - 4}h24`, line.color || CURVE_INK, Math.max(line.width || 1.5, 1.5), DASH[line.dash || "solid"]);
      } else {
        const color = tone(marker.color || CURVE_INK);
        this.root.append(svg("path", {d: MARKS[marker.symbol || "circle"](5), transform: `translate(${x + 12} ${y - 4})`, fill: color, stroke: color}));
      }
      this.write(x + 30, y, trace.name);
    }
  }
  /** A shade over a grid of numbers, with its scale at the right. */
  drawShade(panel, {x, y, z, zmin, zmax, colorscale, colorbar = {}}) {
    const all = z.flat().filter((v) => v !== null);
    const low = zmin ?? Math.min(...all), high = zmax ?? Math.max(...all);
    const scale = colorscale.map(([share, color]) => [share, shade(color)]);
    const mixed = (share) => {
      const k = Math.max(scale.findIndex(([edge]) => edge >= share), 1), [[a, from], [b, to]] = [scale[k - 1], scale[k]];
      const t = (share - a) / (b - a);
      return from.map((c, i) => Math.round(255 * (c + t * (to[i] - c))));
    };
    const sheet = document.createElement("canvas");
    [sheet.width, sheet.height] = [x.length, y.length];
    const pen = sheet.getContext("2d"), picture = pen.createImageData(x.length, y.length);
    z.forEach((row, r) => row.forEach((v, c) => {
      if (v === null) return;
      const share = Math.min(Math.max((v - low) / (high - low || 1), 0), 1);
      picture.data.set([...mixed(share), 255], 4 * ((y.length - 1 - r) * x.length + c));
    }));
    pen.putImageData(picture, 0, 0);
    const half = (values) => (values[values.length - 1] - values[0]) / (values.length - 1) / 2;
    const [a, b] = [panel.x.at(x[0] - half(x)), panel.x.at(x[x.length - 1] + half(x))];
    const [c, d] = [panel.y.at(y[y.length - 1] + half(y)), panel.y.at(y[0] - half(y))];
    this.root.append(svg("image", {href: sheet.toDataURL(), x: a, y: c, width: b - a, height: d - c, preserveAspectRatio: "none", "clip-path": panel.clip, style: "image-rendering: pixelated", class: "shade"}));
    const steps = 40, tall = (panel.bottom - panel.top) / steps;
    for (let k = 0; k < steps; k++) {
      this.root.append(svg("rect", {x: panel.right + 12, y: panel.bottom - (k + 1) * tall, width: 12, height: tall + 0.5, fill: `rgb(${mixed((k + 0.5) / steps).join(" ")})`}));
    }
    for (const [value, at] of [[low, panel.bottom], [high, panel.top + 8]]) {
      this.write(panel.right + 28, at, shortNumber(value), {size: 12});
    }
    this.write(panel.right + 28, (panel.top + panel.bottom) / 2, colorbar.title?.text || "", {size: 12});
  }

  /** The values under the pointer. */
  readout() {
    const box = element("div", {class: "readout", hidden: ""});
    this.root.addEventListener("pointerleave", () => { box.hidden = true; });
    this.root.addEventListener("pointermove", (event) => {
      const {left, top} = this.root.getBoundingClientRect(), [px, py] = [event.clientX - left, event.clientY - top];
      const panel = this.panels.find((one) => py >= one.top - 6 && py <= one.bottom + 6 && px >= one.left - 6 && px <= one.right + 6);
      const lines = panel ? this.values(panel, px, py) : [];
      box.hidden = !lines.length;
      box.replaceChildren(...lines.map((line) => element("div", {}, line)));
      box.style.left = `${Math.min(px + 14, this.target.clientWidth - box.offsetWidth)}px`;
      box.style.top = `${py + 14}px`;
    });
    return box;
  }
  values(panel, px, py) {
    const told = panel.traces.filter((trace) => trace.hoverinfo !== "skip" && trace.type !== "heatmap");
    if (this.layout.hovermode === "x") {
      const x = panel.x.value(px);
      const rows = told.map((trace) => [trace, nearestIndex(trace.x, x)]).filter(([trace, k]) => trace.y[k] !== null);
      return rows.length ? [shortNumber(rows[0][0].x[rows[0][1]]), ...rows.map(([trace, k]) => `${trace.name}: ${shortNumber(trace.y[k])}`)] : [];
    }
    let best = null, near = 18;
    for (const trace of told) {
      trace.x.forEach((x, k) => {
        if (x === null || trace.y[k] === null) return;
        const away = Math.hypot(panel.x.at(x) - px, panel.y.at(trace.y[k]) - py);
        if (away < near) { near = away; best = [trace, k]; }
      });
    }
    if (!best) return [];
    const [trace, k] = best, text = trace.text?.[k];
    return [...(trace.name || text ? [[trace.name, text].filter(Boolean).join(": ")] : []), `${shortNumber(trace.x[k])}, ${shortNumber(trace.y[k])}`];
  }
}

/** Index of the value nearest to x. */
function nearestIndex(values, x) {
  let best = 0;
  values.forEach((value, k) => { if (value !== null && Math.abs(value - x) < Math.abs(values[best] - x)) best = k; });
  return best;
}

/** Draw a chart on the element with an id, or draw it anew. */
function chartOn(id, data, layout) {
  const target = byId(id);
  if (target.chart) target.chart.set({data, layout});
  else new Chart(target, {data, layout});
}
