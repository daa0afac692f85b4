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
  picture: ({ path }) => page.screenshot({ path, fullPage: true }).then(() => null),
  said: async () => said,
};

for await (const line of createInterface({ input: process.stdin })) {
  const { what, ...given } = JSON.parse(line);
  const answer = await answers[what](given).then((result) => ({ result: result ?? null }), (error) => ({ error: error.message }));
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
await browser.close();
