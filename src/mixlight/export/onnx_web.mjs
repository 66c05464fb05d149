// MixLight in JavaScript: a photo into the view that the network knows, and the network's outputs into light.
// No dependencies; runs in browsers and in Node. The network itself (mixlight.onnx) runs in onnxruntime-web:
//
//   import * as ort from "onnxruntime-web";
//   import { canonicalView, decode, environment } from "./mixlight.mjs";
//   const session = await ort.InferenceSession.create("mixlight.onnx");
//   const { data, dims } = canonicalView(imageData.data, imageData.width, imageData.height, fovX);
//   const outputs = await session.run({ photo: new ort.Tensor("float32", data, dims) });
//   const light = decode(outputs.ambient.data, outputs.anchor_energy.data, outputs.camera.data);
//   const map = environment(light, 128);   // linear radiance, RGB, 128 rows of 256 texels
//
// Frame: +X right, +Y up, -Z forward (three.js's own), where -Z is the photo's azimuth; the horizon is level.
// Radiance 1.0 is the photo's linear white. Light is linear Rec.709.

/** What the model beside this file is. */
export const MODEL = {"name": "unknown", "precision": "float32", "height": 96, "width": 128, "fovDeg": 60.0, "anchors": 128, "sharpness": 0.0025};

/**
 * The photo as the network's camera would have taken it: the network's input.
 *
 * The photo is resampled in linear light around its optical axis; each new pixel is the mean over its own
 * area. What a wider photo shows beyond the view is cut; where a narrower or portrait one does not reach, the
 * view gets the mean colour of the rest.
 *
 * @param {ArrayLike<number>} pixels sRGB bytes RGBA, row 0 on top, as a canvas' ImageData holds them; alpha
 *     is composited over black.
 * @param {number} width columns of the photo
 * @param {number} height rows of the photo
 * @param {number} fovX the photo's horizontal field of view in radians, in (0, pi); 60 degrees if unknown
 * @param {{height: number, width: number, fovDeg: number}} model
 * @returns {{data: Float32Array, dims: number[]}} [1, 3, height, width], sRGB in [0, 1]
 */
export function canonicalView(pixels, width, height, fovX = Math.PI / 3, model = MODEL) {
  if (!(width >= 1 && height >= 1) || pixels.length !== 4 * width * height) {
    throw new RangeError(`expected 4 bytes for each of ${width} x ${height} pixels, received ${pixels.length}`);
  }
  if (!(fovX > 0 && fovX < Math.PI)) {
    throw new RangeError(`expected a field of view in (0, pi) radians, received ${fovX}`);
  }
  // Photo pixels that one pixel of the view spans.
  const ratio = ((Math.tan((model.fovDeg * Math.PI) / 360) / model.width) * width) / Math.tan(fovX / 2);
  const rows = bands(height, model.height, ratio);
  const columns = bands(width, model.width, ratio);
  if (!rows.inside.includes(true) || !columns.inside.includes(true)) {
    throw new RangeError("expected a photo that covers a pixel of the view, received a smaller one");
  }
  const linear = Float64Array.from({ length: 256 }, (_, byte) => decodeSrgb(byte / 255));
  const count = model.height * model.width;
  const view = new Float64Array(3 * count);
  const across = new Float64Array(3 * model.width);
  for (let i = 0; i < model.height; i++) {
    if (!rows.inside[i]) continue;
    const { start, weights } = rows.taps[i];
    for (let k = 0; k < weights.length; k++) {
      resampleRow(pixels, (start + k) * width * 4, columns, linear, across);
      for (let c = 0; c < 3; c++) {
        for (let j = 0; j < model.width; j++) {
          view[c * count + i * model.width + j] += weights[k] * across[c * model.width + j];
        }
      }
    }
  }
  const covered = (index) => rows.inside[Math.floor(index / model.width)] && columns.inside[index % model.width];
  const data = new Float32Array(3 * count);
  let brightest = 0;
  for (let c = 0; c < 3; c++) {
    let sum = 0;
    let number = 0;
    for (let index = 0; index < count; index++) {
      if (!covered(index)) continue;
      sum += view[c * count + index];
      number += 1;
    }
    for (let index = 0; index < count; index++) {
      const value = covered(index) ? view[c * count + index] : sum / number;
      brightest = Math.max(brightest, value);
      data[c * count + index] = encodeSrgb(Math.min(1, Math.max(0, value)));
    }
  }
  if (brightest === 0) throw new RangeError("expected a photo with light in it, received an all-black view");
  return { data, dims: [1, 3, model.height, model.width] };
}

/**
 * The network's outputs for one photo of a batch, as light.
 *
 * @param {ArrayLike<number>} ambient [batch, 9, 3]
 * @param {ArrayLike<number>} anchorEnergy [batch, anchors, 3]
 * @param {ArrayLike<number>} camera [batch, 2]
 * @param {number} index which photo of the batch
 * @returns {{ambient: number[], sources: {direction: number[], energy: number[]}[], sharpness: number,
 *     pitch: number, roll: number}} `ambient` is radiance SH, 27 numbers as three.js's LightProbe takes them
 *     (`probe.sh.fromArray(light.ambient)`). A source, brightest first, is a spherical Gaussian: `direction`
 *     points towards it, `energy` is its integrated radiance, which is the irradiance that it gives a surface
 *     facing it (a DirectionalLight of that colour, intensity 1). Pitch is up, roll clockwise, in radians.
 */
export function decode(ambient, anchorEnergy, camera, index = 0, model = MODEL) {
  const size = 3 * model.anchors;
  const pieces = [[ambient, 27], [anchorEnergy, size], [camera, 2]].map(([values, length]) => {
    if (!(values.length > 0 && values.length % length === 0 && values.length >= (index + 1) * length)) {
      throw new RangeError(`expected at least ${index + 1} times ${length} numbers, received ${values.length}`);
    }
    return Array.from({ length }, (_, k) => values[index * length + k]);
  });
  const sources = anchors(model.anchors)
    .map((direction, k) => ({ direction, energy: pieces[1].slice(3 * k, 3 * k + 3) }))
    .filter(({ energy }) => Math.max(...energy) > 0)
    .sort((a, b) => luminance(b.energy) - luminance(a.energy));
  return { ambient: pieces[0], sources, sharpness: model.sharpness, pitch: pieces[2][0], roll: pieces[2][1] };
}

/**
 * The environment map of a light: ambient light clamped at 0, plus the sources.
 *
 * @returns {Float32Array} [height, 2 height, 3] linear radiance; row 0 is +Y, the centre is -Z, right is +X.
 *     The sum of each source over the texels' solid angles is its energy.
 */
export function environment(light, height) {
  if (!(Number.isInteger(height) && height >= 1)) throw new RangeError(`expected rows, received ${height}`);
  const width = 2 * height;
  const map = new Float64Array(3 * width * height);
  for (let i = 0; i < height; i++) {
    for (let j = 0; j < width; j++) {
      const radiance = evaluateHarmonics(light.ambient, texel(i, j, height));
      for (let c = 0; c < 3; c++) map[3 * (i * width + j) + c] = Math.max(0, radiance[c]);
    }
  }
  for (const source of light.sources) addLobe(map, source, light.sharpness, height);
  return Float32Array.from(map);
}

/** Radiance [r, g, b] of the ambient harmonics in a unit direction. */
export function evaluateHarmonics(ambient, [x, y, z]) {
  const basis = [
    0.28209479177387814, 0.4886025119029199 * y, 0.4886025119029199 * z, 0.4886025119029199 * x,
    1.0925484305920792 * x * y, 1.0925484305920792 * y * z, 0.31539156525252005 * (3 * z * z - 1),
    1.0925484305920792 * x * z, 0.5462742152960396 * (x * x - y * y),
  ];
  return [0, 1, 2].map((c) => basis.reduce((sum, value, k) => sum + value * ambient[3 * k + c], 0));
}

/** Unit directions of the anchors, a golden-angle spiral from the zenith to the nadir. */
export function anchors(count) {
  return Array.from({ length: count }, (_, i) => {
    const y = 1 - (2 * i + 1) / count;
    const radius = Math.sqrt(1 - y * y);
    const azimuth = i * Math.PI * (3 - Math.sqrt(5));
    return [radius * Math.sin(azimuth), y, -radius * Math.cos(azimuth)];
  });
}

/** Unit direction of a texel's centre. */
function texel(i, j, height) {
  const polar = ((i + 0.5) / height) * Math.PI;
  const azimuth = ((j + 0.5) / height - 1) * Math.PI;
  return [Math.sin(polar) * Math.sin(azimuth), Math.cos(polar), -Math.sin(polar) * Math.cos(azimuth)];
}

/** Adds one lobe, scaled so that its sum over the texels' solid angles is its energy. */
function addLobe(map, { direction, energy }, sharpness, height) {
  const width = 2 * height;
  const exponents = new Float64Array(width * height);
  let peak = -Infinity;
  for (let i = 0; i < height; i++) {
    for (let j = 0; j < width; j++) {
      const [x, y, z] = texel(i, j, height);
      const chord = (x - direction[0]) ** 2 + (y - direction[1]) ** 2 + (z - direction[2]) ** 2;
      const exponent = (-0.5 * chord) / sharpness;
      exponents[i * width + j] = exponent;
      peak = Math.max(peak, exponent);
    }
  }
  let integral = 0;
  for (let i = 0; i < height; i++) {
    const solidAngle = (Math.PI / height) * (Math.cos((i * Math.PI) / height) - Math.cos(((i + 1) * Math.PI) / height));
    for (let j = 0; j < width; j++) integral += solidAngle * Math.exp(exponents[i * width + j] - peak);
  }
  for (let index = 0; index < exponents.length; index++) {
    const share = Math.exp(exponents[index] - peak) / integral;
    for (let c = 0; c < 3; c++) map[3 * index + c] += share * energy[c];
  }
}

/** For each new pixel, the photo's pixels that it averages: a box over their linear interpolation. */
function bands(count, outCount, ratio) {
  const taps = [];
  const inside = [];
  for (let k = 0; k < outCount; k++) {
    const centre = (k + 0.5 - outCount / 2) * ratio + count / 2;
    inside.push(centre >= 0 && centre <= count);
    const clamp = (value) => Math.min(count - 0.5, Math.max(-0.5, value));
    const [low, high] = [clamp(centre - ratio / 2 - 0.5), clamp(centre + ratio / 2 - 0.5)];
    const start = Math.min(count - 1, Math.max(0, Math.floor(low)));
    const stop = Math.min(count - 1, Math.ceil(high));
    const weights = [];
    for (let position = start; position <= stop; position++) {
      // The first and the last pixel are constant in their outer halves.
      const from = position === 0 ? Math.max(low, 0) : low;
      const to = position === count - 1 ? Math.min(high, count - 1) : high;
      let area = to > from ? hatIntegral(to - position) - hatIntegral(from - position) : 0;
      if (position === 0) area += Math.max(0, Math.min(high, 0) - low);
      if (position === count - 1) area += Math.max(0, high - Math.max(low, count - 1));
      weights.push(area);
    }
    const total = weights.reduce((sum, weight) => sum + weight, 0);
    taps.push({ start, weights: weights.map((weight) => (total > 0 ? weight / total : 0)) });
  }
  return { taps, inside };
}

/** Integral of the hat max(0, 1 - |t|) from -1 to x. */
function hatIntegral(x) {
  if (x <= -1) return 0;
  if (x >= 1) return 1;
  return x < 0 ? 0.5 * (x + 1) ** 2 : 1 - 0.5 * (1 - x) ** 2;
}

/** One row of the photo, decoded and averaged into the view's columns. */
function resampleRow(pixels, offset, columns, linear, across) {
  const width = columns.taps.length;
  for (let j = 0; j < width; j++) {
    const { start, weights } = columns.taps[j];
    let [red, green, blue] = [0, 0, 0];
    for (let k = 0; k < weights.length; k++) {
      const at = offset + 4 * (start + k);
      const weight = (weights[k] * pixels[at + 3]) / 255;
      red += weight * linear[pixels[at]];
      green += weight * linear[pixels[at + 1]];
      blue += weight * linear[pixels[at + 2]];
    }
    across[j] = red;
    across[width + j] = green;
    across[2 * width + j] = blue;
  }
}

function luminance([red, green, blue]) {
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

function decodeSrgb(value) {
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

function encodeSrgb(value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
}
