/* Sliders that move the linkage together, the Play button, and what to show. */

const RATE = {angle: 1.2, slide: 0.35};

/** Displacement as text: degrees or metres. */
const reading = (column, value) => column.angle
  ? `${number(Number((value * 180 / Math.PI).toFixed(1)))}°` : `${number(Number(value.toPrecision(4)))} m`;

/** The value of an angle within half a turn of zero. */
const wrapped = (value) => value - 2 * Math.PI * Math.round(value / (2 * Math.PI));

class Controls {
  /** Sliders for the columns of a scene in a fieldset; `changed` is called after each move. */
  constructor(stage, field, changed = () => {}) {
    Object.assign(this, {stage, changed, columns: stage.scene.columns, prefix: field.id});
    this.values = this.columns.map(() => 0);
    this.moving = 0;
    this.direction = 1;
    this.build(field);
    this.tell("");
  }
  build(field) {
    this.sliders = this.columns.map((column, c) => {
      const id = `${this.prefix}-${c}`, reach = column.angle ? 180 : column.reach;
      const input = element("input", {type: "range", id, min: -reach, max: reach, step: column.angle ? 1 : reach / 100, value: 0});
      const output = element("output", {for: id});
      field.append(element("div", {class: "slider"}, element("label", {for: id}, column.label), output, input));
      input.addEventListener("input", () => this.slide(c, Number(input.value) * (column.angle ? Math.PI / 180 : 1)));
      return {input, output};
    });
    this.play = element("button", {type: "button", class: "play screen"}, "Play");
    this.reset = element("button", {type: "button", class: "reset screen"}, "Reference pose");
    this.note = element("p", {class: "note screen", "aria-live": "polite"});
    field.append(element("div", {class: "buttons screen"}, this.play, this.reset), this.note);
    this.play.hidden = !this.columns.length;
    this.player = player(this.play, (seconds) => this.step(seconds));
    this.reset.addEventListener("click", () => this.home());
  }
  home() {
    this.player.stop();
    this.values.fill(0);
    this.stage.home();
    this.tell("");
  }
  /** Displacements of the inputs at values of the columns. */
  inputs(values) {
    return this.stage.scene.mechanism.inputs.map((_, i) =>
      this.columns.reduce((sum, {column}, c) => sum + column[i] * values[c], 0));
  }
  slide(c, value) {
    this.moving = c;
    const now = this.values[c];
    this.go(c, this.columns[c].angle ? now + wrapped(value - now) : value);
  }
  /** Move one column to a value, as far as the loops close. */
  go(c, value) {
    const aim = this.values.map((v, k) => k === c ? value : v);
    const reached = this.stage.move(this.inputs(aim));
    if (reached) this.values = aim;
    else {
      /* Read where it has stopped from an input that the column moves. */
      const {column} = this.columns[c], i = column.findIndex(Boolean), before = this.inputs(this.values)[i];
      this.values[c] += (this.stage.q[this.stage.mechanism.inputs[i]] - before) / column[i];
    }
    this.tell(reached ? "" : `${this.columns[c].label} stops at ${this.text(c)}: the loops close no further.`);
    return reached;
  }
  step(seconds) {
    const c = this.moving, column = this.columns[c];
    const next = this.values[c] + this.direction * seconds * (column.angle ? RATE.angle : RATE.slide * 2 * column.reach);
    if (!column.angle && Math.abs(next) > column.reach) { this.direction = -Math.sign(next); return; }
    if (!this.go(c, next)) this.direction = -this.direction;
  }
  text(c) {
    const column = this.columns[c];
    return reading(column, column.angle ? wrapped(this.values[c]) : this.values[c]);
  }
  tell(note) {
    this.sliders.forEach(({input, output}, c) => {
      const {angle} = this.columns[c], value = this.values[c];
      input.value = angle ? wrapped(value) * 180 / Math.PI : value;
      output.textContent = this.text(c);
      input.setAttribute("aria-valuetext", output.textContent);
    });
    const label = this.columns[this.moving]?.label;
    this.play.title = `Move ${label}`;
    this.note.textContent = note || (this.columns.length > 1 ? `Sliders combine. Play moves ${label}, the slider that was moved last.` : "");
    this.reset.disabled = this.stage.atRest;
    this.changed();
    this.stage.draw();
  }
}

/** Boxes for what to show, and a choice of the point to trace. */
function buildShown(stage, field) {
  const {scene} = stage;
  const box = (name, text, checked) => {
    const input = element("input", {type: "checkbox", name});
    input.checked = stage.shown[name] = checked;
    input.addEventListener("change", () => { stage.shown[name] = input.checked; stage.view.box = null; stage.draw(); });
    return element("label", {}, input, ` ${text}`);
  };
  const heavy = scene.bodies.filter(({pseudo}) => pseudo[3][3] > 0);
  field.append(box("names", "names", true));
  if (heavy.length) field.append(box("centres", "centres of mass", false));
  if (stage.solids.length) field.append(box("shapes", "shapes of the file", true));
  const places = [["none", null], ...(stage.common() ? [["the centre of mass of all bodies", stage.common()]] : []),
    ...scene.bodies.map(({name, part, tip}) => [`the end of ${plain(name)}`, (pose) => moved(pose[part], tip)])];
  const choice = element("select", {id: `${field.id}-trail`});
  places.forEach(([name], k) => choice.append(element("option", {value: k}, name)));
  choice.addEventListener("change", () => { stage.follow(places[choice.value][1]); stage.draw(); });
  field.append(element("label", {class: "trail", for: choice.id}, "Path of "), choice);
}
