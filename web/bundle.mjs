// Puts the page together, in dist/: two scripts, the engine, and what is in static/.
import { createHash } from 'node:crypto';
import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { brotliCompressSync, constants } from 'node:zlib';
import { build } from 'esbuild';

const MOST = 2_000_000;
const options = { bundle: true, format: 'esm', target: 'es2022', minify: true, legalComments: 'eof', outdir: 'dist' };

rmSync('dist', { recursive: true, force: true });
mkdirSync('dist');
cpSync('static', 'dist', { recursive: true });
cpSync('../samples/lake.jpg', 'dist/sample.jpg');
cpSync('pkg/polyreel_wasm_bg.wasm', 'dist/polyreel_wasm_bg.wasm');
await build({ ...options, entryPoints: { main: 'src/main.ts', worker: 'src/worker/index.ts' } });

const files = readdirSync('dist').sort();
const hash = createHash('sha256');
for (const name of files) hash.update(name).update(readFileSync(`dist/${name}`));
const define = {
  FILES: JSON.stringify(['./', ...files]),
  VERSION: JSON.stringify(hash.digest('hex').slice(0, 12)),
};
await build({ ...options, entryPoints: { sw: 'src/sw.ts' }, define });

const params = { [constants.BROTLI_PARAM_QUALITY]: 9 };
let sum = 0;
for (const name of readdirSync('dist')) {
  const bytes = readFileSync(`dist/${name}`);
  const packed = Math.min(bytes.length, brotliCompressSync(bytes, { params }).length);
  sum += packed;
  console.log(`${String(bytes.length).padStart(9)} ${String(packed).padStart(9)}  ${name}`);
}
console.log(`${' '.repeat(10)}${String(sum).padStart(9)}  in all, compressed`);
if (sum > MOST) throw new Error(`the page is larger than ${MOST} bytes compressed`);
