// Holds the viewer to its types. Skipped where its packages aren't installed.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';

const compiler = 'node_modules/typescript/bin/tsc';
if (!existsSync(compiler)) {
  console.log("skipped: the viewer's packages aren't installed ('npm ci' in viewer/)");
  process.exit(77);
}
process.exit(spawnSync(process.execPath, [compiler, '--noEmit'], { stdio: 'inherit' }).status ?? 1);
