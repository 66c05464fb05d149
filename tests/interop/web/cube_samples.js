// A cube map as a graphics card samples it, without any library between.

import { pack, unpack } from 'harness';

const VERTEX = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0.0, 1.0); }`;

const FRAGMENT = `#version 300 es
precision highp float;
precision highp samplerCube;
uniform samplerCube cube;
uniform highp sampler2D directions;
out vec4 radiance;
void main() { radiance = texture(cube, texelFetch(directions, ivec2(gl_FragCoord.xy), 0).xyz); }`;

/** texture(cube, d) for each direction; faces +X -X +Y -Y +Z -Z of size x size rgb, row 0 first. */
export default function ({ faces, size, directions, count }) {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl.getExtension('EXT_color_buffer_float')) throw new Error('expected float targets');
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);

  const texture = (unit, target) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(target, gl.createTexture());
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, name, gl.NEAREST);
  };
  texture(0, gl.TEXTURE_CUBE_MAP);
  faces.map(unpack).forEach((face, i) => {
    gl.texImage2D(
      gl.TEXTURE_CUBE_MAP_POSITIVE_X + i, 0, gl.RGB32F, size, size, 0, gl.RGB, gl.FLOAT, face,
    );
  });
  texture(1, gl.TEXTURE_2D);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB32F, count, 1, 0, gl.RGB, gl.FLOAT, unpack(directions));
  gl.uniform1i(gl.getUniformLocation(program, 'cube'), 0);
  gl.uniform1i(gl.getUniformLocation(program, 'directions'), 1);

  texture(2, gl.TEXTURE_2D);
  const target = gl.getParameter(gl.TEXTURE_BINDING_2D);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, count, 1, 0, gl.RGBA, gl.FLOAT, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, count, 1);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const pixels = new Float32Array(4 * count);
  gl.readPixels(0, 0, count, 1, gl.RGBA, gl.FLOAT, pixels);
  if (gl.getError()) throw new Error('WebGL refused a call');
  return pack(pixels, [count, 4]);
}
