/* Vectors, displacements (the first three rows of a matrix, as 12 numbers) and screws. */

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

/** Apply the displacement H (null if none) to the point p. */
const moved = (H, p) => H === null ? p : [
  H[0] * p[0] + H[1] * p[1] + H[2] * p[2] + H[3],
  H[4] * p[0] + H[5] * p[1] + H[6] * p[2] + H[7],
  H[8] * p[0] + H[9] * p[1] + H[10] * p[2] + H[11],
];
const turnedBy = (H, d) => H === null ? d : add(moved(H, d), [H[3], H[7], H[11]], -1);

const UNMOVED = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
/** The product of two displacements. */
function compose(A, B) {
  const C = new Array(12);
  for (let r = 0; r < 12; r += 4) {
    for (let c = 0; c < 4; c++) {
      C[r + c] = A[r] * B[c] + A[r + 1] * B[4 + c] + A[r + 2] * B[8 + c] + (c === 3 ? A[r + 3] : 0);
    }
  }
  return C;
}
function inverted(H) {
  const R = [H[0], H[4], H[8], 0, H[1], H[5], H[9], 0, H[2], H[6], H[10], 0];
  const p = moved(R, [H[3], H[7], H[11]]);
  [R[3], R[7], R[11]] = scaled(p, -1);
  return R;
}

/** The displacement exp(q ŝ) of the screw [ω; v], whose ω is a unit vector or zero. */
function along(screw, q) {
  const w = screw.slice(0, 3), v = screw.slice(3);
  if (!norm(w)) return [1, 0, 0, q * v[0], 0, 1, 0, q * v[1], 0, 0, 1, q * v[2]];
  const s = Math.sin(q), c = 1 - Math.cos(q);
  const turn = (p) => add(add(p, cross(w, p), s), cross(w, cross(w, p)), c);
  const [a, b, d] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(turn);
  /* p = (1 - R) (ω × v) + ω ωᵀ v q */
  const lever = cross(w, v), p = add(add(lever, turn(lever), -1), w, dot(w, v) * q);
  return [a[0], b[0], d[0], p[0], a[1], b[1], d[1], p[1], a[2], b[2], d[2], p[2]];
}

/** The screw (or twist) [ω; v] carried by the displacement H. */
function carried(H, screw) {
  const w = turnedBy(H, screw.slice(0, 3)), v = turnedBy(H, screw.slice(3));
  return [...w, ...add(v, cross([H[3], H[7], H[11]], w))];
}
