/* Draw the linkage with beams that bend, exaggerated. */

(() => {
  const frames = data("frames"), canvas = byId("bend"), pen = canvas.getContext("2d");
  const time = byId("bend-time"), scale = byId("bend-scale"), words = byId("bend-words");
  const dark = "#1b1e22", blue = "#0a5ea8", grey = "#9aa3ab";
  time.max = frames.times.length - 1;
  time.value = Math.round(0.6 * time.max);

  const all = [...frames.grounds, ...frames.links.flat(2), ...frames.straight.flat(2)];
  const low = [0, 1].map((i) => Math.min(...all.map((p) => p[i])));
  const high = [0, 1].map((i) => Math.max(...all.map((p) => p[i])));
  const size = Math.max((high[0] - low[0]) / 1040, (high[1] - low[1]) / 600, 1e-12);
  const place = (p) => [
    600 + (p[0] - (low[0] + high[0]) / 2) / size, 360 - (p[1] - (low[1] + high[1]) / 2) / size,
  ];

  // A narrow page shows the canvas small: lines keep half of their width at least.
  const thickness = () => Math.max(1, 600 / Math.max(canvas.clientWidth, 1));

  const line = (points, colour, width) => {
    pen.beginPath();
    points.forEach((p, i) => pen[i ? "lineTo" : "moveTo"](...place(p)));
    pen.strokeStyle = tone(colour);
    pen.lineWidth = width * thickness();
    pen.stroke();
  };

  const draw = () => {
    const k = Number(time.value), factor = 10 ** Number(scale.value);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.lineJoin = pen.lineCap = "round";
    frames.links.forEach((poses) => {
      const points = poses[k], centre = points[points.length - 1];
      points.slice(0, -1).forEach((p) => line([centre, p], dark, 7));
    });
    frames.straight.forEach((poses, b) => {
      line(poses[k], grey, 2);
      const bent = poses[k].map((p, i) => p.map((x, axis) => x + factor * (frames.bent[b][k][i][axis] - x)));
      line(bent, blue, 6);
    });
    frames.grounds.forEach((p) => {
      const [x, y] = place(p);
      pen.fillStyle = tone(dark);
      pen.beginPath();
      pen.arc(x, y, 8 * thickness(), 0, 2 * Math.PI);
      pen.fill();
    });
    words.textContent = `t = ${frames.times[k].toFixed(3)} s, bending × ${factor.toPrecision(3)}`;
  };

  player(byId("bend-play"), () => {
    time.value = (Number(time.value) + 1) % frames.times.length;
    draw();
  });
  redrawn.add(draw);
  time.addEventListener("input", draw);
  scale.addEventListener("input", draw);
  draw();
})();
