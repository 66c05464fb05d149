// The light of webxr.json in the shape of WebXR's XRLightEstimate, for code that is written for one.

// Returns { sphericalHarmonicsCoefficients: Float32Array(27), primaryLightDirection, primaryLightIntensity }.
// Directions are +X right, +Y up, -Z where the photo looks; the primary light's intensity is linear rgb and is not
// contained in the harmonics.
export function fromDocument(document) {
  if (document.format !== "mixlight/webxr" || document.version !== 1) {
    throw new Error(`expected mixlight/webxr of version 1, received ${document.format} ${document.version}`);
  }
  const point = ({ x, y, z, w }) =>
    typeof DOMPointReadOnly === "undefined" ? Object.freeze({ x, y, z, w }) : new DOMPointReadOnly(x, y, z, w);
  return Object.freeze({
    sphericalHarmonicsCoefficients: new Float32Array(document.sphericalHarmonicsCoefficients.coefficients),
    primaryLightDirection: point(document.primaryLightDirection),
    primaryLightIntensity: point(document.primaryLightIntensity),
  });
}

export async function lightEstimate(url = new URL("webxr.json", import.meta.url)) {
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${url}: expected webxr.json, received ${response.status}`);
  }
  return fromDocument(await response.json());
}
