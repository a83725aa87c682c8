// Draws the table, the balls and the cue with WebGL, as seen by a camera.

class Renderer {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.gl = canvas.getContext('webgl2', { antialias: true, alpha: true, premultipliedAlpha: true });
    if (!this.gl) throw new Error('This browser has no WebGL 2, which the table is drawn with.');
    const { gl } = this;
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.programs = { solid: this.program(SOLID), ball: this.program(BALL), line: this.program(LINE) };
    const solid = [3, 3, 3, 1];
    this.table = this.mesh(
      data.table ? tableMesh(data.table) : floorMesh(data.middle, data.extent), solid);
    this.cue = this.mesh(cueMesh(data.cue.length), solid);
    this.sphere = this.mesh(sphereMesh(48, 32), [3]);
    this.lines = data.balls.map((ball) => this.mesh(lineMesh(this.linesOf(ball)), [3, 3, 1, 1, 1]));
    this.looks = data.balls.map(lookOf);
    this.numbers = this.numberTexture();
  }

  // The path of a ball; of the cue ball, also the circles where it was as it met others.
  linesOf({ name, trails }) {
    const { ghosts, radius } = this.data;
    const circles = name === 'cue' ? ghosts : [];
    return [
      ...trails.map(({ motion, points }) => ({ points, motion, lift: 1.5e-3 - radius })),
      ...circles.map((place) => ({ points: circlePoints(place, radius), motion: 'roll', lift: 1.5e-3 })),
    ];
  }

  program({ vertex, fragment }) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
        throw new Error(gl.getShaderInfoLog(shader));
      }
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(program));
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
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
    const stride = sizes.reduce((a, b) => a + b);
    let offset = 0;
    sizes.forEach((size, i) => {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, size, gl.FLOAT, false, 4 * stride, 4 * offset);
      offset += size;
    });
    return { array, count: numbers.length / stride };
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

  // camera: { matrix, eye, target }; balls: [{ place, turn, opacity }]; cue: { tip, opacity };
  // paths: the opacity of the path of each ball.
  draw(camera, balls, cue, paths) {
    const { gl, data } = this;
    const ratio = this.resize();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const light = this.light(camera, balls, cue);

    const solid = this.use('solid', light);
    gl.uniformMatrix4fv(solid.model, false, pose([0, 0, 0, 1], [0, 0, 0]));
    gl.uniform1f(solid.opacity, 1);
    gl.uniform1f(solid.fade, Math.max(3.2 * camera.distance, 1.5));
    const holes = data.table ? data.table.holes.flat() : [];
    gl.uniform1i(solid.holeCount, holes.length / 3);
    if (holes.length) gl.uniform3fv(solid.holes, holes);
    this.render(this.table);

    this.drawLines(camera, ratio, paths);
    this.drawBalls(balls, light);

    if (cue.opacity > 0) {
      this.use('solid', light);
      gl.uniform1f(solid.opacity, cue.opacity);
      gl.uniformMatrix4fv(solid.model, false, poseAlong(data.cue.direction, cue.tip));
      this.render(this.cue);
    }
  }

  drawLines(camera, ratio, opacities) {
    const { gl, data } = this;
    const { program, places } = this.programs.line;
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.camera, false, camera.matrix);
    gl.uniform2f(places.size, this.canvas.width, this.canvas.height);
    this.lines.forEach((line, i) => {
      if (!line.count || opacities[i] <= 0) return;
      gl.uniform1f(places.width, (data.balls[i].pale ? 1 : 2.2) * ratio);
      gl.uniform3fv(places.c, shadeOf(data.balls[i].path));
      gl.uniform1f(places.opacity, opacities[i]);
      this.render(line);
    });
  }

  drawBalls(balls, light) {
    const { gl, data } = this;
    const places = this.use('ball', light);
    gl.uniform1f(places.radius, data.radius);
    balls.forEach(({ place, turn, opacity }, i) => {
      if (opacity <= 0) return;
      const look = this.looks[i];
      gl.uniformMatrix4fv(places.model, false, pose(turn, place));
      gl.uniform3fv(places.ground, look.ground);
      gl.uniform3fv(places.dots, look.dots);
      gl.uniform1i(places.look, look.kind);
      gl.uniform1f(places.cell, look.cell);
      gl.uniform1i(places.self, i);
      gl.uniform1f(places.opacity, opacity);
      this.render(this.sphere);
    });
  }

  // What every shader wants to know of the light, and of what casts shadows.
  light(camera, balls, cue) {
    const { table, radius, cue: { direction, length } } = this.data;
    const spheres = new Float32Array(4 * MOST_BALLS);
    balls.slice(0, MOST_BALLS).forEach(({ place, opacity }, i) => {
      spheres.set([...place, opacity > 0.5 ? radius : 1e-6], 4 * i);
    });
    const high = Math.max(1, 0.5 * camera.distance);
    return {
      camera,
      lamp: table ? [0, 0, 1.0, 0.36 * table.size[0]] : [camera.target[0], camera.target[1], high, 0.6 * high],
      spheres, count: Math.min(balls.length, MOST_BALLS),
      tip: cue.tip, butt: add(cue.tip, direction, -length), shade: 0.75 * cue.opacity,
    };
  }

  use(name, { camera, lamp, spheres, count, tip, butt, shade }) {
    const { gl } = this;
    const { program, places } = this.programs[name];
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.camera, false, camera.matrix);
    gl.uniform3fv(places.eye, camera.eye);
    gl.uniform4fv(places.lamp, lamp);
    gl.uniform4fv(places.balls, spheres);
    gl.uniform1i(places.ballCount, count);
    gl.uniform3fv(places.cueTip, tip);
    gl.uniform3fv(places.cueButt, butt);
    gl.uniform1f(places.cueShade, shade);
    return places;
  }

  render({ array, count }) {
    this.gl.bindVertexArray(array);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, count);
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
