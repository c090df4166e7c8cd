// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// A job type of Flamenco 3: frames × ranges of samples, then one picture of each frame, then a movie where one is wanted.
// Copy it into the folder "scripts" of the Flamenco Manager. Tasks are those of sdf_lights/blender/render_job.py.

const JOB_TYPE = {
    label: "SDF Lights Render",
    description: "Render frames, of which several workers share the samples, and join them",
    settings: [
        {
            key: "frames", type: "string", required: true,
            eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
            evalInfo: { showLinkButton: true, description: "Scene frame range" },
            description: "Frames to render, such as '47', '1-30' or '3, 5-10'",
        },
        {
            key: "samples", type: "int32", required: true, eval: "C.scene.sdf_lights.samples",
            evalInfo: { showLinkButton: true, description: "Samples of the scene" },
            description: "Samples of each pixel, of all tasks together",
        },
        { key: "tasks_per_frame", type: "int32", default: 4, description: "Number of tasks that share the samples of a frame" },
        { key: "denoise", type: "bool", default: false, description: "Denoise each joined frame" },
        { key: "movie", type: "bool", default: false, description: "Make a movie of the joined frames" },
        {
            key: "render_output_root", type: "string", subtype: "dir_path", required: true, visible: "submission",
            description: "Folder in which each job has one of its own",
        },
        {
            key: "render_output_path", type: "string", subtype: "dir_path", editable: false,
            eval: "str(Path(abspath(settings.render_output_root), jobname))",
            description: "Folder of the frames of this job",
        },
        { key: "blendfile", type: "string", required: true, description: "The .blend to render", visible: "web" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const folder = settings.render_output_path;
    const ranges = rangesOf(settings.samples, settings.tasks_per_frame);
    const merges = [];
    for (const frame of frameChunker(settings.frames, 1)) {
        const merge = author.Task(`merge-${frame}`, "blender");
        const denoise = settings.denoise ? ["--denoise"] : [];
        const parts = ranges.map(([first]) => `${partOf(folder, first)}.exr`);
        merge.addCommand(blender(["-c", "sdf_lights_merge", "--frame", frame, ...denoise, path.join(folder, "####.exr"), ...parts]));
        for (const [first, end] of ranges) {
            const task = author.Task(`render-${frame}-${first}-${end}`, "blender");
            task.addCommand(author.Command("blender-render", {
                exe: "{blender}",
                exeArgs: "{blenderArgs}",
                argsBefore: [],
                blendfile: settings.blendfile,
                args: [
                    "-E", "SDF_LIGHTS", "-F", "OPEN_EXR_MULTILAYER", "-o", partOf(folder, first), "-f", frame,
                    "--", "--sdf-samples", `${first}:${end}`,
                ],
            }));
            job.addTask(task);
            merge.addDependency(task);
        }
        job.addTask(merge);
        merges.push(merge);
    }
    if (settings.movie) {
        const task = author.Task("movie", "blender");
        const frames = path.join(folder, "*.exr");
        task.addCommand(blender(["-c", "sdf_lights_movie", path.join(folder, "movie.mp4"), settings.blendfile, frames]));
        for (const merge of merges) task.addDependency(merge);
        job.addTask(task);
    }
}

function blender(args) {
    return author.Command("exec", { exe: "{blender}", args: args });
}

function partOf(folder, first) {
    return path.join(folder, "parts", `${first}_####`);
}

// Samples [first, end) of each task, which differ by one in number.
function rangesOf(samples, count) {
    const found = [];
    for (let index = 0; index < count; index++) {
        const first = Math.floor(samples * index / count), end = Math.floor(samples * (index + 1) / count);
        if (end > first) found.push([first, end]);
    }
    return found;
}
