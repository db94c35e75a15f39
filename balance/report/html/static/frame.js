"use strict";
/* Common to all pages: read the data, and show the report as JSON. */

const byId = (id) => document.getElementById(id);
const data = (id) => JSON.parse(byId(id).textContent);

/* Keep the text: numbers of JSON may exceed the precision of JavaScript. */
byId("json").querySelector("pre").textContent = byId("report").textContent.replaceAll("\\u003c", "<");
