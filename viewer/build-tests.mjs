// Makes programs for Node of the tests, which are TypeScript.
import { build } from 'esbuild';
import { readdirSync } from 'node:fs';

const tests = readdirSync('tests').filter((name) => name.endsWith('.test.ts'));
await build({
  entryPoints: tests.map((name) => `tests/${name}`),
  bundle: true,
  platform: 'node',
  format: 'esm',
  target: 'node18',
  outExtension: { '.js': '.mjs' },
  outdir: process.argv[2] ?? 'build/tests',
  logLevel: 'warning',
});
