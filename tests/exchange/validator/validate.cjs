// Validates the glTF files that are named as arguments: prints the errors and warnings of each, and
// exits with 1 if there is any.
const { readFileSync } = require("node:fs");
const { validateBytes } = require("gltf-validator");

async function main(paths) {
    let problems = 0;
    for (const path of paths) {
        const report = await validateBytes(new Uint8Array(readFileSync(path)), { uri: path });
        problems += report.issues.numErrors + report.issues.numWarnings;
        for (const issue of report.issues.messages)
            if (issue.severity < 2)
                console.log(`${path}: ${issue.code} at ${issue.pointer ?? issue.offset}: ${issue.message}`);
        console.log(`${path}: ${report.issues.numErrors} errors, ${report.issues.numWarnings} warnings, ` +
            `${report.info.totalTriangleCount} triangles`);
    }
    process.exitCode = problems > 0 ? 1 : 0;
}

main(process.argv.slice(2));
