"use strict";
/* What every page does: its data, and the report as it was written. */

const byId = (id) => document.getElementById(id);
const data = (id) => JSON.parse(byId(id).textContent);

/* As text: numbers of JSON need not fit those of JavaScript. */
byId("json").querySelector("pre").textContent = byId("report").textContent.replaceAll("\\u003c", "<");
