// Runs modules in Chromium: node browser.mjs CHROMIUM, then the path of a job on each line of the input. A line is
// printed when a job is done: nothing, or what went wrong.
//
// No socket is opened: a page asks for addresses of a host that does not exist, and gets files of the folders in its
// job. Fields of a job: folders (first part of an address -> folder), module (address), arguments (of the module's
// function `run`), result (JSON to write), screenshot (PNG to write, or null).
import { readFile, writeFile } from 'node:fs/promises';
import path from 'node:path';
import readline from 'node:readline';
import { chromium } from 'playwright-core';

// A page that takes longer hangs.
const SECONDS = 120;
const HOST = 'http://planish.invalid';
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.png': 'image/png', '.json': 'application/json' };

const browser = await chromium.launch({
  executablePath: process.argv[2],
  args: [
    '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync', '--force-color-profile=srgb',
  ],
});
try {
  for await (const line of readline.createInterface({ input: process.stdin })) {
    const late = setTimeout(() => process.exit(1), 1000 * SECONDS);
    const complaint = await done(JSON.parse(await readFile(line, 'utf8'))).then(() => '', String);
    clearTimeout(late);
    process.stdout.write(`${JSON.stringify(complaint)}\n`);
  }
} finally {
  await browser.close();
}

async function done({ folders, module, arguments: parameters, result, screenshot }) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 400 } });
  try {
    const page = await context.newPage();
    const complaints = [];
    page.on('pageerror', (error) => complaints.push(String(error)));
    page.on('console', (message) => {
      if (message.type() === 'error') complaints.push(message.text());
    });
    await page.route('**/*', async (route) => {
      const [, folder, ...rest] = decodeURIComponent(new URL(route.request().url()).pathname).split('/');
      const file = path.join(folders[folder] ?? '/nowhere', ...rest);
      try {
        const contentType = TYPES[path.extname(file)] ?? 'application/octet-stream';
        await route.fulfill({ body: await readFile(file), contentType });
      } catch {
        await route.fulfill({ status: 404 });
      }
    });
    await page.goto(`${HOST}/clients/page.html`);
    const run = async ([address, given]) => (await import(address)).run(given);
    const returned = await page.evaluate(run, [module, parameters]);
    if (screenshot) await page.screenshot({ path: screenshot });
    if (complaints.length > 0) throw new Error(complaints.join('\n'));
    await writeFile(result, JSON.stringify(returned));
  } finally {
    await context.close();
  }
}
