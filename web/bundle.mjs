// Puts the program, packed, the demonstration and the scripts into dist/sma.html.

import { readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const demonstration = Object.fromEntries(
    ["rod.toml", "train.csv", "unseen.csv"].map((name) => [name, readFileSync(`dist/demo/${name}`, "utf8")]),
);
const parts = {
    PROGRAM: gzipSync(readFileSync("dist/sma.wasm"), { level: 9 }).toString("base64"),
    // No tag may end a script.
    DEMONSTRATION: JSON.stringify(demonstration).replaceAll("<", "\\u003c"),
    WORKER: readFileSync("dist/worker.js", "utf8").replaceAll("</script", "<\\/script"),
    PAGE: readFileSync("src/page.js", "utf8").replaceAll("</script", "<\\/script"),
};
const page = readFileSync("src/page.html", "utf8").replaceAll(/>(PROGRAM|DEMONSTRATION|WORKER|PAGE)</g, (_, part) => `>${parts[part]}<`);
writeFileSync("dist/sma.html", page);
