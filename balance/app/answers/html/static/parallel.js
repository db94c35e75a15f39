/* Parallel coordinates: an axis for each column, a line for each row, ranges to brush. */

const RAMP = ["#3b2f6b", "#2a6f97", "#2a9d8f", "#c9a227"];

class Parallel {
  /** `changed` is called when a range was brushed; columns have values, and a brush or none. */
  constructor(target, columns, changed) {
    Object.assign(this, {target, columns: [...columns], changed, colours: null, kept: []});
    this.sheet = target.appendChild(element("canvas", {style: "position: absolute; inset: 0; width: 100%; height: 100%"}));
    this.root = target.appendChild(svg("svg", {style: "position: relative; width: 100%; height: 100%; touch-action: none"}));
    this.root.addEventListener("pointerdown", (event) => this.down(event));
    this.root.addEventListener("pointermove", (event) => this.drag?.(event));
    for (const end of ["pointerup", "pointercancel"]) this.root.addEventListener(end, (event) => { this.drop?.(event); this.drag = this.drop = null; });
    redrawn.add(() => this.draw());
  }
  /** Draw the rows that are kept over the others, with a colour by the values of a column. */
  show(kept, by) {
    [this.kept, this.by] = [kept, by];
    this.draw();
  }
  get top() { return 70; }
  get bottom() { return this.target.clientHeight - 24; }
  x(c) { return 60 + c * (this.target.clientWidth - 120) / Math.max(this.columns.length - 1, 1); }
  y(column, value) {
    const [low, high] = column.range;
    return this.bottom + (this.top - this.bottom) * (value - low) / (high - low || 1);
  }
  value(column, y) {
    const [low, high] = column.range, share = (y - this.bottom) / (this.top - this.bottom);
    return low + Math.min(Math.max(share, 0), 1) * (high - low);
  }
  draw() {
    const W = this.target.clientWidth, H = this.target.clientHeight, dots = onPaper ? 3 : window.devicePixelRatio || 1;
    if (!W) return;
    [this.sheet.width, this.sheet.height] = [W * dots, H * dots];
    const pen = this.sheet.getContext("2d"), kept = new Set(this.kept), count = this.columns[0]?.values.length || 0;
    pen.scale(dots, dots);
    const rows = Array.from({length: count}, (_, k) => k);
    this.strokes(pen, rows.filter((k) => !kept.has(k)), () => tone("#c9ced4", 0.3));
    this.strokes(pen, this.kept, (k) => this.colour(k));
    this.root.replaceChildren(...this.columns.flatMap((column, c) => this.axis(column, this.x(c))));
  }
  colour(k) {
    const [low, high] = this.by.range, value = this.by.values[k];
    if (value === null) return tone("#8d97a3", 0.4);
    const at = Math.min((value - low) / (high - low || 1), 1) * (RAMP.length - 1.001), i = Math.floor(at);
    const [a, b] = [RAMP[i], RAMP[i + 1]].map((hex) => shade(hex));
    return `rgb(${a.map((v, j) => Math.round(255 * (v + (at - i) * (b[j] - v)))).join(" ")} / 0.55)`;
  }
  strokes(pen, rows, colour) {
    for (const k of rows) {
      pen.beginPath();
      let on = false;
      this.columns.forEach((column, c) => {
        const value = column.values[k];
        if (value === null) { on = false; return; }
        pen[on ? "lineTo" : "moveTo"](this.x(c), this.y(column, value));
        on = true;
      });
      pen.strokeStyle = colour(k);
      pen.stroke();
    }
  }
  axis(column, x) {
    const word = (y, text, more = {}) => {
      const made = svg("text", {x, y, "text-anchor": "middle", "font-size": 11, fill: tone("#1b1e22"), class: "halo", ...more});
      made.textContent = text;
      return made;
    };
    const names = column.lines.map((line, k) => word(20 + 13 * k, line, {"font-size": 12, style: "cursor: ew-resize"}));
    const ends = column.range.map((value, end) => word(end ? this.top - 6 : this.bottom + 15, column.text(value)));
    const brush = column.brush && [].concat(Array.isArray(column.brush[0]) ? column.brush : [column.brush]).map(([low, high]) => {
      const from = this.y(column, Math.min(high, column.range[1])), to = this.y(column, Math.max(low, column.range[0]));
      return svg("rect", {x: x - 6, y: from, width: 12, height: Math.max(to - from, 2), fill: tone("#0a5ea8", 0.45), class: "brush"});
    });
    return [svg("path", {d: `M${x} ${this.top}V${this.bottom}`, stroke: tone("#1b1e22"), "stroke-width": 1}), ...(brush || []), ...ends, ...names];
  }
  down(event) {
    const box = this.root.getBoundingClientRect(), at = (e) => [e.clientX - box.left, e.clientY - box.top];
    const [px, py] = at(event), c = this.columns.findIndex((_, k) => Math.abs(this.x(k) - px) < 24);
    if (c < 0) return;
    const column = this.columns[c];
    this.root.setPointerCapture(event.pointerId);
    if (py < this.top - 14) {
      this.drop = (e) => {
        const place = this.columns.findIndex((_, k) => this.x(k) + (this.x(1) - this.x(0)) / 2 > at(e)[0]);
        this.columns.splice(c, 1);
        this.columns.splice(place < 0 ? this.columns.length : place, 0, column);
        this.draw();
      };
      return;
    }
    const first = this.value(column, py);
    this.drag = (e) => {
      column.brush = [first, this.value(column, at(e)[1])].sort((a, b) => a - b);
      this.draw();
    };
    this.drop = (e) => {
      if (Math.abs(at(e)[1] - py) < 4) column.brush = undefined;
      this.changed();
    };
  }
}
