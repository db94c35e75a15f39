/* The one linkage of a page. */

const report = data("report");
const scene = data("scene");
const stage = new Stage(byId("plot"), scene);
const {side, up, normal, vertical, sight, centre, size} = stage.frame;
