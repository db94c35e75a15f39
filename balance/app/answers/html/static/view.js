/* A view of traces in three dimensions: camera, drawing, and the hands and keys that turn it. */

const FONT = 'Charter, "Bitstream Charter", "Liberation Serif", Georgia, serif';
const PAD = 40;

class View {
  /** Draw into an element; `up` and `sight` are the home directions of the camera. */
  constructor(holder, {up, sight, size, planar}) {
    Object.assign(this, {holder, up, home: sight, size, planar});
    this.canvas = holder.appendChild(element("canvas", {tabindex: 0}));
    this.pen = this.canvas.getContext("2d");
    this.tip = holder.appendChild(element("div", {class: "readout", hidden: ""}));
    this.traces = [];
    this.seats = new Map();
    this.listen();
    this.reset();
    redrawn.add(() => this.draw());
  }
  get W() { return this.holder.clientWidth; }
  get H() { return this.holder.clientHeight; }
  get dots() { return onPaper ? 3 : Math.min(window.devicePixelRatio || 1, 2); }
  reset() {
    this.turn([unit(cross(this.up, this.home)), this.up, this.home]);
    this.free = false;
    this.box = null;
    this.seat = null;
  }
  turn([right, , toward]) {
    this.toward = unit(toward);
    this.right = unit(right);
    this.top = cross(this.toward, this.right);
  }
  /** Widen the frame to hold points too, unless the user has moved it. */
  hold(points) {
    this.held = points;
    if (this.free || !this.W) return;
    const at = points.map((p) => [dot(p, this.right), dot(p, this.top)]);
    const box = this.box || [[Infinity, -Infinity], [Infinity, -Infinity]];
    for (const p of at) {
      box.forEach((b, i) => { b[0] = Math.min(b[0], p[i]); b[1] = Math.max(b[1], p[i]); });
    }
    this.box = box;
    const pad = Math.min(PAD, 0.12 * this.W);
    const wide = Math.max(box[0][1] - box[0][0], 1e-6 * this.size), tall = Math.max(box[1][1] - box[1][0], 1e-6 * this.size);
    this.zoom = Math.min((this.W - 2 * pad) / wide, (this.H - 2 * pad) / tall);
    const mid = box.map(([low, high]) => (low + high) / 2);
    const deep = mean(points);
    this.centre = add(add(scaled(this.toward, dot(deep, this.toward)), this.right, mid[0]), this.top, mid[1]);
  }
  project(p) {
    const off = add(p, this.centre, -1);
    return [this.W / 2 + this.zoom * dot(off, this.right), this.H / 2 - this.zoom * dot(off, this.top), dot(off, this.toward)];
  }

  show(traces) {
    this.traces = traces;
    this.draw();
  }
  draw() {
    if (!this.W || !this.traces.length) return;
    if (this.held && !this.free) this.hold(this.held);
    const {canvas, pen, W, H, dots} = this;
    [canvas.width, canvas.height] = [Math.round(W * dots), Math.round(H * dots)];
    pen.setTransform(dots, 0, 0, dots, 0, 0);
    this.found = [];
    this.words = [];
    let surfaces = [], veil = 1;
    const flush = (next = 1) => {
      const drawn = surfaces.length ? solids.draw(this, surfaces) : null;
      pen.globalAlpha = veil;
      if (drawn) pen.drawImage(drawn, 0, 0, W, H);
      pen.globalAlpha = 1;
      [surfaces, veil] = [[], next];
    };
    for (const trace of this.traces) {
      if (trace.kind === "mesh") {
        if (veil !== (trace.veil || 1)) flush(trace.veil);
        if (trace.mesh.pieces().length) surfaces.push(trace);
        this.find(trace, trace.vertices.map((v) => this.place(trace, v)));
        continue;
      }
      flush();
      const points = trace.vertices.map((v) => v && this.place(trace, v));
      this[trace.kind](trace, points);
    }
    flush();
    this.compass();
    this.label();
  }
  place(trace, vertex) { return this.project(moved(trace.H[vertex[0]], vertex[1])); }
  find(trace, points) {
    if (trace.hover) this.found.push({trace, points});
  }
  lines(trace, points) {
    const {pen} = this, {width, color, dash, halo} = trace, segments = [];
    points.forEach((p, k) => { if (p && points[k + 1]) segments.push([p, points[k + 1]]); });
    pen.lineCap = dash ? "butt" : "round";
    pen.lineJoin = "round";
    pen.setLineDash(dash === "dash" ? [7, 5] : dash === "dashdot" ? [9, 4, 2, 4] : []);
    const stroke = (pieces, style, wide) => {
      pen.beginPath();
      for (const piece of pieces) piece.forEach((p, i) => pen[i ? "lineTo" : "moveTo"](p[0], p[1]));
      pen.strokeStyle = style;
      pen.lineWidth = wide;
      pen.stroke();
    };
    if (halo) {
      segments.sort((a, b) => a[0][2] + a[1][2] - b[0][2] - b[1][2]);
      for (const segment of segments) {
        stroke([segment], tone("#ffffff"), width + 3);
        stroke([segment], tone(color), width);
      }
    } else {
      const pieces = [[]];
      for (const p of points) p ? pieces.at(-1).push(p) : pieces.push([]);
      stroke(pieces.filter((piece) => piece.length > 1), tone(color), width);
    }
    pen.setLineDash([]);
    this.find(trace, points);
  }
  marks(trace, points) {
    const {pen} = this, r = trace.size;
    points.forEach(([x, y]) => {
      pen.beginPath();
      if (trace.symbol === "square") pen.rect(x - r, y - r, 2 * r, 2 * r);
      else if (trace.symbol === "diamond") [[0, -r], [r, 0], [0, r], [-r, 0]].forEach(([a, b], i) => pen[i ? "lineTo" : "moveTo"](x + 1.3 * a, y + 1.3 * b));
      else pen.arc(x, y, r, 0, 2 * Math.PI);
      pen.closePath();
      pen.fillStyle = tone(trace.fill);
      pen.strokeStyle = tone(INK);
      pen.lineWidth = 1.6;
      pen.fill();
      if (trace.symbol === "centre") {
        /* The sign of a centre of mass: two quarters filled. */
        pen.fillStyle = tone(INK);
        for (const start of [0, Math.PI]) {
          pen.beginPath(); pen.moveTo(x, y); pen.arc(x, y, r, start, start + Math.PI / 2); pen.closePath(); pen.fill();
        }
        pen.beginPath(); pen.arc(x, y, r, 0, 2 * Math.PI);
      }
      pen.stroke();
    });
    this.find(trace, points);
  }
  texts(trace, points) {
    points.forEach((p, k) => this.words.push({
      key: `${trace.name} ${k}`, text: trace.vertices[k][2], at: p, color: trace.color, size: trace.size,
    }));
  }
  label() { placeLabels(this); }

  /** Inertial axes of a round length in a corner. */
  compass() {
    if (!this.axes) return;
    const {pen} = this, fit = 46 / this.zoom, unit_ = 10 ** Math.floor(Math.log10(fit));
    const long = [5, 2, 1].map((f) => f * unit_).find((l) => l <= fit * 1.0001);
    const ends = this.axes.map(([name, axis]) =>
      [name, long * this.zoom * dot(axis, this.right), -long * this.zoom * dot(axis, this.top)]);
    const span = (k) => [Math.min(0, ...ends.map((e) => e[k])), Math.max(0, ...ends.map((e) => e[k]))];
    const [[x0, x1], [y0, y1]] = [span(1), span(2)], box = [Math.max(x1 - x0, 60) + 34, y1 - y0 + 48];
    this.corner = this.emptiest(box);
    const [x, y] = [this.corner[0] + 16 - x0, this.corner[1] + 16 - y0];
    pen.font = `13px ${FONT}`;
    pen.strokeStyle = pen.fillStyle = tone(SOFT);
    pen.lineWidth = 2;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    for (const [name, a, b] of ends) {
      const away = Math.hypot(a, b);
      if (away < 6) continue;
      pen.beginPath(); pen.moveTo(x, y); pen.lineTo(x + a, y + b); pen.stroke();
      pen.fillText(name, x + a * (1 + 9 / away), y + b * (1 + 9 / away));
    }
    pen.textAlign = "left";
    pen.fillText(`axes ${number(long)} m`, this.corner[0] + 10, this.corner[3] - 10);
  }
  /** The corner of the frame with a size in which least is drawn; it stays until the view is reset. */
  emptiest([w, h]) {
    const corners = [[0, this.H - h], [this.W - w, this.H - h], [0, 0], [this.W - w, 0]].map(([x, y]) => [x, y, x + w, y + h]);
    const crowd = ([a, b, c, d]) => this.found.reduce((sum, {points}) =>
      sum + points.filter((p) => p && p[0] > a && p[0] < c && p[1] > b && p[1] < d).length, 0);
    this.seat ??= corners.map(crowd).reduce((best, n, k, all) => n < all[best] ? k : best, 0);
    return corners[this.seat];
  }

  listen() {
    const {canvas} = this, down = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      down.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
      this.tip.hidden = true;
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = down.get(event.pointerId), now = [event.clientX, event.clientY];
      if (!last) return this.tell(event);
      down.set(event.pointerId, now);
      this.drag(now[0] - last[0], now[1] - last[1], event.shiftKey !== this.planar);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => down.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => { this.tip.hidden = true; });
    canvas.addEventListener("dblclick", () => this.act("Home"));
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.magnify(Math.exp(-0.01 * event.deltaY));
    }, {passive: false});
    canvas.addEventListener("keydown", (event) => {
      if (!event.altKey && !event.ctrlKey && !event.metaKey && this.act(event.key, event.shiftKey)) event.preventDefault();
    });
  }
  /** Do what a key means; whether it means anything. */
  act(key, shift = false) {
    const ways = {ArrowLeft: [-24, 0], ArrowRight: [24, 0], ArrowUp: [0, -24], ArrowDown: [0, 24]};
    if (ways[key]) this.drag(...ways[key], shift !== this.planar);
    else if (key === "+" || key === "=") this.magnify(1.2);
    else if (key === "-") this.magnify(1 / 1.2);
    else if (key === "Home") { this.reset(); this.draw(); }
    else return false;
    return true;
  }
  drag(dx, dy, pan) {
    if (pan) {
      this.free = true;
      this.centre = add(add(this.centre, this.right, -dx / this.zoom), this.top, dy / this.zoom);
    } else {
      const spin = (axis, angle, v) => turnedBy(along([...axis, 0, 0, 0], angle), v);
      const pivot = this.pivot || this.centre, off = add(this.centre, pivot, -1);
      const held = [dot(off, this.right), dot(off, this.top), dot(off, this.toward)];
      const turned = [this.right, this.top, this.toward]
        .map((v) => spin(this.up, -0.008 * dx, spin(this.right, -0.008 * dy, v)));
      this.turn(turned);
      this.free = true;
      this.centre = add(add(add(pivot, this.right, held[0]), this.top, held[1]), this.toward, held[2]);
    }
    this.draw();
  }
  magnify(factor) {
    this.free = true;
    this.zoom *= factor;
    this.draw();
  }
  /** Name what is under the pointer. */
  tell(event) {
    const box = this.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const text = this.named(x, y);
    this.tip.hidden = !text;
    this.tip.textContent = text;
    this.tip.style.left = `${Math.min(x + 14, this.W - this.tip.offsetWidth - 4)}px`;
    this.tip.style.top = `${Math.min(y + 14, this.H - this.tip.offsetHeight - 4)}px`;
  }
  named(x, y) {
    let text = "", near = 12;
    for (const {trace, points} of this.found || []) {
      points.forEach((p, k) => {
        if (!p || !trace.vertices[k][2]) return;
        const q = trace.kind === "lines" ? points[k + 1] || p : p;
        const d = [q[0] - p[0], q[1] - p[1]], square = d[0] ** 2 + d[1] ** 2;
        const t = square ? Math.min(Math.max(((x - p[0]) * d[0] + (y - p[1]) * d[1]) / square, 0), 1) : 0;
        const away = Math.hypot(p[0] + t * d[0] - x, p[1] + t * d[1] - y) + (trace.kind === "lines" ? 4 : 0);
        if (away < near) { near = away; text = trace.vertices[k][2]; }
      });
    }
    return text;
  }
}
