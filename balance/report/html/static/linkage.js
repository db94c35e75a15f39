/* Draw the linkage: links, joints, ground, and names. */

const up = scene.axes[1], side = scene.axes[0], normal = scene.axes[2];
const [vertical, horizontal, depth] = scene.planar
  ? [up, side, normal] : [scene.axes[2], scene.axes[0], scene.axes[1]];

const centre = mean(scene.joints.map((joint) => joint.point));
/* Direction from the linkage to the camera. */
const sight = scene.planar ? normal
  : unit(add(add(scaled(depth, -0.8), horizontal, 1.15), vertical, 0.85));

/* Distance of texts from their objects: larger in a small drawing. */
const gap = 0.055 * size * Math.min(Math.max(640 / (byId("plot").clientWidth || 640), 1), 1.8);

function linkage() {
  const links = new Lines(), plates = new Mesh(), rails = new Lines(), axes = new Lines();
  const ground = new Lines(), base = new Mesh(), names = new Labels();
  const marks = {turning: new Labels(), sliding: new Labels(), balls: new Labels()};
  scene.parts.forEach((part, p) => {
    const corners = part.corners, text = plain(part.names.join(", "));
    if (p === 0) return;
    if (corners.length === 2) links.path(p, corners, text);
    if (corners.length > 2) {
      links.path(p, isFlat(corners) ? [...corners, corners[0]] : corners, text);
      if (isFlat(corners)) plates.fan(p, corners, text);
    }
    if (corners.length) {
      const off = beside(corners), begin = anchor(off);
      const at = add(mean(corners), off, begin === "middle center" ? gap : 0.5 * gap);
      for (const name of part.names) {
        names.put(p, at, plain(name));
        names.vertices[names.vertices.length - 1].push(begin);
      }
    }
  });
  for (const corner of scene.parts[0].corners) drawGround(ground, corner);
  if (scene.parts[0].corners.length > 2 && !scene.planar) {
    base.fan(0, scene.parts[0].corners, "ground");
  }
  for (const joint of scene.joints) {
    const [a, b] = joint.parts, d = unit(joint.direction), half = 0.075 * size;
    const text = `${plain(joint.name)} (${joint.kind}${joint.idle ? ", idle" : ""})`;
    const ball = turningAt(joint.point) > 2;
    if (!joint.idle && !ball) {
      axes.path(a, [add(joint.point, d, -half), add(joint.point, d, half)]);
    }
    const mark = joint.kind === "prismatic" ? "sliding" : ball ? "balls" : "turning";
    marks[mark].put(b, joint.point, text);
    if (joint.kind !== "revolute") rails.between(a, joint.point, b, joint.point, text);
  }
  return {links, plates, rails, axes, ground, base, names, marks, joints: jointNames()};
}

/** Number of rotation axes through this point: three make a ball joint. */
function turningAt(point) {
  const near = (joint) => norm(add(joint.point, point, -1)) < 1e-6 * size;
  return scene.joints.filter((j) => j.kind === "revolute" && !j.idle && near(j)).length;
}

/** Unit vector across a link, away from the middle of the linkage; upwards from a plate. */
function beside(corners) {
  if (corners.length !== 2) return vertical;
  const aside = cross(add(corners[1], corners[0], -1), sight);
  if (norm(aside) < 1e-6 * size) return vertical;
  const out = add(mean(corners), centre, -1);
  return scaled(unit(aside), dot(aside, out) < 0 ? -1 : 1);
}

/** Anchor of a text at a distance in a direction: beside the link, if there is space. */
function anchor(off) {
  if (byId("plot").clientWidth < 560) return "middle center";
  const right = dot(off, unit(cross(vertical, sight)));
  return Math.abs(right) < 0.6 ? "middle center" : right > 0 ? "middle right" : "middle left";
}

/** Whether points are not collinear. */
function isFlat(points) {
  const a = add(points[points.length - 1], points[0], -1);
  return points.some((p) => norm(cross(a, add(p, points[0], -1))) > 1e-6 * size * size);
}

/** Ground symbol: a hatched foot below a joint. */
function drawGround(lines, p) {
  const h = 0.055 * size, w = 0.04 * size, foot = add(p, vertical, -h);
  const feet = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([i, j]) =>
    add(add(foot, horizontal, i * w), depth, scene.planar ? 0 : j * w));
  for (const f of feet) lines.path(0, [p, f]);
  lines.path(0, [...feet, feet[0]]);
  for (let k = -2; k <= 2; k++) {
    const top = add(add(foot, horizontal, k * w / 2), depth, scene.planar ? 0 : -w);
    lines.path(0, [top, add(add(top, vertical, -0.4 * w), horizontal, -0.4 * w)]);
  }
}

const onGround = (point) =>
  scene.parts[0].corners.some((corner) => norm(add(corner, point, -1)) < 1e-6 * size);

/** One name for each point where joints meet: the common part of their names. */
function jointNames() {
  const places = [], labels = new Labels();
  for (const joint of scene.joints) {
    const found = places.find((q) => norm(add(q.point, joint.point, -1)) < 1e-6 * size);
    if (found) found.names.push(joint.name);
    else places.push({point: joint.point, part: joint.parts[1], names: [joint.name]});
  }
  for (const place of places) {
    let common = place.names[0];
    for (const name of place.names) while (!name.startsWith(common)) common = common.slice(0, -1);
    common = place.names.length > 1 ? common.replace(/[._\-\s]+$/, "") : common;
    const text = common.length > 1 || (common && place.names[0][1] === ".") ? common : place.names.join(", ");
    const away = unit(add(place.point, centre, -1));
    const off = onGround(place.point) ? scaled(horizontal, -gap) : scaled(away, gap);
    labels.put(place.part, add(place.point, off), plain(text));
    labels.vertices[labels.vertices.length - 1].push(place.names);
  }
  return labels;
}
