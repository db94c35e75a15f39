/* Draw the least shaking over the duration. */

const front = data("front");
chartOn("front_curve", front.data, front.layout);
