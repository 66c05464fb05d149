// Light estimated by MixLight, for three.js (run with r187; needs r162 or newer).
//
//   import { loadLight } from './light.js';
//   await loadLight(scene);
//
// Radiance 1 is the white of the photo: with renderer.toneMapping left at NoToneMapping, objects look as if they
// stood in it.

import { EquirectangularReflectionMapping, ObjectLoader } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';

/**
 * Light a scene as the room of the photo is lit. Every unit of light arrives exactly once.
 *
 * With `map` the environment map lights MeshStandardMaterial and MeshPhysicalMaterial, beside the directional
 * lights that were taken out of it, and the light probe is off. Without `map` the light probe stands in for it:
 * nothing to download but lights.json, every material that takes lights is lit (MeshLambertMaterial,
 * MeshPhongMaterial and MeshToonMaterial too), and there are no reflections of the room.
 *
 * @param {import('three').Scene} scene
 * @param {object} [options]
 * @param {boolean} [options.map] light with the environment map
 * @param {boolean} [options.background] show the map behind the scene
 * @param {string} [options.folder] URL of the folder with environment.exr and lights.json, ending in a slash;
 *   name it if your bundler moves this file
 * @returns {Promise<{environment: import('three').Texture | null, lights: import('three').Group,
 *   setRotation: (angle: number) => void}>} the map, the group of lights, and a function that turns all of the
 *   light about the vertical (radians, counter-clockwise seen from above)
 */
export async function loadLight(
  scene,
  { map = true, background = map, folder = new URL('.', import.meta.url).href } = {},
) {
  const [environment, lights] = await Promise.all([
    map || background ? new EXRLoader().loadAsync(`${folder}environment.exr`) : null,
    new ObjectLoader().loadAsync(`${folder}lights.json`),
  ]);
  if (environment) environment.mapping = EquirectangularReflectionMapping;
  if (map) scene.environment = environment;
  if (background) scene.background = environment;
  // The map and the probe are the same light in two forms: one of them is on.
  lights.getObjectByName('ambient').visible = !map;
  scene.add(lights);

  const setRotation = (angle) => {
    lights.rotation.y = angle;
    if (map) scene.environmentRotation.y = angle;
    if (background) scene.backgroundRotation.y = angle;
  };
  return { environment, lights, setRotation };
}
