// Does to the page of web/ in Chromium what people do: node web.mjs CHROMIUM JOB.json.
//
// Fields of the job: address (of the page), clients (folder whose files the page finds under /clients/), steps (of this file's
// functions, with their arguments), result (JSON to write: what each step returned), downloads (folder), viewport.
import { readFile, rename, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { chromium } from 'playwright-core';

const job = JSON.parse(await readFile(process.argv[3], 'utf8'));
// A bake that takes longer hangs.
const PATIENCE = 240_000;

const browser = await chromium.launch({
  executablePath: process.argv[2],
  args: [
    '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync', '--force-color-profile=srgb',
  ],
});
const context = await browser.newContext({ acceptDownloads: true, ...job.context });
context.setDefaultTimeout(PATIENCE);
const page = await context.newPage();
const complaints = [];
page.on('pageerror', (error) => complaints.push(String(error)));
page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
const foreign = [];
page.on('request', (request) => new URL(request.url()).origin === new URL(job.address).origin || foreign.push(request.url()));
await page.route('**/clients/*', async (route) => {
  const file = path.join(job.clients, path.basename(new URL(route.request().url()).pathname));
  await route.fulfill({ body: await readFile(file), contentType: 'text/javascript' });
});

/// Path of the file that was saved last.
let last;

const steps = {
  async visit() {
    await page.goto(job.address);
    await page.locator('html[data-ready]').waitFor();
    return page.locator('body').innerText();
  },
  /// Drops files as a hand would: the page gets their names and contents.
  async drop(files) {
    const given = await Promise.all(files.map(async (file) => [path.basename(file), (await readFile(file)).toString('base64')]));
    const transfer = await page.evaluateHandle(async (all) => {
      const made = new DataTransfer();
      for (const [name, text] of all) {
        const bytes = await (await fetch(`data:application/octet-stream;base64,${text}`)).arrayBuffer();
        made.items.add(new File([bytes], name));
      }
      return made;
    }, given);
    for (const type of ['dragover', 'drop']) await page.dispatchEvent('body', type, { dataTransfer: transfer });
  },
  async choose(files) {
    await page.setInputFiles('#files', files);
  },
  /// Waits for the end of the work, and returns the error, or nothing.
  async done() {
    await page.locator('#work:not([hidden])').waitFor({ timeout: 10_000 }).catch(() => {});
    await page.locator('#work').waitFor({ state: 'hidden' });
    return (await page.locator('#error').isVisible()) ? page.locator('#error').innerText() : '';
  },
  /// Waits until the work has come to a stage.
  async stage(name) {
    await page.waitForFunction((wanted) => document.getElementById('work-stage').textContent === wanted, name, { polling: 5 });
  },
  click: (selector) => page.locator(selector).click(),
  open: (selector) => page.locator(selector).evaluate((details) => (details.open = true)),
  check: (selector, is) => page.locator(selector).setChecked(is),
  select: (selector, value) => page.locator(selector).selectOption(value),
  fill: (selector, value) => page.locator(selector).fill(value),
  press: (selector, key) => page.locator(selector).press(key),
  text: (selector) => page.locator(selector).innerText(),
  texts: (selector) => page.locator(selector).allInnerTexts(),
  enabled: (selector) => page.locator(selector).isEnabled(),
  visible: (selector) => page.locator(selector).isVisible(),
  value: (selector) => page.locator(selector).inputValue(),
  /// Takes a picture of the canvas, or of the whole page.
  async picture(file, selector) {
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    await (selector ? page.locator(selector) : page).screenshot({ path: file });
  },
  /// Presses a button and saves what it hands out.
  async download(selector) {
    const [download] = await Promise.all([page.waitForEvent('download'), page.locator(selector).click()]);
    last = path.join(job.downloads, download.suggestedFilename());
    await download.saveAs(last);
    return last;
  },
  /// Gives the file that was saved last another name.
  rename: (name) => rename(last, path.join(job.downloads, name)),
  /// Positions of the vertices at rest and where three.js draws them, as base64, for each mesh.
  positions: () => page.evaluate(async () => {
    const [{ displaced }, { base64 }] = await Promise.all([import('/clients/threejs.js'), import('/clients/numbers.js')]);
    const { view } = window.planish;
    view.isSplit = false;
    view.drawNow();
    return view.meshes.map((mesh) => [mesh.geometry.attributes.position.array, displaced(view.renderer, mesh)].map(base64));
  }),
  async offline() {
    await page.evaluate(() => navigator.serviceWorker.ready.then(() => undefined));
    await page.reload();
    await context.setOffline(true);
    await page.reload();
    await page.locator('html[data-ready]').waitFor();
  },
  /// Names in the accessibility tree that are empty, and how wide the page is beyond its window.
  structure: () => page.evaluate(() => ({
    overflow: document.documentElement.scrollWidth - innerWidth,
    unnamed: [...document.querySelectorAll('button, input:not([hidden]), select')]
      .filter((item) => !item.closest('[hidden]'))
      .filter((item) => !(item.labels?.length || item.getAttribute('aria-label') || item.textContent.trim()))
      .map((item) => item.outerHTML),
  })),
  evaluate: (code) => page.evaluate(code),
};

try {
  const results = [];
  for (const [name, ...parameters] of job.steps) results.push((await steps[name](...parameters)) ?? null);
  await writeFile(job.result, JSON.stringify({ results, complaints, foreign }));
} finally {
  await browser.close();
}
