// What the page makes has the bytes of what the program makes.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { copyFileSync, cpSync } from 'node:fs';
import { join } from 'node:path';
import { ffmpeg, folder, launch, open, pick, polyreel, read, root, save, serve, skip } from './browser.mjs';

let site;
let browser;
before(async () => {
  if (skip) return;
  site = await serve();
  browser = await launch();
  copyFileSync(join(root, 'samples/boat/0001.png'), join(folder, 'boat.png'));
  copyFileSync(join(root, 'samples/planet.gif'), join(folder, 'planet.gif'));
  cpSync(join(root, 'samples/boat'), join(folder, 'boat'), { recursive: true });
  ffmpeg('-i', join(root, 'samples/lake.jpg'), 'lake.png');
  ffmpeg('-f', 'lavfi', '-i', 'color=red@0.0:s=160x120,format=rgba,geq=r=X:g=Y:b=128:a=X+Y', '-frames:v', '1', 'clear.png');
  ffmpeg('-f', 'lavfi', '-i', 'mandelbrot=s=320x240:r=15', '-frames:v', '30', 'mandelbrot.gif');
  ffmpeg('-framerate', '12', '-i', 'boat/%04d.png', '-f', 'apng', '-plays', '0', 'boat.apng');
});
after(async () => {
  await browser?.close();
  await site?.stop();
});

const STILLS = [
  ['boat.png', ''],
  ['lake.png', ''],
  ['clear.png', ''],
  ...['paper', 'bold', 'fine', 'sketch', 'stained-glass', 'crystal'].map(name => ['lake.png', `preset=${name}`]),
  ...['median', 'centroid', 'linear', 'gouraud', 'none'].map(fill => ['boat.png', `fill=${fill}`]),
  ['boat.png', 'shape=polygons'],
  ['lake.png', 'shape=voronoi&points=900'],
  ['lake.png', 'outline=%23ffffff&outline-width=3&outline-contrast=12'],
  ['lake.png', 'points=2500&regularity=0.9&saturation=1.4&contrast=1.2'],
  ['boat.png', 'focus=saliency&seed=5'],
  ['lake.png', 'preset=sketch&points=700&wash=0.2'],
  ['clear.png', 'points=300&edges=hard'],
];

/** Pictures larger than their source. */
const LARGE = [
  ['boat.png', '', 'x2'],
  ['lake.png', 'preset=sketch', 'x3'],
  ['clear.png', 'shape=polygons&outline=%23102030&outline-width=1', 'x2'],
];

/** The words of a command line, quotes taken off. */
const words = line => line.match(/'[^']*'|\S+/g).map(word => word.replaceAll("'", ''));

for (const [name, look, size] of [...STILLS, ...LARGE]) {
  test(`a PNG of ${name} with "${look}"${size ? `, ${size}` : ''}`, { skip }, async () => {
    const { context, page, faults } = await open(browser, site.address, { hash: `#${look}` });
    await pick(page, name);
    const saved = await save(page, 'png', { size });
    // The very command line that the page shows.
    const [program, ...args] = words(saved.line.replaceAll('=\'', '=').replaceAll("'", ''));
    assert.equal(program, 'polyreel');
    assert.equal(saved.line.includes(' --scale '), size !== undefined, saved.line);
    polyreel(...args, '-y', '-q');
    assert.ok(read(saved.path).equals(read(join(folder, saved.name))), saved.line);
    assert.deepEqual(faults, []);
    await context.close();
  });
}

for (const [name, look] of [['boat.png', ''], ['lake.png', 'preset=stained-glass'], ['clear.png', 'points=200']]) {
  test(`an SVG of ${name} with "${look}"`, { skip }, async () => {
    const { context, page } = await open(browser, site.address, { hash: `#${look}` });
    await pick(page, name);
    const saved = await save(page, 'svg');
    const [, ...args] = words(saved.line);
    polyreel(...args, '-y', '-q');
    const wanted = read(join(folder, saved.name), 'utf8');
    const title = text => text.replace(/<title>.*<\/title>/, '');
    assert.equal(title(read(saved.path, 'utf8')), title(wanted));
    await context.close();
  });
}

/** All frames of a file, as RGBA. */
const frames = (...input) => ffmpeg(...input, '-fps_mode', 'passthrough', '-f', 'rawvideo', '-pix_fmt', 'rgba', '-');

for (const [name, look, args] of [
  ['mandelbrot.gif', '', []],
  ['planet.gif', 'preset=bold', ['--preset', 'bold']],
  ['boat.apng', 'fill=linear&coherence=0.7', ['--fill', 'linear', '--coherence', '0.7']],
]) {
  test(`every frame of ${name} with "${look}"`, { skip }, async () => {
    const { context, page } = await open(browser, site.address, { hash: `#${look}` });
    await pick(page, name);
    const saved = await save(page, 'apng');
    const stem = name.replace('.', '-');
    polyreel('render', name, '-o', `${stem}-%03d.png`, ...args, '-y', '-q');
    const wanted = frames('-i', `${stem}-%03d.png`);
    const found = frames('-f', 'apng', '-i', saved.path);
    assert.equal(found.length, wanted.length, 'as many frames');
    assert.ok(found.equals(wanted), 'the same frames');
    await context.close();
  });
}
