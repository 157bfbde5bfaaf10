// Draws a list of things with WebGL 2: a pass from the sun for shadows, then ground, solids, ribbons, what is transparent, marks.

const SHADOW_SIZE = 2048;
const TO_SUN = unit([0.45, -0.3, 0.85]);

class Renderer {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) throw new Error("WebGL 2 is not available");
    Object.assign(this, { canvas, gl, shapes: new Map() });
    this.solid = this.program(SOLID_VERTEX, SOLID_FRAGMENT);
    this.depth = this.program(SOLID_VERTEX, DEPTH_FRAGMENT);
    this.ground = this.program(GROUND_VERTEX, GROUND_FRAGMENT);
    this.ribbon = this.program(RIBBON_VERTEX, RIBBON_FRAGMENT);
    this.empty = gl.createVertexArray();
    this.createShadowMap();
  }

  /** Compiles a program; gives it with the places of its uniforms. */
  program(vertex, fragment) {
    const { gl } = this, program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const places = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  createShadowMap() {
    const { gl } = this;
    this.shadowMap = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    this.shadowBuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowBuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadowMap, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** The triangles of a shape on the graphics unit; made once for each name. */
  shape(name, make) {
    if (!this.shapes.has(name)) {
      const { gl } = this, { positions, normals, indices } = make(), array = gl.createVertexArray();
      gl.bindVertexArray(array);
      [positions, normals].forEach((numbers, place) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
      });
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
      gl.bindVertexArray(null);
      this.shapes.set(name, { array, count: indices.length });
    }
    return this.shapes.get(name);
  }

  /** A line through points (x, y, z one after the other) on the graphics unit. */
  line(points) {
    const { gl } = this, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
    for (const place of [0, 1]) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 12, 12 * place);
      gl.vertexAttribDivisor(place, 1);
    }
    gl.bindVertexArray(null);
    return { array, segments: Math.max(points.length / 3 - 1, 0) };
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2), { canvas } = this;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  }

  /**
   * Draws everything once.
   * solids: [{ shape, pose (matrix), scale, color, shadow, above }], ribbons: [{ line, color, now }],
   * view: { matrix, eye }, bounds: { center, radius, ground, hasFloor }, colors: { background, ground, lines }
   */
  draw(solids, ribbons, view, bounds, colors) {
    const sun = this.sunMatrix(bounds);
    this.drawShadows(solids, sun);
    const { gl, canvas } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...colors.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    if (bounds.hasFloor && view.eye[2] > bounds.ground) this.drawGround(view, bounds, colors, sun);
    this.drawSolids(solids.filter(({ color, above }) => color[3] >= 1 && !above), view, sun);
    for (const ribbon of ribbons) this.drawRibbon(ribbon, view);
    gl.depthMask(false);
    this.drawSolids(solids.filter(({ color }) => color[3] < 1), view, sun);
    gl.depthMask(true);
    // Marks inside of bodies shine through.
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.drawSolids(solids.filter(({ above }) => above), view, sun);
  }

  sunMatrix({ center, radius }) {
    const eye = add(center, scaled(TO_SUN, 2 * radius));
    return multiply(orthographic(1.1 * radius, 0.5 * radius, 3.6 * radius), looking(eye, center, [0, 1, 0]));
  }

  drawShadows(solids, sun) {
    const { gl } = this, { program, places } = this.depth;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowBuffer);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.depthMask(true);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.camera, false, sun);
    for (const solid of solids) if (solid.shadow) this.drawShape(solid, places);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  drawSolids(solids, view, sun) {
    const { gl } = this, { program, places } = this.solid;
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.camera, false, view.matrix);
    gl.uniformMatrix4fv(places.sunMatrix, false, sun);
    gl.uniform3fv(places.eye, view.eye);
    gl.uniform3fv(places.toSun, TO_SUN);
    for (const solid of solids) {
      gl.uniform4fv(places.color, solid.color);
      this.drawShape(solid, places);
    }
  }

  drawShape({ shape, pose, scale }, places) {
    const { gl } = this;
    gl.uniformMatrix4fv(places.pose, false, pose);
    gl.uniform3fv(places.scale, scale);
    gl.bindVertexArray(shape.array);
    gl.drawElements(gl.TRIANGLES, shape.count, gl.UNSIGNED_INT, 0);
  }

  drawGround(view, bounds, colors, sun) {
    const { gl } = this, { program, places } = this.ground;
    gl.useProgram(program);
    gl.bindVertexArray(this.empty);
    gl.uniformMatrix4fv(places.camera, false, view.matrix);
    gl.uniformMatrix4fv(places.sunMatrix, false, sun);
    gl.uniform4fv(places.disc, [bounds.center[0], bounds.center[1], bounds.ground, 7 * bounds.radius]);
    gl.uniform1f(places.spacing, bounds.spacing);
    gl.uniform3fv(places.ground, colors.ground);
    gl.uniform3fv(places.lines, colors.lines);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  drawRibbon({ line, color, now }, view) {
    const { gl, canvas } = this, { program, places } = this.ribbon;
    gl.useProgram(program);
    gl.bindVertexArray(line.array);
    gl.uniformMatrix4fv(places.camera, false, view.matrix);
    gl.uniform2fv(places.viewport, [canvas.width, canvas.height]);
    gl.uniform1f(places.width, 2.5 * Math.min(window.devicePixelRatio || 1, 2));
    gl.uniform1f(places.now, now);
    gl.uniform4fv(places.color, color);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, line.segments);
  }
}
