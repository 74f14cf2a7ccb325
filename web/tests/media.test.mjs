// Clips, animations and cameras.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { copyFileSync, readFileSync, truncateSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { drawn, ffmpeg, folder, launch, open, openSave, pick, pictures, polyreel, probe, root, save, serve, skip } from './browser.mjs';

let site;
let browser;
const SOUND = ['-f', 'lavfi', '-i', 'sine=frequency=440:sample_rate=48000'];
before(async () => {
  if (skip) return;
  site = await serve();
  browser = await launch();
  const clip = (size, seconds) => ['-f', 'lavfi', '-i', `testsrc2=s=${size}:r=25:d=${seconds}`, ...SOUND, '-t', String(seconds)];
  ffmpeg(...clip('320x240', 2), '-c:v', 'libx264', '-pix_fmt', 'yuv420p', '-c:a', 'aac', 'clip.mp4');
  ffmpeg(...clip('321x241', 1), '-c:v', 'libvpx', '-b:v', '1M', '-c:a', 'libopus', 'odd.webm');
  ffmpeg(...clip('320x240', 1), '-c:v', 'mpeg4', '-c:a', 'aac', 'old.mp4');
  turn('clip.mp4', 'turned.mp4');
  copyFileSync(join(folder, 'clip.mp4'), join(folder, 'short.mp4'));
  truncateSync(join(folder, 'short.mp4'), 9000);
  copyFileSync(join(root, 'samples/planet.gif'), join(folder, 'planet.gif'));
  writeFileSync(join(folder, 'text.png'), 'no picture at all');
  writeFileSync(join(folder, 'empty.mp4'), '');
});
after(async () => {
  await browser?.close();
  await site?.stop();
});

/** A copy of an MP4 that is to be shown turned by a quarter: ffmpeg has several options for that, by its version. */
function turn(name, turned) {
  const bytes = readFileSync(join(folder, name));
  const matrix = bytes.indexOf('tkhd') + 44;
  [0, 0x10000, 0, -0x10000, 0, 0, 240 << 16, 0, 0x40000000].forEach((value, i) => bytes.writeInt32BE(value, matrix + 4 * i));
  writeFileSync(join(folder, turned), bytes);
}

const rate = stream => [stream.width, stream.height, Number(stream.nb_read_frames)];
const of = (found, type) => found.streams.find(stream => stream.codec_type === type);

test('a clip plays, stops, and is at the time that is chosen', { skip }, async () => {
  const { context, page, faults } = await open(browser, site.address);
  await pick(page, 'clip.mp4');
  await drawn(page, (await pictures(page)) + 10);
  await page.click('#play');
  await page.waitForFunction(() => document.getElementById('video').paused);
  const count = await pictures(page);
  await page.fill('#time', '1.2');
  await drawn(page, count + 1);
  assert.ok(Math.abs((await page.evaluate(() => document.getElementById('video').currentTime)) - 1.2) < 0.05);
  await page.locator('.look').nth(2).click();
  await drawn(page, count + 2);
  assert.deepEqual(faults, []);
  await context.close();
});

for (const format of ['mp4', 'webm']) {
  test(`a clip with sound as ${format}: every frame, and the sound`, { skip }, async () => {
    const { context, page } = await open(browser, site.address);
    await pick(page, 'clip.mp4');
    const saved = await save(page, format).catch(error => {
      // A browser without the encoder says so.
      assert.match(String(error), /encode|disabled|checked/);
      return null;
    });
    if (!saved) return void console.log(`this browser does not encode ${format}`);
    const found = probe(saved.path);
    console.log(`${saved.line} (${saved.seconds} s)`);
    assert.deepEqual(rate(of(found, 'video')), [320, 240, 50]);
    assert.ok(of(found, 'audio'), 'there is sound');
    assert.ok(Math.abs(Number(found.format.duration) - 2) < 0.1, found.format.duration);
    await context.close();
  });
}

test('a clip with odd sides, and one that is turned', { skip }, async () => {
  const { context, page } = await open(browser, site.address);
  await pick(page, 'odd.webm');
  assert.deepEqual(rate(of(probe((await save(page, 'webm')).path), 'video')), [320, 240, 25]);
  await pick(page, 'turned.mp4');
  assert.deepEqual(rate(of(probe((await save(page, 'webm')).path), 'video')), [240, 320, 50]);
  await context.close();
});

test('a clip as GIF, APNG and mesh stream', { skip }, async () => {
  const { context, page } = await open(browser, site.address, { hash: '#points=300' });
  await pick(page, 'clip.mp4');
  const gif = probe((await save(page, 'gif')).path);
  assert.deepEqual(rate(gif.streams[0]), [320, 240, 50]);
  const apng = (await save(page, 'apng')).path;
  assert.equal(ffmpeg('-f', 'apng', '-i', apng, '-fps_mode', 'passthrough', '-f', 'rawvideo', '-pix_fmt', 'rgba', '-').length, 50 * 4 * 320 * 240);
  const mesh = await save(page, 'polyreel');
  const info = JSON.parse(polyreel('info', mesh.path, '--json'));
  assert.equal(info.frames, 50);
  polyreel('render', mesh.path, '-o', 'mesh.gif', '-y', '-q');
  await context.close();
});

test('an animation plays, and is exported as a film', { skip }, async () => {
  const { context, page, faults } = await open(browser, site.address);
  await pick(page, 'planet.gif');
  await drawn(page, (await pictures(page)) + 5);
  // Thumbnails are of this animation, whose middle is an orange planet, and not of the sample.
  await page.waitForFunction(() => {
    const canvas = document.createElement('canvas');
    const context = canvas.getContext('2d');
    context.drawImage(document.querySelectorAll('.look canvas')[0], 0, 0, 30, 20);
    const [red, , blue] = context.getImageData(13, 9, 1, 1).data;
    return red > 100 && red > blue + 30;
  });
  const frames = Number(probe('planet.gif').streams[0].nb_read_frames);
  const film = probe((await save(page, 'webm')).path);
  assert.equal(Number(of(film, 'video').nb_read_frames), frames);
  const gif = probe((await save(page, 'gif')).path);
  assert.equal(Number(gif.streams[0].nb_read_frames), frames);
  assert.ok(Math.abs(Number(gif.format.duration) - Number(probe('planet.gif').format.duration)) < 0.02);
  assert.deepEqual(faults, []);
  await context.close();
});

test('an export is cancelled', { skip }, async () => {
  const { context, page } = await open(browser, site.address);
  await pick(page, 'clip.mp4');
  await openSave(page);
  await page.check('#format-apng', { force: true });
  await page.click('#go');
  await page.waitForFunction(() => /Frame/.test(document.getElementById('outcome').textContent));
  await page.click('#cancel');
  await page.waitForFunction(() => /Cancelled/.test(document.getElementById('outcome').textContent));
  await context.close();
});

for (const [name, words] of [
  ['text.png', /damaged|cannot read/],
  ['short.mp4', /damaged|cannot read|No frame/],
  ['empty.mp4', /empty/],
  ['old.mp4', /decode|cannot read|mpeg|no picture/],
]) {
  test(`${name} is refused in words`, { skip }, async () => {
    const { context, page } = await open(browser, site.address, { sample: true });
    await page.setInputFiles('#picker', join(folder, name));
    await page.waitForSelector('#note.error');
    const said = await page.textContent('#note');
    assert.match(said, words);
    await context.close();
  });
}

test('a clip of a minute is exported to its last frame', { skip }, async () => {
  ffmpeg('-f', 'lavfi', '-i', 'testsrc2=s=160x120:r=10:d=60', '-c:v', 'libx264', '-pix_fmt', 'yuv420p', 'minute.mp4');
  const { context, page } = await open(browser, site.address, { hash: '#points=200' });
  await pick(page, 'minute.mp4');
  const saved = await save(page, 'webm');
  assert.equal(saved.frames, 600);
  const film = probe(saved.path);
  assert.equal(Number(of(film, 'video').nb_read_frames), 600);
  assert.ok(Math.abs(Number(film.format.duration) - 60) < 0.2, film.format.duration);
  await context.close();
});

test('a screen is shown live', { skip }, async () => {
  const { context, page, faults } = await open(browser, site.address);
  await page.click('header [data-open="screen"]');
  await page.waitForFunction(() => document.getElementById('stage').dataset.kind === 'stream');
  await drawn(page, (await pictures(page)) + 3);
  assert.deepEqual(faults, []);
  await context.close();
});

test('a camera is shown live, and a recording of it is a clip', { skip }, async () => {
  const { context, page, faults } = await open(browser, site.address, { permissions: ['camera'] });
  await page.click('#welcome [data-open="camera"]');
  await page.waitForFunction(() => document.getElementById('stage').dataset.kind === 'stream');
  await drawn(page, (await pictures(page)) + 8);
  await page.click('#record');
  await drawn(page, (await pictures(page)) + 20);
  await page.click('#record');
  await page.waitForFunction(() => document.getElementById('stage').dataset.kind === 'clip');
  await drawn(page, (await pictures(page)) + 3);
  const saved = await save(page, 'webm');
  assert.ok(saved.frames > 3);
  assert.deepEqual(faults, []);
  await context.close();
});
