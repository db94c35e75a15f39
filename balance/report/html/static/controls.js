/* Sliders that move the linkage. */

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

const reading = (column, k) => {
  const value = column.values[k], name = column.label === column.input ? "" : `${column.input} = `;
  const degrees = Number((value * 180 / Math.PI).toFixed(1));
  return name + (column.angle ? `${number(degrees)}°` : `${number(value)} m`);
};

function buildSliders() {
  const field = byId("sliders");
  const home = (column) => column.values.findIndex((value) => value === 0);
  const sliders = scene.columns.map((column, c) => {
    const id = `slider${c}`;
    const input = element("input", {
      type: "range", id, min: 0, max: column.values.length - 1, step: 1, value: home(column),
    });
    const output = element("output", {for: id});
    const label = element("label", {for: id}, column.label);
    field.append(element("div", {class: "slider"}, label, output, input));
    return {column, input, output};
  });
  const reset = element("button", {type: "button", id: "reset", class: "screen"}, "Reference pose");
  field.append(reset);
  if (sliders.length > 1) {
    field.append(element("p", {class: "note screen"},
      "Each slider moves alone, from the reference pose: the others go back to 0."));
  }
  const stopped = scene.columns.filter((column) => column.stopped.some(Boolean));
  if (stopped.length) {
    field.append(element("p", {class: "note screen"},
      `${stopped.map((column) => column.label).join("; ")}: a range ends where the loops can no longer be closed.`));
  }
  const show = () => {
    for (const {column, input, output} of sliders) {
      output.textContent = reading(column, Number(input.value));
      input.setAttribute("aria-valuetext", output.textContent);
    }
    reset.disabled = pose === rest;
    caption();
  };
  const sendHome = (but) => {
    for (const other of sliders) if (other !== but) other.input.value = home(other.column);
  };
  for (const slider of sliders) {
    slider.input.addEventListener("input", () => {
      sendHome(slider);
      const k = Number(slider.input.value);
      pose = slider.column.values[k] === 0 ? rest : slider.column.poses[k];
      show(); draw();
    });
  }
  reset.addEventListener("click", () => { sendHome(null); pose = rest; show(); draw(); });
  show();
}
