// One light for all: a lamp over the table, as three points; balls and the cue cast its shadows.

const MOST_BALLS = 24;

const LIGHT = `
  uniform vec3 eye;
  uniform vec4 lamp;             // its middle (x, y, z) and half its length, along x
  uniform vec4 balls[${MOST_BALLS}];  // centre and radius
  uniform int ballCount;
  uniform vec3 cueTip, cueButt;
  uniform float cueShade;

  // Part of the light from a point that balls let through.
  float through(vec3 p, vec3 light) {
    vec3 way = light - p;
    vec3 d = normalize(way);
    float part = 1.0;
    for (int i = 0; i < ballCount; i++) {
      vec3 to = balls[i].xyz - p;
      float r = balls[i].w;
      float along = dot(to, d);
      if (along <= 0.0) continue;
      float wide = 0.12 * along + 0.05 * r;
      part *= smoothstep(r - wide, r + wide, length(to - along * d));
    }
    return part;
  }

  // Part of the sky that balls leave free.
  float open(vec3 p, vec3 n) {
    float part = 1.0;
    for (int i = 0; i < ballCount; i++) {
      vec3 to = balls[i].xyz - p;
      float far2 = dot(to, to);
      float r = balls[i].w;
      part *= 1.0 - 0.9 * max(dot(n, to) * inversesqrt(far2), 0.0) * min(r * r / far2, 1.0);
    }
    return part;
  }

  float underCue(vec3 p) {
    vec3 axis = cueButt - cueTip;
    float t = clamp(dot((p - cueTip).xy, axis.xy) / max(dot(axis.xy, axis.xy), 1e-6), 0.0, 1.0);
    vec3 over = cueTip + t * axis;
    float r = 0.006 + 0.008 * t;
    float high = max(over.z - p.z, 0.0);
    float wide = r + 0.25 * high;
    return 1.0 - cueShade * (r / wide) * (1.0 - smoothstep(0.0, 1.3 * wide, distance(over.xy, p.xy)));
  }

  // Light of the lamp, as far as balls let it through if they are in its way.
  float lamps(vec3 p, vec3 n, bool shaded) {
    float light = 0.0;
    for (int k = -1; k <= 1; k++) {
      vec3 from = lamp.xyz + vec3(float(k) * 0.7 * lamp.w, 0.0, 0.0);
      vec3 way = from - p;
      float far2 = dot(way, way) / (lamp.z * lamp.z);
      light += max(dot(n, normalize(way)), 0.0) / (0.35 + 0.65 * far2) * (shaded ? through(p, from) : 1.0);
    }
    return light;
  }

  vec3 lit(vec3 p, vec3 n, vec3 colour, vec3 sky) {
    return colour * (0.42 * lamps(p, n, true) + sky * open(p, n));
  }

  vec4 shown(vec3 light) {
    vec3 soft = light * (1.0 + 0.15 * light) / (1.0 + 0.55 * light);
    return vec4(pow(soft * 1.28, vec3(1.0 / 2.2)), 1.0);
  }

  // Part of a pixel that is covered, at the edge of something round.
  float covered(vec3 n, vec3 view) {
    float edge = max(-dot(n, view), 0.0);
    return clamp(edge / max(fwidth(edge), 1e-4), 0.0, 1.0);
  }

  float hash(vec2 p) { // D. Hoskins, "Hash without sine", 2014
    vec3 q = fract(p.xyx * 0.1031);
    q += dot(q, q.yzx + 33.33);
    return fract((q.x + q.y) * q.z);
  }

  float noise(vec2 p) {
    vec2 i = floor(p), f = fract(p);
    f = f * f * (3.0 - 2.0 * f);
    return mix(mix(hash(i), hash(i + vec2(1, 0)), f.x),
               mix(hash(i + vec2(0, 1)), hash(i + vec2(1, 1)), f.x), f.y);
  }
`;

const SOLID = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 place;
    layout(location = 1) in vec3 normal;
    layout(location = 2) in vec3 colour;
    layout(location = 3) in float material;
    uniform mat4 camera, model;
    out vec3 p, n, c;
    flat out int kind;
    void main() {
      p = (model * vec4(place, 1.0)).xyz;
      n = mat3(model) * normal;
      c = colour;
      kind = int(material);
      gl_Position = camera * vec4(p, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 p, n, c;
    flat in int kind;
    uniform vec3 holes[6];
    uniform int holeCount;
    uniform float fade;      // m from the lamp's foot to where an endless cloth ends
    uniform float opacity;
    uniform bool round;      // its edges are smoothed here, not by more samples
    out vec4 colour;
    ${LIGHT}
    void main() {
      if (kind == ${CLOTH} || kind == ${WOOD}) {
        for (int i = 0; i < holeCount; i++) {
          if (p.z > -1e-4 && n.z > 0.5 && distance(p.xy, holes[i].xy) < holes[i].z) discard;
        }
      }
      vec3 base = c;
      vec3 normal = normalize(n);
      if (dot(normal, eye - p) < 0.0) normal = -normal;
      if (kind == ${CLOTH} || kind == ${FLOOR}) {
        base *= 0.9 + 0.12 * noise(p.xy * 900.0) + 0.10 * noise(p.xy * 7.0);
      }
      if (kind == ${FLOOR}) {
        vec2 near = abs(fract(p.xy + 0.5) - 0.5), wide = 1.2 * fwidth(p.xy) + 0.0012;
        float line = 1.0 - min(smoothstep(vec2(0.0), wide, near).x, smoothstep(vec2(0.0), wide, near).y);
        base *= 1.0 + 0.5 * line;
      }
      if (kind == ${WOOD}) {
        vec2 grain = abs(p.x) * 0.52 > abs(p.y) ? p.yx : p.xy;
        float rings = noise(vec2(grain.x * 3.0, grain.y * 130.0)) + noise(vec2(grain.x * 9.0, grain.y * 420.0));
        base *= 0.72 + 0.28 * rings;
      }
      vec3 light = base * (0.42 * lamps(p, normal, false) + 0.20); // shadows are drawn later
      if (kind == ${WOOD} || kind == ${PLAIN}) {   // varnish
        vec3 r = reflect(normalize(p - eye), normal);
        float up = max(r.z, 1e-3);
        vec2 q = p.xy + r.xy * (lamp.z - p.z) / up - lamp.xy;
        float seen = (1.0 - smoothstep(0.6, 1.4, abs(q.x) / lamp.w)) * (1.0 - smoothstep(0.05, 0.5, abs(q.y)));
        light += 0.05 * seen * step(0.0, r.z) * (kind == ${WOOD} ? 1.0 : 2.0);
      }
      colour = shown(light);
      float there = opacity;
      if (round) there *= covered(normal, normalize(p - eye));
      if (kind == ${FLOOR}) there *= 1.0 - smoothstep(0.55 * fade, fade, distance(p.xy, lamp.xy));
      colour *= there;
    }`,
};

const BALL = { // a disc, on which the ball is seen
  vertex: `#version 300 es
    precision highp float;
    uniform mat4 camera, model;
    uniform vec3 eye;
    uniform float radius;
    out vec3 seen;
    out vec2 disc;           // from -1 to 1
    void main() {
      vec3 to = eye - model[3].xyz;
      vec3 right = normalize(cross(abs(to.z) < 0.99 * length(to) ? vec3(0, 0, 1) : vec3(1, 0, 0), to));
      vec3 up = normalize(cross(to, right));
      float part = radius * radius / dot(to, to);
      disc = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
      seen = model[3].xyz + part * to + radius * sqrt(1.0 - part) * (disc.x * right + disc.y * up);
      gl_Position = camera * vec4(seen, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 seen;
    in vec2 disc;
    uniform mat4 camera, model;
    uniform float radius;
    uniform vec3 ground;     // colour
    uniform int look;        // 0: dots, 1: a number, 2: a number and a stripe
    uniform vec3 dots;       // their colour
    uniform float cell;      // of the number in the picture of numbers
    uniform sampler2D numbers;
    uniform float opacity;
    out vec4 colour;
    ${LIGHT}
    const vec3 WHITE = vec3(0.93, 0.91, 0.84);

    vec3 paint(vec3 o) {
      float soft = fwidth(o.x) + fwidth(o.y) + fwidth(o.z);
      if (look == 0) {
        float far = 1.0;
        for (int k = 0; k < 3; k++) far = min(far, 1.0 - abs(o[k]));
        return mix(dots, ground, smoothstep(0.020, 0.020 + 0.2 * soft, far));
      }
      vec3 base = look == 2 ? mix(ground, WHITE, smoothstep(0.53, 0.53 + soft, abs(o.z))) : ground;
      float aside = length(o.yz);
      base = mix(WHITE, base, smoothstep(0.44, 0.44 + soft, aside));
      vec2 at = 0.5 + vec2(o.x > 0.0 ? o.y : -o.y, o.z) / 0.88;
      float ink = aside < 0.44 ? texture(numbers, vec2((cell + at.x) / 16.0, 1.0 - at.y)).a : 0.0;
      return mix(base, vec3(0.02), ink);
    }

    void main() {
      float edge = 1.0 - length(disc), covered = clamp(edge / fwidth(edge), 0.0, 1.0);
      vec3 view = normalize(seen - eye), from = eye - model[3].xyz;
      vec3 aside = from - dot(from, view) * view; // from the centre to the ray of view
      vec3 p = model[3].xyz + aside - sqrt(max(radius * radius - dot(aside, aside), 0.0)) * view;
      vec3 normal = (p - model[3].xyz) / radius;
      vec3 base = paint(normal * mat3(model));
      if (covered == 0.0) discard;
      vec4 place = camera * vec4(p, 1.0);
      gl_FragDepth = 0.5 + 0.5 * place.z / place.w;
      float down = 0.5 - 0.5 * normal.z;
      vec3 sky = mix(vec3(0.26), vec3(0.02, 0.11, 0.07), down) * (1.0 - 0.5 * down * down);
      vec3 light = lit(p, normal, base, sky);
      vec3 r = reflect(view, normal);
      float fresnel = 0.04 + 0.96 * pow(1.0 - max(dot(-view, normal), 0.0), 5.0);
      vec3 mirror = mix(vec3(0.03, 0.10, 0.07), vec3(0.12, 0.13, 0.15), smoothstep(-0.1, 0.2, r.z));
      if (r.z > 0.0) {
        vec2 q = p.xy + r.xy * (lamp.z - p.z) / r.z - lamp.xy;
        mirror += 16.0 * (1.0 - smoothstep(0.92, 1.08, abs(q.x) / lamp.w))
                       * (1.0 - smoothstep(0.92, 1.08, abs(q.y) / 0.16));
      }
      colour = shown(light + 0.9 * fresnel * mirror) * opacity * covered;
    }`,
};

const LINE = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec4 here;    // place, how far along
    layout(location = 1) in vec4 there;   // the next point
    layout(location = 2) in float pattern; // below 0: no line ends there
    uniform mat4 camera;
    uniform vec2 size;       // of the canvas, in pixels
    uniform float width;     // of lines, in pixels
    out float along, across; // m; pixels from the middle of the line
    flat out int motion;
    void main() {
      vec4 a = camera * vec4(here.xyz, 1.0), b = camera * vec4(there.xyz, 1.0);
      vec2 d = (b.xy / b.w - a.xy / a.w) * size;
      d = length(d) > 1e-6 ? normalize(d) : vec2(1.0, 0.0);
      bool end = gl_VertexID > 1;
      gl_Position = end ? b : a;
      float side = float(gl_VertexID % 2) * 2.0 - 1.0;
      gl_Position.xy += side * vec2(-d.y, d.x) * (width + 1.0) / size * gl_Position.w;
      across = 0.5 * side * (width + 1.0);
      if (pattern < 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
      along = end ? there.w : here.w;
      motion = int(pattern);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in float along, across;
    uniform float width;
    flat in int motion;      // 0: a full line, 1: dashes, 2: dots
    uniform vec3 c;
    uniform float opacity;
    out vec4 colour;
    void main() {
      if (motion == 1 && fract(along / 0.03) > 0.7) discard;
      if (motion == 2 && fract(along / 0.015) > 0.45) discard;
      colour = vec4(c, 1.0) * opacity * clamp(0.5 * width + 0.5 - abs(across), 0.0, 1.0);
    }`,
};

// What a ball, or the cue, takes of the light of the cloth: drawn over the picture of the cloth.
const SHADOW = {
  vertex: `#version 300 es
    precision highp float;
    uniform mat4 camera;
    uniform vec2 middle, along, across; // along and across: to the edges of a rectangle
    out vec3 p;
    void main() {
      vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
      p = vec3(middle + corner.x * along + corner.y * across, 2e-4);
      gl_Position = camera * vec4(p, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 p;
    out vec4 colour;
    ${LIGHT}
    void main() {
      vec3 n = vec3(0.0, 0.0, 1.0), sky = vec3(0.20);
      float all = ballCount > 0 ? lamps(p, n, false) : 1.0;
      float left = ballCount > 0 ? lit(p, n, vec3(1.0), sky).x / (0.42 * all + sky.x) : underCue(p);
      colour = vec4(vec3(pow(left, 1.0 / 1.6)), 1.0);
    }`,
};

const COPY = { // a picture with how deep everything in it is, and the room around it
  vertex: `#version 300 es
    out vec2 at;
    void main() {
      at = vec2(gl_VertexID % 2, gl_VertexID / 2);
      gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec2 at;
    uniform sampler2D picture;
    uniform highp sampler2D depth;
    uniform vec3 room[2];    // its colour in the middle and at the edges
    out vec4 colour;
    void main() {
      colour = texture(picture, at);
      if (colour.a < 1.0) {
        float far = smoothstep(0.0, 1.0, length(2.0 * at - 1.0));
        colour += (1.0 - colour.a) * vec4(mix(room[0], room[1], far), 1.0);
      }
      gl_FragDepth = texture(depth, at).r;
    }`,
};

const DOT = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 place;
    uniform mat4 camera;
    uniform float width;     // pixels
    void main() {
      gl_Position = camera * vec4(place, 1.0);
      gl_PointSize = width;
    }`,
  fragment: `#version 300 es
    precision highp float;
    uniform vec3 c;
    uniform float opacity;
    out vec4 colour;
    void main() { colour = vec4(c, 1.0) * opacity; }`,
};
