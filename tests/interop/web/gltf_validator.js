// Khronos's validator as a module: its build is a classic script that hangs itself on `exports`.
import { loadScript } from 'harness';

globalThis.exports ??= {};
await loadScript('/node_modules/gltf-validator/gltf_validator.dart.js');

/** The report on glTF JSON, without a time stamp. */
export const validate = (text) =>
  globalThis.exports.validateString(text, { writeTimestamp: false, maxIssues: 0 });

/** The validator's version. */
export const version = () => globalThis.exports.version();
