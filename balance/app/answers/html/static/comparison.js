/* Loads before and after a change, on common axes, for the motion that is chosen. */

const comparison = data("comparison");
const courses = byId("along");

function showLoads() {
  const {polar, time, harmonics} = comparison.motions[courses.value];
  chartOn("force", polar.data, polar.layout);
  chartOn("loads", time.data, time.layout);
  byId("harmonics").hidden = !harmonics;
  if (harmonics) chartOn("harmonics", harmonics.data, harmonics.layout);
}

comparison.motions.forEach(({label}, k) => courses.append(element("option", {value: k}, plain(label))));
courses.value = comparison.start;
courses.addEventListener("change", showLoads);
showLoads();
