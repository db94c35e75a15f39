/* Curves, drawn by Plotly, each figure in its place. */

data("figures").forEach((figure, k) => {
  Plotly.newPlot(`traces${k}`, figure.data, figure.layout, {responsive: true, displayModeBar: false});
});
