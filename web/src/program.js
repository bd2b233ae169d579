// The program `sma` as WebAssembly: one call with files of its own, in memory.

import { ConsoleStdout, Directory, File, OpenFile, PreopenDirectory, WASI } from "@bjorn3/browser_wasi_shim";

/**
 * Runs the program to its end.
 *
 * @param {WebAssembly.Module} module The program.
 * @param {string[]} args Arguments, as a shell would give them; paths begin with "/".
 * @param {Map<string, Uint8Array>} files Files at the root, by name.
 * @param {(line: string) => void} said Gets each line of stderr as it is written.
 * @returns {Promise<{code: number, stdout: string, files: Map<string, Uint8Array>}>} Exit code, what it printed, and all files
 *     at the root when it ended.
 */
export async function run(module, args, files, said) {
    const printed = [];
    const tree = new Map([...files].map(([name, bytes]) => [name, new File(bytes)]));
    // Where results are written before they get their names.
    tree.set("tmp", new Directory(new Map()));
    const root = new PreopenDirectory("/", tree);
    const wasi = new WASI(
        ["sma", ...args],
        ["SMA_PROGRESS=lines", "TMPDIR=/tmp"],
        [
            new OpenFile(new File([])),
            new ConsoleStdout((bytes) => printed.push(bytes.slice())),
            ConsoleStdout.lineBuffered(said),
            root,
        ],
        { debug: false },
    );
    // The library counts characters, and writes bytes.
    const n_bytes = ["sma", ...args].reduce((sum, arg) => sum + new TextEncoder().encode(arg).length + 1, 0);
    wasi.wasiImport.args_sizes_get = (count, size) => {
        const memory = new DataView(wasi.inst.exports.memory.buffer);
        memory.setUint32(count, args.length + 1, true);
        memory.setUint32(size, n_bytes, true);
        return 0;
    };
    const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi.wasiImport });
    const code = wasi.start(instance);
    const left = [...root.dir.contents].filter(([, inode]) => inode instanceof File);
    return {
        code,
        stdout: new TextDecoder().decode(joined(printed)),
        files: new Map(left.map(([name, file]) => [name, file.data])),
    };
}

function joined(parts) {
    const all = new Uint8Array(parts.reduce((length, part) => length + part.length, 0));
    let at = 0;
    for (const part of parts) {
        all.set(part, at);
        at += part.length;
    }
    return all;
}
