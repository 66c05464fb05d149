// A matte sphere in Filament, lit by what was exported for it.

import { loadScript, pack, unpack } from 'harness';

/** The sphere of a .glb seen along -Z (or along +Z from behind): what the canvas shows, 8-bit sRGB, row 0 on top. */
export default async function ({ glb, sh, lights, size, behind }) {
  await loadScript('/node_modules/filament/filament.js');
  await new Promise((resolve) => window.Filament.init([], resolve));
  const { Filament } = window; // another object than before
  const canvas = Object.assign(document.createElement('canvas'), { width: size, height: size });
  const engine = Filament.Engine.create(canvas);
  const scene = engine.createScene();

  const asset = engine.createAssetLoader().createAsset(unpack(glb));
  await new Promise((resolve) => asset.loadResources(resolve));
  scene.addEntities(asset.getEntities());

  const light = Filament.IndirectLight.Builder().irradianceSh(3, new Float32Array(sh)).intensity(1).build(engine);
  scene.setIndirectLight(light);
  lights.forEach(({ direction, color, intensity }) => {
    const entity = Filament.EntityManager.get().create();
    Filament.LightManager.Builder(Filament.LightManager$Type.DIRECTIONAL)
      .direction(direction).color(color).intensity(intensity).build(engine, entity);
    scene.addEntity(entity);
  });

  const camera = engine.createCamera(Filament.EntityManager.get().create());
  camera.setProjection(Filament.Camera$Projection.ORTHO, -1, 1, -1, 1, 0.1, 10);
  camera.lookAt([0, 0, behind ? -5 : 5], [0, 0, 0], [0, 1, 0]);
  camera.setExposureDirect(1);
  const view = engine.createView();
  view.setCamera(camera);
  view.setScene(scene);
  view.setViewport([0, 0, size, size]);
  view.setColorGrading(
    Filament.ColorGrading.Builder().toneMapping(Filament.ColorGrading$ToneMapping.LINEAR).build(engine),
  );

  const renderer = engine.createRenderer();
  const swapChain = engine.createSwapChain();
  const gl = canvas.getContext('webgl2');
  const pixels = new Uint8Array(4 * size * size);
  for (let frame = 0; frame < 4; frame++) {
    // Materials compile while the first frames are drawn.
    await new Promise((resolve) => setTimeout(resolve, 30));
    renderer.render(swapChain, view);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    gl.readPixels(0, 0, size, size, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  }
  const rows = [];
  for (let row = size - 1; row >= 0; row--) rows.push(...pixels.subarray(4 * row * size, 4 * (row + 1) * size));
  return pack(Uint8Array.from(rows), [size, size, 4]);
}
