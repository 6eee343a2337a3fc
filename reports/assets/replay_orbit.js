// A camera that is turned by hand. Needs three.js.
'use strict';
const FirnReplayOrbit = (() => {
  // Turns about a target, z up. Angles in rad.
  class Orbit {
    constructor(camera) {
      this.camera = camera;
      this.target = new THREE.Vector3();
    }
    // All of a box, from a little above and the front.
    frame(box, aspect) {
      const size = box.getSize(new THREE.Vector3()), corner = new THREE.Vector3();
      box.getCenter(this.target);
      this.radius = 0.5 * size.length();
      this.azimuth = -1.05;
      this.elevation = 0.42;
      this.distance = 1;
      this.apply(aspect);
      const high = Math.tan(this.camera.fov * Math.PI / 360), m = this.camera.matrix.elements;
      const along = (k) => corner.x * m[k] + corner.y * m[k + 1] + corner.z * m[k + 2];
      for (let n = 0; n < 8; ++n) {
        corner.set(n & 1 ? size.x : -size.x, n & 2 ? size.y : -size.y, n & 4 ? size.z : -size.z).multiplyScalar(0.5);
        const wanted = along(8) + Math.max(Math.abs(along(4)) / high, Math.abs(along(0)) / (high * aspect));
        this.distance = Math.max(n ? this.distance : 0, 1.03 * wanted);
      }
    }
    // A point from a direction.
    from(point, direction, distance) {
      this.target.copy(point);
      if (Math.hypot(direction.x, direction.y) > 1e-3) this.azimuth = Math.atan2(direction.y, direction.x);
      this.elevation = Math.max(-1.4, Math.min(1.4, Math.asin(direction.z)));
      this.distance = distance;
    }
    turn(right, up) {
      this.azimuth -= right;
      this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation + up));
    }
    zoom(factor) {
      this.distance = Math.max(0.02 * this.radius, Math.min(20 * this.radius, factor * this.distance));
    }
    // Shares of the picture's height.
    pan(right, up) {
      const reach = 2 * this.distance * Math.tan(this.camera.fov * Math.PI / 360);
      const m = this.camera.matrix.elements;
      for (const [axis, k] of [['x', 0], ['y', 1], ['z', 2]]) {
        this.target[axis] += reach * (-right * m[k] - up * m[4 + k]);
      }
    }
    apply(aspect) {
      const c = this.camera, flatness = Math.cos(this.elevation);
      const distance = this.distance;
      c.position.set(Math.cos(this.azimuth) * flatness, Math.sin(this.azimuth) * flatness,
                     Math.sin(this.elevation)).multiplyScalar(distance).add(this.target);
      c.near = 0.01 * distance;
      c.far = distance + 30 * this.radius;
      c.aspect = aspect;
      c.lookAt(this.target);
      c.updateProjectionMatrix();
      c.updateMatrix();
      c.updateMatrixWorld();
    }
  }

  return {Orbit};
})();
