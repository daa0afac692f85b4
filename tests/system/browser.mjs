// Drives Chromium with Playwright for the Python tests: one JSON request per line on standard input, one JSON reply per line on standard output.
//   node browser.mjs FOLDER-WITH-NODE_MODULES
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const { chromium } = createRequire(`${process.argv[2]}/`)("playwright-core");
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-background-networking"] });
const page = await browser.newPage();
const said = []; // console messages and page errors, with their location
page.on("console", (message) => {
  if (["warning", "error"].includes(message.type())) said.push(`${message.location().url}: ${message.text()}`);
});
page.on("pageerror", (error) => said.push(`${page.url()}: ${error.stack}`));

const answers = {
  open: ({ url }) => page.goto(url).then(() => null),
  // As an expression: the page's Content Security Policy forbids new Function().
  run: ({ body, values }) => page.evaluate(`(async function () { ${body} }).apply(null, ${JSON.stringify(values)})`),
  resize: ({ width, height }) => page.setViewportSize({ width, height }),
  colours: ({ scheme }) => page.emulateMedia({ colorScheme: scheme }),
  press: ({ key }) => page.keyboard.press(key),
  click: ({ selector }) => page.locator(selector).click({ timeout: 10_000 }).then(() => null),
  fill: ({ selector, text }) => page.locator(selector).fill(text, { timeout: 10_000 }).then(() => null),
  // Steps like ["move", x, y], ["down"], ["wheel", 0, -100]: methods of Playwright's mouse.
  mouse: async ({ steps }) => {
    for (const [method, ...given] of steps) await page.mouse[method](...given);
  },
  choose: ({ selector, value }) => page.locator(selector).selectOption(value, { timeout: 10_000 }).then(() => null),
  hover: ({ selector, x, y }) => page.locator(selector).hover({ position: { x, y }, timeout: 10_000 }).then(() => null),
  reload: () => page.reload().then(() => null),
  // The file that a click saves: its proposed name, and where it was saved.
  download: async ({ selector }) => {
    const [file] = await Promise.all([page.waitForEvent("download", { timeout: 10_000 }), page.locator(selector).click({ timeout: 10_000 })]);
    return { name: file.suggestedFilename(), path: await file.path() };
  },
  clipboard: async () => {
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    return page.evaluate("navigator.clipboard.readText()");
  },
  // Steps like [type, [[x, y], ...]] of the protocol's dispatchTouchEvent: fingers that touch, move or leave.
  touch: async ({ steps }) => {
    const session = await page.context().newCDPSession(page);
    for (const [type, points] of steps) await session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    await session.detach();
  },
  picture: ({ path }) => page.screenshot({ path, fullPage: true }).then(() => null),
  said: async () => said,
};

for await (const line of createInterface({ input: process.stdin })) {
  const { what, ...given } = JSON.parse(line);
  const answer = await answers[what](given).then((result) => ({ result: result ?? null }), (error) => ({ error: error.message }));
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
await browser.close();
