// Fills, inlets, sensors, outlets, measurement regions and axes of a scene. Needs three.js.
'use strict';
const FirnReplayMarkers = (() => {
  const COLORS = {'fill': 0x0072b2, 'inlet': 0x56b4e9, 'sensor': 0x009e73, 'outlet': 0xd55e00, 'tag rule': 0xe69f00,
                   'measurement': 0xcc79a7, 'motion': 0x8a5a00, 'free body': 0x7a3fb0, 'coupling': 0xb71c1c};
  const css = (number) => '#' + number.toString(16).padStart(6, '0');

  // Joins all parts into one mesh. Each part is scaled down about its middle, so that gaps separate them.
  const apart = (parts) => {
    const vertices = [], triangles = [];
    for (const part of parts) {
      const first = vertices.length / 3, count = part.vertices.length / 3, middle = [0, 0, 0];
      for (let i = 0; i < part.vertices.length; ++i) middle[i % 3] += part.vertices[i] / count;
      for (let i = 0; i < part.vertices.length; ++i)
        vertices.push(middle[i % 3] + 0.9 * (part.vertices[i] - middle[i % 3]));
      for (const corner of part.triangles) triangles.push(first + corner);
    }
    return {vertices: Float32Array.from(vertices), triangles};
  };

  class Markers {
    constructor(scene, replay) {
      this.scene = scene;
      this.list = [];
      this.kinds = new Map();  // kind -> {color, count}
      for (const marker of replay.markers || []) {
        const known = this.kinds.get(marker.kind) || {color: css(COLORS[marker.kind] || 0x666666), count: 0};
        ++known.count;
        this.kinds.set(marker.kind, known);
        const made = {marker, group: new THREE.Group(), at: new THREE.Vector3()};
        made.group.visible = false;
        scene.add(made.group);
        this.list.push(made);
      }
    }

    // Drawn again for a scene of this radius, m.
    resize(radius) {
      for (const {marker, group, at} of this.list) {
        group.remove(...group.children);
        const color = COLORS[marker.kind] || 0x666666;
        if (marker.form === 'box') this.addBox(marker, group, at, color, radius);
        else if (marker.form === 'plane') this.addPlane(marker, group, at, color, radius);
        else if (marker.form === 'point') this.addPoint(marker, group, at, color, radius);
        else if (marker.form === 'line') this.addLine(marker, group, at, color);
        else this.addAxis(marker, group, at, color, radius);
      }
    }
    addBox(marker, group, at, color, radius) {
      const low = new THREE.Vector3(...marker.low), high = new THREE.Vector3(...marker.high);
      const size = high.clone().sub(low).max(new THREE.Vector3(1, 1, 1).multiplyScalar(1e-3 * radius));
      const geometry = new THREE.BoxBufferGeometry(size.x, size.y, size.z);
      const edges = new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({color}));
      const body = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({color, transparent: true, opacity: 0.08,
          depthWrite: false}));
      group.add(edges, body);
      group.position.copy(low).add(high).multiplyScalar(0.5);
      at.copy(group.position);
      at.z = high.z;
    }
    addPlane(marker, group, at, color, radius) {
      const normal = new THREE.Vector3(...marker.normal).normalize();
      const plane = new THREE.Mesh(new THREE.PlaneBufferGeometry(radius, radius), new THREE.MeshBasicMaterial({
          color, transparent: true, opacity: 0.15, side: THREE.DoubleSide, depthWrite: false}));
      plane.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
      const arrow = new THREE.ArrowHelper(normal, new THREE.Vector3(), 0.2 * radius, color, 0.06 * radius, 0.04 * radius);
      group.add(plane, arrow);
      group.position.set(...marker.point);
      at.copy(group.position);
    }
    addPoint(marker, group, at, color, radius) {
      group.add(new THREE.Mesh(new THREE.SphereBufferGeometry(0.025 * radius, 16, 12),
          new THREE.MeshBasicMaterial({color, depthTest: false})));
      group.position.set(...marker.point);
      at.copy(group.position);
    }
    addLine(marker, group, at, color) {
      const low = new THREE.Vector3(...marker.low), high = new THREE.Vector3(...marker.high);
      group.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints([low, high]),
          new THREE.LineBasicMaterial({color, depthTest: false})));
      at.copy(low).add(high).multiplyScalar(0.5);
    }
    addAxis(marker, group, at, color, radius) {
      const direction = new THREE.Vector3(...marker.direction).normalize(), length = 0.5 * radius;
      const arrow = new THREE.ArrowHelper(direction, direction.clone().multiplyScalar(-0.5 * length), length, color,
          0.08 * radius, 0.05 * radius);
      group.add(arrow);
      if (marker.turns) {
        // Three quarters of a turn in the sense of the rotation.
        const points = [];
        for (let k = 0; k <= 36; ++k) {
          const angle = 1.5 * Math.PI * k / 36;
          points.push(new THREE.Vector3(Math.cos(angle), Math.sin(angle), 0).multiplyScalar(0.12 * radius));
        }
        const ring = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({color}));
        ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction);
        const tip = new THREE.Mesh(new THREE.ConeBufferGeometry(0.025 * radius, 0.06 * radius, 12),
            new THREE.MeshBasicMaterial({color}));
        tip.position.set(0, -0.12 * radius, 0);
        tip.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(1, 0, 0));
        ring.add(tip);
        group.add(ring);
      }
      group.position.set(...marker.point);
      at.copy(group.position).addScaledVector(direction, 0.5 * length);
      group.traverse((part) => { if (part.material) part.material.depthTest = false; });
    }

    show(kind, wanted) {
      for (const {marker, group} of this.list) if (marker.kind === kind) group.visible = wanted;
    }

    // The names of shown markers and where they stand.
    labels() {
      return this.list.filter((m) => m.group.visible)
          .map(({marker, at}) => ({text: marker.name ? `${marker.kind}: ${marker.name}` : marker.kind, at}));
    }
  }

  // Places texts {text, at, strong} as elements over the picture, none over another one.
  const placeLabels = (root, labels, camera, width, height) => {
    const shown = labels.slice(0, 40);
    while (root.childNodes.length < shown.length) root.append(document.createElement('span'));
    while (root.childNodes.length > shown.length) root.lastChild.remove();
    const point = new THREE.Vector3(), taken = [];
    shown.forEach(({text, at, strong}, i) => {
      const span = root.childNodes[i];
      point.copy(at).project(camera);
      if (span.textContent !== text) span.textContent = text;
      span.classList.toggle('replay-strong', Boolean(strong));
      const half = Math.min(3.5 * text.length + 5, 0.5 * width);
      let x = (0.5 + 0.5 * point.x) * width, y = (0.5 - 0.5 * point.y) * height;
      if (x >= 0 && x <= width) x = Math.min(Math.max(x, half), width - half);  // whole in the picture
      while (taken.some((t) => Math.abs(t.x - x) < t.half + half && Math.abs(t.y - y) < 18)) y += 18;
      taken.push({x, y, half});
      span.style.left = `${x}px`;
      span.style.top = `${y}px`;
      span.hidden = point.z > 1;
    });
  };

  return {Markers, placeLabels, apart};
})();
