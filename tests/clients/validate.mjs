// Prints the Khronos validator's report on a glTF file as JSON: node validate.mjs FILE
import { readFile } from 'node:fs/promises';
import validator from 'gltf-validator';

const bytes = new Uint8Array(await readFile(process.argv[2]));
process.stdout.write(JSON.stringify(await validator.validateBytes(bytes, { maxIssues: 0 })));
