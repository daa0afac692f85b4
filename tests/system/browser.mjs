// Drives Chromium with Playwright for the Python tests: one JSON request per line on standard input, one JSON reply per line on standard output.
//   node browser.mjs FOLDER-WITH-NODE_MODULES
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const { chromium } = createRequire(`${process.argv[2]}/`)("playwright-core");
const kPatience_ms = 60_000; // a busy machine is slow
const browser = await chromium.launch({ timeout: kPatience_ms, executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-background-networking"] });
const pages = new Map(); // by the number that the tests give; each has storage of its own

async function newPage() {
  const page = await browser.newPage();
  page.setDefaultTimeout(kPatience_ms);
  await page.addInitScript(() => { window.clicks = 0; addEventListener("click", () => { window.clicks += 1; }, true); });
  const said = []; // console messages and page errors, with their location
  page.on("console", (message) => {
    if (["warning", "error"].includes(message.type())) said.push(`${message.location().url}: ${message.text()}`);
  });
  page.on("pageerror", (error) => said.push(`${page.url()}: ${error.stack}`));
  return { page, said };
}

const answers = {
  open: ({ page }, { url }) => page.goto(url).then(() => null),
  // As an expression: the page's Content Security Policy forbids new Function().
  run: ({ page }, { body, values }) => page.evaluate(`(async function () { ${body} }).apply(null, ${JSON.stringify(values)})`),
  resize: ({ page }, { width, height }) => page.setViewportSize({ width, height }),
  colours: ({ page }, { scheme }) => page.emulateMedia({ colorScheme: scheme }),
  press: ({ page }, { key }) => page.keyboard.press(key),
  // Again if the page disabled the element between Playwright's look and the click, which was then none.
  click: async ({ page }, { selector }) => {
    const clicks = () => page.evaluate("window.clicks");
    for (const before = await clicks(); (await clicks()) === before; ) await page.locator(selector).click();
  },
  fill: ({ page }, { selector, text }) => page.locator(selector).fill(text).then(() => null),
  // Steps like ["move", x, y], ["down"], ["wheel", 0, -100]: methods of Playwright's mouse.
  mouse: async ({ page }, { steps }) => {
    for (const [method, ...given] of steps) await page.mouse[method](...given);
  },
  choose: ({ page }, { selector, value }) => page.locator(selector).selectOption(value).then(() => null),
  hover: ({ page }, { selector, x, y }) => page.locator(selector).hover({ position: { x, y } }).then(() => null),
  reload: ({ page }) => page.reload().then(() => null),
  // The file that a click saves: its proposed name, and where it was saved.
  download: async ({ page }, { selector }) => {
    const [file] = await Promise.all([page.waitForEvent("download"), page.locator(selector).click()]);
    return { name: file.suggestedFilename(), path: await file.path() };
  },
  clipboard: async ({ page }) => {
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    return page.evaluate("navigator.clipboard.readText()");
  },
  // Steps like [type, [[x, y], ...]] of the protocol's dispatchTouchEvent: fingers that touch, move or leave.
  touch: async ({ page }, { steps }) => {
    const session = await page.context().newCDPSession(page);
    for (const [type, points] of steps) await session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    await session.detach();
  },
  picture: ({ page }, { path }) => page.screenshot({ path, fullPage: true }).then(() => null),
  said: async ({ said }) => said,
};

for await (const line of createInterface({ input: process.stdin })) {
  const { what, page, ...given } = JSON.parse(line);
  const answered = async () => {
    if (!pages.has(page)) pages.set(page, await newPage());
    if (what !== "close") return answers[what](pages.get(page), given);
    await pages.get(page).page.context().close();
    pages.delete(page);
  };
  const answer = await answered().then((result) => ({ result: result ?? null }), (error) => ({ error: error.message }));
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
await browser.close();
