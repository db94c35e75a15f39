/* Initialise the page. */

buildLegend();
buildSliders();
buildChoice();
buildMomenta();
spectrum();
window.addEventListener("resize", spectrum);
draw();
