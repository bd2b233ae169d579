// The page's program against the installed one: the same call prints the same words and writes the same JSON and
// model, numbers to 1e-6.
// Machines round exponentials and logarithms differently in the last digit.
//
//     node check.mjs dist/sma.wasm path/of/sma folder/of/a/rig

import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { run } from "./src/program.js";

const [wasm, installed, rig] = process.argv.slice(2);
const inputs = ["rod.toml", "train.csv", "unseen.csv"];
// A name of more bytes than characters.
const unseen = "Prüfstand 5 µm.csv";
const outputs = ["diagnosis.json", "model.toml"];
const at = (folder) => (name) => `${folder}/${name}`;
const call = (place) => [
    "diagnose", ...inputs.slice(0, 1).map(place), "--train", place("train.csv"), "--validate", place(unseen),
    "--json", place("diagnosis.json"), "--save-model", place("model.toml"), "--report", place("report.html"), "-v",
];

const module = await WebAssembly.compile(readFileSync(wasm));
const called = (name) => (name === "unseen.csv" ? unseen : name);
const files = new Map(inputs.map((name) => [called(name), new Uint8Array(readFileSync(join(rig, name)))]));
const began = performance.now();
const ended = await run(module, call(at("")), files, () => {});
const seconds = (performance.now() - began) / 1000;
if (ended.code !== 0) {
    throw new Error(`the program ended with code ${ended.code}`);
}

const folder = mkdtempSync(join(tmpdir(), "sma-web-"));
try {
    for (const name of inputs) {
        copyFileSync(join(rig, name), join(folder, called(name)));
    }
    const begun = performance.now();
    const stdout = execFileSync(installed, [...call(at(folder)), "--threads", "1"], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
    const expected = (performance.now() - begun) / 1000;
    same("what is printed", ended.stdout, stdout.replaceAll(`${folder}/`, "/"));
    for (const name of outputs) {
        // Beside the command, which names folders and threads.
        const kept = (text) => text.replaceAll(`${folder}/`, "/").replaceAll(" --threads 1", "");
        same(name, kept(new TextDecoder().decode(ended.files.get(name))), kept(readFileSync(join(folder, name), "utf8")));
    }
    console.log(`equal: what is printed, ${outputs.join(", ")}; ${(seconds / expected).toFixed(1)} times the time on one thread`);
} finally {
    rmSync(folder, { recursive: true });
}

function same(what, found, expected) {
    const number = /-?\d+\.\d+(?:e[-+]?\d+)?/gi;
    if (found.replaceAll(number, "#") !== expected.replaceAll(number, "#")) {
        throw new Error(`${what}: other words`);
    }
    const [a, b] = [found, expected].map((text) => (text.match(number) ?? []).map(Number));
    const k = a.findIndex((value, k) => Math.abs(value - b[k]) > 1e-6 * Math.max(Math.abs(b[k]), 1e-6));
    if (k >= 0) {
        throw new Error(`${what}: ${a[k]} instead of ${b[k]}`);
    }
}
