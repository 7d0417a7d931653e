// How long people wait: from opening the page to the first complete surface, and from a move of the isovalue to
// the complete surface.
// usage: node tests/viewer/measure.mjs PROGRAM VOLUME [MOVES [PIXEL_ERROR]]
import { rmSync } from 'node:fs';
import { basename, dirname } from 'node:path';
import { makeScene, openBrowser, settled, startService } from './support.mjs';

const [program, volume, moves = '60', error = '3'] = process.argv.slice(2);
if (!volume) {
  console.error('usage: node tests/viewer/measure.mjs PROGRAM VOLUME [MOVES [PIXEL_ERROR]]');
  process.exit(2);
}
const service = await startService(program, { sources: dirname(volume) });
const browser = await openBrowser();

const quantile = (values, q) =>
  [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.ceil(q * values.length) - 1)];

/** Milliseconds from the page's own begin to its first complete surface. */
async function load(address) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  await page.goto(address);
  await settled(page);
  const time = await page.evaluate(
    () => performance.getEntriesByName('isofront:settled')[0].startTime,
  );
  return [page, time];
}

/** Moves the isovalue by keys, and waits each time until all is there. */
function move(page, keys) {
  return page.evaluate(async (all) => {
    const app = document.getElementById('app');
    const handle = document.querySelector('.histogram .handle');
    const times = [];
    for (const key of all) {
      const begin = performance.now();
      handle.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
      await new Promise((done) => {
        const watch = new MutationObserver(() => {
          if (app.dataset.settled !== 'true') return;
          watch.disconnect();
          done();
        });
        watch.observe(app, { attributes: true });
      });
      // the picture with it is the next one that is drawn
      await new Promise((done) => requestAnimationFrame(() => done()));
      times.push(performance.now() - begin);
    }
    return times;
  }, keys);
}

try {
  const scene = await makeScene(service.address, { name: 'measured', file: basename(volume) });
  const address = `${service.address}#scene=${scene.id}&error=${error}`;
  const [first, cold] = await load(address);
  await first.close();
  const [page, warm] = await load(address);
  const triangles = await page.evaluate(() => document.getElementById('app').dataset.triangles);
  // there and back by small steps, so that about half of the isovalues have been seen before
  const keys = Array.from({ length: Number(moves) }, (_, i) => (i % 20 < 13 ? 'ArrowRight' : 'ArrowLeft'));
  const complete = await move(page, keys);
  console.log(`${basename(volume)}, error ${error} px, picture of 960 x 720, ${triangles} triangles at first`);
  console.log(`from page load to complete surface: ${cold.toFixed(0)} ms, once more ${warm.toFixed(0)} ms`);
  console.log(
    `from a move of the isovalue to the complete surface (${complete.length} moves): ` +
      `p50 ${quantile(complete, 0.5).toFixed(0)} ms, p99 ${quantile(complete, 0.99).toFixed(0)} ms`,
  );
} finally {
  await browser.close();
  await service.stop();
  rmSync(service.data, { recursive: true, force: true });
}
