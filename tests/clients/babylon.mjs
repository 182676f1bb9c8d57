// Runs the snippet for Babylon.js without a screen: node babylon.mjs JOB.json
import { readFile, writeFile } from 'node:fs/promises';
import { Mesh, NullEngine, Scene, VertexBuffer, VertexData } from '@babylonjs/core';
import { base64, floats } from './numbers.js';

const job = JSON.parse(await readFile(process.argv[2], 'utf8'));
const { displace } = await import(job.snippet);
const mesh = new Mesh('scan', new Scene(new NullEngine()));
const data = new VertexData();
data.positions = floats(job.positions);
data.normals = floats(job.normals);
data.uvs = floats(job.uvs);
data.indices = job.indices;
data.applyToMesh(mesh, true);
displace(mesh, floats(job.image), job.entry, job.entry.lambda);
const places = Float32Array.from(mesh.getVerticesData(VertexBuffer.PositionKind));
await writeFile(job.result, JSON.stringify(base64(places)));
