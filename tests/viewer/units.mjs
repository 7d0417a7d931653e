// Builds the viewer's tests into a folder and runs them. Skipped where its packages aren't installed.
import { spawnSync } from 'node:child_process';
import { existsSync, readdirSync } from 'node:fs';
import { join } from 'node:path';

if (!existsSync('node_modules/esbuild')) {
  console.log("skipped: the viewer's packages aren't installed ('npm ci' in viewer/)");
  process.exit(77);
}
const folder = process.argv[2];
const run = (...command) => {
  const { status } = spawnSync(process.execPath, command, { stdio: 'inherit' });
  if (status !== 0) process.exit(status ?? 1);
};
run('build-tests.mjs', folder);
const programs = readdirSync(folder).filter((name) => name.endsWith('.test.mjs'));
run('--test', ...programs.map((name) => join(folder, name)));
