/* Surfaces, drawn by WebGL into a hidden canvas that all drawings of the page share. */

const VERTEX = `#version 300 es
in vec3 point; in vec3 normal;
uniform mat4 place; uniform mat3 turn; uniform vec3 centre, scale; uniform vec2 shift;
out vec3 seen, out_normal;
void main() {
  seen = turn * ((place * vec4(point, 1.)).xyz - centre);
  out_normal = turn * mat3(place) * normal;
  gl_Position = vec4(seen * scale + vec3(shift, 0.), 1.);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 seen, out_normal;
uniform vec4 colour;
out vec4 shown;
void main() {
  vec3 n = dot(out_normal, out_normal) > 1e-12 ? out_normal : cross(dFdx(seen), dFdy(seen));
  float light = .62 + .4 * abs(dot(normalize(n), vec3(.3, .45, .84)));
  shown = vec4(min(colour.rgb * light, 1.) * colour.a, colour.a);
}`;

const solids = {
  start() {
    if (this.gl !== undefined) return this.gl;
    this.canvas = document.createElement("canvas");
    const gl = this.gl = this.canvas.getContext("webgl2", {antialias: true, premultipliedAlpha: true, preserveDrawingBuffer: true});
    if (!gl) return null;
    const program = this.program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "point");
    gl.bindAttribLocation(program, 1, "normal");
    gl.linkProgram(program);
    gl.useProgram(program);
    this.at = Object.fromEntries(["place", "turn", "centre", "scale", "shift", "colour"].map((name) => [name, gl.getUniformLocation(program, name)]));
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    return gl;
  },
  /** Buffers of one piece, made once. */
  buffers(piece) {
    const gl = this.gl, made = gl.createVertexArray();
    gl.bindVertexArray(made);
    [piece.points, piece.normals].forEach((values, k) => {
      if (!values) { gl.vertexAttrib3f(k, 0, 0, 0); return; }
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 0, 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, piece.faces, gl.STATIC_DRAW);
    return made;
  },
  /** Draw traces of surfaces as a view sees them; the canvas, or null without WebGL. */
  draw(view, traces) {
    const gl = this.start();
    if (!gl) return null;
    const W = Math.round(view.W * view.dots), H = Math.round(view.H * view.dots);
    if (this.canvas.width !== W || this.canvas.height !== H) [this.canvas.width, this.canvas.height] = [W, H];
    gl.viewport(0, 0, W, H);
    gl.clearColor(0, 0, 0, 0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const {right, top, toward} = view;
    gl.uniformMatrix3fv(this.at.turn, false, [0, 1, 2].flatMap((i) => [right[i], top[i], toward[i]]));
    gl.uniform3fv(this.at.centre, view.centre);
    gl.uniform3f(this.at.scale, 2 * view.zoom / view.W, 2 * view.zoom / view.H, -0.02 / view.size);
    gl.uniform2f(this.at.shift, 0, 0);
    for (const {mesh, H: pose, color, opacity} of [...traces].sort((a, b) => b.opacity - a.opacity)) {
      gl.depthMask(opacity === 1);
      gl.uniform4f(this.at.colour, ...shade(color), opacity);
      for (const piece of mesh.pieces()) {
        const P = pose[piece.part] ?? UNMOVED;
        gl.uniformMatrix4fv(this.at.place, false, [0, 1, 2, 3].flatMap((c) => [P[c], P[4 + c], P[8 + c], c === 3 ? 1 : 0]));
        gl.bindVertexArray(piece.buffers ||= this.buffers(piece));
        gl.drawElements(gl.TRIANGLES, piece.faces.length, gl.UNSIGNED_INT, 0);
      }
    }
    return this.canvas;
  },
};
