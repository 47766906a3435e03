// Land and sea: the ground with its relief, lakes and rocks or, for a volume of water, its surface and floor.

import {
  BackSide, BoxGeometry, BufferAttribute, BufferGeometry, CircleGeometry, Color, DataTexture, DoubleSide, FloatType, Group, IcosahedronGeometry, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, NearestFilter, PlaneGeometry, RedFormat, ShaderMaterial, Vector2,
} from "./vendor.js";
import { LAND_FRAGMENT, WATER_FRAGMENT, WATER_VERTEX } from "./shaders.js";

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
    this.highest = this.heights.reduce((a, b) => Math.max(a, b), 0);
    this.lowest = this.heights.reduce((a, b) => Math.min(a, b), 0);
    this.texture = new DataTexture(this.heights, this.nx || 1, this.ny || 1, RedFormat, FloatType, undefined, undefined, undefined, NearestFilter, NearestFilter);
    this.texture.needsUpdate = true;
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

/** The static elements of the scene. */
export class Ground {
  /**
   * @param {Hello} hello
   * @param {Relief} relief
   */
  constructor(hello, relief) {
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
    this.soil = new MeshLambertMaterial({ vertexColors: Boolean(relief.nx) });
    this.flat = new ShaderMaterial({
      vertexShader: WATER_VERTEX, fragmentShader: LAND_FRAGMENT, side: DoubleSide, transparent: true, depthWrite: false,
      uniforms: { size: { value: new Vector2(...hello.size) }, grassy: { value: new Color() }, bare: { value: new Color() }, beyond: { value: 1 } },
    });
    this.lake = new MeshLambertMaterial({ transparent: true, opacity: 0.86 });
    this.stone = new MeshLambertMaterial({ flatShading: true });
    this.surface = new MeshBasicMaterial({ transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false });
    this.water = new ShaderMaterial({
      vertexShader: WATER_VERTEX, fragmentShader: WATER_FRAGMENT, side: BackSide,
      uniforms: {
        depth: { value: hello.size[2] ?? 0 }, murk: { value: this.murk }, day: { value: 1 },
        shallow: { value: new Color() }, deep: { value: new Color() }, night: { value: new Color() },
      },
    });
    if (this.volume) this.sea();
    else this.land();
  }

  land() {
    const [x, y] = this.hello.size;
    if (this.relief.nx) this.group.add(this.hills());
    else {
      const plane = new Mesh(new PlaneGeometry(9 * x, 9 * y), this.flat); // the land around the world fades into the distance
      plane.position.set(x / 2, y / 2, -0.02 * Math.min(1, x / 100));
      plane.renderOrder = -1;
      this.group.add(plane, this.grid());
    }
    for (const lake of this.hello.terrain?.lakes ?? []) this.group.add(this.disc(lake));
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
    const { nx, ny, size } = this.relief;
    const most = this.hello.terrain?.colours ? 256 : 160;
    const [mx, my] = [Math.min(most, nx), Math.min(most, ny)];
    const geometry = new PlaneGeometry(size[0], size[1], mx, my);
    const at = geometry.getAttribute("position");
    for (let k = 0; k < at.count; k++) {
      const [x, y] = [at.getX(k) + size[0] / 2, at.getY(k) + size[1] / 2];
      at.setXYZ(k, x, y, this.relief.at(x, y));
    }
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(at.count * 3), 3));
    geometry.computeVertexNormals();
    this.mountains = geometry;
    return new Mesh(geometry, this.soil);
  }

  /** @param {import("./protocol.js").Landmark} lake */
  disc(lake) {
    const geometry = new CircleGeometry(lake.radius, 48);
    const at = geometry.getAttribute("position");
    const lift = 0.004 * Math.max(...this.hello.size);
    const level = this.relief.at(lake.at[0], lake.at[1]);
    for (let k = 0; k < at.count; k++) {
      const [x, y] = [at.getX(k) + lake.at[0], at.getY(k) + lake.at[1]];
      at.setXYZ(k, x, y, Math.max(level, this.relief.at(x, y)) + lift);
    }
    geometry.computeVertexNormals();
    return new Mesh(geometry, this.lake);
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
    this.group.add(box, surface, new LineSegments(edges, this.lines));
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
    this.lake.color.copy(dark ? mix("#173248", "#2f6f9e") : mix("#6f93b0", "#7fb7dc"));
    this.stone.color.copy(dark ? mix("#3c4347", "#6b7377") : mix("#8b9297", "#aab0b3"));
    this.surface.color.copy(mix("#5b7fa6", "#d9f3ff"));
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
    const stops = (dark ? ["#1d3226", "#2a3d2a", "#4a4a3c", "#77736a"] : ["#cde2b4", "#dde6bd", "#dccfa9", "#f3f1ec"]).map((hex) => new Color(hex));
    const [at, colour] = [geometry.getAttribute("position"), geometry.getAttribute("color")];
    const span = Math.max(1e-6, this.relief.highest - this.relief.lowest);
    const mixed = new Color();
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
