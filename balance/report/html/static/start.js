/* Everything is there: begin. */

buildLegend();
buildSliders();
buildChoice();
buildMomenta();
spectrum();
window.addEventListener("resize", spectrum);
draw();
