/* Poses of a linkage whose loops are closed: products of exponentials and Newton's method. */

const CLOSED = 1e-11, TURN = 0.06, MOST_STEPS = 400;

/** Solve (AᵀA + ε 1) x = Aᵀ b for rows A: the shortest of the least squares. */
function leastSquares(A, b) {
  const n = A[0].length, M = Array.from({length: n}, () => new Float64Array(n + 1));
  A.forEach((row, r) => {
    for (let i = 0; i < n; i++) {
      if (row[i] === 0) continue;
      for (let j = i; j < n; j++) M[i][j] += row[i] * row[j];
      M[i][n] += row[i] * b[r];
    }
  });
  let trace = 0;
  for (let i = 0; i < n; i++) trace += M[i][i];
  for (let i = 0; i < n; i++) {
    M[i][i] += 1e-13 * trace;
    for (let j = 0; j < i; j++) M[i][j] = M[j][i];
  }
  for (let i = 0; i < n; i++) {
    for (let k = i + 1; k < n; k++) {
      const f = M[k][i] / M[i][i];
      if (f !== 0) for (let j = i; j <= n; j++) M[k][j] -= f * M[i][j];
    }
  }
  const x = new Float64Array(n);
  for (let i = n - 1; i >= 0; i--) {
    x[i] = M[i][n];
    for (let j = i + 1; j < n; j++) x[i] -= M[i][j] * x[j];
    x[i] /= M[i][i];
  }
  return x;
}

/** The joints of a linkage, and how they move. */
class Mechanism {
  constructor({parent, screws, ends, mimics, inputs, length}) {
    Object.assign(this, {parent, screws, ends, mimics, inputs, length});
    this.size = parent.length;
    this.dependent = parent.map((_, j) => j).filter((j) => !inputs.includes(j));
    const path = (link) => link < 0 ? [] : [...path(parent[link]), link];
    /* Joints that carry only one of the two ends of a loop, with the sign of their twist. */
    this.around = ends.map(([a, b]) => {
      const [one, other] = [path(a), path(b)];
      return [...one.filter((j) => !other.includes(j)).map((j) => [j, 1]),
        ...other.filter((j) => !one.includes(j)).map((j) => [j, -1])];
    });
  }
  /** Displacements of all links at joint positions q. */
  links(q) {
    const H = [];
    this.screws.forEach((screw, j) => {
      const own = along(screw, q[j]);
      H.push(this.parent[j] < 0 ? own : compose(H[this.parent[j]], own));
    });
    return H;
  }
  /** Screws of all joints at the pose with these displacements. */
  screwsAt(H) {
    return this.screws.map((screw, j) => this.parent[j] < 0 ? screw : carried(H[this.parent[j]], screw));
  }
  /** Rows that joint rates satisfy, and how far the loops are open. */
  closure(q) {
    const H = this.links(q), screws = this.screwsAt(H), rows = [], open = [];
    this.ends.forEach(([a, b], k) => {
      /* exp(-open) = H_b H_a⁻¹ is the displacement that is missing at the end. */
      const G = compose(b < 0 ? UNMOVED : H[b], a < 0 ? UNMOVED : inverted(H[a]));
      const half = [(G[9] - G[6]) / 2, (G[2] - G[8]) / 2, (G[4] - G[1]) / 2];
      const sine = norm(half), cosine = (G[0] + G[5] + G[10] - 1) / 2;
      const turn = scaled(half, sine > 1e-9 ? Math.atan2(sine, cosine) / sine : 1);
      const shift = add([G[3], G[7], G[11]], cross(turn, [G[3], G[7], G[11]]), -0.5);
      const twist = [...turn, ...scaled(shift, 1 / this.length)];
      for (let i = 0; i < 6; i++) {
        const row = new Float64Array(this.size);
        for (const [j, sign] of this.around[k]) row[j] += sign * screws[j][i] / (i < 3 ? 1 : this.length);
        rows.push(row); open.push(twist[i]);
      }
    });
    for (const row of this.mimics) {
      rows.push(Float64Array.from(row));
      open.push(-row.reduce((sum, f, j) => sum + f * q[j], 0));
    }
    return {rows, open, error: Math.max(0, ...open.map(Math.abs))};
  }
  /** Joint rates for rates of the inputs, at joint positions q. */
  rates(q, inputs) {
    const rate = new Float64Array(this.size);
    this.inputs.forEach((j, i) => { rate[j] = inputs[i]; });
    if (!this.dependent.length) return rate;
    const {rows} = this.closure(q);
    const right = rows.map((row) => -this.inputs.reduce((sum, j) => sum + row[j] * rate[j], 0));
    const x = leastSquares(this.select(rows), right);
    this.dependent.forEach((j, i) => { rate[j] = x[i]; });
    return rate;
  }
  select(rows) { return rows.map((row) => this.dependent.map((j) => row[j])); }
  /** Twists [ω; v] of all links at joint positions and rates. */
  twists(q, rate) {
    const found = [];
    this.screwsAt(this.links(q)).forEach((screw, j) => {
      const before = this.parent[j] < 0 ? [0, 0, 0, 0, 0, 0] : found[this.parent[j]];
      found.push(before.map((x, i) => x + rate[j] * screw[i]));
    });
    return found;
  }
  /** Close the loops from a guess by moving the dependent joints; null if that fails. */
  closed(guess, most) {
    const q = Float64Array.from(guess);
    if (!this.dependent.length) return q;
    for (let k = 0; k < 12; k++) {
      const {rows, open, error} = this.closure(q);
      if (error < CLOSED) return q;
      const x = leastSquares(this.select(rows), open);
      this.dependent.forEach((j, i) => { q[j] += x[i]; });
      if (!this.dependent.every((j) => Math.abs(q[j] - guess[j]) <= most * this.unitOf(j))) return null;
    }
    return null;
  }
  /** Radians, or the characteristic length of a joint that slides. */
  unitOf(j) { return norm(this.screws[j].slice(0, 3)) ? 1 : this.length; }
  /** Move the inputs along a line from q towards u, on one branch, as far as the loops close. */
  toward(q, u) {
    const start = this.inputs.map((j) => q[j]);
    const way = Math.max(...u.map((x, i) => Math.abs(x - start[i]) / this.unitOf(this.inputs[i])), 0);
    let share = 0, now = Float64Array.from(q), step = Math.min(1, TURN / (way || 1));
    for (let k = 0; share < 1 && k < MOST_STEPS; k++) {
      const long = Math.min(step, 1 - share);
      const rate = this.rates(now, u.map((x, i) => x - start[i]));
      const fast = Math.max(1e-9, ...this.dependent.map((j) => Math.abs(rate[j]) / this.unitOf(j)));
      /* No joint turns by more than 0.25 rad in a step, and the correction stays small. */
      const part = Math.min(long, 0.25 / fast);
      const guess = now.map((x, j) => x + part * rate[j]);
      this.inputs.forEach((j, i) => { guess[j] = start[i] + (share + part) * (u[i] - start[i]); });
      const next = this.closed(guess, 0.35 * Math.max(part * fast, 1e-6));
      if (next) { now = next; share += part; step = Math.min(2 * part, TURN / (way || 1)); }
      else step = part / 2;
      if (step * way < 1e-5) break;
    }
    return {q: now, reached: share > 1 - 1e-9};
  }
}
