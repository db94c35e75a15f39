/* Vectors, displacements, and shapes with vertices on parts. */

const report = data("report");
const scene = data("scene");

const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = (a) => Math.sqrt(dot(a, a));
const unit = (a) => scaled(a, 1 / (norm(a) || 1));
const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const mean = (points) => scaled(points.reduce((a, b) => add(a, b), [0, 0, 0]), 1 / points.length);

/** Two unit vectors that form a right-handed frame with the unit vector d. */
function across(d) {
  const helper = Math.abs(d[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const u = unit(cross(helper, d));
  return [u, cross(d, u)];
}

/** Apply the displacement H (first three rows; null if none) to the point p. */
const moved = (H, p) => H === null ? p : [
  H[0] * p[0] + H[1] * p[1] + H[2] * p[2] + H[3],
  H[4] * p[0] + H[5] * p[1] + H[6] * p[2] + H[7],
  H[8] * p[0] + H[9] * p[1] + H[10] * p[2] + H[11],
];

const INK = "#2b3036", LINK = "#8d97a3", GHOST = "#c3c8ce", SOFT = "#5a626b";
const PLUS = "#0a5ea8", MINUS = "#d2691e", STRIPE = "#d5e4f3";
const size = scene.size;

/** Lines, each through vertices of one or several parts. */
class Lines {
  constructor() { this.vertices = []; }
  path(part, points, text = "") {
    for (const p of points) this.vertices.push([part, p, text]);
    this.vertices.push(null);
  }
  between(partA, a, partB, b, text = "") {
    this.vertices.push([partA, a, text], [partB, b, text], null);
  }
  circle(part, centre, u, v, radius, count = 24) {
    const ring = [];
    for (let k = 0; k <= count; k++) {
      const t = 2 * Math.PI * k / count;
      ring.push(add(add(centre, u, radius * Math.cos(t)), v, radius * Math.sin(t)));
    }
    this.path(part, ring);
  }
}

/** Triangles. */
class Mesh {
  constructor() { this.vertices = []; this.faces = []; }
  grid(part, rows, text = "") {
    const start = this.vertices.length, width = rows[0].length;
    for (const row of rows) for (const p of row) this.vertices.push([part, p, text]);
    for (let r = 0; r + 1 < rows.length; r++) {
      for (let c = 0; c < width; c++) {
        const a = start + r * width + c, b = start + r * width + (c + 1) % width;
        this.faces.push([a, b, b + width], [a, b + width, a + width]);
      }
    }
  }
  fan(part, corners, text = "") {
    const start = this.vertices.length, count = corners.length;
    this.vertices.push([part, mean(corners), text], ...corners.map((p) => [part, p, text]));
    for (let k = 0; k < count; k++) {
      this.faces.push([start, start + 1 + k, start + 1 + (k + 1) % count]);
    }
  }
  sphere(part, centre, radius, text) {
    const rows = [];
    for (let r = 0; r <= 10; r++) {
      const a = Math.PI * r / 10, row = [];
      for (let c = 0; c < 18; c++) {
        const b = 2 * Math.PI * c / 18;
        row.push(add(centre, [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)], radius));
      }
      rows.push(row);
    }
    this.grid(part, rows, text);
  }
  /** A surface around the axis through points, with a radius at each. */
  turned(part, points, radii, d, text) {
    const [u, v] = across(d);
    const rows = points.map((p, i) => Array.from({length: 16}, (_, c) => {
      const t = 2 * Math.PI * c / 16;
      return add(add(p, u, radii[i] * Math.cos(t)), v, radii[i] * Math.sin(t));
    }));
    this.grid(part, rows, text);
  }
}

/** A point with a text. */
class Labels {
  constructor() { this.vertices = []; }
  put(part, point, text) { this.vertices.push([part, point, text]); }
}

/* Plotly interprets some HTML in texts: escape names from files. */
const plain = (text) => (text.length > 40 ? `${text.slice(0, 40)}…` : text)
  .replace(/</g, "‹").replace(/>/g, "›").replace(/&/g, "＆");

/** Format a number with four digits. */
const number = (x) => String(Number(x.toPrecision(4))).replace("-", "−");
