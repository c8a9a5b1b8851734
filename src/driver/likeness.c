/* Field by field, because structs have gaps. FNV-1a, 64 bits, over words of 32 bits: Fowler, Noll,
 * Vo, "FNV hash history", 1991; it tells accidents apart, and is no protection against malice. */
#include "driver/likeness.h"

#include "driver/implementation_note.h"

#include <math.h>
#include <string.h>

static const uint64_t first_hash = 0xcbf29ce484222325u, prime = 0x100000001b3u;

/* `bytes`: a multiple of four, or the last word is filled with zeroes. */
static void add(uint64_t *hash, const void *data, size_t bytes)
{
    const char *at = data;
    for (size_t i = 0; data && i < bytes; i += 4) {
        uint32_t word = 0;
        memcpy(&word, at + i, bytes - i < 4 ? bytes - i : 4);
        *hash = (*hash ^ word) * prime;
    }
}

static void add_text(uint64_t *hash, const char *text)
{
    if (text)
        add(hash, text, strlen(text) + 1);
}

static uint64_t hash_version(void)
{
    uint64_t hash = first_hash;
    add_text(&hash, PACKAGE_VERSION);
    add_text(&hash, rk_implementation_note);
    return hash;
}

static void add_float(uint64_t *hash, float number)
{
    add(hash, &number, sizeof number);
}

/* The functions that scenes and features call, at numbers of usual size. */
static uint64_t hash_arithmetic(void)
{
    enum { examples = 1000 };
    uint64_t hash = first_hash;
    for (int i = 0; i < examples; i++) {
        const float x = ((float)i + 0.37f) / examples;
        add_float(&hash, sinf(6 * x));
        add_float(&hash, cosf(6 * x));
        add_float(&hash, powf(x, 20 * x));
        add_float(&hash, expf(-8 * x));
        add_float(&hash, logf(x));
        add_float(&hash, (float)pow((double)x, 2.4));
        add_float(&hash, atan2f(x, 1 - x));
    }
    return hash;
}

/* Processes may have folders of their own. */
static uint64_t hash_command(const rk_driver *driver)
{
    uint64_t hash = first_hash;
    for (char **argument = driver->argv; argument && *argument; argument++) {
        if (argument == driver->argv || strncmp(*argument, "--out=", 6) == 0)
            continue;
        if (strcmp(*argument, "--out") == 0 && argument[1])
            argument++;
        else
            add_text(&hash, *argument);
    }
    return hash;
}

static void add_material(uint64_t *hash, const rk_material *m)
{
    add(hash, &m->kd, sizeof m->kd);
    add(hash, &m->ks, sizeof m->ks);
    add(hash, &m->absorption, sizeof m->absorption);
    add_float(hash, m->shininess);
    add_float(hash, m->alpha);
    add_float(hash, m->alpha_cutoff);
}

static void add_mesh(uint64_t *hash, const rk_mesh *mesh)
{
    const size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    add(hash, mesh->positions, vertices * sizeof *mesh->positions);
    add(hash, mesh->normals, vertices * sizeof *mesh->normals);
    add(hash, mesh->texcoords, vertices * sizeof *mesh->texcoords);
    add(hash, mesh->colours, vertices * sizeof *mesh->colours);
    add(hash, mesh->triangles, triangles * sizeof *mesh->triangles);
    add(hash, mesh->triangle_materials, triangles * sizeof *mesh->triangle_materials);
    for (uint32_t i = 0; i < mesh->material_count; i++)
        add_material(hash, &mesh->materials[i]);
    for (uint32_t i = 0; i < mesh->texture_count; i++) {
        const rk_image *image = &mesh->textures[i].image;
        add(hash, image->pixels, image->width * image->height * sizeof *image->pixels);
    }
}

static uint64_t hash_scene(const rk_scene *scene)
{
    uint64_t hash = first_hash;
    const size_t side = scene->environment.side;
    add_mesh(&hash, &scene->mesh);
    for (int face = 0; side > 0 && face < RK_FACES; face++)
        add(&hash, scene->environment.faces[face],
            side * side * sizeof *scene->environment.faces[face]);
    return hash;
}

rk_likeness rk_likeness_of(const rk_driver *driver)
{
    return (rk_likeness){.version = hash_version(),
                         .arithmetic = hash_arithmetic(),
                         .command = hash_command(driver),
                         .scene = hash_scene(&driver->scene)};
}

const char *rk_likeness_difference(const rk_likeness *a, const rk_likeness *b)
{
    return a->version != b->version         ? "another version of raykit or of its units"
           : a->arithmetic != b->arithmetic ? "another mathematics library (libm)"
           : a->command != b->command       ? "other options"
           : a->scene != b->scene           ? "another scene, of another file with the same name,"
                                            : NULL;
}
