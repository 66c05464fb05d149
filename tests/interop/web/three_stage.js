// A scene without a window: what three.js makes of lights, as linear numbers.

import * as THREE from 'three';
import { pack } from 'harness';

export class Stage {
  /** Stages may share a renderer, and with it what it compiled. */
  constructor(renderer = new THREE.WebGLRenderer()) {
    this.renderer = renderer;
    this.scene = new THREE.Scene();
  }

  /** Light the scene by the light.js that was exported into a folder. */
  async load(folder, options) {
    const { loadLight } = await import(`${folder}light.js`);
    return loadLight(this.scene, { folder, ...options });
  }

  /** The scene through a camera: linear radiance, row 0 on top. */
  render(camera, size) {
    const target = new THREE.WebGLRenderTarget(size, size, { type: THREE.FloatType });
    this.renderer.setRenderTarget(target);
    this.renderer.render(this.scene, camera);
    const pixels = new Float32Array(4 * size * size);
    this.renderer.readRenderTargetPixels(target, 0, 0, size, size, pixels);
    this.renderer.setRenderTarget(null);
    target.dispose();
    const picture = new Float32Array(3 * size * size);
    for (let row = 0; row < size; row++) {
      for (let column = 0; column < size; column++) {
        const from = 4 * ((size - 1 - row) * size + column);
        picture.set(pixels.subarray(from, from + 3), 3 * (row * size + column));
      }
    }
    return pack(picture, [size, size, 3]);
  }

  /** What a viewer at the origin sees who turns right by yaw and looks up by pitch, 90 degrees wide. */
  view(yaw, pitch, size) {
    const camera = new THREE.PerspectiveCamera(90, 1, 0.1, 100);
    camera.rotation.set(pitch, -yaw, 0, 'YXZ');
    return this.render(camera, size);
  }

  /** A sphere that fills the picture, without background, seen along -Z (or along +Z from behind). */
  sphere(material, size, { behind = false } = {}) {
    const mesh = new THREE.Mesh(new THREE.SphereGeometry(1, 128, 96), material);
    const { background } = this.scene;
    this.scene.background = null;
    this.scene.add(mesh);
    const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
    camera.position.z = behind ? -5 : 5;
    camera.lookAt(0, 0, 0);
    const picture = this.render(camera, size);
    this.scene.remove(mesh);
    this.scene.background = background;
    mesh.geometry.dispose();
    return picture;
  }
}

const gray = (value) => new THREE.Color(value, value, value);

/** Lambert's law and nothing else; knows no environment map. */
export const matte = (albedo) => new THREE.MeshLambertMaterial({ color: gray(albedo) });

/** Lambert's law and nothing else, by lights and environment map: the shine of glass is taken off. */
export const matteStandard = (albedo) =>
  new THREE.MeshPhysicalMaterial({ color: gray(albedo), roughness: 1, metalness: 0, specularIntensity: 0 });

/** A metal of this reflectance. */
export const metal = (reflectance, roughness) =>
  new THREE.MeshStandardMaterial({ color: gray(reflectance), roughness, metalness: 1 });
