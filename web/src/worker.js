// Runs calls of the program beside the page, which stays alive meanwhile; to stop a call the page ends the worker.

import { run } from "./program.js";

self.onmessage = async ({ data: { module, args, files } }) => {
    try {
        const ended = await run(module, args, files, (line) => self.postMessage({ line }));
        self.postMessage({ ended });
    } catch (error) {
        self.postMessage({ fault: String(error) });
    }
};
