// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// One thread per pixel: samples are added up in float32 for a batch, which the host adds to the film in float64. A
// thread whose path has ended begins its next sample while others continue (Novák et al. 2010, "Path regeneration for
// interactive path tracing").
//
// Before this file come the workspace, the kernels, `sums` of this thread's pixel, and `#define`s of GROUP, the threads
// of a work group; of PIXEL_SIZE and of FILM_name, the index of each sum in a pixel, if a pass needs it; of
// EACH_SUM(what), which repeats `what` for all indices; of GOES_ON; of PIXEL_SEED, the sampler's; and of PATH and
// SAMPLE, the first rows of the workspace's tables. OUTPUTS: the film has passes of kernels/outputs/. CATCHERS: a path
// that has hit a shadow catcher continues once more from there, past all other objects (see catchers.py).

layout(local_size_x = GROUP) in;

layout(std430, binding = 1) buffer Film { float film[]; };
layout(std430, binding = 2) buffer Pixels { uint unfinished; uint pixels[]; };

// Of this dispatch: first index in `pixels` and number of them; first sample of the batch, and the one to stop before.
// Corner and width of the film.
uniform ivec4 work;
uniform ivec3 film_place;
uniform int film_seed;
uniform int film_offset;  // samples of this seed that other renders take

void add_vector(int at, vec3 value)
{
    sums[at] += value.x;
    sums[at + 1] += value.y;
    sums[at + 2] += value.z;
}

void put_vector(int at, vec3 value)
{
    sums[at] = value.x;
    sums[at + 1] = value.y;
    sums[at + 2] = value.z;
}

// As accumulate.add_sample.
void add_sample(int index)
{
    sums[FILM_COUNT] += 1.0;
    vec3 light = SAMPLE.combined;
    float total = light.x + light.y + light.z + SAMPLE.alpha;
    if (!(abs(total) < INFINITE)) {
        sums[FILM_NAN] += isnan(total) ? 1.0 : 0.0;
        sums[FILM_INFINITE] += isnan(total) ? 0.0 : 1.0;
        return;
    }
    add_vector(FILM_COMBINED, light);
    sums[FILM_COMBINED + 3] += SAMPLE.alpha;
    if ((index & HALF_BIT) != 0) {
        add_vector(FILM_HALF, light);
    }
#ifdef FILM_LAMPS
    add_vector(FILM_LAMPS, SAMPLE.lamps);
#endif
#ifdef FILM_EMISSION
    add_vector(FILM_EMISSION, SAMPLE.emission);
#endif
#ifdef FILM_ENVIRONMENT
    add_vector(FILM_ENVIRONMENT, SAMPLE.environment);
#endif
#ifdef FILM_DIFFUSE_ALBEDO
    add_vector(FILM_DIFFUSE_ALBEDO, SAMPLE.diffuse_albedo);
#endif
#ifdef OUTPUTS
    ADD_OUTPUTS(0);
#endif
    if (SAMPLE.found != 0) {
#ifdef FILM_NORMAL
        add_vector(FILM_NORMAL, SAMPLE.normal);
#endif
#ifdef FILM_ALBEDO
        add_vector(FILM_ALBEDO, SAMPLE.albedo);
#endif
        if (sums[FILM_SURFACES] == 0.0) {
#ifdef FILM_POSITION
            put_vector(FILM_POSITION, SAMPLE.position);
#endif
#ifdef FILM_DEPTH
            sums[FILM_DEPTH] = SAMPLE.depth;
#endif
        }
        sums[FILM_SURFACES] += 1.0;
    }
}

#ifdef CATCHERS
// The data of light sampling, and the media around the path, are outdated.
void forget()
{
    lamp_cuts_row.lamp = -1;
    light_cut_row.count = 0;
#ifdef MEDIA
    if (bare) {
        inside_rows[0].count = 0;
    }
#endif
}
#endif

// Software renderers end all loops of a thread after a total number of iterations (Mesa: 65535). Then its samples are
// wrong, and every loop ends after one iteration.
bool loops_end_early()
{
    int turns = 0;
    while (turns < 2 + (work.w >> 30)) {
        turns++;
    }
    return turns < 2;
}

// Not in a loop: an index that is no constant would put the sums of a thread into memory. Neighbouring threads read
// neighbouring words: first the first sum of all pixels, then the second.
#define LOAD_SUM(i) sums[i] = film[place + i * pixels_held];
#define STORE_SUM(i) film[place + i * pixels_held] = sums[i];

void main()
{
    int thread = int(gl_GlobalInvocationID.x);
    if (thread >= work.y) {
        return;
    }
    int place = work.x + thread;
    int pixel = int(pixels[place]);
    int x = film_place.x + pixel % film_place.z;
    int y = film_place.y + pixel / film_place.z;
    int pixels_held = film.length() / PIXEL_SIZE;
    EACH_SUM(LOAD_SUM);
    clear_workspace();
    choose_noted_lamp(thread);
    PATH.seed = PIXEL_SEED(x, y, film_seed);
    int index = work.z + int(sums[FILM_COUNT]);
    bool fresh = true;
#ifdef CATCHERS
    bool caught = false;  // the path continues from the catcher that it has hit
#endif
    while (index < work.w) {
        if (fresh) {
            PATH.index = film_offset + index;
            path_clear_sample();
#ifdef OUTPUTS
            CLEAR();
#endif
            integrator_start_path(x, y);
        }
#ifdef CATCHERS
        bool met = caught || integrator_intersect_and_gather();
        caught = false;
        fresh = !met || integrator_shade_and_scatter(false) != GOES_ON || !integrator_prepare_ray();
        if (fresh) {
            if (bare) {
                ADD_BARE();
                bare = false;
            } else {
                caught = RELEASE();
                bare = caught;
            }
            forget();
            fresh = !caught;
        }
#else
        fresh = integrator_advance(false) != GOES_ON || !integrator_prepare_ray();
#endif
        if (fresh) {
            add_sample(index);
            index++;
        }
    }
    if (loops_end_early()) {
        unfinished = 1u;
        return;
    }
    EACH_SUM(STORE_SUM);
    write_lengths();
}
