// Runs the GLSL of docs/clients.md in WebGL 2 and gives the displaced vertices back, by transform feedback.
import { base64, floats } from './numbers.js';

/// Numbers come and go as base64; `height` is the call of the snippet that gives a vertex its height.
export async function run({ snippet, height, positions, normals, uvs, image, size, parameters }) {
  const code = await (await fetch(snippet)).text();
  const gl = document.querySelector('canvas').getContext('webgl2');
  const program = gl.createProgram();
  const vertex = `#version 300 es
    precision highp float;
    precision highp sampler2D;
    layout(location = 0) in vec3 position;
    layout(location = 1) in vec3 normal;
    layout(location = 2) in vec2 uv;
    out vec3 place;
    ${code}
    void main() { place = displaced(position, normal, ${height}); }`;
  for (const [kind, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, '#version 300 es\nvoid main() {}'],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.transformFeedbackVaryings(program, ['place'], gl.SEPARATE_ATTRIBS);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  for (const [name, value] of Object.entries(parameters)) gl.uniform1f(gl.getUniformLocation(program, name), value);

  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, ...size, 0, gl.RED, gl.FLOAT, floats(image));
  [[positions, 3], [normals, 3], [uvs, 2]].forEach(([numbers, width], location) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, floats(numbers), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, width, gl.FLOAT, false, 0, 0);
  });
  const places = floats(positions);
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer);
  gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, places.byteLength, gl.STREAM_READ);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
  gl.enable(gl.RASTERIZER_DISCARD);
  gl.beginTransformFeedback(gl.POINTS);
  gl.drawArrays(gl.POINTS, 0, places.length / 3);
  gl.endTransformFeedback();
  gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, places);
  if (gl.getError() !== gl.NO_ERROR) throw new Error('WebGL reports an error');
  return base64(places);
}
