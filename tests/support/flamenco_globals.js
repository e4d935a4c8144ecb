// SPDX-License-Identifier: GPL-3.0-or-later
// What Flamenco 3's Manager offers to a job type (internal/manager/job_compilers: author.go, js_globals.go), and a job that is compiled by it.
// `node flamenco_globals.js JOB_TYPE.js SETTINGS.json` prints the job type and the tasks.
const fs = require("fs");
const vm = require("vm");
const [script, settings] = process.argv.slice(2);
const author = {
    Task(name, type) {
        if (!name.trim() || !type.trim()) throw new Error("author.Task(name, type): both are required");
        return {
            name, type, commands: [], dependencies: [],
            addCommand(command) { this.commands.push(command); },
            addDependency(task) { this.dependencies.push(task.name); },
        };
    },
    Command(name, parameters) { return { name, parameters }; },
};
const tasks = [];
const context = vm.createContext({ author, print() {} });
vm.runInContext(fs.readFileSync(script, "utf8") + "\nthis.JOB_TYPE = JOB_TYPE; this.compileJob = compileJob;", context);
const defaults = {};
for (const one of context.JOB_TYPE.settings) defaults[one.key] = one.default;
const job = {
    settings: Object.assign(defaults, JSON.parse(settings)),
    // The Manager copies a task when it is added: what is changed afterwards is lost.
    addTask(task) { tasks.push(JSON.parse(JSON.stringify(task))); },
};
context.compileJob(job);
console.log(JSON.stringify({ jobType: context.JOB_TYPE, tasks }));
