/* Place the labels of a view beside their objects, so that none covers another. */

const SEATS = [[1, 0], [0, -1], [-1, 0], [0, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]]
  .flatMap(([i, j]) => [11, 20, 34].map((far) => ({i, j, far})));

/** Rectangle of a label at a seat beside a point. */
function seated({at, wide, size}, {i, j, far}) {
  const off = i && j ? 0.75 * far : far, tall = 1.15 * size;
  const x = at[0] + i * off - (i < 0 ? wide : i ? 0 : wide / 2);
  const y = at[1] + j * off - (j < 0 ? tall : j ? 0 : tall / 2);
  return [x, y, x + wide, y + tall];
}
const shared = (a, b) => Math.max(0, Math.min(a[2], b[2]) - Math.max(a[0], b[0]))
  * Math.max(0, Math.min(a[3], b[3]) - Math.max(a[1], b[1]));

/** Squares along what is drawn, which labels had better not cover. */
function obstacles(view) {
  const found = [];
  for (const {trace, points} of view.found) {
    if (trace.veil) continue;
    points.forEach((p, k) => {
      if (!p || (trace.kind === "mesh" && k % 3)) return;
      const half = trace.kind === "marks" ? trace.size + 2 : (trace.width || 2) / 2 + 1, q = points[k + 1];
      const count = trace.kind === "lines" && q ? Math.min(Math.ceil(Math.hypot(q[0] - p[0], q[1] - p[1]) / 9), 80) : 1;
      for (let s = 0; s < count; s++) {
        const [x, y] = count > 1 ? [0, 1].map((i) => p[i] + (q[i] - p[i]) * s / count) : p;
        found.push([x - half, y - half, x + half, y + half]);
      }
    });
  }
  return found;
}

function placeLabels(view) {
  const {pen, W, H} = view, taken = view.corner ? [view.corner] : [], blocked = view.words.length ? obstacles(view) : [];
  view.placed = [];
  for (const word of view.words) {
    word.wide = wide(word.text, word.size) + 4;
    let best = null;
    for (const seat of SEATS) {
      const box = seated(word, seat), area = (box[2] - box[0]) * (box[3] - box[1]);
      if (box[0] < 1 || box[1] < 1 || box[2] > W - 1 || box[3] > H - 1) continue;
      let cost = 0.25 * seat.far + (seat.i && seat.j ? 1 : 0);
      for (const other of taken) cost += 120 * Math.min(1, 4 * shared(box, other) / area);
      for (const other of blocked) if (shared(box, other)) cost += 1.5;
      if (view.seats.get(word.key) === seat) cost -= 5;
      if (!best || cost < best.cost) best = {cost, seat, box};
    }
    /* A label that finds no place is left out; the pointer still names the object. */
    if (!best || best.cost > 75) continue;
    view.seats.set(word.key, best.seat);
    taken.push(best.box);
    view.placed.push({text: word.text, box: best.box});
    pen.font = `${word.size}px ${FONT}`;
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    const [x, y] = [best.box[0] + 2, (best.box[1] + best.box[3]) / 2];
    pen.lineJoin = "round";
    pen.lineWidth = 3.5;
    pen.strokeStyle = tone("#ffffff", 0.85);
    pen.strokeText(word.text, x, y);
    pen.fillStyle = tone(word.color);
    pen.fillText(word.text, x, y);
  }
}
