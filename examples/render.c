/* Renders a built-in scene, or a mesh file, to a PNG or EXR picture with the installed library.
 *
 *     cc render.c $(pkg-config --cflags --libs raykit) -o render       (or c++ -x c++ render.c ...)
 *     ./render teapot teapot.png
 *     ./render dragon.obj dragon.png
 */
#include <raykit.h>

#include <stdio.h>
#include <string.h>

static bool load(rk_scene *scene, const char *name, rk_error *error)
{
    rk_mesh mesh;
    const rk_framing framing = rk_framing_default();
    rk_framed framed;
    if (!strchr(name, '.'))
        return rk_builtin_scene(scene, name, error);
    return rk_mesh_file_read(&mesh, name, error) &&
           rk_scene_framed(scene, name, &mesh, &framing, &framed, error);
}

static bool render(const rk_scene *scene, const char *path, rk_error *error)
{
    rk_render_options options = rk_render_options_default();
    options.shadows = true;
    rk_image image;
    rk_accel accel;
    rk_counters counters;
    memset(&image, 0, sizeof image); /* which C++ takes, too */
    memset(&accel, 0, sizeof accel);
    rk_pool *pool = rk_pool_start(0, error);
    bool ok = pool && rk_image_init(&image, options.width, options.height, error) &&
              rk_accel_build(&accel, RK_ACCEL_WIDE, scene, error) &&
              rk_render(&image, scene, &accel, &options, pool, &counters, NULL, error) &&
              rk_image_file_write(path, &image, error);
    if (ok)
        printf("%s: %.2f boxes and %.2f triangles tested per ray\n", path,
               (double)counters.box_tests / (double)(counters.primary_rays + counters.shadow_rays),
               (double)counters.triangle_tests /
                   (double)(counters.primary_rays + counters.shadow_rays));
    rk_accel_free(&accel);
    rk_image_free(&image);
    rk_pool_stop(pool);
    return ok;
}

int main(int argc, char **argv)
{
    rk_error error = {""};
    rk_scene scene;
    memset(&scene, 0, sizeof scene);
    if (argc != 3) {
        fprintf(stderr, "usage: render SCENE_OR_MESH_FILE PICTURE.png\n");
        return 2;
    }
    bool ok = rk_image_file_can_write(argv[2], &error) && load(&scene, argv[1], &error) &&
              render(&scene, argv[2], &error);
    if (!ok)
        fprintf(stderr, "render: %s\n", error.text);
    rk_scene_free(&scene);
    return ok ? 0 : 1;
}
