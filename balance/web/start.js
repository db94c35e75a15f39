/* As it was written: numbers of JSON need not fit those of JavaScript. */
byId("json").querySelector("pre").textContent = byId("report").textContent.replaceAll("\\u003c", "<");
buildLegend();
buildSliders();
buildChoice();
spectrum();
window.addEventListener("resize", spectrum);
draw();
