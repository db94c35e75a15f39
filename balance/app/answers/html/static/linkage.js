/* The shapes of a linkage: links, joints, ground, centres of mass, and names. */

/** Directions, middle and size of the drawing of a scene. */
function frameOf(scene) {
  const [side, up, normal] = scene.axes;
  const [vertical, horizontal, depth] = scene.planar
    ? [up, side, normal] : [scene.axes[2], scene.axes[0], scene.axes[1]];
  /* Direction from the linkage to the camera. */
  const sight = scene.planar ? normal
    : unit(add(add(scaled(depth, -0.8), horizontal, 1.15), vertical, 0.85));
  const centre = mean(scene.joints.map((joint) => joint.point));
  return {side, up, normal, vertical, horizontal, depth, sight, centre, size: scene.size};
}

function linkage(scene, frame) {
  const {size} = frame;
  const links = new Lines(), plates = new Mesh(), rails = new Lines(), axes = new Lines();
  const ground = new Lines(), base = new Mesh(), names = new Labels();
  const shapes = {turning: new Labels(), sliding: new Labels(), balls: new Labels()};
  scene.parts.forEach((part, p) => {
    const corners = part.corners, text = plain(part.names.join(", "));
    if (p === 0) return;
    if (corners.length === 2) links.path(p, corners, text);
    if (corners.length > 2) {
      links.path(p, isFlat(corners, size) ? [...corners, corners[0]] : corners, text);
      if (isFlat(corners, size)) plates.fan(p, corners, text);
    }
    if (corners.length) for (const name of part.names) names.put(p, mean(corners), plain(name));
  });
  for (const corner of scene.parts[0].corners) drawGround(ground, corner, frame, scene.planar);
  if (scene.parts[0].corners.length > 2 && !scene.planar) {
    base.fan(0, scene.parts[0].corners, "ground");
  }
  for (const joint of scene.joints) {
    const [a, b] = joint.parts, d = unit(joint.direction), half = 0.075 * size;
    const text = `${plain(joint.name)} (${joint.kind}${joint.idle ? ", idle" : ""})`;
    const ball = turningAt(scene, joint.point) > 2;
    if (!joint.idle && !ball) {
      axes.path(a, [add(joint.point, d, -half), add(joint.point, d, half)]);
    }
    const mark = joint.kind === "prismatic" ? "sliding" : ball ? "balls" : "turning";
    shapes[mark].put(b, joint.point, text);
    if (joint.kind !== "revolute") rails.between(a, joint.point, b, joint.point, text);
  }
  return {links, plates, rails, axes, ground, base, names, marks: shapes, joints: jointNames(scene), centres: massCentres(scene)};
}

/** Number of rotation axes through this point: three make a ball joint. */
function turningAt(scene, point) {
  const near = (joint) => norm(add(joint.point, point, -1)) < 1e-6 * scene.size;
  return scene.joints.filter((j) => j.kind === "revolute" && !j.idle && near(j)).length;
}

/** Whether points are not collinear. */
function isFlat(points, size) {
  const a = add(points[points.length - 1], points[0], -1);
  return points.some((p) => norm(cross(a, add(p, points[0], -1))) > 1e-6 * size * size);
}

/** Ground symbol: a hatched foot below a joint. */
function drawGround(shape, p, {size, vertical, horizontal, depth}, planar) {
  const h = 0.055 * size, w = 0.04 * size, foot = add(p, vertical, -h);
  const feet = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([i, j]) =>
    add(add(foot, horizontal, i * w), depth, planar ? 0 : j * w));
  for (const f of feet) shape.path(0, [p, f]);
  shape.path(0, [...feet, feet[0]]);
  for (let k = -2; k <= 2; k++) {
    const top = add(add(foot, horizontal, k * w / 2), depth, planar ? 0 : -w);
    shape.path(0, [top, add(add(top, vertical, -0.4 * w), horizontal, -0.4 * w)]);
  }
}

/** One name for each point where joints meet: the common part of their names. */
function jointNames(scene) {
  const places = [], labels = new Labels();
  for (const joint of scene.joints) {
    const found = places.find((q) => norm(add(q.point, joint.point, -1)) < 1e-6 * scene.size);
    if (found) found.names.push(joint.name);
    else places.push({point: joint.point, part: joint.parts[1], names: [joint.name]});
  }
  for (const place of places) {
    let common = place.names[0];
    for (const name of place.names) while (!name.startsWith(common)) common = common.slice(0, -1);
    common = place.names.length > 1 ? common.replace(/[._\-\s]+$/, "") : common;
    const text = common.length > 1 || (common && place.names[0][1] === ".") ? common : place.names.join(", ");
    labels.put(place.part, place.point, plain(text));
    labels.vertices[labels.vertices.length - 1].push(place.names);
  }
  return labels;
}

/** Centres of mass of the bodies of the file. */
function massCentres(scene) {
  const labels = new Labels();
  for (const {name, part, centre, pseudo} of scene.bodies) {
    if (pseudo[3][3] > 0) labels.put(part, centre, `centre of mass of ${plain(name)}, ${number(pseudo[3][3])} kg`);
  }
  return labels;
}
