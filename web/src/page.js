// The page: recordings in, verdict and report out. Nothing leaves the machine.

/** Files that a diagnosis leaves. */
const RESULTS = ["report.html", "model.toml", "diagnosis.json"];

const $ = (id) => document.getElementById(id);
const text = (bytes) => new TextDecoder().decode(bytes);
const bytesOf = (string) => new TextEncoder().encode(string);

/** Recordings by name, with their role: "train", "validate" or "none". */
const recordings = new Map();
let program;
let is_busy = false;

/** The program, unpacked from the page on first use. */
async function theProgram() {
    if (!program) {
        const packed = Uint8Array.from(atob($("program").textContent), (c) => c.charCodeAt(0));
        const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
        program = WebAssembly.compile(await new Response(stream).arrayBuffer());
    }
    return program;
}

/** One call of the program; `null` if it was stopped. */
async function call(args, files) {
    busy(true);
    const worker = new Worker(URL.createObjectURL(new Blob([$("worker").textContent], { type: "text/javascript" })));
    const notes = [];
    const running = new Promise((resolve, reject) => {
        worker.onmessage = ({ data }) => {
            if (data.fault) {
                reject(new Error([data.fault, ...notes].join("\n")));
            } else if (data.ended) {
                resolve({ ...data.ended, notes });
            } else if (data.line.startsWith("progress: ")) {
                $("progress").textContent = data.line.slice("progress: ".length);
            } else {
                notes.push(data.line.trimEnd());
            }
        };
        worker.onerror = (event) => reject(new Error(event.message));
        $("stop").onclick = () => resolve(null);
        theProgram().then((module) => worker.postMessage({ module, args, files }), reject);
    });
    return running
        .then((ended) => ended && { ...ended, given: [...files.keys()] })
        .finally(() => {
            worker.terminate();
            busy(false);
        });
}

function busy(is) {
    is_busy = is;
    $("choose").disabled = is;
    for (const id of ["look", "diagnose", "demo"]) {
        $(id).disabled = is;
    }
    $("stop").hidden = !is;
    $("progress").textContent = is ? "…" : "";
}

function filesOfCall() {
    return new Map([
        ["rod.toml", bytesOf($("rod").value)],
        ...[...recordings].filter(([, one]) => one.role !== "none").map(([name, one]) => [name, one.bytes]),
    ]);
}

function named(role) {
    return [...recordings].filter(([, one]) => one.role === role).map(([name]) => `/${name}`);
}

/** What the program said, with the names that the files have here. */
function said(ended) {
    const notes = ended.notes.filter((note) => note !== "").join("\n");
    const words = [ended.stdout.trimEnd(), notes].filter((part) => part !== "").join("\n\n");
    return [...ended.given, ...RESULTS].reduce((text, name) => text.replaceAll(`/${name}`, name), words);
}

function show(words, is_fault) {
    $("said").textContent = words;
    $("said").classList.toggle("fault", is_fault);
    $("result").hidden = words === "";
}

async function guarded(work) {
    $("kept").replaceChildren();
    $("report").hidden = true;
    show("", false);
    try {
        await work();
    } catch (error) {
        show(`This did not work: ${error.message}`, true);
    }
}

async function propose_rod() {
    const [first] = recordings.keys();
    const files = new Map([[first, recordings.get(first).bytes]]);
    const ended = await call(["init", `/${first}`, "--rod", "/rod.toml"], files);
    if (!ended) {
        return;
    }
    if (ended.code === 0) {
        $("rod").value = text(ended.files.get("rod.toml")).replaceAll(`/${first}`, first);
    }
    show(said(ended), ended.code !== 0);
}

/** A name that no recording has yet: files of several folders may have the same one. */
function free(name) {
    let other = name;
    for (let k = 2; recordings.has(other); k += 1) {
        other = `${k}-${name}`;
    }
    return other;
}

async function take(files) {
    for (const file of files) {
        if (file.name.endsWith(".toml")) {
            $("rod").value = await file.text();
        } else {
            recordings.set(free(file.name), { bytes: new Uint8Array(await file.arrayBuffer()), role: "train" });
        }
    }
    // The last of several tests the fit of the others.
    const all = [...recordings.values()];
    if (all.length > 1 && all.every((one) => one.role === "train")) {
        all[all.length - 1].role = "validate";
    }
    list();
    if ($("rod").value.trim() === "" && recordings.size > 0) {
        await propose_rod();
    }
}

function list() {
    const rows = [...recordings].map(([name, one]) => {
        const row = document.createElement("li");
        const role = document.createElement("select");
        for (const [value, label] of [["train", "fitted"], ["validate", "unseen: tests the fit"], ["none", "left out"]]) {
            role.add(new Option(label, value, false, value === one.role));
        }
        role.ariaLabel = `Role of ${name}`;
        role.onchange = () => {
            one.role = role.value;
        };
        row.append(role, ` ${name}, ${Math.ceil(one.bytes.length / 1024)} KB`);
        return row;
    });
    $("recordings").replaceChildren(...rows);
}

async function look() {
    const given = [...named("train"), ...named("validate")];
    if (given.length === 0) {
        show("No recording: drop one, or take the demonstration.", true);
        return;
    }
    const ended = await call(["inspect", ...given, "--rod", "/rod.toml"], filesOfCall());
    if (ended) {
        show(said(ended), ended.code !== 0);
    }
}

async function diagnose() {
    const train = named("train");
    const validate = named("validate");
    if (train.length === 0) {
        show("No recording to fit: drop one, or take the demonstration.", true);
        return;
    }
    const args = ["diagnose", "/rod.toml", "--train", ...train];
    if (validate.length > 0) {
        args.push("--validate", ...validate);
    }
    args.push("--effort", $("effort").value, "--report", "/report.html", "--save-model", "/model.toml", "--json", "/diagnosis.json");
    const began = performance.now();
    const ended = await call(args, filesOfCall());
    if (!ended) {
        show("Stopped.", false);
        return;
    }
    show(`${said(ended)}\n\n${((performance.now() - began) / 1000).toFixed(1)} s in this page.`, ended.code !== 0 && ended.code !== 4);
    keep(ended.files);
}

function keep(files) {
    const types = { "report.html": "text/html", "model.toml": "text/plain", "diagnosis.json": "application/json" };
    for (const [name, type] of Object.entries(types)) {
        const bytes = files.get(name);
        if (!bytes || bytes.length === 0) {
            continue;
        }
        const link = document.createElement("a");
        link.href = URL.createObjectURL(new Blob([bytes], { type }));
        link.download = name;
        link.textContent = name;
        $("kept").append(link, " ");
        if (name === "report.html") {
            $("report").src = link.href;
            $("report").hidden = false;
        }
    }
}

async function demo() {
    recordings.clear();
    $("rod").value = "";
    const demonstration = JSON.parse($("demonstration").textContent);
    await take(Object.entries(demonstration).map(([name, content]) => new File([content], name)));
    show("A simulated wire, with physics that the program is not told. Next: say what is missing.", false);
}

$("choose").onchange = (event) => guarded(() => take(event.target.files));
const place = $("place");
place.ondragover = (event) => {
    event.preventDefault();
    place.classList.add("over");
};
place.ondragleave = () => place.classList.remove("over");
place.ondrop = (event) => {
    event.preventDefault();
    place.classList.remove("over");
    if (!is_busy) {
        guarded(() => take(event.dataTransfer.files));
    }
};
$("look").onclick = () => guarded(look);
$("diagnose").onclick = () => guarded(diagnose);
$("demo").onclick = () => guarded(demo);
