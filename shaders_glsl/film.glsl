// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// One thread a pixel: samples, added up in float32 for a batch, which the host adds to the film in float64.
//
// Before this file come `#define`s of PIXEL_SIZE and of FILM_name, the place of each sum in a pixel, where a pass
// needs it; the workspace, with `path_row` and `sample_row`; the kernels.

layout(local_size_x = 64) in;

layout(std430, binding = 1) buffer Film { float film[]; };
layout(std430, binding = 2) readonly buffer Pixels { uint pixels[]; };

// Of this dispatch: first place in `pixels` and number of them, first sample and number of them; corner and width of the film.
uniform ivec4 work;
uniform ivec3 film_place;
uniform int film_seed;

void add_vector(int at, vec3 value)
{
    film[at] += value.x;
    film[at + 1] += value.y;
    film[at + 2] += value.z;
}

void put_vector(int at, vec3 value)
{
    film[at] = value.x;
    film[at + 1] = value.y;
    film[at + 2] = value.z;
}

// As accumulate.add_sample.
void add_sample(int at, int index)
{
    film[at + FILM_COUNT] += 1.0;
    vec3 light = sample_row.combined;
    float total = light.x + light.y + light.z + sample_row.alpha;
    if (!(abs(total) < INFINITE)) {
        film[at + (isnan(total) ? FILM_NAN : FILM_INFINITE)] += 1.0;
        return;
    }
    add_vector(at + FILM_COMBINED, light);
    film[at + FILM_COMBINED + 3] += sample_row.alpha;
    if ((index & HALF_BIT) != 0) {
        add_vector(at + FILM_HALF, light);
    }
#ifdef FILM_LAMPS
    add_vector(at + FILM_LAMPS, sample_row.lamps);
#endif
#ifdef FILM_EMISSION
    add_vector(at + FILM_EMISSION, sample_row.emission);
#endif
    if (sample_row.found != 0) {
#ifdef FILM_NORMAL
        add_vector(at + FILM_NORMAL, sample_row.normal);
#endif
#ifdef FILM_ALBEDO
        add_vector(at + FILM_ALBEDO, sample_row.albedo);
#endif
#ifdef FILM_DIFFUSE_ALBEDO
        add_vector(at + FILM_DIFFUSE_ALBEDO, sample_row.diffuse_albedo);
#endif
        if (film[at + FILM_SURFACES] == 0.0) {
#ifdef FILM_POSITION
            put_vector(at + FILM_POSITION, sample_row.position);
#endif
#ifdef FILM_DEPTH
            film[at + FILM_DEPTH] = sample_row.depth;
#endif
        }
        film[at + FILM_SURFACES] += 1.0;
    }
}

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
    clear_workspace();
    path_row.seed = pixel_seed(x, y, film_seed);
    for (int index = work.z; index < work.z + work.w; index++) {
        path_row.index = index;
        path_clear_sample();
        integrator_trace_path(x, y);
        add_sample(place * PIXEL_SIZE, index);
    }
}
