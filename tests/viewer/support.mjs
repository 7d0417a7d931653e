// What tests and measurements of the viewer share: the real service, and a real browser.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const ROOT = join(dirname(fileURLToPath(import.meta.url)), '../..');
const { chromium } = createRequire(join(ROOT, 'viewer/package.json'))('playwright-core');

export const CHROMIUM = [
  process.env.ISOFRONT_CHROMIUM ?? '',
  '/usr/bin/chromium',
  '/usr/bin/chromium-browser',
].find(existsSync);
/** For what ought to take seconds; the machine may be busy. */
export const PATIENCE = 240_000;

/** Starts the service on a port and with a folder of its own, or where another one was. */
export async function startService(program, { sources, options = [], after = null }) {
  const data = after ? after.data : mkdtempSync(join(tmpdir(), 'isofront-viewer-'));
  const port = after ? new URL(after.address).port : '0';
  const args = ['serve', '--port', port, '--data', data, '--sources', sources, '--log-level', 'warning'];
  const service = spawn(program, [...args, ...options], { stdio: ['ignore', 'ignore', 'pipe'] });
  let told = '';
  const address = await new Promise((found, failed) => {
    service.stderr.on('data', (text) => {
      told += text;
      const match = /isofront serves (\S+)/.exec(told);
      if (match) found(match[1]);
    });
    service.on('exit', (code) => failed(new Error(`the service ended with ${code}: ${told}`)));
  });
  const ended = new Promise((done) => service.on('exit', done));
  return {
    address,
    data,
    /** As if the machine had lost its power. */
    async kill() {
      service.kill('SIGKILL');
      await ended;
    },
    async stop() {
      service.kill('SIGTERM');
      await ended;
    },
  };
}

/** Makes a scene and waits until it can be shown. */
export async function makeScene(address, scene) {
  const made = await fetch(`${address}v1/scenes`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify(scene),
  });
  let record = await made.json();
  if (!made.ok) throw new Error(record.detail);
  while (record.state === 'preparing') {
    await new Promise((done) => setTimeout(done, 20));
    record = await (await fetch(`${address}v1/scenes/${record.id}`)).json();
  }
  if (record.state !== 'ready') throw new Error(record.failure);
  return record;
}

const QUIET = [
  '--no-sandbox',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];
/** By Mesa's software renderer if it can be had, otherwise by the browser's own. */
const DEVICES = [['--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist'], []];

/** A browser that has WebGL 2. */
export async function openBrowser() {
  for (const device of DEVICES) {
    const browser = await chromium.launch({
      executablePath: CHROMIUM,
      args: [...QUIET, ...device],
      timeout: PATIENCE,
    });
    const page = await browser.newPage();
    const isGood = await page.evaluate(
      () => document.createElement('canvas').getContext('webgl2') !== null,
    );
    await page.close();
    if (isGood) return browser;
    await browser.close();
  }
  throw new Error('the browser has no WebGL 2');
}

/** Waits until all that the page wants is on show. */
export function settled(page) {
  return page.waitForFunction(
    () => document.getElementById('app')?.dataset.settled === 'true',
    undefined,
    { timeout: PATIENCE, polling: 20 },
  );
}
