/* Initialise the page. */

buildLegend();
buildChoice();
const controls = new Controls(stage, byId("sliders"), caption);
buildShown(stage, byId("view"));
buildMomenta();
spectrum();
redrawn.add(spectrum);
stage.draw();
