// Runs one module in Chromium and writes down what it returns: node browser.mjs JOB.json
//
// No socket is opened: the page asks for addresses of a host that does not exist, and gets files of the folders in the
// job. Fields of the job: chromium (path), folders (first part of an address -> folder), module (address), arguments
// (of the module's function `run`), result (JSON to write), screenshot (PNG to write).
import { readFile, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { chromium } from 'playwright-core';

const HOST = 'http://planish.invalid';
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.png': 'image/png', '.json': 'application/json' };

const job = JSON.parse(await readFile(process.argv[2], 'utf8'));
const browser = await chromium.launch({
  executablePath: job.chromium,
  args: [
    '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync', '--force-color-profile=srgb',
  ],
});
try {
  const page = await browser.newPage({ viewport: { width: 1200, height: 400 } });
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error') complaints.push(message.text());
  });
  await page.route('**/*', async (route) => {
    const [, folder, ...rest] = decodeURIComponent(new URL(route.request().url()).pathname).split('/');
    const file = path.join(job.folders[folder] ?? '/nowhere', ...rest);
    try {
      const contentType = TYPES[path.extname(file)] ?? 'application/octet-stream';
      await route.fulfill({ body: await readFile(file), contentType });
    } catch {
      await route.fulfill({ status: 404 });
    }
  });
  await page.goto(`${HOST}/clients/page.html`);
  const returned = await page.evaluate(async ([module, arguments_]) => (await import(module)).run(arguments_), [
    job.module, job.arguments,
  ]);
  if (job.screenshot) await page.screenshot({ path: job.screenshot });
  await writeFile(job.result, JSON.stringify({ returned, complaints }));
} finally {
  await browser.close();
}
