/* What the format has no place for is refused by name, before anything is written: a picture of
 * half a scene would compare two scenes. */
#include "driver/scene_json.h"

#include "base/file.h"

/* --- What cannot be written ------------------------------------------------------------------ */

static bool is_plain(const rk_material *m)
{
    bool matt = m->ks.x == 0 && m->ks.y == 0 && m->ks.z == 0;
    return matt && m->alpha == 1 && !m->kd_texture;
}

static bool has_plain_materials(const rk_mesh *mesh)
{
    for (uint32_t i = 0; i < mesh->material_count; i++)
        if (!is_plain(&mesh->materials[i]))
            return false;
    return true;
}

static bool has_plain_lights(const rk_scene *scene)
{
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind != RK_LIGHT_PARALLELOGRAM ||
            !rk_light_has_one_colour(&scene->lights[i]))
            return false;
    return true;
}

/* Does a picture of it show only what the file tells of? */
static bool check(const rk_scene *scene, const rk_render_options *options, rk_error *error)
{
    const rk_mesh *mesh = &scene->mesh;
    const char *more =
        scene->sphere_count > 0       ? "exact spheres"
        : scene->environment.side > 0 ? "an environment"
        : scene->background > 0       ? "a background"
        : mesh->normals               ? "smooth normals"
        : !has_plain_materials(mesh)  ? "mirrors, glass or textures"
        : !has_plain_lights(scene)    ? "lights other than parallelograms of one colour"
        : options->shading.model != RK_SHADING_LAMBERT || !options->shading.normalized
            ? "shading other than Lambert's, normalized"
        : options->light.falloff != RK_FALLOFF_PHYSICAL ? "light without falloff"
        : !options->shadows                             ? "light without shadows"
        : options->lens_samples > 0 && options->lens.focal != RK_FOCAL_PLANE ? "a focal sphere"
                                                                             : NULL;
    return !more || rk_fail(error, "scene %s: it needs %s, which the JSON file has no place for",
                            scene->name, more);
}

/* --- Values ---------------------------------------------------------------------------------- */

/* Nine digits restore a float to the bit. */
static void put_vector(FILE *out, const char *name, rk_vec3 v)
{
    fprintf(out, "\"%s\": [%.9g, %.9g, %.9g]", name, (double)v.x, (double)v.y, (double)v.z);
}

/* Between the items of a list. */
static const char *comma(uint32_t i)
{
    return i > 0 ? "," : "";
}

static void put_camera(FILE *out, const rk_scene *scene, const rk_render_options *options)
{
    const rk_view view = rk_view_of(&scene->camera, options->width, options->height);
    fprintf(out, "\"camera\": {");
    put_vector(out, "position", view.position);
    fprintf(out, ",\n ");
    put_vector(out, "right", view.right);
    fprintf(out, ",\n ");
    put_vector(out, "up", view.up);
    fprintf(out, ",\n ");
    put_vector(out, "forward", view.forward);
    fprintf(out, ",\n \"half_height\": %.9g},\n", (double)view.half_height);
}

static void put_lens(FILE *out, const rk_render_options *options)
{
    const rk_lens *lens = &options->lens;
    if (options->lens_samples > 0)
        fprintf(out, "\"lens\": {\"focal_distance\": %.9g, \"diameter\": %.9g},\n",
                (double)lens->focal_distance, (double)lens->aperture / 1000);
    else
        fprintf(out, "\"lens\": null,\n");
}

static bool moves(const rk_scene *scene, const rk_render_options *options)
{
    return scene->moving_count > 0 && options->motion.samples > 0;
}

static void put_shutter(FILE *out, const rk_scene *scene, const rk_render_options *options)
{
    const rk_shutter *shutter = &options->motion.shutter;
    if (moves(scene, options))
        fprintf(out, "\"shutter\": {\"open\": %.9g, \"close\": %.9g},\n", (double)shutter->open,
                (double)shutter->close);
    else
        fprintf(out, "\"shutter\": null,\n");
}

static void put_materials(FILE *out, const rk_mesh *mesh)
{
    fprintf(out, "\"materials\": [");
    for (uint32_t i = 0; i < mesh->material_count; i++) {
        fprintf(out, "%s\n {", comma(i));
        put_vector(out, "kd", mesh->materials[i].kd);
        fprintf(out, "}");
    }
    fprintf(out, "],\n");
}

/* `count` triangles from `first` on, with corners of their own: the file needs no shared ones. */
static void put_object(FILE *out, const rk_mesh *mesh, uint32_t first, uint32_t count,
                       const rk_motion *motion)
{
    fprintf(out, "\n {\"vertices\": [");
    for (uint32_t i = 0; i < 3 * count; i++) {
        const rk_vec3 p = mesh->positions[mesh->triangles[first + i / 3][i % 3]];
        fprintf(out, "%s\n  [%.9g, %.9g, %.9g]", comma(i), (double)p.x, (double)p.y, (double)p.z);
    }
    fprintf(out, "],\n  \"triangle_materials\": [");
    for (uint32_t i = 0; i < count; i++)
        fprintf(out, "%s%u", comma(i), mesh->triangle_materials[first + i]);
    if (motion)
        fprintf(out, "],\n  \"path\": [%.9g, %.9g, %.9g]}", (double)motion->a, (double)motion->b,
                (double)motion->c);
    else
        fprintf(out, "],\n  \"path\": null}");
}

static void put_objects(FILE *out, const rk_scene *scene, const rk_render_options *options)
{
    const bool moving = moves(scene, options);
    const uint32_t at_rest = moving ? scene->moving[0].first : scene->mesh.triangle_count;
    fprintf(out, "\"objects\": [");
    put_object(out, &scene->mesh, 0, at_rest, NULL);
    for (uint32_t i = 0; moving && i < scene->moving_count; i++) {
        const rk_moving *object = &scene->moving[i];
        fprintf(out, ",");
        put_object(out, &scene->mesh, object->first, object->count, &object->motion);
    }
    fprintf(out, "],\n");
}

static void put_lights(FILE *out, const rk_scene *scene)
{
    fprintf(out, "\"lights\": [");
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const rk_light *light = &scene->lights[i];
        fprintf(out, "%s\n {", comma(i));
        put_vector(out, "position", light->position);
        fprintf(out, ",\n  ");
        put_vector(out, "edge01", light->edge01);
        fprintf(out, ",\n  ");
        put_vector(out, "edge02", light->edge02);
        fprintf(out, ",\n  ");
        put_vector(out, "radiance", light->colours[0]);
        fprintf(out, "}");
    }
    fprintf(out, "]");
}

/* --- The file -------------------------------------------------------------------------------- */

bool rk_scene_json_write(const char *path, const rk_scene *scene, const rk_render_options *options,
                         rk_error *error)
{
    rk_file file;
    if (!check(scene, options, error) || !rk_file_begin(&file, path, error))
        return false;
    FILE *out = file.stream;
    fprintf(out, "{\"name\": \"%s\", \"width\": %u, \"height\": %u,\n", scene->name, options->width,
            options->height);
    put_camera(out, scene, options);
    put_lens(out, options);
    put_shutter(out, scene, options);
    put_materials(out, &scene->mesh);
    put_objects(out, scene, options);
    put_lights(out, scene);
    fprintf(out, "}\n");
    return rk_file_commit(&file, error);
}
