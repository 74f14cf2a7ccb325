// A browser with the page in it, and the program to hold it against.
import { execFileSync, spawnSync } from 'node:child_process';
import { createReadStream, existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { extname, join, normalize, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

export const root = fileURLToPath(new URL('../..', import.meta.url));
const dist = join(root, 'web/dist');
const TYPES = {
  '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm', '.svg': 'image/svg+xml',
  '.jpg': 'image/jpeg', '.webmanifest': 'application/manifest+json',
};

const names = [process.env.BROWSER, 'chromium-headless-shell', 'chromium', 'google-chrome'].filter(Boolean);
export const browserPath = names
  .map(name => spawnSync('sh', ['-c', `command -v "${name}"`], { encoding: 'utf8' }).stdout.trim())
  .find(Boolean);
if (!browserPath && process.env.REQUIRE_BROWSER) throw new Error('there is no Chromium to test the page in');
/** Why tests are skipped, or nothing. */
export const skip = browserPath ? false : 'there is no Chromium';

/** A folder that vanishes with the tests. */
export const folder = mkdtempSync(join(tmpdir(), 'polyreel-web-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

export function ffmpeg(...args) {
  return execFileSync('ffmpeg', ['-v', 'error', '-nostdin', '-y', ...args], { cwd: folder, maxBuffer: 1 << 30 });
}

export function polyreel(...args) {
  return execFileSync(process.env.POLYREEL, args, { cwd: folder, maxBuffer: 1 << 30 });
}

export function probe(name) {
  const entries = 'stream=codec_type,codec_name,width,height,nb_read_frames,duration:format=duration';
  const args = ['-v', 'error', '-count_frames', '-show_entries', entries, '-of', 'json', resolve(folder, name)];
  return JSON.parse(execFileSync('ffprobe', args));
}

/** Serves web/dist; `stop` makes the network fail. */
export async function serve() {
  const server = createServer((request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname));
    const file = join(dist, path.endsWith('/') ? `${path}index.html` : path);
    if (!file.startsWith(dist) || !existsSync(file)) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise(resolve => server.listen(0, '127.0.0.1', resolve));
  const stop = () => {
    server.closeAllConnections();
    return new Promise(resolve => server.close(resolve));
  };
  return { address: `http://127.0.0.1:${server.address().port}/`, stop };
}

export function launch(...args) {
  return chromium.launch({
    executablePath: browserPath,
    args: ['--no-sandbox', '--use-fake-device-for-media-stream', '--use-fake-ui-for-media-stream', ...args],
  });
}

/** The page, ready, with a list of what should not happen: errors and requests to elsewhere. */
export async function open(browser, address, options = {}) {
  const { hash = '', sample = false, ...rest } = options;
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, acceptDownloads: true, ...rest });
  const page = await context.newPage();
  const faults = [];
  page.on('console', message => ['error', 'warning'].includes(message.type()) && faults.push(message.text()));
  page.on('pageerror', error => faults.push(String(error)));
  page.on('request', request => {
    const { protocol, origin } = new URL(request.url());
    if (['http:', 'https:', 'ws:', 'wss:'].includes(protocol) && `${origin}/` !== address) faults.push(request.url());
  });
  await page.goto(address + hash);
  await page.waitForSelector('body[data-ready="yes"]');
  if (sample) await shown(page);
  return { context, page, faults };
}

/** Waits for a picture after the last one. */
export async function shown(page) {
  await page.waitForSelector('body[data-state="shown"]');
}

/** The number of pictures so far. */
export const pictures = page => page.evaluate(() => Number(document.getElementById('stage').dataset.pictures ?? 0));

/** Waits until `count` pictures were drawn. */
export const drawn = (page, count) =>
  page.waitForFunction(n => Number(document.getElementById('stage').dataset.pictures ?? 0) >= n, count);

/** Waits until the picture is drawn at its full size and nothing changes. */
export const settled = (page, size) =>
  page.waitForFunction(wanted => document.getElementById('stage').dataset.size === wanted, size);

/** Opens a file of `folder` as a person would. */
export async function pick(page, name) {
  await page.setInputFiles('#picker', join(folder, name));
  // The sample's picture may still come before it.
  await page.waitForFunction(wanted => document.getElementById('stage').dataset.shown === wanted, name);
  await shown(page);
}

/** Opens the dialog that saves. It opens when the page knows which formats there are. */
export async function openSave(page) {
  await page.click('#open-save');
  await page.waitForSelector('#save[open]');
}

export async function closeSave(page) {
  await page.click('#cancel');
  await page.waitForSelector('#save:not([open])', { state: 'attached' });
}

/** Saves in `format`, and returns the path of the file. */
export async function save(page, format, { size } = {}) {
  await openSave(page);
  await page.check(`#format-${format}`, { force: true });
  if (size) await page.selectOption('#size', size);
  const download = page.waitForEvent('download', { timeout: 300_000 });
  const failed = page
    .waitForFunction(() => {
      const outcome = document.getElementById('outcome').textContent;
      return document.getElementById('save').dataset.state === 'idle' && outcome !== '' && !/ready/.test(outcome) && outcome;
    }, null, { timeout: 300_000 })
    .then(handle => handle.jsonValue())
    .then(words => Promise.reject(new Error(words)));
  failed.catch(() => undefined);
  await page.click('#go');
  const file = await Promise.race([download, failed]);
  const path = join(folder, `saved-${format}-${file.suggestedFilename()}`);
  await file.saveAs(path);
  const line = await (await page.waitForFunction(() => document.getElementById('line').textContent)).jsonValue();
  const { seconds, frames } = await page.evaluate(() => ({ ...document.getElementById('save').dataset }));
  await closeSave(page);
  return { path, name: file.suggestedFilename(), line, seconds: Number(seconds), frames: Number(frames) };
}

export const read = readFileSync;
