// The viewer in a real browser, with the real service and, where there is any, a real CT volume.
// usage: node browser.mjs PROGRAM DATA
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { covered, overlap, Pictures } from './pictures.mjs';

const [program, data] = process.argv.slice(2);

function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}
if (!existsSync(join(dirname(program), '../share/isofront/viewer/index.html')))
  skip("the viewer isn't built ('npm ci' in viewer/ needs the network once)");
const { CHROMIUM, makeScene, openBrowser, PATIENCE, settled, startService } = await import('./support.mjs');
if (!CHROMIUM) skip("there is no browser ('apt-get install chromium')");

const real = join(process.env.ISOFRONT_TEST_DATA ?? '', 'volumes');
const scan = existsSync(join(real, 'engine_256x256x128_u8.nrrd'))
  ? { folder: real, file: 'engine_256x256x128_u8.nrrd', isovalue: 90, other: 115 }
  : { folder: join(data, 'volumes'), file: 'fuel_68x68x68_u8.nrrd', isovalue: 20, other: 60 };

const folder = mkdtempSync(join(tmpdir(), 'isofront-pictures-'));
let service = await startService(program, { sources: scan.folder });
const browser = await openBrowser();
const pictures = await Pictures.in(browser);
const complaints = [];

/** A page that nothing may go wrong on. */
async function openPage(options) {
  const page = await browser.newPage(options);
  page.setDefaultTimeout(PATIENCE);
  page.on('pageerror', (error) => complaints.push(`error: ${error.message}`));
  page.on('console', (message) => {
    if (message.type() === 'error') complaints.push(`console: ${message.text()}`);
  });
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith(service.address) && !url.startsWith('blob:') && !url.startsWith('data:'))
      complaints.push(`a request elsewhere: ${url}`);
  });
  return page;
}

async function step(name, test) {
  const begin = performance.now();
  await test();
  console.log(`ok ${name} (${((performance.now() - begin) / 1000).toFixed(1)} s)`);
}

const triangles = (page) =>
  page.evaluate(() => Number(document.getElementById('app').dataset.triangles));
const isovalueOf = async (page) => Number(await page.inputValue('input.value'));

/** What is on the canvas, before one colour. */
async function takePicture(page) {
  await page.evaluate(() => {
    for (const element of [document.documentElement, document.body]) element.style.background = '#204060';
  });
  // what was chosen is drawn with the next frame
  await page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
  const clip = await page.locator('canvas').boundingBox();
  return page.screenshot({ clip, animations: 'disabled', caret: 'hide' });
}

/** What the engine draws itself of the same view; nothing where it was built without a renderer. */
function engineSilhouette(page, isovalue, empty = false) {
  const address = new URLSearchParams(new URL(page.url()).hash.slice(1));
  const { width, height } = page.viewportSize();
  const vector = (name) => address.get(name).replaceAll('_', ',');
  const output = join(folder, 'engine.png');
  execFileSync(program, [
    'render', join(scan.folder, scan.file), '-q', '-o', output,
    '--isovalue', String(empty ? 1e6 : isovalue),
    `--eye=${vector('eye')}`, `--target=${vector('target')}`,
    '--fov', '45', '--size', `${width - 320}x${height}`, '--pixel-error', address.get('error'),
  ], { stdio: ['ignore', 'ignore', 'inherit'] });
  return readFileSync(output);
}

const hasRenderer = execFileSync(program, ['--help']).toString().includes('render');

async function showsWhatTheEngineShows(page, isovalue) {
  const mine = await pictures.silhouette(await takePicture(page));
  assert.ok(covered(mine) > 0.02 && covered(mine) < 0.9, `it covers ${covered(mine)}`);
  if (!hasRenderer) return mine;
  const background = engineSilhouette(page, isovalue, true);
  const engine = await pictures.silhouette(engineSilhouette(page, isovalue), background);
  const common = overlap(mine, engine);
  console.log(`   overlap with the engine's own picture: ${common.toFixed(4)}`);
  // both may be off by the error that was allowed, along all of the outline
  assert.ok(common > 0.9, `only ${common} is common to the page and the engine`);
  return mine;
}

try {
  const scene = await makeScene(service.address, { name: 'A scan', file: scan.file });
  const page = await openPage({ viewport: { width: 800, height: 480 }, acceptDownloads: true });
  let first;

  await step('a scene is picked, and its surface is shown', async () => {
    await page.goto(service.address);
    await page.getByRole('button', { name: 'A scan' }).click();
    await page.locator('#pixel-error').fill('2.5'); // of 2, so 5.66 px: enough to be recognised
    const field = page.locator('input.value');
    await field.fill(String(scan.isovalue));
    await field.press('Enter');
    await settled(page);
    assert.ok((await triangles(page)) > 500);
    assert.equal(await isovalueOf(page), scan.isovalue);
    first = await showsWhatTheEngineShows(page, scan.isovalue);
  });

  await step('dragging the isovalue shows the old surface until the new one is there', async () => {
    await page.locator('.histogram').scrollIntoViewIfNeeded();
    const handle = await page.locator('.histogram .handle').boundingBox();
    const histogram = await page.locator('.histogram').boundingBox();
    // every change of what is shown is looked at: never is there nothing
    await page.evaluate(() => {
      const app = document.getElementById('app');
      globalThis.leastTriangles = Infinity;
      new MutationObserver(() => {
        globalThis.leastTriangles = Math.min(globalThis.leastTriangles, Number(app.dataset.triangles));
      }).observe(app, { attributes: true });
    });
    const [low, high] = scene.description.value_range;
    const x = histogram.x + (histogram.width * (scan.other - low)) / (high - low);
    const y = histogram.y + histogram.height / 2;
    await page.mouse.move(handle.x + handle.width / 2, y);
    await page.mouse.down();
    await page.mouse.move(x, y, { steps: 12 });
    await page.mouse.up();
    const isovalue = await isovalueOf(page);
    assert.ok(Math.abs(isovalue - scan.other) < 0.01 * (high - low), `it is ${isovalue}`);
    await settled(page);
    assert.ok((await page.evaluate(() => globalThis.leastTriangles)) > 0);
    const second = await showsWhatTheEngineShows(page, isovalue);
    assert.ok(overlap(first, second) < 0.95);
  });

  await step('a picture is saved', async () => {
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name: 'Picture' }).click(),
    ]);
    const saved = await pictures.silhouette(readFileSync(await download.path()));
    assert.ok(overlap(saved, await pictures.silhouette(await takePicture(page))) > 0.99);
  });

  await step('keys move the isovalue', async () => {
    const before = await isovalueOf(page);
    await page.locator('.histogram .handle').focus();
    await page.keyboard.press('PageDown');
    await page.keyboard.press('ArrowLeft');
    assert.ok((await isovalueOf(page)) < before);
    await settled(page);
  });

  await step('ways of looking differ', async () => {
    const seen = new Set();
    for (const name of ['Surface', 'Levels', 'Normals']) {
      await page.getByRole('button', { name, exact: true }).click();
      seen.add((await takePicture(page)).toString('base64'));
    }
    const whole = await pictures.silhouette(await takePicture(page));
    await page.getByLabel('Triangles').check();
    seen.add((await takePicture(page)).toString('base64'));
    assert.equal(seen.size, 4);
    await page.getByRole('button', { name: 'X', exact: true }).click();
    const cut = await pictures.silhouette(await takePicture(page));
    assert.ok(covered(cut) < 0.95 * covered(whole), 'a plane cuts nothing away');
  });

  await step('hands turn the view, and a brush makes places finer', async () => {
    const address = page.url();
    await page.mouse.move(200, 200);
    await page.mouse.down();
    await page.mouse.move(260, 230, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction((before) => location.href !== before, address);
    await settled(page);
    await page.getByRole('button', { name: 'Off', exact: true }).click();
    const before = await triangles(page);
    await page.getByRole('button', { name: 'Brush' }).click();
    // somewhere in the middle is surface
    for (const [x, y] of [[240, 240], [220, 220], [260, 250], [230, 270]]) await page.mouse.click(x, y);
    await page.waitForFunction(() => location.hash.includes('spot='));
    await settled(page);
    assert.ok((await triangles(page)) > before);
  });

  await step('an address brings all of it back', async () => {
    await page.waitForTimeout(300); // the address follows what is seen by a moment
    const picture = await pictures.silhouette(await takePicture(page));
    const [count, address] = [await triangles(page), page.url()];
    const again = await openPage({ viewport: { width: 800, height: 480 }, acceptDownloads: true });
    await again.goto(address);
    await settled(again);
    assert.equal(await again.getByLabel('Triangles').isChecked(), true);
    assert.equal(await again.getByRole('button', { name: 'Normals' }).getAttribute('aria-pressed'), 'true');
    assert.equal(await isovalueOf(again), await isovalueOf(page));
    const share = (await triangles(again)) / count;
    assert.ok(share > 0.8 && share < 1.25, `${share} of the triangles`);
    assert.ok(overlap(picture, await pictures.silhouette(await takePicture(again))) > 0.97);
    await again.close();
  });

  await step('a phone has room for both, in the dark', async () => {
    const phone = await openPage({
      viewport: { width: 360, height: 740 },
      hasTouch: true,
      isMobile: true,
      colorScheme: 'dark',
    });
    await phone.goto(`${service.address}#scene=${scene.id}&error=8`);
    await settled(phone);
    const layout = await phone.evaluate(() => ({
      width: document.documentElement.scrollWidth,
      picture: document.querySelector('canvas').clientHeight,
      ink: getComputedStyle(document.body).color,
    }));
    assert.equal(layout.width, 360);
    assert.ok(layout.picture >= 0.45 * 740, `the picture is ${layout.picture} px high`);
    assert.match(layout.ink, /rgb\(2\d\d, 2\d\d, 2\d\d\)/);
    await phone.getByRole('button', { name: 'Controls' }).tap();
    await phone.waitForFunction(() => document.querySelector('canvas').clientHeight > 600);
    await phone.close();
  });

  await step('nothing failed on the way, and nobody else was asked for anything', () =>
    assert.deepEqual(complaints, []),
  );

  await step('when the service is gone the surface stays, and it is said', async () => {
    const before = await triangles(page);
    await service.kill();
    await page.getByText('The service is not there').waitFor();
    assert.equal(await triangles(page), before);
  });

  await step('when it is there again the stream goes on by itself', async () => {
    service = await startService(program, { sources: scan.folder, after: service });
    await settled(page);
    await page.locator('.status').waitFor({ state: 'hidden' });
    const field = page.locator('input.value');
    await field.fill(String(scan.isovalue));
    await field.press('Enter');
    await settled(page);
    assert.equal(await isovalueOf(page), scan.isovalue);
  });

  await step('who needs a token is asked for it', async () => {
    await service.stop();
    const tokens = join(folder, 'tokens');
    writeFileSync(tokens, 'read anna 2c7e0d1f6b9a4835\n', { mode: 0o600 });
    service = await startService(program, {
      sources: scan.folder,
      options: ['--tokens', tokens],
      after: service,
    });
    const guest = await browser.newPage();
    guest.setDefaultTimeout(PATIENCE);
    await guest.goto(`${service.address}#scene=${scene.id}&error=8`);
    await guest.getByLabel('Token').fill('wrong');
    await guest.getByRole('button', { name: 'Use it' }).click();
    await guest.getByText('The token is not known').waitFor();
    await guest.getByLabel('Token').fill('2c7e0d1f6b9a4835');
    await guest.getByRole('button', { name: 'Use it' }).click();
    await settled(guest);
    assert.ok((await triangles(guest)) > 0);
    assert.ok(!guest.url().includes('2c7e'));
    await guest.close();
  });

  await step('what can not be shown is explained', async () => {
    const lost = await browser.newPage();
    lost.setDefaultTimeout(PATIENCE);
    await lost.addInitScript(() => sessionStorage.setItem('isofront-token', '2c7e0d1f6b9a4835'));
    await lost.goto(`${service.address}#scene=0123456789abcdef0123456789abcdef`);
    await lost.getByText("There is no scene '0123").waitFor();
    await lost.addInitScript(() => {
      HTMLCanvasElement.prototype.getContext = () => null;
    });
    await lost.reload();
    await lost.getByText('This browser has no WebGL 2').waitFor();
    await lost.close();
  });
} finally {
  await browser.close();
  await service.stop();
  rmSync(service.data, { recursive: true, force: true });
  rmSync(folder, { recursive: true, force: true });
}
