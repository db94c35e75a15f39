/* Draw each figure of curves with Plotly. */

data("figures").forEach((figure, k) => {
  Plotly.newPlot(`traces${k}`, figure.data, figure.layout, {responsive: true, displayModeBar: false});
});
