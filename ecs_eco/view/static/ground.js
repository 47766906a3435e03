// Land and sea: the ground with its relief, lakes and rocks or, for a volume of water, its surface and floor.

import {
  BackSide, BoxGeometry, BufferAttribute, BufferGeometry, CircleGeometry, Color, DataTexture, DoubleSide, FloatType, Group, IcosahedronGeometry, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, NearestFilter, PlaneGeometry, RedFormat, ShaderMaterial, Vector2, Vector3,
} from "./vendor.js";
import { LAKE_FRAGMENT, LAND_FRAGMENT, SHAFT_FRAGMENT, SHAFT_VERTEX, SOIL, SURFACE_FRAGMENT, WATER_FRAGMENT, WATER_VERTEX } from "./shaders.js";

/** @typedef {import("./protocol.js").Hello} Hello */

/** Heights of the ground, interpolated bilinearly between cell centers; 0 everywhere if there is no terrain. */
export class Relief {
  /** @param {Hello} hello */
  constructor(hello) {
    this.size = hello.size;
    this.torus = hello.edges === "torus";
    const terrain = hello.terrain;
    this.nx = terrain?.nx ?? 0;
    this.ny = terrain?.ny ?? 0;
    const bytes = terrain ? Uint8Array.from(atob(terrain.heights), (letter) => letter.charCodeAt(0)) : new Uint8Array(4);
    this.heights = new Float32Array(bytes.buffer);
    this.levels = (terrain?.lakes ?? []).map((lake) => this.drown(lake));
    const most = terrain?.colours ? 256 : 160;
    this.parts = [Math.min(most, this.nx), Math.min(most, this.ny)]; // of its mesh, along x and y
    this.highest = this.heights.reduce((a, b) => Math.max(a, b), 0);
    this.lowest = this.heights.reduce((a, b) => Math.min(a, b), 0);
    this.texture = new DataTexture(this.heights, this.nx || 1, this.ny || 1, RedFormat, FloatType, undefined, undefined, undefined, NearestFilter, NearestFilter);
    this.texture.needsUpdate = true;
  }

  /** Lowers the ground of a lake to its level, the lowest point of its shore; returns the level [m]. @param {import("./protocol.js").Landmark} lake */
  drown({ at, radius }) {
    const { nx, ny, size, heights } = this;
    const from = (/** @type {number} */ i, /** @type {number} */ j) => Math.hypot(((i + 0.5) * size[0]) / nx - at[0], ((j + 0.5) * size[1]) / ny - at[1]) / radius;
    const within = Array.from(heights, (_, k) => from(k % nx, Math.floor(k / nx)));
    const shore = heights.filter((_, k) => within[k] > 0.93 && within[k] < 1.07), level = shore.length ? Math.min(...shore) : this.at(at[0], at[1]);
    within.forEach((share, k) => share < 1 && (heights[k] = Math.min(heights[k], level)));
    return level;
  }

  /**
   * @param {number} x [m]
   * @param {number} y [m]
   */
  at(x, y) {
    if (!this.nx) return 0;
    const { nx, ny, heights } = this;
    const u = (x / this.size[0]) * nx - 0.5;
    const v = (y / this.size[1]) * ny - 0.5;
    const [i, j] = [Math.floor(u), Math.floor(v)];
    const into = (/** @type {number} */ a, /** @type {number} */ n) => (this.torus ? (a + n) % n : Math.min(n - 1, Math.max(0, a)));
    const cell = (/** @type {number} */ a, /** @type {number} */ b) => heights[into(b, ny) * nx + into(a, nx)];
    const [p, q] = [u - i, v - j];
    return (cell(i, j) * (1 - p) + cell(i + 1, j) * p) * (1 - q) + (cell(i, j + 1) * (1 - p) + cell(i + 1, j + 1) * p) * q;
  }
}

/** Hills get the texture of their land cover. @param {MeshLambertMaterial} material @param {Record<string, {value: any}>} own */
function textured(material, own) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, own);
    shader.vertexShader = `varying vec2 vOver;\n${shader.vertexShader.replace("#include <begin_vertex>", "#include <begin_vertex>\n  vOver = position.xy;")}`;
    shader.fragmentShader = SOIL + shader.fragmentShader.replace("#include <color_fragment>", "#include <color_fragment>\n  diffuseColor.rgb = textured(diffuseColor.rgb);");
  };
}

/** The static elements of the scene. */
export class Ground {
  /**
   * @param {Hello} hello
   * @param {Relief} relief
   * @param {number} largest radius of the largest animal [m]
   */
  constructor(hello, relief, largest) {
    this.hello = hello;
    this.relief = relief;
    this.group = new Group();
    this.volume = hello.size.length > 2;
    this.light = 1;
    this.murk = this.volume ? 2.6 / hello.size[2] : 0;
    /** @type {boolean | undefined} whether the hills are painted for the dark theme */
    this.painted = undefined;
    /** @type {LineSegments | null} */
    this.fenced = null;
    /** @type {(Mesh | LineSegments)[]} roads and borders of areas */
    this.used = [];
    this.wood = new LineBasicMaterial();
    this.dust = new MeshLambertMaterial({ side: DoubleSide, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2 });
    this.borders = { harvest: new LineBasicMaterial({ color: "#d6454f" }), plant: new LineBasicMaterial({ color: "#3f9b4f" }) };
    this.lines = new LineBasicMaterial({ transparent: true });
    this.soil = new MeshLambertMaterial({ vertexColors: true });
    this.sides = new MeshBasicMaterial({ side: DoubleSide });
    this.grain = { value: 1.5 * largest || Math.max(...hello.size) / 200 };
    const { nx, ny, cover } = hello.terrain ?? { nx: 1, ny: 1, cover: undefined };
    const kinds = new DataTexture(cover ? Uint8Array.from(atob(cover), (letter) => letter.charCodeAt(0)) : new Uint8Array(nx * ny), nx, ny, RedFormat);
    Object.assign(kinds, { unpackAlignment: 1, needsUpdate: true });
    textured(this.soil, { cover: { value: kinds }, size: { value: new Vector2(...hello.size) }, grain: this.grain });
    this.flat = new ShaderMaterial({
      vertexShader: WATER_VERTEX, fragmentShader: LAND_FRAGMENT, side: DoubleSide, transparent: true, depthWrite: false,
      uniforms: { size: { value: new Vector2(...hello.size) }, grain: this.grain, grassy: { value: new Color() }, bare: { value: new Color() }, beyond: { value: 1 } },
    });
    this.lake = { value: new Color() };
    this.stone = new MeshLambertMaterial({ flatShading: true });
    const shine = { value: new Color() };
    this.shine = shine.value;
    this.surface = new ShaderMaterial({ vertexShader: WATER_VERTEX, fragmentShader: SURFACE_FRAGMENT, transparent: true, side: DoubleSide, depthWrite: false, uniforms: { colour: shine, grain: this.grain } });
    this.water = new ShaderMaterial({
      vertexShader: WATER_VERTEX, fragmentShader: WATER_FRAGMENT, side: BackSide,
      uniforms: {
        depth: { value: hello.size[2] ?? 0 }, grain: this.grain,  murk: { value: this.murk }, day: { value: 1 },
        shallow: { value: new Color() }, deep: { value: new Color() }, night: { value: new Color() },
      },
    });
    const { shallow, deep, night } = this.water.uniforms;
    this.waters = { shallow, deep, night };
    if (this.volume) this.sea();
    else this.land();
  }

  land() {
    const [x, y] = this.hello.size;
    const plane = new Mesh(new PlaneGeometry(9 * x, 9 * y), this.flat); // the land around the world fades into the distance
    plane.position.set(x / 2, y / 2, this.relief.nx ? this.relief.lowest - 0.03 * Math.max(x, y) : -0.02 * Math.min(1, x / 100));
    plane.renderOrder = -1;
    this.group.add(plane, ...(this.relief.nx ? [this.hills(), this.cut()] : [this.grid()]));
    for (const [i, lake] of (this.hello.terrain?.lakes ?? []).entries()) this.group.add(this.disc(lake, this.relief.levels[i]));
    for (const [i, rock] of (this.hello.terrain?.rocks ?? []).entries()) this.group.add(this.rock(rock, i));
  }

  /** Draws grid lines at round distances, and the border. */
  grid() {
    const [x, y] = this.hello.size;
    const step = round(Math.max(x, y) / 8);
    const points = [];
    for (let a = 0; a <= x + 1e-6; a += step) points.push(a, 0, 0, a, y, 0);
    for (let b = 0; b <= y + 1e-6; b += step) points.push(0, b, 0, x, b, 0);
    points.push(x, 0, 0, x, y, 0, 0, y, 0, x, y, 0);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    return new LineSegments(geometry, this.lines);
  }

  hills() {
    const { size, parts: [mx, my] } = this.relief;
    const geometry = new PlaneGeometry(size[0], size[1], mx, my);
    const at = geometry.getAttribute("position");
    for (let k = 0; k < at.count; k++) {
      const [x, y] = [at.getX(k) + size[0] / 2, at.getY(k) + size[1] / 2];
      at.setXYZ(k, x, y, this.relief.at(x, y));
      this.hello.terrain?.lakes?.forEach(({ at: [u, v], radius }, i) => { // round shores
        const away = Math.hypot(x - u, y - v);
        if (Math.abs(away - radius) < (0.7 * size[0]) / mx) at.setXYZ(k, u + ((x - u) * radius) / away, v + ((y - v) * radius) / away, this.relief.levels[i]);
      });
    }
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(at.count * 3), 3));
    geometry.computeVertexNormals();
    this.mountains = geometry;
    return new Mesh(geometry, this.soil);
  }

  /** The cut edges of the land. */
  cut() {
    const { relief, hello: { size: [x, y] } } = this, low = relief.lowest - 0.03 * Math.max(x, y), parts = 128, points = [];
    const ring = [[0, 0], [x, 0], [x, y], [0, y], [0, 0]];
    for (let side = 0; side < 4; side++)
      for (let p = 0; p < parts; p++) {
        const [a, b] = [p, p + 1].map((at) => ring[side].map((from, axis) => from + ((ring[side + 1][axis] - from) * at) / parts));
        const [high, next] = [a, b].map(([u, v]) => relief.at(u, v));
        points.push(...a, low, ...b, low, ...b, next, ...a, low, ...b, next, ...a, high);
      }
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    geometry.computeVertexNormals();
    return new Mesh(geometry, this.sides);
  }

  /** @param {import("./protocol.js").Landmark} lake @param {number} level [m] */
  disc({ at: [x, y], radius }, level) {
    const uniforms = { colour: this.lake, grain: this.grain, round: { value: [x, y, radius, 0] } };
    const water = new Mesh(new CircleGeometry(radius, 96), new ShaderMaterial({ vertexShader: WATER_VERTEX, fragmentShader: LAKE_FRAGMENT, transparent: true, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -16, uniforms }));
    water.position.set(x, y, level + 0.0006 * Math.max(...this.hello.size));
    return water;
  }

  /**
   * @param {import("./protocol.js").Landmark} rock
   * @param {number} i
   */
  rock(rock, i) {
    const geometry = new IcosahedronGeometry(1, 1);
    const at = geometry.getAttribute("position");
    for (let k = 0; k < at.count; k++) {
      const [x, y, z] = [at.getX(k), at.getY(k), at.getZ(k)];
      const bump = 0.9 + 0.14 * Math.sin(5 * x + 3.1 * i) * Math.cos(4 * y - 2.3 * i + 3 * z);
      at.setXYZ(k, x * bump, y * bump, z * bump);
    }
    geometry.computeVertexNormals();
    const mesh = new Mesh(geometry, this.stone);
    mesh.position.set(rock.at[0], rock.at[1], this.relief.at(rock.at[0], rock.at[1]));
    mesh.scale.set(rock.radius, rock.radius, rock.height || rock.radius * 0.7);
    return mesh;
  }

  /**
   * Draws fences, given the corners [m] of each.
   * @param {number[][][]} fences
   */
  fence(fences) {
    if (this.fenced) this.group.remove(this.fenced);
    const points = [];
    const tall = 0.012 * Math.max(...this.hello.size);
    for (const corners of fences) {
      for (let k = 1; k < corners.length; k++) {
        const [[ax, ay], [bx, by]] = [corners[k - 1], corners[k]];
        const parts = Math.max(1, Math.ceil(Math.hypot(bx - ax, by - ay) / tall));
        for (let p = 0; p <= parts; p++) {
          const at = (/** @type {number} */ share) => [ax + (bx - ax) * share, ay + (by - ay) * share];
          const [x, y] = at(p / parts);
          const ground = this.relief.at(x, y);
          points.push(x, y, ground, x, y, ground + tall);
          if (p === parts) continue;
          const [u, v] = at((p + 1) / parts);
          for (const level of [0.45, 0.85]) points.push(x, y, ground + level * tall, u, v, this.relief.at(u, v) + level * tall);
        }
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    this.fenced = new LineSegments(geometry, this.wood);
    this.group.add(this.fenced);
  }

  /**
   * Draws roads, and the dashed borders of land-use and sea-use areas.
   * @param {import("./protocol.js").Strip[]} roads
   * @param {import("./protocol.js").Area[]} areas
   */
  use(roads, areas) {
    for (const part of this.used) {
      this.group.remove(part);
      part.geometry.dispose();
    }
    this.used = this.volume ? [] : roads.map((road) => this.road(road));
    for (const area of areas) this.used.push(this.border(area));
    for (const part of this.used) this.group.add(part);
  }

  /** @param {import("./protocol.js").Strip} road */
  road({ line, width }) {
    const points = [];
    const fine = Math.max(width, 0.01 * Math.max(...this.hello.size));
    for (let k = 1; k < line.length; k++) {
      const [[ax, ay], [bx, by]] = [line[k - 1], line[k]];
      const long = Math.hypot(bx - ax, by - ay) || 1e-9;
      const [ux, uy] = [((bx - ax) / long) * (width / 2), ((by - ay) / long) * (width / 2)];
      const parts = Math.max(1, Math.ceil(long / fine));
      const across = (/** @type {number} */ share, /** @type {number} */ side) => {
        const beyond = share === 0 ? -1 : share === 1 ? 1 : 0; // extends the ends, to avoid gaps at corners
        const [x, y] = [ax + (bx - ax) * share + beyond * ux - side * uy, ay + (by - ay) * share + beyond * uy + side * ux];
        return [x, y, this.relief.at(x, y) + 0.001 * Math.max(...this.hello.size)];
      };
      for (let p = 0; p < parts; p++) {
        const [a, b, c, d] = [across(p / parts, -1), across(p / parts, 1), across((p + 1) / parts, -1), across((p + 1) / parts, 1)];
        points.push(...a, ...c, ...b, ...b, ...c, ...d);
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    geometry.computeVertexNormals();
    return new Mesh(geometry, this.dust);
  }

  /** @param {import("./protocol.js").Area} area */
  border({ kind, border }) {
    const points = [];
    const dash = 0.012 * Math.max(...this.hello.size);
    for (let k = 1; k < border.length; k++) {
      const [[ax, ay], [bx, by]] = [border[k - 1], border[k]];
      const parts = 2 * Math.max(1, Math.round(Math.hypot(bx - ax, by - ay) / dash / 2));
      for (let p = 0; p < parts; p += 2) {
        for (const share of [p / parts, (p + 1) / parts]) {
          const [x, y] = [ax + (bx - ax) * share, ay + (by - ay) * share];
          points.push(x, y, this.volume ? this.hello.size[2] : this.relief.at(x, y) + dash / 4);
        }
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    return new LineSegments(geometry, this.borders[kind]);
  }

  sea() {
    const [x, y, z] = this.hello.size;
    const box = new Mesh(new BoxGeometry(x, y, z), this.water); // only the far inner sides are drawn
    box.position.set(x / 2, y / 2, z / 2);
    const surface = new Mesh(new PlaneGeometry(x, y), this.surface);
    surface.position.set(x / 2, y / 2, z);
    surface.renderOrder = 5;
    const points = [];
    for (const [a, b] of [[0, 0], [x, 0], [x, y], [0, y]]) points.push(a, b, 0, a, b, z);
    for (const c of [0, z]) points.push(0, 0, c, x, 0, c, x, 0, c, x, y, c, x, y, c, 0, y, c, 0, y, c, 0, 0, c);
    const edges = new BufferGeometry();
    edges.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    this.group.add(box, surface, this.shafts(), new LineSegments(edges, this.lines));
  }

  /** Shafts of light, from the surface to the deep. */
  shafts() {
    const corners = [], each = [], chance = (/** @type {number} */ k) => (0.618034 * k) % 1;
    for (let k = 1; k <= 14; k++)
      for (const [u, v] of [[-1, 0], [1, 0], [1, 1], [-1, 0], [1, 1], [-1, 1]]) {
        corners.push(u, 0.9 * v, 0);
        each.push(0.05 + 0.72 * chance(k), 0.05 + 0.8 * chance(2.7 * k), 0.012 + 0.03 * chance(5.3 * k), 0.5 + 0.5 * chance(7.1 * k));
      }
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(corners), 3)).setAttribute("shaft", new BufferAttribute(new Float32Array(each), 4));
    const uniforms = { size: { value: new Vector3(...this.hello.size) }, colour: this.surface.uniforms.colour, day: this.water.uniforms.day };
    const mesh = new Mesh(geometry, new ShaderMaterial({ vertexShader: SHAFT_VERTEX, fragmentShader: SHAFT_FRAGMENT, transparent: true, side: DoubleSide, depthWrite: false, uniforms }));
    mesh.frustumCulled = false;
    mesh.renderOrder = 4;
    return mesh;
  }

  /**
   * Sets the colors for a theme and the current light.
   * @param {boolean} dark
   * @param {number} light 0 … 1
   */
  tint(dark, light) {
    const day = Math.min(1, Math.max(0, light));
    const mix = (/** @type {string} */ night, /** @type {string} */ noon) => new Color(night).lerp(new Color(noon), day);
    const land = this.flat.uniforms; // two colors of equal luminance, so that organisms stand out everywhere
    land.grassy.value.copy(dark ? mix("#101a15", "#14251a") : mix("#b3c0b4", "#e4f3d6"));
    land.bare.value.copy(dark ? mix("#161816", "#22221a") : mix("#bcbcb0", "#f6efdf"));
    land.beyond.value = dark ? 0.72 : 0.87;
    this.lines.color.copy(dark ? new Color("#5b6f73") : new Color("#7d8a86"));
    this.lines.opacity = this.volume ? 0.55 : dark ? 0.28 : 0.26;
    this.dust.color.copy(dark ? mix("#2c2822", "#5a5041") : mix("#a89f8c", "#d8ccb4"));
    this.wood.color.copy(new Color(dark ? "#c9a36a" : "#7a5a2e"));
    this.sides.color.copy(dark ? mix("#1c1712", "#3a2f24") : mix("#6d5c48", "#a08a6c"));
    this.lake.value.copy(dark ? mix("#173248", "#2f6f9e") : mix("#6f93b0", "#7fb7dc"));
    this.stone.color.copy(dark ? mix("#3c4347", "#6b7377") : mix("#8b9297", "#aab0b3"));
    this.shine.copy(mix("#5b7fa6", "#d9f3ff"));
    const uniforms = this.water.uniforms;
    uniforms.day.value = day;
    uniforms.shallow.value.set(dark ? "#2f7fa3" : "#a9d8ea");
    uniforms.deep.value.set(dark ? "#07263a" : "#2d6a8e");
    uniforms.night.value.set(dark ? "#0a141d" : "#35506a");
    this.paint(dark);
  }

  /** Sets the colors of the hills by height. @param {boolean} dark */
  paint(dark) {
    const geometry = this.mountains;
    if (!geometry || this.painted === dark) return;
    this.painted = dark;
    const cells = this.hello.terrain?.colours;
    const land = cells && Uint8Array.from(atob(cells), (letter) => letter.charCodeAt(0));
    const soil = this.hello.species.some(({ sessile }) => sessile) ? (dark ? ["#40362a", "#473c2e"] : ["#d9c49a", "#dcc9a2"]) : dark ? ["#1d3226", "#2a3d2a"] : ["#b8e096", "#cde6a8"]; // bare below plants
    const stops = [...soil, ...(dark ? ["#4a4a3c", "#77736a"] : ["#dccfa9", "#f3f1ec"])].map((hex) => new Color(hex));
    const [at, colour] = [geometry.getAttribute("position"), geometry.getAttribute("color")];
    const span = Math.max(1e-6, this.relief.highest - this.relief.lowest);
    const mixed = new Color(), shore = new Color(dark ? "#4d4430" : "#f3e6c0");
    for (let k = 0; k < at.count; k++) {
      const level = 2.999 * Math.min(1, Math.max(0, (at.getZ(k) - this.relief.lowest) / span));
      const i = Math.floor(level);
      mixed.copy(stops[i]).lerp(stops[i + 1], level - i);
      if (land) {
        const { nx, ny, size } = this.relief;
        const cell = (/** @type {number} */ at, /** @type {number} */ n) => Math.min(n - 1, Math.max(0, Math.floor(at * n)));
        const c = 3 * (cell(at.getY(k) / size[1], ny) * nx + cell(at.getX(k) / size[0], nx));
        mixed.setHex(land[c] * 65536 + land[c + 1] * 256 + land[c + 2]).multiplyScalar(dark ? 0.3 : 1);
      }
      for (const { at: [x, y], radius } of this.hello.terrain?.lakes ?? []) { // a sandy shore
        const away = Math.hypot(at.getX(k) - x, at.getY(k) - y) / radius - 1;
        if (away < 0.1) mixed.lerp(shore, Math.min(1, 1.2 - away / 0.1));
      }
      colour.setXYZ(k, mixed.r, mixed.g, mixed.b);
    }
    colour.needsUpdate = true;
  }
}

/** The largest number of the form 1, 2 or 5 × 10ⁿ that does not exceed a value. @param {number} value */
export function round(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return power * (lead >= 5 ? 5 : lead >= 2 ? 2 : 1);
}
