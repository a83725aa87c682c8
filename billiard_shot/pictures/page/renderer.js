// Draws the table, the balls and the cue with WebGL, as seen by a camera. What does not move is drawn
// once for a camera, and copied into each picture: its light takes much longer than all else. The
// canvas is opaque, or the browser would have to draw the page below it for each picture, too.

const SHADE = 12; // radii, as far as which balls shade each other
const ROOM_COLOURS = ['--glow', '--room']; // of the page's style

class Renderer {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.gl = canvas.getContext('webgl2', { antialias: false, alpha: false });
    if (!this.gl) throw new Error('This browser has no WebGL 2, which the table is drawn with.');
    const { gl } = this;
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    const shaders = { solid: SOLID, copy: COPY, shadow: SHADOW, line: LINE, dot: DOT, ball: BALL };
    const begun = Object.entries(shaders).map(([name, shader]) => [name, this.program(shader)]);
    this.programs = Object.fromEntries(begun.map(([name, given]) => [name, this.linked(given)]));
    const solid = [3, 3, 3, 1];
    this.table = this.mesh(data.table ? tableMesh(data.table) : floorMesh([0, 0], FLOOR_SIZE), solid);
    this.cue = this.mesh(cueMesh(data.cue.length), solid);
    this.nothing = gl.createVertexArray(); // of programs whose vertices have only a number
    this.lines = new Map(); // by their names
    this.dots = new Map();
    this.looks = data.balls.map(lookOf);
    this.numbers = this.numberTexture();
    const two = (what) => [gl[`create${what}`](), gl[`create${what}`]()];
    this.still = { key: '', frames: two('Framebuffer'), pictures: two('Texture'), parts: [] };
    this.asked = null; // signals that a picture is drawn
    this.readRoom();
  }

  /** Read the colours of the room, which differ by day and by night. */
  readRoom() {
    const style = getComputedStyle(document.documentElement);
    this.room = ROOM_COLOURS.flatMap((name) => shadeOf(style.getPropertyValue(name).trim()));
  }

  /** Begin to compile a program: browsers compile several at a time. */
  program({ vertex, fragment }) {
    const { gl } = this;
    const program = gl.createProgram();
    const sources = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]];
    const shaders = sources.map(([kind, source]) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      return shader;
    });
    gl.linkProgram(program);
    return { program, shaders };
  }

  /** Wait for a program, and find its uniforms. */
  linked({ program, shaders }) {
    const { gl } = this;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      const logs = shaders.map((shader) => gl.getShaderInfoLog(shader));
      throw new Error([...logs, gl.getProgramInfoLog(program)].join(' '));
    }
    const places = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name.replace('[0]', '')] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  mesh(numbers, sizes) {
    const { gl } = this;
    const mesh = { array: gl.createVertexArray(), buffer: gl.createBuffer() };
    const stride = sizes.reduce((a, b) => a + b);
    gl.bindVertexArray(mesh.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
    let offset = 0;
    sizes.forEach((size, i) => {
      this.attribute(i, size, stride, offset);
      offset += size;
    });
    return this.upload(mesh, new Float32Array(numbers), stride);
  }

  attribute(place, size, stride, offset) {
    const { gl } = this;
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 4 * stride, 4 * offset);
  }

  upload(mesh, numbers, stride) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
    return Object.assign(mesh, { count: numbers.length / stride });
  }

  /** Set the lines of a name: points as of `pointsOfLines`. */
  setLines(name, points) {
    const { gl } = this;
    if (!this.lines.has(name)) {
      const line = { array: gl.createVertexArray(), buffer: gl.createBuffer() };
      gl.bindVertexArray(line.array);
      gl.bindBuffer(gl.ARRAY_BUFFER, line.buffer);
      [[0, 4, 0], [1, 4, POINT], [2, 1, POINT + 4]].forEach(([place, size, offset]) => {
        this.attribute(place, size, POINT, offset);
        gl.vertexAttribDivisor(place, 1);
      });
      this.lines.set(name, line);
    }
    this.upload(this.lines.get(name), points, POINT);
  }

  /** Set the dots of a name: places [x, y, z] one after the other. */
  setDots(name, places) {
    if (this.dots.has(name)) this.upload(this.dots.get(name), new Float32Array(places), 3);
    else this.dots.set(name, this.mesh(places, [3]));
  }

  // The numbers 0 to 15 beside each other.
  numberTexture() {
    const { gl } = this;
    const size = 128;
    const picture = document.createElement('canvas');
    picture.width = 16 * size;
    picture.height = size;
    const pen = picture.getContext('2d');
    pen.font = `bold ${0.66 * size}px Helvetica, Arial, "DejaVu Sans", sans-serif`;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    for (let i = 1; i < 16; i++) {
      pen.fillText(String(i), (i + 0.5) * size, 0.54 * size, 0.8 * size);
    }
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    return texture;
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight]
      .map((size) => Math.max(1, Math.round(ratio * size)));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      Object.assign(this.canvas, { width, height });
    }
    return ratio;
  }

  // camera: { matrix, eye, target }; balls: [{ place, turn, opacity }]; cue: { tip, direction,
  // opacity }; lines, dots: [{ name, colour, width, opacity }].
  draw(camera, balls, cue, lines, dots) {
    const { gl } = this;
    const ratio = this.resize();
    this.light = this.lightOf(camera, cue);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    this.drawStill(camera);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.copyStill();
    this.drawShadows(balls, cue);
    this.drawMarks('line', this.lines, camera, ratio, lines);
    this.drawMarks('dot', this.dots, camera, ratio, dots);
    this.drawBalls(balls);
    if (cue.opacity > 0) {
      const solid = this.use('solid');
      gl.uniform1i(solid.round, 1);
      gl.uniform1f(solid.opacity, cue.opacity);
      gl.uniformMatrix4fv(solid.model, false, poseAlong(cue.direction, cue.tip));
      this.render(this.cue);
    }
    gl.deleteSync(this.asked);
    this.asked = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  }

  // ---- what does not move ----

  drawStill(camera) {
    const { gl, data, still } = this;
    const { width, height } = this.canvas;
    const key = [width, height, ...camera.matrix].join();
    if (key === still.key) return;
    if (still.width !== width || still.height !== height) this.makeStill(width, height);
    still.key = key;
    const [drawn, copied] = still.frames;
    gl.bindFramebuffer(gl.FRAMEBUFFER, drawn);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const solid = this.use('solid');
    gl.uniformMatrix4fv(solid.model, false, pose([0, 0, 0, 1], [0, 0, 0]));
    gl.uniform1i(solid.round, 0);
    gl.uniform1f(solid.opacity, 1);
    gl.uniform1f(solid.fade, Math.max(3.2 * camera.distance, 1.5));
    const holes = data.table ? data.table.holes.flat() : [];
    gl.uniform1i(solid.holeCount, holes.length / 3);
    if (holes.length) gl.uniform3fv(solid.holes, holes);
    this.render(this.table);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, drawn);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, copied);
    for (const part of [gl.COLOR_BUFFER_BIT, gl.DEPTH_BUFFER_BIT]) {
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, part, gl.NEAREST);
    }
  }

  /** Whether all that was asked for is drawn. */
  isDone() {
    const { gl, asked } = this;
    return asked !== null && gl.getSyncParameter(asked, gl.SYNC_STATUS) !== gl.UNSIGNALED;
  }

  // Two frames: one with several samples a pixel, and one that can be read as pictures.
  makeStill(width, height) {
    const { gl, still } = this;
    Object.assign(still, { width, height });
    const samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
    const formats = [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]];
    still.parts.forEach((part) => gl.deleteRenderbuffer(part));
    gl.bindFramebuffer(gl.FRAMEBUFFER, still.frames[0]);
    still.parts = formats.map(([format, place]) => {
      const part = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, part);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, part);
      return part;
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, still.frames[1]);
    formats.forEach(([format, place], i) => {
      const [content, kind] = i ? [gl.DEPTH_COMPONENT, gl.UNSIGNED_INT] : [gl.RGBA, gl.UNSIGNED_BYTE];
      gl.bindTexture(gl.TEXTURE_2D, still.pictures[i]);
      gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, content, kind, null);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, still.pictures[i], 0);
    });
  }

  copyStill() {
    const { gl, still, programs: { copy: { program, places } } } = this;
    gl.depthFunc(gl.ALWAYS);
    gl.disable(gl.BLEND);
    gl.useProgram(program);
    still.pictures.forEach((picture, i) => {
      gl.activeTexture(gl.TEXTURE0 + i);
      gl.bindTexture(gl.TEXTURE_2D, picture);
      gl.uniform1i(i ? places.depth : places.picture, i);
    });
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform3fv(places.room, this.room);
    this.strip(1);
    gl.enable(gl.BLEND);
    gl.depthFunc(gl.LESS);
  }

  // ---- what moves ----

  drawShadows(balls, cue) {
    const { gl, data: { scene: { radius }, cue: { length } } } = this;
    gl.depthMask(false);
    gl.blendFuncSeparate(gl.DST_COLOR, gl.ZERO, gl.ZERO, gl.ONE);
    const { lamp } = this.light;
    balls.forEach((ball) => {
      const { place: [x, y, z], opacity } = ball;
      if (opacity <= 0.5 || z < 0 || z > 0.8 * lamp[2]) return;
      const places = this.use('shadow');
      this.shade(places, [ball]);
      // from the ends of the lamp, the shadow of the ball is farther away
      const away = z / (lamp[2] - z);
      const wide = radius * (3 + 2.5 * away);
      const [dx, dy] = [(x - lamp[0]) * away, (y - lamp[1]) * away];
      gl.uniform2f(places.middle, x + dx / 2, y + dy / 2);
      gl.uniform2f(places.along, wide + Math.abs(dx) / 2 + 0.7 * lamp[3] * away, 0);
      gl.uniform2f(places.across, 0, wide + Math.abs(dy) / 2);
      this.strip(1);
    });
    if (cue.opacity > 0) {
      const places = this.use('shadow');
      const { tip, direction: [dx, dy] } = cue;
      const butt = add(tip, cue.direction, -length);
      const wide = 0.02 + 0.33 * butt[2]; // as underCue has it
      const level = Math.hypot(dx, dy);
      const [ux, uy] = level > 1e-6 ? [dx / level, dy / level] : [1, 0];
      const far = wide + 0.5 * length * level;
      gl.uniform2f(places.middle, (tip[0] + butt[0]) / 2, (tip[1] + butt[1]) / 2);
      gl.uniform2f(places.along, far * ux, far * uy);
      gl.uniform2f(places.across, -wide * uy, wide * ux);
      this.strip(1);
    }
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(true);
  }

  /** Draw lines, or dots. */
  drawMarks(program, meshes, camera, ratio, marks) {
    const { gl, programs: { [program]: { program: used, places } } } = this;
    gl.useProgram(used);
    gl.uniformMatrix4fv(places.camera, false, camera.matrix);
    gl.uniform2f(places.size, this.canvas.width, this.canvas.height);
    for (const { name, colour, width, opacity } of marks) {
      const { array, count } = meshes.get(name) ?? { count: 0 };
      if (count < 1 || opacity <= 0) continue;
      gl.uniform1f(places.width, width * ratio);
      gl.uniform3fv(places.c, shadeOf(colour));
      gl.uniform1f(places.opacity, opacity);
      if (meshes === this.lines) this.strip(count - 1, array);
      else this.render({ array, count }, gl.POINTS);
    }
  }

  drawBalls(balls) {
    const { gl, data } = this;
    const places = this.use('ball');
    gl.bindTexture(gl.TEXTURE_2D, this.numbers);
    gl.uniform1f(places.radius, data.scene.radius);
    balls.forEach(({ place, turn, opacity }, i) => {
      if (opacity <= 0) return;
      const look = this.looks[i];
      gl.uniformMatrix4fv(places.model, false, pose(turn, place));
      gl.uniform3fv(places.ground, look.ground);
      gl.uniform3fv(places.dots, look.dots);
      gl.uniform1i(places.look, look.kind);
      gl.uniform1f(places.cell, look.cell);
      this.shade(places, balls.filter((other) => other.opacity > 0.5 && other.place !== place
        && Math.hypot(...add(other.place, place, -1)) < SHADE * data.scene.radius));
      gl.uniform1f(places.opacity, opacity);
      this.strip(1);
    });
  }

  // What every shader wants to know of the light, and of the cue, which casts a shadow.
  lightOf(camera, cue) {
    const { table, cue: { length } } = this.data;
    const high = Math.max(1, 0.5 * camera.distance);
    const [x, y] = camera.target;
    return {
      camera, lamp: table ? [0, 0, 1.0, 0.36 * table.size[0]] : [x, y, high, 0.6 * high],
      tip: cue.tip, butt: add(cue.tip, cue.direction, -length), shade: 0.75 * cue.opacity,
    };
  }

  use(name) {
    const { gl, light: { camera, lamp, tip, butt, shade } } = this;
    const { program, places } = this.programs[name];
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.camera, false, camera.matrix);
    gl.uniform3fv(places.eye, camera.eye);
    gl.uniform4fv(places.lamp, lamp);
    gl.uniform3fv(places.cueTip, tip);
    gl.uniform3fv(places.cueButt, butt);
    gl.uniform1f(places.cueShade, shade);
    this.shade(places, []);
    return places;
  }

  /** Let balls shade what is drawn next. */
  shade(places, balls) {
    const { gl, data: { scene: { radius } } } = this;
    const shading = balls.slice(0, MOST_BALLS);
    if (shading.length) gl.uniform4fv(places.balls, shading.flatMap(({ place }) => [...place, radius]));
    gl.uniform1i(places.ballCount, shading.length);
  }

  render({ array, count }, kind = this.gl.TRIANGLES) {
    this.gl.bindVertexArray(array);
    this.gl.drawArrays(kind, 0, count);
  }

  /** Draw rectangles whose corners a program makes of their numbers. */
  strip(count, array = this.nothing) {
    this.gl.bindVertexArray(array);
    this.gl.drawArraysInstanced(this.gl.TRIANGLE_STRIP, 0, 4, count);
  }
}

// How a ball is painted: with its number, or with dots that let its spin be seen.
function lookOf({ name, colour, striped }) {
  const number = /^\d+$/.test(name) && Number(name) < 16 ? Number(name) : 0;
  const ground = colourOf(colour);
  const bright = ground[0] + ground[1] + ground[2] > 1.5;
  return {
    kind: number ? (striped ? 2 : 1) : 0, cell: number, ground,
    dots: name === 'cue' ? colourOf('#c5161d') : ground.map((c) => (bright ? 0.6 * c : 0.2 + 0.8 * c)),
  };
}

// The pose of something along +x that is to point along a direction.
function poseAlong(direction, place) {
  const up = Math.abs(direction[2]) > 0.99 ? [1, 0, 0] : [0, 0, 1];
  const y = unit(cross(up, direction));
  const z = cross(direction, y);
  return new Float32Array([...direction, 0, ...y, 0, ...z, 0, ...place, 1]);
}
