/* Shapes with vertices on parts of a linkage, and traces that a view draws of them. */

const INK = "#2b3036", LINK = "#8d97a3", GHOST = "#c3c8ce", SOFT = "#5a626b";
const PLUS = "#0a5ea8", MINUS = "#d2691e", STRIPE = "#d5e4f3";
const TRAIL = "#3d7a3d";

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
  /** Triangles of points. */
  surface(part, {points, faces}, text) {
    const start = this.vertices.length;
    for (const p of points) this.vertices.push([part, p, text]);
    for (const face of faces) this.faces.push(face.map((k) => start + k));
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
  /** The triangles of each part as arrays, with normals averaged over faces. */
  pieces() {
    if (this.made) return this.made;
    const at = new Map(), found = new Map();
    this.vertices.forEach(([part, p], k) => {
      if (!found.has(part)) found.set(part, {part, points: [], normals: [], faces: []});
      const piece = found.get(part);
      at.set(k, piece.points.length / 3);
      piece.points.push(...p);
      piece.normals.push(0, 0, 0);
    });
    for (const face of this.faces) {
      const [a, b, c] = face.map((k) => this.vertices[k][1]), normal = cross(add(b, a, -1), add(c, a, -1));
      const piece = found.get(this.vertices[face[0]][0]);
      for (const k of face) {
        piece.faces.push(at.get(k));
        for (let i = 0; i < 3; i++) piece.normals[3 * at.get(k) + i] += normal[i];
      }
    }
    this.made = [...found.values()].map(({part, points, normals, faces}) => ({
      part, points: new Float32Array(points), normals: new Float32Array(normals.map((x) => 1e3 * x)), faces: new Uint32Array(faces),
    }));
    return this.made;
  }
}

/** A point with a text. */
class Labels {
  constructor() { this.vertices = []; }
  put(part, point, text) { this.vertices.push([part, point, text]); }
}

/** Shorten long names. */
const plain = (text) => text.length > 40 ? `${text.slice(0, 40)}…` : text;

/** Format a number with four digits. */
const number = (x) => String(Number(x.toPrecision(4))).replace("-", "−");

/* Traces: a kind, a name, vertices on parts, and the pose that moves them. */
const lines = (name, shape, H, line, hover = false) =>
  ({kind: "lines", name, vertices: shape.vertices, H, hover, width: 2, ...line});
const mesh = (name, shape, H, color, opacity = 1) =>
  ({kind: "mesh", name, mesh: shape, vertices: shape.vertices, H, color, opacity, hover: true});
const texts = (name, labels, H, color, size) =>
  ({kind: "texts", name, vertices: labels.vertices, H, color, size});
const marks = (name, labels, H, symbol, size, fill = "#ffffff") =>
  ({kind: "marks", name, vertices: labels.vertices, H, symbol, size, fill, hover: true});
