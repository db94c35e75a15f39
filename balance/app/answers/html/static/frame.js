"use strict";
/* Common to all pages: read the data, make elements, follow light and dark, show the report. */

const byId = (id) => document.getElementById(id);
const data = (id) => JSON.parse(byId(id).textContent);

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/* Keep the text: numbers of JSON may exceed the precision of JavaScript. */
byId("json").addEventListener("toggle", (event) => {
  const text = event.target.querySelector("pre");
  text.textContent ||= byId("report").textContent.replaceAll("\\u003c", "<");
});

/** What to draw again when the width, the colour scheme or the paper changes. */
const redrawn = new Set();
const drawAgain = () => redrawn.forEach((draw) => draw());

const scheme = matchMedia("(prefers-color-scheme: dark)");
let onPaper = false;
scheme.addEventListener("change", drawAgain);
addEventListener("beforeprint", () => { onPaper = true; drawAgain(); });
addEventListener("afterprint", () => { onPaper = false; drawAgain(); });
let width = innerWidth;
addEventListener("resize", () => {
  if (innerWidth !== width) { width = innerWidth; drawAgain(); }
});

/** A colour of the light scheme as red, green and blue, 0 to 1, in the scheme of the page. */
const shade = (() => {
  const known = new Map();
  const channels = (hex) => {
    const long = hex.length === 4 ? [...hex.slice(1)].map((c) => c + c).join("") : hex.slice(1);
    return [0, 2, 4].map((i) => parseInt(long.slice(i, i + 2), 16) / 255);
  };
  return (hex) => {
    const dark = scheme.matches && !onPaper, key = hex + dark;
    if (!known.has(key)) {
      let rgb = channels(hex);
      if (dark) {
        /* Turn the lightness around and keep the hue. */
        const middle = (Math.max(...rgb) + Math.min(...rgb)) / 2, light = 0.96 - 0.86 * middle;
        const stretch = Math.min(light, 1 - light) / (Math.min(middle, 1 - middle) || 1);
        rgb = rgb.map((c) => Math.min(Math.max(light + (c - middle) * stretch, 0), 1));
      }
      known.set(key, rgb);
    }
    return known.get(key);
  };
})();

/** The same as text for styles, with an opacity. */
const tone = (hex, opacity = 1) =>
  `rgb(${shade(hex).map((c) => Math.round(255 * c)).join(" ")} / ${opacity})`;

/** Width of a text in pixels. */
const wide = (() => {
  const pen = document.createElement("canvas").getContext("2d");
  return (text, size = 13, weight = 400) => {
    pen.font = `${weight} ${size}px Charter, "Liberation Serif", Georgia, serif`;
    return pen.measureText(text).width;
  };
})();

/* Samples of colours beside text have the colours of what they explain. */
const ink = () => document.querySelectorAll("[data-ink]").forEach((sample) => { sample.style.color = tone(sample.dataset.ink); });
redrawn.add(ink);
ink();

/** Play and stop: calls `step` with the seconds since the last call while it plays. */
function player(button, step) {
  let last = null;
  const tick = (now) => {
    if (last === null) return;
    step(Math.min((now - last) / 1000, 0.1));
    last = now;
    requestAnimationFrame(tick);
  };
  const stop = () => { last = null; button.textContent = "Play"; };
  button.addEventListener("click", () => {
    if (last !== null) return stop();
    last = performance.now();
    button.textContent = "Stop";
    requestAnimationFrame(tick);
  });
  addEventListener("beforeprint", stop);
  return {stop, playing: () => last !== null};
}
