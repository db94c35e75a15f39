/* Draw each figure of curves. */

data("figures").forEach((figure, k) => new Chart(byId(`traces${k}`), figure));
