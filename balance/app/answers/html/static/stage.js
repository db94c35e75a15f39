/* A drawing of a linkage at a pose, with its overlays. */

class Stage {
  constructor(holder, scene) {
    this.scene = scene;
    this.holder = holder;
    this.frame = frameOf(scene);
    this.parts = linkage(scene, this.frame);
    this.mechanism = new Mechanism(scene.mechanism);
    this.rest = scene.parts.map(() => null);
    this.shown = {names: true, centres: false, shapes: true};
    /* Overlays: functions from a pose to traces, names to show, and outer points. */
    this.layers = [];
    this.named = {bodies: [], joints: []};
    this.points = [];
    this.trail = null;
    this.solids = robotShapes(scene.shapes);
    const {vertical, sight, size, normal} = this.frame;
    this.view = new View(holder, {up: vertical, sight, size, planar: scene.planar});
    const axes = [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]];
    this.view.axes = axes.filter(([, axis]) => !scene.planar || Math.abs(dot(axis, normal)) < 0.999);
    this.view.pivot = this.frame.centre;
    this.home();
    holder.setAttribute("aria-busy", "true");
  }
  home() {
    this.q = new Float64Array(this.mechanism.size);
    this.pose = this.rest;
    this.view.box = null;
    this.trail?.points.splice(0);
  }
  get atRest() { return this.pose === this.rest; }
  /** Put the joints at positions. */
  put(q) {
    this.q = q;
    const H = this.mechanism.links(q);
    this.pose = this.scene.mechanism.carriers.map((link) => link < 0 ? null : H[link]);
  }
  /** Move the inputs towards displacements; whether they are reached. */
  move(u) {
    const {q, reached} = this.mechanism.toward(this.q, u);
    this.put(q);
    this.trail?.points.push(this.trail.at(this.pose));
    return reached;
  }
  /** Trace a point that is given by a function of the pose; null for none. */
  follow(at) {
    this.trail = at && {at, points: [at(this.pose)]};
  }
  /** The centre of mass of all bodies, as a function of the pose. */
  common() {
    const heavy = this.scene.bodies.filter(({pseudo}) => pseudo[3][3] > 0);
    const whole = heavy.reduce((sum, {pseudo}) => sum + pseudo[3][3], 0);
    return whole > 0 && ((pose) => heavy.reduce((sum, {part, centre, pseudo}) =>
      add(sum, moved(pose[part], centre), pseudo[3][3] / whole), [0, 0, 0]));
  }

  /** Names to show: all if there are few, otherwise those of the overlay. */
  names() {
    const bodies = new Labels(), joints = new Labels(), {parts, scene} = this;
    const few = scene.bodies.length + parts.joints.vertices.length <= 10;
    if (this.shown.names) {
      bodies.vertices = parts.names.vertices.filter((v) => few || this.named.bodies.includes(v[2]));
      joints.vertices = parts.joints.vertices.filter((v) => few || v[3].some((name) => this.named.joints.includes(name)));
    }
    return {bodies, joints};
  }
  traces() {
    const {parts, pose, rest, shown} = this, names = this.names(), trail = new Lines(), common = new Labels();
    if (this.trail) trail.path(0, this.trail.points);
    const at = this.common();
    if (shown.centres && at) common.put(0, at(pose), "centre of mass of all bodies");
    const faint = this.solids.length && shown.shapes;
    return [
      lines("reference", this.atRest ? new Lines() : parts.links, rest, {color: GHOST, width: 2, dash: "dash"}),
      ...(shown.shapes ? this.solids.map((solid) => ({...mesh("shapes", solid, pose, solid.color), veil: 0.55})) : []),
      mesh("base", parts.base, pose, LINK, 0.1),
      lines("rails", parts.rails, pose, {color: LINK, width: 4}, true),
      lines("axes", parts.axes, pose, {color: SOFT, width: 1.5, dash: "dashdot"}),
      lines("ground", parts.ground, pose, {color: INK, width: 2}),
      mesh("plates", parts.plates, pose, LINK, 0.28),
      lines("links", parts.links, pose, {color: LINK, width: faint ? 4 : 7, halo: true}, true),
      lines("trail", trail, rest, {color: TRAIL, width: 2}),
      marks("joints", parts.marks.turning, pose, "circle", 5),
      marks("balls", parts.marks.balls, pose, "circle", 5.5, SOFT),
      marks("slides", parts.marks.sliding, pose, "square", 5),
      ...this.layers.flatMap((layer) => layer(pose)),
      ...(shown.centres ? [marks("centres", parts.centres, pose, "centre", 6), marks("common centre", common, rest, "centre", 9)] : []),
      texts("bodies", names.bodies, pose, SOFT, 13),
      texts("joint names", names.joints, pose, SOFT, 12),
    ];
  }
  /** Corners, joints and outer points of the overlay at the pose. */
  cloud() {
    const {scene, pose} = this;
    const foot = -0.09 * scene.size;
    return [
      ...scene.parts.flatMap((part, p) => part.corners.map((corner) => moved(pose[p], corner))),
      ...scene.parts[0].corners.map((corner) => add(corner, this.frame.vertical, foot)),
      ...scene.joints.flatMap((joint) => joint.parts.map((p) => moved(pose[p], joint.point))),
      ...this.points.map(([p, point]) => moved(pose[p], point)),
      ...this.solids.flatMap(({corners, part}) => this.shown.shapes ? corners.map((p) => moved(pose[part], p)) : []),
      ...(this.shown.centres ? this.parts.centres.vertices.map(([p, point]) => moved(pose[p], point)) : []),
    ];
  }
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    this.holder.setAttribute("aria-busy", "true");
    requestAnimationFrame(() => {
      this.waiting = false;
      this.view.hold(this.cloud());
      this.view.show(this.traces());
      this.holder.setAttribute("aria-busy", "false");
    });
  }
  /** Vertices of a trace as they are drawn, in the inertial frame. */
  drawn(name) {
    return this.view.traces.filter((trace) => trace.name === name).flatMap(({vertices, H}) =>
      vertices.map((v) => v && moved(H[v[0]], v[1])));
  }
}



/** Surfaces of the file, from numbers of 16 bits in base 64. */
function robotShapes(shapes) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  return (shapes || []).map(({part, low, high, points, faces, wide, color, name}) => {
    const grid = new Uint16Array(bytes(points)), values = new Float32Array(grid.length);
    for (let k = 0; k < grid.length; k++) values[k] = low[k % 3] + grid[k] / 65535 * (high[k % 3] - low[k % 3]);
    const indices = Uint32Array.from(new (wide ? Uint32Array : Uint16Array)(bytes(faces)));
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((i) => k >> i & 1 ? high[i] : low[i]));
    return {part, color, name, corners, vertices: [], pieces() { return this.made ||= [{part, points: values, faces: indices}]; }};
  });
}
