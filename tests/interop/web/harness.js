// What scripts of the tests share. `pack` and `unpack` are the other ends of those in ../web.py.

/** A typed array as JSON; Python gets a NumPy array of this shape. */
export function pack(array, shape = [array.length]) {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  let text = '';
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  const dtype = dtypeOf(array.constructor);
  return { dtype, shape, base64: btoa(text) };
}

const TYPES = [
  Int8Array, Uint8Array, Int16Array, Uint16Array, Int32Array, Uint32Array, BigInt64Array, Float32Array, Float64Array,
];

/** What NumPy calls the numbers of a typed array. */
const dtypeOf = (Type) => Type.name.replace(/^Big|(Clamped)?Array$/g, '').toLowerCase();

/** The typed array that Python packed. */
export function unpack({ dtype, base64 }) {
  const Type = TYPES.find((type) => dtypeOf(type) === dtype);
  if (!Type) throw new Error(`expected a known dtype, received ${dtype}`);
  const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  return new Type(bytes.buffer);
}

/** Run a classic script, such as a package that is no module. */
export function loadScript(url) {
  return new Promise((resolve, reject) => {
    const script = Object.assign(document.createElement('script'), { src: url, onload: resolve });
    script.onerror = () => reject(new Error(`${url}: not loaded`));
    document.head.append(script);
  });
}
