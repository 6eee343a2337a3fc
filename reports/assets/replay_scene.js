// What a replay shows: bodies, boundaries, paths, and a camera that is turned by hand. Needs three.js.
'use strict';
const FirnReplayScene = (() => {
  // Faces apart, so that each is shaded flat.
  const flat = (mesh) => {
    const corners = new Float32Array(3 * mesh.triangles.length);
    mesh.triangles.forEach((v, i) => corners.set(mesh.vertices.subarray(3 * v, 3 * v + 3), 3 * i));
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(corners, 3));
    geometry.computeVertexNormals();
    return geometry;
  };

  // three.js r111 has no color of an instance: the shader gets one.
  const tinted = () => {
    const material = new THREE.MeshLambertMaterial({color: 0xffffff});
    material.onBeforeCompile = (shader) => {
      shader.vertexShader = 'attribute vec3 tint;\nvarying vec3 vTint;\n' + shader.vertexShader.replace(
          '#include <begin_vertex>', '#include <begin_vertex>\nvTint = tint;');
      shader.fragmentShader = 'varying vec3 vTint;\n' + shader.fragmentShader.replace(
          '#include <color_fragment>', '#include <color_fragment>\ndiffuseColor.rgb *= vTint;');
    };
    return material;
  };

  // A color for each triangle, little shaded: what it is on the scale must be seen.
  const mapped = () => {
    const material = new THREE.MeshLambertMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide});
    material.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace('#include <envmap_fragment>', `
          float lit = dot(outgoingLight, vec3(1.0)) / max(1e-3, dot(diffuseColor.rgb, vec3(1.0)));
          outgoingLight = diffuseColor.rgb * mix(0.68, 1.0, clamp((lit - 0.4) / 0.9, 0.0, 1.0));`);
    };
    return material;
  };
  const paint = (geometry, colors) => {
    const corners = new Float32Array(3 * colors.length);
    for (let i = 0; i < corners.length; ++i) corners[i] = colors[3 * Math.floor(i / 9) + i % 3];
    geometry.setAttribute('color', new THREE.BufferAttribute(corners, 3));
  };

  // Without a graphics processor smooth edges cost too much.
  const drawnByProcessor = (canvas) => {
    const probe = canvas.cloneNode().getContext('webgl');
    const names = probe && probe.getExtension('WEBGL_debug_renderer_info');
    const name = names ? String(probe.getParameter(names.UNMASKED_RENDERER_WEBGL)) : '';
    if (probe && probe.getExtension('WEBGL_lose_context')) probe.getExtension('WEBGL_lose_context').loseContext();
    return /swiftshader|llvmpipe|software|basic render/i.test(name);
  };

  class Scene {
    constructor(canvas, replay) {
      this.replay = replay;
      this.slow = drawnByProcessor(canvas);
      this.renderer = new THREE.WebGLRenderer({canvas, antialias: !this.slow, preserveDrawingBuffer: true});
      this.scene = new THREE.Scene();
      this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 10);
      this.camera.up.set(0, 0, 1);
      this.orbit = this.sceneOrbit = new FirnReplayOrbit.Orbit(this.camera);
      this.sky = new THREE.HemisphereLight(0xffffff, 0x8090a0, 0.85);
      this.light = new THREE.DirectionalLight(0xffffff, 0.55);
      this.scene.add(this.sky, this.light, this.light.target);
      this.shapes = new Map();  // surfaces with maps, each in a separate scene
      this.shape = null;        // the one that is shown
      this.alone = false;       // boundaries without particles
      this.position = [0, 0, 0];
      this.quaternion = [0, 0, 0, 1];
      this.matrix = new THREE.Matrix4();
      this.selected = -1;
      this.highlighted = -1;    // boundary
      this.addParticles();
      this.addBoundaries();
      this.addLines();
      this.markers = new FirnReplayMarkers.Markers(this.scene, replay);
      this.home();
    }

    addParticles() {
      const r = this.replay;
      this.groups = r.shapes.map((shape, s) => {
        const ids = [];
        for (let i = 0; i < r.particles; ++i) if (r.shape[i] === s) ids.push(i);
        const geometry = flat(shape);
        geometry.computeBoundingSphere();
        const pieces = shape.parts && shape.parts.length ? flat(FirnReplayMarkers.apart(shape.parts)) : null;
        const tint = new THREE.InstancedBufferAttribute(new Float32Array(3 * Math.max(1, ids.length)), 3);
        geometry.setAttribute('tint', tint);
        if (pieces) pieces.setAttribute('tint', tint);
        const mesh = new THREE.InstancedMesh(geometry, tinted(), Math.max(1, ids.length));
        mesh.frustumCulled = false;
        mesh.visible = ids.length > 0;
        this.scene.add(mesh);
        return {ids, mesh, tint, whole: geometry, pieces, radius: geometry.boundingSphere.radius + geometry.boundingSphere.center.length(),
                shown: []};
      });
    }

    // Draws particles by their convex contact parts, or whole.
    showParts(wanted) {
      for (const group of this.groups) group.mesh.geometry = wanted && group.pieces ? group.pieces : group.whole;
    }
    get hasParts() { return this.groups.some((group) => group.pieces); }

    addBoundaries() {
      const {WALLS} = FirnReplayColors;
      this.boundaries = this.replay.boundaries.map((boundary, b) => {
        const material = new THREE.MeshLambertMaterial({color: WALLS[b % WALLS.length],
            // A plane is seen from its free side alone, or those in front would veil the scene.
            side: boundary.plane ? THREE.FrontSide : THREE.DoubleSide, transparent: true, depthWrite: false});
        const mesh = new THREE.Mesh(flat(boundary), material);
        mesh.userData.plane = boundary.plane;
        mesh.matrixAutoUpdate = false;
        mesh.frustumCulled = false;
        this.scene.add(mesh);
        return {mesh, material, wanted: true, color: '#' + material.color.getHexString(), body: this.replay.particles + b};
      });
      this.setOpacity(0.25);
    }

    setOpacity(share) {
      this.opacity = share;
      this.boundaries.forEach(({mesh, material}, b) => {
        const usual = mesh.userData.plane && share < 1 ? 0.6 * share : share;
        material.opacity = b === this.highlighted ? Math.max(usual, 0.5) : usual;
        material.transparent = share < 1;
        material.depthWrite = share >= 1;
        material.needsUpdate = true;
      });
    }

    // One boundary in another color and with its edges, in front of everything; -1: none.
    highlight(b) {
      this.highlighted = b;
      this.boundaries.forEach(({mesh, material}, i) => {
        material.emissive.setHex(i === b ? 0x8a3a00 : 0);
        if (i === b && !mesh.userData.edges) {
          mesh.userData.edges = new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry, 25),
              new THREE.LineBasicMaterial({color: 0xd55e00, depthTest: false}));
          mesh.userData.edges.frustumCulled = false;
          mesh.add(mesh.userData.edges);
        }
        if (mesh.userData.edges) mesh.userData.edges.visible = i === b;
      });
      this.setOpacity(this.opacity);
    }

    // The middle of a boundary where it is, world; null: it is not shown.
    middleOf(b) {
      const {mesh} = this.boundaries[b];
      if (!mesh.visible || this.shape) return null;
      if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
      return mesh.geometry.boundingSphere.center.clone().applyMatrix4(mesh.matrix);
    }

    // The boundary nearest under a point of the picture (-1 ... 1 each way), -1: none.
    pickBoundary(x, y) {
      const hit = this.shape ? null : this.firstHit(this.visibleBoundaries(), x, y);
      return hit ? hit.index : -1;
    }

    // A color for each triangle, opaque; null: as it was.
    paintBoundary(b, colors) {
      const {mesh, material} = this.boundaries[b];
      if (colors) paint(mesh.geometry, colors);
      mesh.material = colors ? this.map = this.map || mapped() : material;
    }

    // A shape by its map in place of the scene; -1: the scene.
    showShape(k) {
      if (k >= 0 && !this.shapes.has(k)) {
        const mesh = new THREE.Mesh(flat(this.replay.maps[k]), this.map = this.map || mapped());
        const shape = {scene: new THREE.Scene(), mesh, orbit: new FirnReplayOrbit.Orbit(this.camera)};
        mesh.geometry.computeBoundingBox();
        shape.scene.add(mesh);
        this.shapes.set(k, shape);
        this.shape = shape;
        this.orbit = shape.orbit;
        this.frame();
      }
      this.shape = k < 0 ? null : this.shapes.get(k);
      this.orbit = this.shape ? this.shape.orbit : this.sceneOrbit;
      (this.shape ? this.shape.scene : this.scene).add(this.sky, this.light, this.light.target);
    }
    paintShape(k, colors) { paint(this.shapes.get(k).mesh.geometry, colors); }

    // Looks at a triangle of a boundary's map, or of the shape's that is shown, from its free side.
    face(b, triangle) {
      const mesh = this.shape ? this.shape.mesh : this.boundaries[b].mesh, geometry = mesh.geometry;
      const corner = (k) => new THREE.Vector3().fromBufferAttribute(geometry.getAttribute('position'), 3 * triangle + k);
      const face = new THREE.Triangle(corner(0), corner(1), corner(2));
      const normal = face.getNormal(new THREE.Vector3()).transformDirection(mesh.matrix);
      geometry.computeBoundingSphere();
      this.orbit.from(face.getMidpoint(new THREE.Vector3()).applyMatrix4(mesh.matrix), normal,
                      2.5 * geometry.boundingSphere.radius);
      this.orbit.apply(this.camera.aspect);
    }

    // The triangle of a map nearest under a point of the picture, or null.
    probe(x, y) {
      return this.firstHit(this.shape ? [this.shape.mesh] : this.visibleBoundaries().filter((m) => m.material === this.map),
                           x, y);
    }

    visibleBoundaries() { return this.boundaries.map((b) => b.mesh).filter((m) => m.visible); }

    // The ray from the eye through a point of the picture, -1 to 1 each.
    caster(x, y) {
      const caster = new THREE.Raycaster();
      caster.setFromCamera(new THREE.Vector2(x, y), this.camera);
      return caster;
    }

    // The nearest of the meshes under a point, with its boundary's index, or -1; null: none.
    firstHit(meshes, x, y) {
      const [hit] = this.caster(x, y).intersectObjects(meshes);
      return hit ? {index: this.boundaries.findIndex((b) => b.mesh === hit.object), triangle: hit.faceIndex,
                    distance: hit.distance} : null;
    }

    addLines() {
      const line = (type, points) => {
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * points), 3));
        geometry.setDrawRange(0, 0);
        const made = new type(geometry, new THREE.LineBasicMaterial({color: 0xd55e00}));
        made.frustumCulled = false;
        this.scene.add(made);
        return made;
      };
      this.path = line(THREE.Line, this.replay.time.length);
      this.path.material.depthTest = false;  // seen through what is in front
      this.bonds = line(THREE.LineSegments, Math.max(1, 2 * this.replay.bonds.length));
      this.bonds.material.depthTest = false;
    }

    // The first view: scene_extent() in reports/replay/replay_data.h.
    home() {
      const {low, high} = this.replay.extent;
      this.box = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high));
      this.markers.resize(0.5 * this.box.getSize(new THREE.Vector3()).length());
      this.frame();
    }

    // When to begin with a still picture: at the start, or, where less than half of the particles
    // are in view then (they come later, or from above), when most of them are.
    stillTime() {
      const r = this.replay, counts = [], times = [], place = new THREE.Vector3();
      for (let f = 0; f < r.time.length; f += Math.ceil(r.time.length / 40)) {
        let inside = 0;
        for (let i = 0; i < r.particles; ++i) {
          if (!r.present(f, i)) continue;
          r.position(f, i, this.position);
          if (this.box.containsPoint(place.fromArray(this.position))) ++inside;
        }
        counts.push(inside);
        times.push(r.time[f]);
      }
      const most = Math.max(0, ...counts);
      return most === 0 || 2 * counts[0] >= most ? r.start : times[counts.lastIndexOf(most)];
    }

    frame() {
      const {clientWidth, clientHeight} = this.renderer.domElement;
      this.orbit.frame(this.shape ? this.shape.mesh.geometry.boundingBox : this.box,
                       clientHeight ? clientWidth / clientHeight : 1.5);
    }

    placeBoundary(mesh, t, frame, body) {
      if (!this.replay.pose(t, frame, body, this.position, this.quaternion)) return false;
      mesh.matrix.compose(new THREE.Vector3().fromArray(this.position),
          new THREE.Quaternion().fromArray(this.quaternion), new THREE.Vector3(1, 1, 1));
      mesh.matrixWorldNeedsUpdate = true;
      return true;
    }

    // `color(id, t, frame, out, at)` writes red, green, blue.
    show(t, color) {
      const r = this.replay, frame = r.frameAt(t), m = this.matrix.elements;
      for (const group of this.groups) {
        let n = 0;
        group.shown.length = 0;
        const matrices = group.mesh.instanceMatrix.array, tints = group.tint.array;
        for (const id of this.alone ? [] : group.ids) {
          if (!r.pose(t, frame, id, this.position, this.quaternion)) continue;
          rotation(this.quaternion, m);
          m[12] = this.position[0]; m[13] = this.position[1]; m[14] = this.position[2];
          matrices.set(m, 16 * n);
          color(id, t, frame, tints, 3 * n);
          if (id === this.selected) tints.set([1.6, 0.45, 0.1], 3 * n);
          group.shown.push(id);
          ++n;
        }
        group.mesh.count = n;
        group.mesh.instanceMatrix.needsUpdate = true;
        group.tint.needsUpdate = true;
      }
      for (const b of this.boundaries) {
        b.mesh.visible = b.wanted && this.placeBoundary(b.mesh, t, frame, b.body);
      }
      this.showBonds(t, frame);
    }

    showBonds(t, frame) {
      const r = this.replay, out = this.bonds.geometry.getAttribute('position');
      let n = 0;
      for (const bond of r.bonds) {
        if (bond.broken <= t) continue;
        const center = (id) => r.pose(t, frame, id, this.position, this.quaternion) ? [...this.position] : null;
        // A bond to a boundary has an end in place of a second body.
        const ends = [center(bond.a), bond.end || center(bond.b)];
        if (!ends[0] || !ends[1]) continue;
        out.array.set(ends[0], 3 * n++);
        out.array.set(ends[1], 3 * n++);
      }
      this.bonds.geometry.setDrawRange(0, n);
      out.needsUpdate = true;
    }

    select(id) {
      this.selected = id;
      const out = this.path.geometry.getAttribute('position');
      let n = 0;
      for (let f = 0; id >= 0 && f < this.replay.time.length; ++f) {
        if (this.replay.present(f, id)) this.replay.position(f, id, out.array, 3 * n++);
      }
      this.path.geometry.setDrawRange(0, n);
      out.needsUpdate = true;
    }

    // The particle nearest under a point of the picture (-1 ... 1 each way), -1: none; and how far.
    pick(x, y) {
      const caster = this.caster(x, y);
      const own = new THREE.Ray(), hit = new THREE.Vector3(), inverse = new THREE.Matrix4();
      const ball = new THREE.Sphere(), corners = [0, 1, 2].map(() => new THREE.Vector3());
      let best = -1, nearest = Infinity;
      for (const group of this.groups) {
        const vertices = group.mesh.geometry.getAttribute('position');
        group.shown.forEach((id, n) => {
          this.matrix.fromArray(group.mesh.instanceMatrix.array, 16 * n);
          ball.set(ball.center.setFromMatrixPosition(this.matrix), group.radius);
          if (!caster.ray.intersectsSphere(ball)) return;
          own.copy(caster.ray).applyMatrix4(inverse.getInverse(this.matrix));
          for (let v = 0; v < vertices.count; v += 3) {
            corners.forEach((c, k) => c.fromBufferAttribute(vertices, v + k));
            if (!own.intersectTriangle(...corners, false, hit)) continue;
            const distance = hit.distanceTo(own.origin);  // bodies are not scaled
            if (distance < nearest) [best, nearest] = [id, distance];
          }
        });
      }
      return {particle: best, distance: nearest};
    }

    // Browsers allow few contexts: this one is given back.
    dispose() {
      this.renderer.dispose();
      this.renderer.forceContextLoss();
    }

    render(width, height, ratio, background) {
      // Even the same size again would make a new, empty picture.
      const size = `${width} ${height} ${ratio}`;
      if (size !== this.size) {
        this.size = size;
        this.renderer.setPixelRatio(ratio);
        this.renderer.setSize(width, height, false);
      }
      this.renderer.setClearColor(background);
      this.orbit.apply(width / height);
      // From over the viewer's left shoulder.
      const e = this.camera.matrix.elements;
      this.light.position.set(e[8] - 0.5 * e[0] + 0.6 * e[4], e[9] - 0.5 * e[1] + 0.6 * e[5],
                              e[10] - 0.5 * e[2] + 0.6 * e[6]).add(this.orbit.target);
      this.light.target.position.copy(this.orbit.target);
      this.light.target.updateMatrixWorld();
      this.renderer.render(this.shape ? this.shape.scene : this.scene, this.camera);
    }
  }

  // Columns of a rotation matrix from a unit quaternion x y z w.
  const rotation = ([x, y, z, w], m) => {
    m[0] = 1 - 2 * (y * y + z * z); m[1] = 2 * (x * y + z * w); m[2] = 2 * (x * z - y * w); m[3] = 0;
    m[4] = 2 * (x * y - z * w); m[5] = 1 - 2 * (x * x + z * z); m[6] = 2 * (y * z + x * w); m[7] = 0;
    m[8] = 2 * (x * z + y * w); m[9] = 2 * (y * z - x * w); m[10] = 1 - 2 * (x * x + y * y); m[11] = 0;
    m[15] = 1;
  };

  return {Scene};
})();
